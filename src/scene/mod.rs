//! Scenes with ground truth: points on moving walls, and the true holes of those walls.
//!
//! In: a kind of scene and [`Options`]. Out: an endless sequence of [`Frame`]s. Each has its points, the difference
//! from the previous frame, the true holes with lasting ids, and their events.
//!
//! ```text
//! composition ─▶ shapes ─▶ poses of walls ─▶ points on them           ─▶ all points, and the difference
//!               (motion)  └▶ ideal holes   ─▶ truth (ids and events)
//! ```
//!
//! Invariants: the frames depend only on the kind and the options, and are the same on every machine, bit for bit. The
//! cost of a frame is in proportion to its points. Memory does not grow with time.
//!
//! Must not know: the topology of clouds, formats, files, clocks.

mod composition;
mod motion;
mod random;
mod shape;
mod truth;
mod turn;
mod wall;

use thiserror::Error;

use composition::{Composition, compose};
pub use composition::{Kind, UnknownScene};
use random::Random;
use shape::{Layout, Shape};
use truth::TruthTracker;
pub use truth::{TrueEvent, TrueHole};
use wall::{Pose, Wall};

/// Frames in a second of event time.
pub const FRAMES_A_SECOND: f64 = 30.0;

/// The largest noise, as a share of the radius.
pub const MOST_NOISE: f64 = 0.3;

/// The smallest churn, as a share of the points.
pub const LEAST_CHURN: f64 = 0.01;

/// Points in a length of one radius. With the fewest a wall is a loose scatter; with the most a scene fills the memory.
pub const DENSITIES: std::ops::RangeInclusive<u32> = 2..=10_000;

/// A hole of the ideal shape is a true hole from this persistence on, as a share of the smallest radius.
const SHARE_ABOVE: f64 = 0.4;

/// The parameters of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The seed of all random numbers.
    pub seed: u64,
    /// Points along a wall in a length of the hole's radius: 2 to 10,000.
    pub points_per_radius: u32,
    /// Each point lies uniformly in a disc around its position on the wall. This is the disc's radius as a share of the
    /// hole's radius: 0 to 0.3.
    pub noise: f64,
    /// The share of each wall's points that is drawn again in every frame: 0.01 to 1.
    pub churn: f64,
    /// Whether points come in random order instead of along the walls.
    pub shuffle: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, points_per_radius: 16, noise: 0.1, churn: 0.1, shuffle: false }
    }
}

/// An option that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OptionError {
    /// [`Options::points_per_radius`].
    #[error("{0} points per radius: it must be 2 to 10000")]
    PointsPerRadius(u32),
    /// [`Options::noise`].
    #[error("a noise of {0}: it must be 0 to 0.3 of a radius, so that holes stay open")]
    Noise(f64),
    /// [`Options::churn`].
    #[error("a churn of {0}: the share of points that are drawn again must be 0.01 to 1")]
    Churn(f64),
}

/// A frame of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Counts frames from 1.
    pub number: u64,
    /// Event time, in seconds.
    pub time: f64,
    /// All points of the frame.
    pub points: Vec<[f64; 2]>,
    /// Points of the previous frame that are no longer there.
    pub gone: Vec<[f64; 2]>,
    /// Points that were not in the previous frame.
    pub come: Vec<[f64; 2]>,
    /// The true holes, by id.
    pub holes: Vec<TrueHole>,
    /// The events of the true holes.
    pub events: Vec<TrueEvent>,
}

/// A running scene.
///
/// ```
/// use hopes::scene::{Kind, Options, Scene, TrueEvent};
///
/// let mut scene = Scene::new(Kind::Pinch, Options { noise: 0.05, ..Options::default() })?;
/// let frames: Vec<_> = (0..200).map(|_| scene.next_frame()).collect();
/// assert!(frames.iter().flat_map(|frame| &frame.events).any(|event| matches!(event, TrueEvent::Split { .. })));
/// # Ok::<(), hopes::scene::OptionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    composition: Composition,
    options: Options,
    walls: Vec<Wall>,
    layout: Layout,
    /// Each point of each wall as it was seen in the previous frame.
    seen: Vec<Option<[f64; 2]>>,
    truth: TruthTracker,
    smallest_radius: f64,
    order: Random,
    number: u64,
}

