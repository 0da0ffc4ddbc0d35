//! Scenes with ground truth: points on moving walls, and the true holes of those walls.
//!
//! In: a kind of scene and its options. Out: an endless sequence of [`Frame`]s. Each has its points, the difference
//! from the previous frame, the true holes with lasting ids, and their events.
//!
//! There are three families. A [`Scene`] is in the plane. A [`space::SpaceScene`] is in R^d. A [`signal::Signal`] is a
//! series of numbers. [`AnyKind`] knows the kinds of all three by name. A scene in the plane:
//!
//! ```text
//! composition ─▶ shapes ─▶ poses of walls ─▶ points on them           ─▶ all points, and the difference
//!               (motion)  └▶ ideal holes   ─▶ truth (ids and events)
//! ```
//!
//! Stray points ([`Options::clutter`]) lie around the walls' points. A [`Camera`] then moves all points and all holes.
//!
//! Invariants: the frames depend only on the kind and the options, and are the same on every machine, bit for bit. The
//! cost of a frame is in proportion to its points. Memory does not grow with time.
//!
//! Must not know: the topology of clouds, formats, files, clocks.

mod camera;
mod catalog;
mod clutter;
mod composition;
mod frame;
mod motion;
mod random;
mod samples;
mod shape;
pub mod signal;
pub mod space;
mod truth;
mod turn;
mod wall;

use thiserror::Error;

pub use camera::{Camera, MOST_SPEED, Motion, UnknownCamera};
pub use catalog::{AnyKind, UnknownScene};
use clutter::Clutter;
pub use composition::Kind;
use composition::{Composition, compose};
pub use frame::Frame;
use random::Random;
use shape::{Layout, Shape};
use truth::TruthTracker;
pub use truth::{TrueEvent, TrueHole};
use turn::moved;
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
    /// How the whole picture moves. None: it rests.
    pub camera: Option<Camera>,
    /// Stray points for each point of a wall, uniformly distributed in the bounding box: 0 to 1. The truth is without
    /// them.
    pub clutter: f64,
    /// Whether stray points come in clumps of 2 to 6 instead of alone.
    pub clumps: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            seed: 1,
            points_per_radius: 16,
            noise: 0.1,
            churn: 0.1,
            shuffle: false,
            camera: None,
            clutter: 0.0,
            clumps: false,
        }
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
    /// [`Options::clutter`].
    #[error("a clutter of {0}: the stray points for each point of a wall must be 0 to 1")]
    Clutter(f64),
    /// [`space::SpaceOptions::points`].
    #[error("{0} points: it must be 3 to 100000")]
    Points(u32),
    /// The dimension of a [`space::SpaceKind`].
    #[error("{0} coordinates: a cube has 1 to 4096, delay vectors have 2 to 100")]
    Dimension(usize),
    /// The points of a frame have too many coordinates in all.
    #[error("{points} points of {dimension} coordinates: a frame has at most 4000000 coordinates")]
    Coordinates {
        /// [`space::SpaceOptions::points`].
        points: u32,
        /// Coordinates of a point.
        dimension: usize,
    },
    /// [`signal::SignalOptions::samples`].
    #[error("{0} samples in a frame: it must be 1 to 120, so that no frame has two changes")]
    Samples(u32),
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
    /// The same of stray points.
    seen_clutter: Vec<Option<[f64; 2]>>,
    clutter: Clutter,
    camera: Option<camera::Path>,
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
        let density = f64::from(options.points_per_radius);
        let wall = |plan| Wall::new(plan, density, options.noise, random.fork());
        let walls = composition.shapes.iter().flat_map(Shape::walls).map(wall).collect();
        let smallest_radius = composition.shapes.iter().map(Shape::smallest_hole).fold(f64::INFINITY, f64::min);
        let (camera_random, clutter_random) = (random.fork(), random.fork());
        let path = |camera| camera::Path::new(camera, smallest_radius, composition.half, camera_random);
        let camera = options.camera.map(path);
        let clutter = Clutter::new(options.clutter, options.clumps, smallest_radius, clutter_random);
        let smallest_radius = smallest_radius * options.camera.map_or(1.0, Camera::least_scale);
        Ok(Self {
            composition,
            options,
            walls,
            layout: Layout::default(),
            seen: Vec::new(),
            seen_clutter: Vec::new(),
            clutter,
            camera,
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
        let mut walls = self.visible_points(moment);
        let mut clutter = self.stray_points(&walls, moment);
        if let Some(camera) = &mut self.camera {
            let view = camera.next_view(moment);
            self.layout.holes.iter_mut().for_each(|hole| *hole = view.hole(hole));
            walls.iter_mut().chain(&mut clutter).flatten().for_each(|point| *point = view.place(*point));
        }
        let mut frame = Frame::new(self.number, self.truth.advance(&self.layout.holes));
        frame.clutter = clutter.iter().flatten().count();
        frame.show(&mut self.seen, walls);
        frame.show(&mut self.seen_clutter, clutter);
        if self.options.shuffle {
            frame.shuffle(&mut self.order);
        }
        frame
    }

    /// Stray points around the walls' points. They move with the whole scene.
    fn stray_points(&mut self, walls: &[Option<[f64; 2]>], moment: f64) -> Vec<Option<[f64; 2]>> {
        let drift = self.composition.drift.at(moment);
        let at_rest = walls.iter().flatten().map(|&point| moved(point, drift, -1.0));
        self.clutter.advance(self.options.churn, at_rest);
        self.clutter.points().map(|point| point.map(|point| moved(point, drift, 1.0))).collect()
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

    /// Each point of each wall as it is seen in a frame.
    fn visible_points(&self, moment: f64) -> Vec<Option<[f64; 2]>> {
        let bar = self.composition.sweep.map(|sweep| sweep.at(moment));
        let stride = self.composition.stride(moment);
        let points = |(wall, pose): (&Wall, &Pose)| wall.points(pose, bar, stride).collect::<Vec<_>>();
        self.walls.iter().zip(&self.layout.poses).flat_map(points).collect()
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
        check_noise(self.noise)?;
        check_churn(self.churn)?;
        if (0.0..=1.0).contains(&self.clutter) { Ok(()) } else { Err(OptionError::Clutter(self.clutter)) }
    }
}

fn check_noise(noise: f64) -> Result<(), OptionError> {
    if (0.0..=MOST_NOISE).contains(&noise) { Ok(()) } else { Err(OptionError::Noise(noise)) }
}

fn check_churn(churn: f64) -> Result<(), OptionError> {
    if (LEAST_CHURN..=1.0).contains(&churn) { Ok(()) } else { Err(OptionError::Churn(churn)) }
}
