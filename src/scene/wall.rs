//! The points of one wall: their positions on it, their noise, and which are drawn again.
//!
//! In: form, density and noise; for every frame a [`Pose`]. Out: the visible points.
//!
//! Invariants: the wall is divided into pieces of equal length. Each has one point at a random position, so the density
//! stays the same however many points are drawn again. A point that is not drawn again keeps its position on the wall
//! and its noise, and moves with the wall.
//!
//! Must not know: other walls, holes, time.

use std::f64::consts::TAU;

use super::random::Random;
use super::samples::Samples;
use super::turn::{direction, distance_squared, moved, turned};

/// The form of a wall. Its size is the radius of the largest disc inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A circle.
    Circle,
    /// A regular polygon with this number of corners.
    Polygon(u8),
}

impl Form {
    /// The length of the wall around a disc of radius 1.
    fn length(self) -> f64 {
        match self {
            Self::Circle => TAU,
            Self::Polygon(corners) => 2.0 * f64::from(corners) * half_side(corners),
        }
    }

    /// The largest distance of the wall from its centre, around a disc of radius 1.
    pub fn reach(self) -> f64 {
        match self {
            Self::Circle => 1.0,
            Self::Polygon(corners) => 1.0 / direction(0.5 / f64::from(corners))[0],
        }
    }

    /// The position after a share of the way around.
    fn place(self, share: f64) -> [f64; 2] {
        match self {
            Self::Circle => direction(share),
            Self::Polygon(corners) => {
                let sides = share * f64::from(corners);
                let side = sides.floor();
                let along = (2.0 * (sides - side) - 1.0) * half_side(corners);
                turned([1.0, along], direction(side / f64::from(corners)))
            }
        }
    }
}

/// Half the length of a side of a polygon around a disc of radius 1.
fn half_side(corners: u8) -> f64 {
    let [cos, sin] = direction(0.5 / f64::from(corners));
    sin / cos
}

/// The pose of a wall in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// The position of its centre.
    pub center: [f64; 2],
    /// Its rotation in turns.
    pub turns: f64,
    /// The radius of the largest disc inside.
    pub radius: f64,
    /// Its missing part.
    pub missing: Missing,
}

impl Pose {
    /// Whether a place on the wall is in its missing part: `ideal` around a disc of radius 1, `place` in the scene.
    pub fn is_missing(&self, ideal: [f64; 2], place: [f64; 2]) -> bool {
        match self.missing {
            Missing::Nothing => false,
            Missing::All => true,
            Missing::Inside(center, radius) => distance_squared(place, center) < radius * radius,
            Missing::Gap(toward, cosine) => ideal[0] * toward[0] + ideal[1] * toward[1] > cosine,
        }
    }
}

/// The part of a wall that is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Missing {
    /// None.
    Nothing,
    /// All.
    All,
    /// The part inside a disc with this centre and radius.
    Inside([f64; 2], f64),
    /// A gap: its direction from the centre, and the cosine of half the angle at which the centre sees it.
    Gap([f64; 2], f64),
}

/// A thin bar of infinite length. It hides the points under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// The unit vector across the bar.
    pub normal: [f64; 2],
    /// The position of its middle line along the normal.
    pub offset: f64,
    /// How wide it is.
    pub width: f64,
}

impl Bar {
    fn hides(&self, [x, y]: [f64; 2]) -> bool {
        (x * self.normal[0] + y * self.normal[1] - self.offset).abs() <= self.width / 2.0
    }
}

/// The point of one piece of the wall.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The position in the piece, from 0 up to 1.
    along: f64,
    /// The position in a disc of noise of radius 1.
    noise: [f64; 2],
}

impl Sample {
    fn draw(random: &mut Random) -> Self {
        Self { along: random.unit(), noise: random.in_ball() }
    }
}

/// One wall.
#[derive(Clone, Debug)]
pub struct Wall {
    form: Form,
    samples: Samples<Sample>,
    /// The radius of the noise, relative to the wall's radius.
    noise: f64,
}

impl Wall {
    /// A wall with `density` points in a length of its radius. Noise is the radius of its disc, in radii of the wall.
    pub fn new(form: Form, density: f64, noise: f64, random: Random) -> Self {
        let count = ((form.length() * density).round() as u32).max(3);
        Self { form, samples: Samples::new(count, random, Sample::draw), noise }
    }

    /// Draws a share of the points again.
    pub fn churn(&mut self, share: f64) {
        self.samples.churn(share, Sample::draw);
    }

    /// Every point, in order along the wall. None: it is not visible.
    pub fn points(&self, pose: &Pose, bar: Option<Bar>) -> impl Iterator<Item = Option<[f64; 2]>> {
        let (turn, pieces) = (direction(pose.turns), self.samples.len() as f64);
        (0..).zip(self.samples.iter()).map(move |(number, sample)| {
            let ideal = self.form.place((f64::from(number) + sample.along) / pieces);
            let place = |local: [f64; 2]| moved(pose.center, turned(local, turn), pose.radius);
            let seen = place(moved(ideal, sample.noise, self.noise));
            (!pose.is_missing(ideal, place(ideal)) && !bar.is_some_and(|bar| bar.hides(seen))).then_some(seen)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: Pose = Pose { center: [3.0, 4.0], turns: 0.0, radius: 2.0, missing: Missing::Nothing };

    fn seen(wall: &Wall, pose: &Pose) -> Vec<[f64; 2]> {
        wall.points(pose, None).flatten().collect()
    }

    #[test]
    fn points_are_on_the_wall_with_the_given_density() {
        for (form, count) in [(Form::Circle, 101), (Form::Polygon(4), 128), (Form::Polygon(3), 166)] {
            let points = seen(&Wall::new(form, 16.0, 0.0, Random::new(1)), &POSE);
            assert_eq!(points.len(), count, "{form:?}");
            for point in points {
                let distance = distance_squared(point, POSE.center).sqrt() / 2.0;
                assert!((1.0 - 1e-12..=form.reach() + 1e-12).contains(&distance), "{form:?}: {distance}");
            }
        }
    }

    #[test]
    fn noise_is_bounded_by_its_disc() {
        let wall = Wall::new(Form::Circle, 100.0, 0.1, Random::new(1));
        let off = |point| (distance_squared(point, POSE.center).sqrt() - 2.0).abs();
        let largest = seen(&wall, &POSE).into_iter().map(off).fold(0.0, f64::max);
        assert!(largest <= 0.2 + 1e-12 && largest > 0.15, "{largest}");
    }

    #[test]
    fn removed_and_hidden_parts_have_no_points() {
        let wall = Wall::new(Form::Circle, 100.0, 0.0, Random::new(1));
        let count = |missing| seen(&wall, &Pose { missing, ..POSE }).len() as f64 / 628.0;
        assert_eq!(count(Missing::All), 0.0);
        // A disc of the same radius around a point of the circle covers a third of the circle.
        assert!((count(Missing::Inside([5.0, 4.0], 2.0)) - 2.0 / 3.0).abs() < 0.01);
        assert!((count(Missing::Gap([0.0, 1.0], 0.5)) - 2.0 / 3.0).abs() < 0.01);
        let bar = Bar { normal: [1.0, 0.0], offset: 3.0, width: 2.0 };
        let under = wall.points(&POSE, Some(bar)).filter(Option::is_none).count() as f64 / 628.0;
        // Two arcs of 60 degrees.
        assert!((under - 1.0 / 3.0).abs() < 0.01, "{under}");
    }
}
