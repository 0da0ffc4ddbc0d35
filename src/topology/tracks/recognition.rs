//! Which of the dots of a frame are those of tracks that are there already.
//!
//! In: what was last seen of each track, and the sightings of a frame. Out: of each track, the sighting that is its own. Identity is anchored on the hole: first on its
//! death triangle; else on its centre and radius inside a gate, by optimal assignment; where a hole was filled last may jump far inside it,
//! as between the lobes of a dumb-bell or around an annulus, so what is left is recognized by regions: each holds the other's centre. Never on
//! the critical edge or the birth, which jump. Invariants: the order of sightings decides nothing but ties. Must not know: events, hysteresis.

use std::collections::HashMap;

use super::assignment::{Pair, assign};
use super::hole_region::HoleRegion;
use super::sighting::Sighting;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::Hole;

/// Centres of one hole are no farther apart than this share of the larger radius.
const NEAR: f64 = 0.5;

/// Radii of one hole differ by no more than this factor.
const ALIKE: f64 = 2.0;

/// What of a track's past is looked for.
#[derive(Clone, Copy, Debug)]
pub struct LastSeen<'a, R> {
    /// The triangle that named its death.
    pub triangle: [VertexId; 3],
    /// Where its hole was last.
    pub hole: Hole,
    /// Where it should be now.
    pub expected: [f64; 2],
    /// What it took up when that was looked at last; unknown before the track is announced, and then the other's region decides alone.
    pub region: &'a R,
    /// How far it has moved since.
    pub shift: [f64; 2],
    /// A dot of less persistence is no continuation, unless it is selected.
    pub least: f64,
}

/// How a track was recognized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recognized {
    /// The same triangle, or a hole near by.
    Place,
    /// A hole in the same region.
    Region,
}

/// Of each known track, the place of the sighting that is its own.
pub fn recognize<R: HoleRegion>(
    known: &[LastSeen<'_, R>],
    sightings: &[Sighting],
    is_selected: &[bool],
    find_region: impl FnMut(&Sighting) -> R,
) -> Vec<Option<(usize, Recognized)>> {
    let (own, is_taken) = (vec![None; known.len()], vec![false; sightings.len()]);
    let mut search = Search { known, sightings, is_selected, own, is_taken };
    search.by_triangle();
    let near = search.pairs_near();
    search.assign(&near, Recognized::Place);
    let inside = search.pairs_inside(find_region);
    search.assign(&inside, Recognized::Region);
    search.own
}

struct Search<'a, R> {
    known: &'a [LastSeen<'a, R>],
    sightings: &'a [Sighting],
    is_selected: &'a [bool],
    own: Vec<Option<(usize, Recognized)>>,
    is_taken: Vec<bool>,
}

impl<R: HoleRegion> Search<'_, R> {
    fn by_triangle(&mut self) {
        let places: HashMap<[VertexId; 3], usize> =
            self.sightings.iter().enumerate().map(|(place, sighting)| (sighting.triangle, place)).collect();
        for (track, known) in self.known.iter().enumerate() {
            let Some(&place) = places.get(&known.triangle) else { continue };
            if self.goes_on(known, place) {
                self.give(track, place, Recognized::Place);
            }
        }
    }

    /// Whether a sighting is persistent enough to be a track's.
    fn goes_on(&self, known: &LastSeen<'_, R>, place: usize) -> bool {
        self.is_selected[place] || self.sightings[place].persistence() >= known.least
    }

    fn give(&mut self, track: usize, sighting: usize, by: Recognized) {
        self.own[track] = Some((sighting, by));
        self.is_taken[sighting] = true;
    }

    fn assign(&mut self, pairs: &[Pair], by: Recognized) {
        for (track, sighting) in assign(pairs) {
            self.give(track, sighting, by);
        }
    }

    /// Tracks and sightings that are free, where one is near the place of the other, or near where it should be now.
    fn pairs_near(&self) -> Vec<Pair> {
        let mut free: Vec<usize> = (0..self.sightings.len()).filter(|&place| !self.is_taken[place]).collect();
        let x = |place: usize| self.sightings[place].hole.center[0];
        free.sort_by(|&a, &b| x(a).total_cmp(&x(b)));
        let mut pairs = Vec::new();
        for (track, known) in self.known.iter().enumerate().filter(|&(track, _)| self.own[track].is_none()) {
            // No gate is wider.
            let reach = NEAR * ALIKE * known.hole.radius;
            let [was, is] = [known.hole.center, known.expected].map(|center| center[0]);
            let first = free.partition_point(|&place| x(place) < was.min(is) - reach);
            let near = free[first..].iter().take_while(|&&place| x(place) <= was.max(is) + reach);
            for &place in near {
                let Sighting { hole, .. } = self.sightings[place];
                let places = [known.expected, known.hole.center];
                let cost = places
                    .map(|center| remoteness(Hole { center, ..known.hole }, hole))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                if cost <= 1.0 && self.goes_on(known, place) {
                    pairs.push(Pair { row: track, column: place, cost });
                }
            }
        }
        pairs
    }

    /// The same where each one's region holds the other's centre.
    fn pairs_inside(&self, mut find_region: impl FnMut(&Sighting) -> R) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let mut regions: HashMap<usize, R> = HashMap::new();
        for (track, known) in self.known.iter().enumerate().filter(|&(track, _)| self.own[track].is_none()) {
            for (place, sighting) in self.sightings.iter().enumerate().filter(|&(place, _)| !self.is_taken[place]) {
                let hole = sighting.hole;
                let is_possible = are_alike(known.hole.radius, hole.radius)
                    && self.goes_on(known, place)
                    && (known.region.is_unknown() || held(known.region, known.shift, hole.center))
                    && regions.entry(place).or_insert_with(|| find_region(sighting)).contains(known.hole.center);
                if is_possible {
                    // Any of them is possible; the nearest is the likeliest.
                    let apart = distance(known.hole.center, hole.center) / (known.hole.radius + hole.radius);
                    pairs.push(Pair { row: track, column: place, cost: apart / (1.0 + apart) });
                }
            }
        }
        pairs
    }
}

/// How far two holes are from being one: 0 if they are the same, more than 1 outside the gate.
fn remoteness(a: Hole, b: Hole) -> f64 {
    let apart = distance(a.center, b.center) / (NEAR * a.radius.max(b.radius));
    let unlike = (b.radius / a.radius).ln().abs() / ALIKE.ln();
    if apart <= 1.0 && unlike <= 1.0 { (apart + unlike) / 2.0 } else { f64::INFINITY }
}

fn are_alike(a: f64, b: f64) -> bool {
    a <= ALIKE * b && b <= ALIKE * a
}

/// Whether a region holds a point that was looked at some frames ago. How far the hole's centre has come since is how far the region has, or only how far the centre has inside
/// it: either will do.
pub fn held(region: &impl HoleRegion, shift: [f64; 2], point: [f64; 2]) -> bool {
    region.contains(point) || region.contains(back(point, shift))
}

/// Where a point was before a shift.
pub fn back(point: [f64; 2], shift: [f64; 2]) -> [f64; 2] {
    [point[0] - shift[0], point[1] - shift[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
