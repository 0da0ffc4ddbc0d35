//! Clouds in R^d that stay: a circle, a cube, delay vectors.
//!
//! In: the number of points and of coordinates; for every frame the share of the points that is new.
//! Out: the points, and the ideal holes.
//! Invariants: the number of points does not change. Delay vectors are those of one series that goes on.
//! Must not know: bodies that move.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use super::cycle::{IdealCycle, half_diameter};
use super::{FILLED, SHARE_ABOVE};
use crate::scene::random::Random;
use crate::scene::samples::Samples;
use crate::scene::turn::{direction, wave};
use crate::scene::wall::{Form, Missing, Pose, Wall, WallPlan};

/// Samples in a period of the sine.
const PERIOD: u32 = 120;
/// Samples from one coordinate of a delay vector to the next.
const LAG: usize = 3;

/// A circle of radius 1 in the plane that stays.
const CIRCLE: Pose = Pose { center: [0.0; 2], turns: 0.0, radius: 1.0, missing: Missing::Nothing };

/// A cloud.
#[derive(Clone, Debug)]
pub enum Cloud {
    /// A circle in the plane.
    Circle(Wall),
    /// Uniform in a cube of side 1.
    Cube(Samples<Vec<f64>>),
    /// The last delay vectors of a noisy sine.
    Delay(Delay),
}

impl Cloud {
    /// A circle. The noise is relative to its radius.
    pub fn circle(points: u32, noise: f64, random: Random) -> Self {
        Self::Circle(Wall::new(WallPlan::new(Form::Circle, 1.0), f64::from(points) / TAU, noise, random))
    }

    /// A cube of this dimension.
    pub fn cube(dimension: u16, points: u32, random: Random) -> Self {
        Self::Cube(Samples::new(points, random, |random| in_cube(dimension, random)))
    }

    /// Replaces a share of the points.
    pub fn churn(&mut self, share: f64) {
        match self {
            Self::Circle(wall) => wall.churn(share),
            Self::Cube(samples) => {
                let dimension = samples.iter().next().map_or(0, |point| point.len() as u16);
                samples.churn(share, |random| in_cube(dimension, random));
            }
            Self::Delay(delay) => delay.advance(share),
        }
    }

    /// The points. Those of the frame before that are still there have the same places in the list.
    pub fn points(&self) -> Vec<Vec<f64>> {
        match self {
            Self::Circle(wall) => wall.points(&CIRCLE, None, 1).flatten().map(|point| point.to_vec()).collect(),
            Self::Cube(samples) => samples.iter().cloned().collect(),
            Self::Delay(delay) => delay.vectors(),
        }
    }

    /// The radius of its hole. Without a hole: infinity.
    pub fn smallest_hole(&self) -> f64 {
        self.curve().map_or(f64::INFINITY, |curve| half_diameter(&curve))
    }

    /// The persistence from which on its hole is a true one.
    pub fn above(&self) -> f64 {
        SHARE_ABOVE * self.smallest_hole()
    }

    /// The ideal holes.
    pub fn cycles(&self) -> Vec<IdealCycle> {
        let hole = |curve: Vec<Vec<f64>>| {
            let persistence = FILLED * half_diameter(&curve);
            IdealCycle { curve, orbit: None, persistence, partner: None }
        };
        self.curve().map(hole).into_iter().collect()
    }

    /// The closed curve that it is spread around.
    fn curve(&self) -> Option<Vec<Vec<f64>>> {
        match self {
            Self::Circle(_) => Some(shares().map(|share| direction(share).to_vec()).collect()),
            Self::Cube(_) => None,
            // Less than a period is not closed.
            Self::Delay(delay) if delay.points < PERIOD => None,
            Self::Delay(delay) => Some(shares().map(|share| delay.ideal(share)).collect()),
        }
    }
}

fn in_cube(dimension: u16, random: &mut Random) -> Vec<f64> {
    (0..dimension).map(|_| random.unit()).collect()
}

/// Shares of the way around a closed curve: two for each sample of a period.
fn shares() -> impl Iterator<Item = f64> {
    (0..2 * PERIOD).map(|half| f64::from(half) / f64::from(2 * PERIOD))
}

/// Delay vectors of a noisy sine.
#[derive(Clone, Debug)]
pub struct Delay {
    dimension: u16,
    /// The samples of all vectors, the oldest one first.
    series: VecDeque<f64>,
    /// Samples so far.
    drawn: u64,
    points: u32,
    /// The fraction of a sample that is still to come.
    due: f64,
    noise: f64,
    random: Random,
}

impl Delay {
    /// The first vectors. The noise is relative to the amplitude.
    pub fn new(dimension: u16, points: u32, noise: f64, random: Random) -> Self {
        let mut delay = Self { dimension, series: VecDeque::new(), drawn: 0, points, due: 0.0, noise, random };
        let samples = points as usize + (usize::from(dimension) - 1) * LAG;
        (0..samples).for_each(|_| delay.draw());
        delay
    }

    fn draw(&mut self) {
        let turns = (self.drawn % u64::from(PERIOD)) as f64 / f64::from(PERIOD);
        self.series.push_back(wave(turns) + self.noise * self.random.between(-1.0, 1.0));
        self.drawn += 1;
    }

    fn advance(&mut self, share: f64) {
        let due = self.due + share * f64::from(self.points);
        self.due = due - due.floor();
        for _ in 0..due.floor() as u64 {
            self.series.pop_front();
            self.draw();
        }
    }

    /// The vectors. Each keeps its place as long as it is there.
    fn vectors(&self) -> Vec<Vec<f64>> {
        let points = self.points as usize;
        // The place of the oldest vector.
        let oldest = ((self.drawn - self.series.len() as u64) % points as u64) as usize;
        let vector =
            |from: usize| (0..usize::from(self.dimension)).map(|axis| self.series[from + axis * LAG]).collect();
        (0..points).map(|place| vector((place + points - oldest) % points)).collect()
    }

    /// The vector without noise at a share of the period.
    fn ideal(&self, share: f64) -> Vec<f64> {
        let later = |axis: u16| f64::from(axis) * LAG as f64 / f64::from(PERIOD);
        (0..self.dimension).map(|axis| wave(share + later(axis))).collect()
    }
}
