//! The kinds of scenes in R^d, and what is in each.
//!
//! In: a kind, the number of points, the noise, random numbers.
//! Out: the scene's bodies, or its cloud.
//! Invariants: the bodies of a scene have all its points. Rings that are not linked never come near each other.
//! Must not know: how points are made.

use super::body::{Body, Motion};
use super::cloud::{Cloud, Delay};
use super::form::Form;
use super::vector::{Tumble, Vector};
use crate::scene::composition::{PairMotion, pair};
use crate::scene::motion::{Cycle, Oscillation};
use crate::scene::random::Random;

/// The largest number of coordinates of a cube.
const MOST_IN_CUBE: u16 = 4096;
/// The largest number of coordinates of delay vectors.
const MOST_DELAYS: u16 = 100;

/// The kinds of scenes in R^d.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpaceKind {
    /// A torus that turns, with a tube that swells.
    Torus,
    /// A thick trefoil knot that turns.
    Trefoil,
    /// Three rings that move and turn.
    Rings,
    /// Two rings that link and part.
    Links,
    /// A ring that pinches in two and opens again.
    Pinch,
    /// A circle in the plane that stays.
    Circle,
    /// A sphere that turns.
    Sphere,
    /// Uniform points in a cube of this dimension.
    Cube(u16),
    /// Delay vectors of this dimension of a noisy sine.
    Delay(u16),
}

/// What has the points of a scene.
#[derive(Clone, Debug)]
pub enum Content {
    /// Bodies in R^3.
    Bodies(Vec<Body>),
    /// A cloud that stays.
    Cloud(Cloud),
}

impl SpaceKind {
    /// Every kind; those of any dimension with one of them.
    pub const ALL: [Self; 9] = [
        Self::Torus,
        Self::Trefoil,
        Self::Rings,
        Self::Links,
        Self::Pinch,
        Self::Circle,
        Self::Sphere,
        Self::Cube(3),
        Self::Delay(20),
    ];

    /// The name of the kind.
    pub fn name(self) -> String {
        match self {
            Self::Torus => "torus".to_owned(),
            Self::Trefoil => "trefoil".to_owned(),
            Self::Rings => "rings3".to_owned(),
            Self::Links => "links".to_owned(),
            Self::Pinch => "pinch3".to_owned(),
            Self::Circle => "circle".to_owned(),
            Self::Sphere => "sphere".to_owned(),
            Self::Cube(dimension) => format!("cube:{dimension}"),
            Self::Delay(dimension) => format!("delay:{dimension}"),
        }
    }

