//! Scenes with ground truth: points on walls that move, and which holes they truly have.
//!
//! In: a scene's name and [`Options`]. Out: [`Frame`]s without an end, each with its cloud, what changed in it, the
//! true holes under ids that last, and what happened to them.
//!
//! ```text
//! script ─▶ actors ─▶ how walls stand ─▶ points on them          ─▶ cloud, and its change
//! (cast)   (motion) └▶ ideal holes     ─▶ truth (ids and events)
//! ```
//!
//! Invariants: what comes depends on the name and the options alone, and is the same on every machine, bit for bit; a
//! frame costs what its points do, and no memory grows with time. Must not know: the topology of clouds, formats,
//! files, clocks.

mod actor;
mod motion;
mod random;
mod script;
mod truth;
mod turn;
mod wall;

use thiserror::Error;

use actor::{Actor, Tableau};
use random::Random;
use script::{Cast, cast};
pub use script::{Kind, UnknownScene};
use truth::Chronicle;
pub use truth::{TrueEvent, TrueHole};
use wall::{Stand, Wall};

/// Frames in a second of event time.
pub const FRAMES_A_SECOND: f64 = 30.0;

/// Noise, at the most: a share of the radius.
pub const MOST_NOISE: f64 = 0.3;

/// Churn, at the least: a share of the points.
pub const LEAST_CHURN: f64 = 0.01;

/// Points to a length of a radius: few enough to be nothing but a scatter, and so many that a scene fills memory.
pub const DENSITIES: std::ops::RangeInclusive<u32> = 2..=10_000;

/// A hole counts if it has this share of the smallest radius as its persistence.
const SHARE_ABOVE: f64 = 0.4;

/// How a scene is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Of all that is random.
    pub seed: u64,
    /// So many points to a length of the radius of a hole, along its wall: 2 to 10,000.
    pub points_per_radius: u32,
    /// Each point lies, uniformly, within a disc around its place on the wall; the radius of that disc as a share of
    /// the hole's: 0 to 0.3.
    pub noise: f64,
    /// This share of each wall's points is drawn anew in every frame: 0.01 to 1.
    pub churn: f64,
    /// Whether points come in a random order, instead of along the walls.
    pub shuffle: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, points_per_radius: 16, noise: 0.1, churn: 0.1, shuffle: false }
    }
}

/// Options that no scene can be played with.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OptionError {
    /// [`Options::points_per_radius`].
    #[error("{0} points per radius are too few or too many: take 2 to 10000")]
    PointsPerRadius(u32),
    /// [`Options::noise`].
    #[error("a noise of {0} is no share of a radius that leaves a hole: take 0 to 0.3")]
    Noise(f64),
    /// [`Options::churn`].
    #[error("a churn of {0} is no share of points to draw anew: take 0.01 to 1")]
    Churn(f64),
}

/// A frame of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Counts from 1.
    pub number: u64,
    /// Event time, in seconds.
    pub time: f64,
    /// All points.
    pub points: Vec<[f64; 2]>,
    /// Points of the frame before that are not there any more.
    pub gone: Vec<[f64; 2]>,
    /// Points that were not there in the frame before.
    pub come: Vec<[f64; 2]>,
    /// What holes there truly are, by id.
    pub holes: Vec<TrueHole>,
    /// What happened to them.
    pub events: Vec<TrueEvent>,
}

/// A scene that is played.
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
    cast: Cast,
    options: Options,
    walls: Vec<Wall>,
    tableau: Tableau,
    /// Each point of each wall, where it could be seen in the frame before.
    seen: Vec<Option<[f64; 2]>>,
    chronicle: Chronicle,
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
        let cast = cast(kind, &mut random.fork());
        let order = random.fork();
        let wall = |(form, size)| {
            let density = f64::from(options.points_per_radius) * size;
            Wall::new(form, density, options.noise / size, random.fork())
        };
        let walls = cast.actors.iter().flat_map(Actor::walls).map(wall).collect();
        let smallest_radius = cast.actors.iter().map(Actor::least).fold(f64::INFINITY, f64::min);
        Ok(Self {
            cast,
            options,
            walls,
            tableau: Tableau::default(),
            seen: Vec::new(),
            chronicle: Chronicle::new(SHARE_ABOVE * smallest_radius),
            smallest_radius,
            order,
            number: 0,
        })
    }

    /// The least radius that a hole ever has.
    pub fn smallest_radius(&self) -> f64 {
        self.smallest_radius
    }

    /// The persistence from which on a hole of the ideal shape is a true hole.
    pub fn above(&self) -> f64 {
        SHARE_ABOVE * self.smallest_radius
    }

    /// The next frame. There always is one.
    pub fn next_frame(&mut self) -> Frame {
        if self.number > 0 {
            self.walls.iter_mut().for_each(|wall| wall.churn(self.options.churn));
        }
        self.number += 1;
        let moment = self.number as f64;
        self.play(moment);
        let (holes, events) = self.chronicle.write(&self.tableau.ideals);
        let time = moment / FRAMES_A_SECOND;
        let mut frame = Frame { number: self.number, time, holes, events, ..Frame::default() };
        self.show(moment, &mut frame);
        if self.options.shuffle {
            for points in [&mut frame.points, &mut frame.gone, &mut frame.come] {
                let count = points.len();
                self.order.choose(points, count);
            }
        }
        frame
    }

    fn play(&mut self, moment: f64) {
        let Tableau { stands, ideals } = &mut self.tableau;
        stands.clear();
        ideals.clear();
        let drift = self.cast.drift.at(moment);
        for actor in &self.cast.actors {
            actor.play(moment, drift, &mut self.tableau);
        }
    }

    /// Looks at all points, and at how that differs from the frame before.
    fn show(&mut self, moment: f64, frame: &mut Frame) {
        let bar = self.cast.sweep.map(|sweep| sweep.at(moment));
        let points = |(wall, stand): (&Wall, &Stand)| wall.points(stand, bar).collect::<Vec<_>>();
        let seen: Vec<Option<[f64; 2]>> = self.walls.iter().zip(&self.tableau.stands).flat_map(points).collect();
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
    /// Whether a scene can be played with them.
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
