//! The points on one wall: where on it each lies, how far off by noise, and which are drawn anew.
//!
//! In: a form, how dense, how noisy; in every frame a [`Stand`]. Out: the points that can be seen. Invariants: the wall
//! is cut into pieces of equal length with one point in each, anywhere in it, so that the density holds however many
//! are drawn anew; a point that is not drawn anew keeps its place on the wall and its noise, and is carried along. Must
//! not know: other walls, holes, time.

use std::f64::consts::TAU;

use super::random::Random;
use super::turn::{direction, distance_squared, moved, turned};

/// What a wall looks like; its size is the radius of the largest disc inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A circle.
    Circle,
    /// A regular polygon with so many corners.
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

    /// The farthest that the wall is from its centre, around a disc of radius 1.
    pub fn reach(self) -> f64 {
        match self {
            Self::Circle => 1.0,
            Self::Polygon(corners) => 1.0 / direction(0.5 / f64::from(corners))[0],
        }
    }

    /// The place after a share of the way around.
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

/// How a wall stands in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Stand {
    /// Where its centre is.
    pub center: [f64; 2],
    /// How far it is turned.
    pub turns: f64,
    /// Radius of the largest disc inside.
    pub radius: f64,
    /// What is not there of it.
    pub gone: Gone,
}

/// Which part of a wall is not there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gone {
    /// None.
    Nothing,
    /// All.
    All,
    /// What lies inside a disc: centre and radius.
    Inside([f64; 2], f64),
    /// What a gap takes: in which direction from the centre, and the cosine of half the angle that it is seen under.
    Gap([f64; 2], f64),
}

/// A thin bar that hides the points under it, without an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Across the bar.
    pub normal: [f64; 2],
    /// Where its middle line is, along the normal.
    pub offset: f64,
    /// How wide it is.
    pub width: f64,
}

impl Bar {
    fn hides(&self, [x, y]: [f64; 2]) -> bool {
        (x * self.normal[0] + y * self.normal[1] - self.offset).abs() <= self.width / 2.0
    }
}

/// One point on its piece of the wall.
#[derive(Clone, Copy, Debug)]
struct Mark {
    /// Where in the piece: from 0 up to 1.
    along: f64,
    /// Where in the disc of noise, as if that had radius 1.
    noise: [f64; 2],
}

impl Mark {
    fn draw(random: &mut Random) -> Self {
        Self { along: random.unit(), noise: random.in_disc() }
    }
}

/// One wall.
#[derive(Clone, Debug)]
pub struct Wall {
    form: Form,
    marks: Vec<Mark>,
    random: Random,
    /// Radius of the noise, where the wall's own is 1.
    noise: f64,
    /// How much of a point more than whole ones is due to be drawn anew.
    due: f64,
    /// The numbers of the marks, in any order.
    numbers: Vec<u32>,
}

impl Wall {
    /// A wall with so many points to a length of its radius, and noise of a disc of so many of its radii.
    pub fn new(form: Form, density: f64, noise: f64, mut random: Random) -> Self {
        let count = ((form.length() * density).round() as u32).max(3);
        let marks = (0..count).map(|_| Mark::draw(&mut random)).collect();
        Self { form, marks, random, noise, due: 0.0, numbers: (0..count).collect() }
    }

    /// Draws a share of the points anew.
    pub fn churn(&mut self, share: f64) {
        let due = self.due + share * self.marks.len() as f64;
        self.due = due - due.floor();
        let count = (due.floor() as usize).min(self.marks.len());
        self.random.choose(&mut self.numbers, count);
        for &number in &self.numbers[..count] {
            self.marks[number as usize] = Mark::draw(&mut self.random);
        }
    }

    /// Every point, in order along the wall, where it can be seen.
    pub fn points(&self, stand: &Stand, bar: Option<Bar>) -> impl Iterator<Item = Option<[f64; 2]>> {
        let (turn, pieces) = (direction(stand.turns), self.marks.len() as f64);
        (0..).zip(&self.marks).map(move |(number, mark)| {
            let ideal = self.form.place((f64::from(number) + mark.along) / pieces);
            let place = |local: [f64; 2]| moved(stand.center, turned(local, turn), stand.radius);
            let is_gone = match stand.gone {
                Gone::Nothing => false,
                Gone::All => true,
                Gone::Inside(center, radius) => distance_squared(place(ideal), center) < radius * radius,
                Gone::Gap(toward, cosine) => ideal[0] * toward[0] + ideal[1] * toward[1] > cosine,
            };
            let seen = place(moved(ideal, mark.noise, self.noise));
            (!is_gone && !bar.is_some_and(|bar| bar.hides(seen))).then_some(seen)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAND: Stand = Stand { center: [3.0, 4.0], turns: 0.0, radius: 2.0, gone: Gone::Nothing };

    fn seen(wall: &Wall, stand: &Stand) -> Vec<[f64; 2]> {
        wall.points(stand, None).flatten().collect()
    }

    #[test]
    fn points_lie_on_the_wall_and_are_as_dense_as_wanted() {
        for (form, count) in [(Form::Circle, 101), (Form::Polygon(4), 128), (Form::Polygon(3), 166)] {
            let points = seen(&Wall::new(form, 16.0, 0.0, Random::new(1)), &STAND);
            assert_eq!(points.len(), count, "{form:?}");
            for point in points {
                let distance = distance_squared(point, STAND.center).sqrt() / 2.0;
                assert!((1.0 - 1e-12..=form.reach() + 1e-12).contains(&distance), "{form:?}: {distance}");
            }
        }
    }

    #[test]
    fn noise_is_bounded_by_its_disc() {
        let wall = Wall::new(Form::Circle, 100.0, 0.1, Random::new(1));
        let off = |point| (distance_squared(point, STAND.center).sqrt() - 2.0).abs();
        let largest = seen(&wall, &STAND).into_iter().map(off).fold(0.0, f64::max);
        assert!(largest <= 0.2 + 1e-12 && largest > 0.15, "{largest}");
    }

    #[test]
    fn churn_draws_its_share_anew_and_no_more() {
        let mut wall = Wall::new(Form::Circle, 16.0, 0.1, Random::new(1));
        let mut changed = 0;
        for _ in 0..100 {
            let before = seen(&wall, &STAND);
            wall.churn(0.105);
            changed += before.iter().zip(seen(&wall, &STAND)).filter(|(a, b)| *a != b).count();
        }
        assert_eq!(changed, (101.0_f64 * 0.105 * 100.0) as usize);
        let before = seen(&wall, &STAND);
        wall.churn(1.0);
        assert!(before.iter().zip(seen(&wall, &STAND)).all(|(a, b)| *a != b));
    }

    #[test]
    fn what_is_gone_is_not_seen() {
        let wall = Wall::new(Form::Circle, 100.0, 0.0, Random::new(1));
        let count = |gone| seen(&wall, &Stand { gone, ..STAND }).len() as f64 / 628.0;
        assert_eq!(count(Gone::All), 0.0);
        // A disc of the same radius around a point of the circle covers a third of it.
        assert!((count(Gone::Inside([5.0, 4.0], 2.0)) - 2.0 / 3.0).abs() < 0.01);
        assert!((count(Gone::Gap([0.0, 1.0], 0.5)) - 2.0 / 3.0).abs() < 0.01);
        let bar = Bar { normal: [1.0, 0.0], offset: 3.0, width: 2.0 };
        let under = wall.points(&STAND, Some(bar)).filter(Option::is_none).count() as f64 / 628.0;
        // Two arcs of 60 degrees.
        assert!((under - 1.0 / 3.0).abs() < 0.01, "{under}");
    }
}