impl Scene {
    /// A scene before its first frame.
    ///
    /// # Errors
    /// [`OptionError`]: an option is out of its range.
    pub fn new(kind: Kind, options: Options) -> Result<Self, OptionError> {
        options.check()?;
        let mut random = Random::new(options.seed);
        let composition = compose(kind, &mut random.fork());
        let order = random.fork();
        let wall = |(form, size)| {
            let density = f64::from(options.points_per_radius) * size;
            Wall::new(form, density, options.noise / size, random.fork())
        };
        let walls = composition.shapes.iter().flat_map(Shape::walls).map(wall).collect();
        let smallest_radius = composition.shapes.iter().map(Shape::smallest_hole).fold(f64::INFINITY, f64::min);
        Ok(Self {
            composition,
            options,
            walls,
            layout: Layout::default(),
            seen: Vec::new(),
            truth: TruthTracker::new(SHARE_ABOVE * smallest_radius),
            smallest_radius,
            order,
            number: 0,
        })
    }

    /// The smallest radius that a hole ever has.
    pub fn smallest_radius(&self) -> f64 {
        self.smallest_radius
    }

    /// The persistence from which on a hole of the ideal shape is a true hole.
    pub fn above(&self) -> f64 {
        SHARE_ABOVE * self.smallest_radius
    }

    /// The next frame. A scene has no end.
    pub fn next_frame(&mut self) -> Frame {
        if self.number > 0 {
            self.walls.iter_mut().for_each(|wall| wall.churn(self.options.churn));
        }
        self.number += 1;
        let moment = self.number as f64;
        self.update_layout(moment);
        let (holes, events) = self.truth.advance(&self.layout.holes);
        let time = moment / FRAMES_A_SECOND;
        let mut frame = Frame { number: self.number, time, holes, events, ..Frame::default() };
        self.collect_points(moment, &mut frame);
        if self.options.shuffle {
            for points in [&mut frame.points, &mut frame.gone, &mut frame.come] {
                let count = points.len();
                self.order.choose(points, count);
            }
        }
        frame
    }

    fn update_layout(&mut self, moment: f64) {
        let Layout { poses, holes } = &mut self.layout;
        poses.clear();
        holes.clear();
        let drift = self.composition.drift.at(moment);
        for shape in &self.composition.shapes {
            shape.add_to(moment, drift, &mut self.layout);
        }
    }

    /// Collects the visible points of a frame, and the differences from the previous frame.
    fn collect_points(&mut self, moment: f64, frame: &mut Frame) {
        let bar = self.composition.sweep.map(|sweep| sweep.at(moment));
        let points = |(wall, pose): (&Wall, &Pose)| wall.points(pose, bar).collect::<Vec<_>>();
        let seen: Vec<Option<[f64; 2]>> = self.walls.iter().zip(&self.layout.poses).flat_map(points).collect();
        self.seen.resize(seen.len(), None);
        for (&before, &now) in self.seen.iter().zip(&seen) {
            frame.points.extend(now);
            if before != now {
                frame.gone.extend(before);
                frame.come.extend(now);
            }
        }
        self.seen = seen;
    }
}

impl Options {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`OptionError`]: which option is out of its range.
    pub fn check(&self) -> Result<(), OptionError> {
        if !DENSITIES.contains(&self.points_per_radius) {
            return Err(OptionError::PointsPerRadius(self.points_per_radius));
        }
        if !(0.0..=MOST_NOISE).contains(&self.noise) {
            return Err(OptionError::Noise(self.noise));
        }
        if !(LEAST_CHURN..=1.0).contains(&self.churn) {
            return Err(OptionError::Churn(self.churn));
        }
        Ok(())
    }
}