    /// A description of one line.
    pub fn about(self) -> &'static str {
        match self {
            Self::Torus => "a torus turns and its tube swells: a hole around the tube, one around the middle",
            Self::Trefoil => "a thick trefoil knot turns: one hole",
            Self::Rings => "3 rings in R^3 move and turn on their own",
            Self::Links => "2 rings come together, link like a chain, and part: two holes all the time",
            Self::Pinch => "a ring in R^3 pinches in two at its waist and opens again",
            Self::Circle => "a circle in the plane stays",
            Self::Sphere => "a sphere turns: no hole that a curve goes around",
            Self::Cube(_) => "uniform points in a cube of any dimension (cube:D), no true hole",
            Self::Delay(_) => "the last delay vectors of a noisy sine (delay:D): one hole",
        }
    }

    /// Coordinates of a point.
    pub fn dimension(self) -> usize {
        match self {
            Self::Circle => 2,
            Self::Cube(dimension) | Self::Delay(dimension) => usize::from(dimension),
            Self::Torus | Self::Trefoil | Self::Rings | Self::Links | Self::Pinch | Self::Sphere => 3,
        }
    }

    /// Whether its points are off their places. Those of a cube have none.
    pub fn has_noise(self) -> bool {
        !matches!(self, Self::Cube(_))
    }

    /// The kind of a name with a dimension, as in `cube:5`.
    pub fn with_dimension(word: &str) -> Option<Self> {
        let (name, digits) = word.split_once(':')?;
        let is_number = digits.bytes().all(|digit| digit.is_ascii_digit());
        let dimension = digits.parse().ok().filter(|_| is_number)?;
        let kind = match name {
            "cube" => Self::Cube(dimension),
            "delay" => Self::Delay(dimension),
            _ => return None,
        };
        Some(kind).filter(|kind| kind.has_dimension())
    }

    /// Whether there is such a scene of its dimension.
    pub(super) fn has_dimension(self) -> bool {
        match self {
            Self::Cube(dimension) => (1..=MOST_IN_CUBE).contains(&dimension),
            Self::Delay(dimension) => (2..=MOST_DELAYS).contains(&dimension),
            _ => true,
        }
    }

    /// What has the points.
    pub(super) fn content(self, points: u32, noise: f64, random: &mut Random) -> Content {
        let parts = match self {
            Self::Circle => return Content::Cloud(Cloud::circle(points, noise, random.fork())),
            Self::Cube(dimension) => return Content::Cloud(Cloud::cube(dimension, points, random.fork())),
            Self::Delay(dimension) => {
                return Content::Cloud(Cloud::Delay(Delay::new(dimension, points, noise, random.fork())));
            }
            Self::Torus => vec![(Form::Torus, turning(random))],
            Self::Trefoil => vec![(Form::Knot, turning(random))],
            Self::Sphere => vec![(Form::Sphere, turning(random))],
            Self::Pinch => vec![(Form::Pair(pair(random, PairMotion::Both, 0.0)), turning(random))],
            Self::Rings => [-1.0, 0.0, 1.0].map(|place| ring(place, random)).to_vec(),
            Self::Links => links(random),
        };
        Content::Bodies(bodies(parts, points, noise, random))
    }
}

/// Bodies that have all the points, in proportion to their size.
fn bodies(parts: Vec<(Form, Motion)>, points: u32, noise: f64, random: &mut Random) -> Vec<Body> {
    let all: f64 = parts.iter().map(|(form, _)| form.unit()).sum();
    let (mut size, mut given) = (0.0, 0);
    let body = |(form, motion): (Form, Motion)| {
        size += form.unit();
        let count = (f64::from(points) * (size / all)).round() as u32 - given;
        given += count;
        Body::new(form, motion, count, noise, random.fork())
    };
    parts.into_iter().map(body).collect()
}

fn turning(random: &mut Random) -> Motion {
    Motion::Free { place: [0.0; 3], path: Oscillation::default(), tumble: Tumble::draw(random) }
}

/// One of the rings in a row. Two of them are never nearer to each other than twice the radius of the larger one.
fn ring(place: f64, random: &mut Random) -> (Form, Motion) {
    const REACH: Vector = [0.4, 0.8, 0.8];
    const STEP: f64 = 5.8;
    let periods = [(); 3].map(|()| random.between(250.0, 375.0));
    let phases = [(); 3].map(|()| random.unit());
    let path = Oscillation { reach: REACH, periods, phases };
    let motion = Motion::Free { place: [STEP * place, 0.0, 0.0], path, tumble: Tumble::draw(random) };
    (Form::Circle(random.between(0.8, 1.2)), motion)
}

/// Two rings of radius 1 in planes across each other, on one line. They touch where their centres are 2 apart.
fn links(random: &mut Random) -> Vec<(Form, Motion)> {
    const FAR: f64 = 3.6;
    const LINKED: f64 = 1.3;
    let apart = Cycle::new(&[[FAR, 60.0], [FAR, 100.0], [LINKED, 90.0], [LINKED, 100.0]], 0.0);
    let tumble = Tumble::draw(random);
    [-1.0, 1.0].map(|side| (Form::Circle(1.0), Motion::Chained { side, apart: apart.clone(), tumble })).to_vec()
}
