//! A body in R^3: points on a form that moves.
//!
//! In: a form, a motion, the number of its points; for every frame the share that is drawn again.
//! Out: the points, and the ideal holes.
//! Invariants: points are spread evenly over the form, however many are drawn again: on a curve each has a piece of its
//! own, on a surface a place of a Fibonacci lattice, off by up to half of the lattice's mean step. A point that is not
//! drawn again keeps its position on the form and its noise, and moves with it.
//! Must not know: other bodies.

use super::cycle::IdealCycle;
use super::form::Form;
use super::vector::{Attitude, Tumble, Vector, moved};
use crate::scene::motion::{Cycle, Oscillation};
use crate::scene::random::Random;
use crate::scene::samples::Samples;

/// The golden ratio minus 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// One point.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// How far off it is in its piece, from 0 up to 1.
    along: [f64; 2],
    /// The position in a ball of noise of radius 1.
    noise: Vector,
}

impl Sample {
    fn draw(random: &mut Random) -> Self {
        Self { along: [random.unit(), random.unit()], noise: random.in_ball() }
    }
}

/// How a body moves.
#[derive(Clone, Debug)]
pub enum Motion {
    /// It turns around a position that moves.
    Free {
        /// The mean position.
        place: Vector,
        /// The motion around it.
        path: Oscillation<3>,
        /// How it turns.
        tumble: Tumble,
    },
    /// One of two rings across each other, on one line through both, that turn together.
    Chained {
        /// -1 for the one, 1 for the other.
        side: f64,
        /// The distance of their centres.
        apart: Cycle,
        /// How they turn together.
        tumble: Tumble,
    },
}

/// A position and an attitude.
struct Placement {
    center: Vector,
    /// The one that is done last comes last.
    attitudes: [Attitude; 2],
}

impl Motion {
    fn at(&self, frame: f64) -> Placement {
        let level = Attitude::new(0.0, 0.0);
        match self {
            Self::Free { place, path, tumble } => {
                Placement { center: moved(*place, path.at(frame), 1.0), attitudes: [level, tumble.at(frame)] }
            }
            Self::Chained { side, apart, tumble } => {
                let together = tumble.at(frame);
                let center = together.of([side * apart.at(frame) / 2.0, 0.0, 0.0]);
                let upright = if *side > 0.0 { Attitude::new(0.25, 0.0) } else { level };
                Placement { center, attitudes: [upright, together] }
            }
        }
    }
}

impl Placement {
    fn of(&self, local: Vector) -> Vector {
        let [first, second] = &self.attitudes;
        moved(self.center, second.of(first.of(local)), 1.0)
    }
}

/// A body.
#[derive(Clone, Debug)]
pub struct Body {
    form: Form,
    motion: Motion,
    samples: Samples<Sample>,
    /// The radius of the noise.
    noise: f64,
}

impl Body {
    /// A body with so many points. `noise` is relative to the form's unit.
    pub fn new(form: Form, motion: Motion, points: u32, noise: f64, random: Random) -> Self {
        let noise = noise * form.unit();
        Self { form, motion, samples: Samples::new(points, random, Sample::draw), noise }
    }

    /// Draws a share of the points again.
    pub fn churn(&mut self, share: f64) {
        self.samples.churn(share, Sample::draw);
    }

    /// The smallest radius that one of its holes ever has.
    pub fn smallest_hole(&self) -> f64 {
        self.form.smallest_hole()
    }

    /// The persistence from which on its holes are true ones.
    pub fn above(&self) -> f64 {
        self.form.above()
    }

    /// Every point in a frame. None: it is on a part that is missing.
    pub fn points(&self, frame: f64) -> impl Iterator<Item = Option<Vector>> {
        let (outline, placement) = (self.form.at(frame), self.motion.at(frame));
        (0..).zip(self.samples.iter()).map(move |(number, sample)| {
            let ideal = outline.place(self.shares(number, sample))?;
            Some(placement.of(moved(ideal, sample.noise, self.noise)))
        })
    }

    /// The ideal holes in a frame.
    pub fn cycles(&self, frame: f64) -> Vec<IdealCycle> {
        let placement = self.motion.at(frame);
        self.form.at(frame).cycles(|local| placement.of(local))
    }

    /// Where on the form a sample is.
    fn shares(&self, number: u32, sample: &Sample) -> [f64; 2] {
        let count = self.samples.len() as f64;
        let number = f64::from(number);
        if !self.form.is_surface() {
            return [(number + sample.along[0]) / count, 0.0];
        }
        let step = 1.0 / count.sqrt();
        let [along, across] = sample.along.map(|off| (off - 0.5) * step);
        let turns = number * GOLDEN;
        [(number + 0.5) / count + along, turns - turns.floor() + across]
    }
}
