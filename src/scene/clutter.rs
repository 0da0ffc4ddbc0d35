//! Clutter: stray points that belong to no wall, alone or in clumps.
//!
//! In: how many there are for each point of a wall; for every frame the walls' points. Out: the stray points.
//!
//! Invariants: they are uniformly distributed in the bounding box of the walls' points, widened by [`MARGIN`] of its
//! sides at each side, as it is when they are drawn. A share of them is drawn again in every frame; the others stay.
//!
//! Must not know: walls, holes, cameras.

use super::random::Random;
use super::samples::Samples;
use super::turn::moved;

/// How much the bounding box is widened at each side, as a share of its sides.
const MARGIN: f64 = 0.05;

/// The points of a clump.
const CLUMP: std::ops::RangeInclusive<usize> = 2..=6;

/// The radius of a clump, as a share of the radius of the smallest hole.
const CLUMP_RADIUS: f64 = 0.06;

/// Stray points that are drawn together.
#[derive(Clone, Debug)]
struct Clump {
    /// Its position in the box, in shares of the sides, until it is put there.
    place: [f64; 2],
    /// Its points, relative to the position.
    points: Vec<[f64; 2]>,
    is_new: bool,
}

/// The clutter of a scene.
#[derive(Clone, Debug)]
pub struct Clutter {
    share: f64,
    /// The radius of clumps. None: each point is alone.
    clump_radius: Option<f64>,
    clumps: Samples<Clump>,
}

impl Clutter {
    /// Before the first frame. `share` is of the number of the walls' points; clumps have it in the mean.
    pub fn new(share: f64, in_clumps: bool, smallest_radius: f64, random: Random) -> Self {
        let clump_radius = in_clumps.then_some(CLUMP_RADIUS * smallest_radius);
        Self { share, clump_radius, clumps: Samples::new(0, random, |random| draw(random, clump_radius)) }
    }

    /// The next frame: draws a share of the clumps again, and keeps their number in proportion to the walls' points.
    pub fn advance(&mut self, churn: f64, walls: impl Iterator<Item = [f64; 2]>) {
        let (count, low, high) = bounds(walls);
        let of_a_clump = if self.clump_radius.is_some() { (CLUMP.start() + CLUMP.end()) as f64 / 2.0 } else { 1.0 };
        let wanted = (self.share * f64::from(count) / of_a_clump).round() as u32;
        let radius = self.clump_radius;
        self.clumps.churn(churn, |random| draw(random, radius));
        self.clumps.resize(wanted, |random| draw(random, radius));
        for clump in self.clumps.iter_mut().filter(|clump| clump.is_new) {
            clump.is_new = false;
            clump.place = std::array::from_fn(|axis| {
                let side = high[axis] - low[axis];
                low[axis] + side * ((1.0 + 2.0 * MARGIN) * clump.place[axis] - MARGIN)
            });
        }
    }

    /// All stray points. Each clump has as many slots as the largest; None: a slot without a point.
    pub fn points(&self) -> impl Iterator<Item = Option<[f64; 2]>> {
        let slots = if self.clump_radius.is_some() { *CLUMP.end() } else { 1 };
        self.clumps.iter().flat_map(move |clump| {
            (0..slots).map(|slot| clump.points.get(slot).map(|&point| moved(point, clump.place, 1.0)))
        })
    }
}

fn draw(random: &mut Random, clump_radius: Option<f64>) -> Clump {
    let place = [random.unit(), random.unit()];
    let points = match clump_radius {
        None => vec![[0.0; 2]],
        Some(radius) => {
            let count = CLUMP.start() + random.below(CLUMP.count());
            (0..count).map(|_| moved([0.0; 2], random.in_ball(), radius)).collect()
        }
    };
    Clump { place, points, is_new: true }
}

/// The number of positions, and the corners of their bounding box.
fn bounds(places: impl Iterator<Item = [f64; 2]>) -> (u32, [f64; 2], [f64; 2]) {
    places.fold((0, [f64::INFINITY; 2], [f64::NEG_INFINITY; 2]), |(count, low, high), [x, y]| {
        (count + 1, [low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall of 1,000 points from (10, 0) to (14, 2).
    fn wall() -> impl Iterator<Item = [f64; 2]> {
        (0..1000).map(|number| [10.0 + f64::from(number) / 999.0 * 4.0, f64::from(number % 2) * 2.0])
    }

    fn points(clutter: &Clutter) -> Vec<[f64; 2]> {
        clutter.points().flatten().collect()
    }

    #[test]
    fn stray_points_fill_the_widened_box() {
        let mut clutter = Clutter::new(0.5, false, 1.0, Random::new(1));
        clutter.advance(0.1, wall());
        let first = points(&clutter);
        assert_eq!(first.len(), 500);
        let (_, low, high) = bounds(first.iter().copied());
        assert!(low[0] >= 9.8 && low[0] < 9.9 && high[0] <= 14.2 && high[0] > 14.1, "{low:?} {high:?}");
        assert!(low[1] >= -0.1 && low[1] < -0.05 && high[1] <= 2.1 && high[1] > 2.05, "{low:?} {high:?}");
        clutter.advance(0.1, wall());
        let moved = first.iter().zip(points(&clutter)).filter(|&(before, now)| *before != now).count();
        assert_eq!(moved, 50);
        clutter.advance(0.1, wall().take(100));
        assert_eq!(points(&clutter).len(), 50);
        clutter.advance(0.1, std::iter::empty());
        assert_eq!(points(&clutter), Vec::<[f64; 2]>::new());
    }

    #[test]
    fn clumps_are_small_and_have_two_to_six_points() {
        let mut clutter = Clutter::new(0.4, true, 2.0, Random::new(2));
        clutter.advance(1.0, wall());
        let slots: Vec<Option<[f64; 2]>> = clutter.points().collect();
        assert_eq!(slots.len(), 600);
        let mut sizes = [0; 7];
        for clump in slots.chunks(6) {
            let (count, low, high) = bounds(clump.iter().flatten().copied());
            assert!(high[0] - low[0] <= 0.24 && high[1] - low[1] <= 0.24);
            sizes[count as usize] += 1;
        }
        assert_eq!(sizes[..2], [0, 0]);
        assert!(sizes[2..].iter().all(|&count| count > 8), "{sizes:?}");
    }
}
