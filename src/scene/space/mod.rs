//! Scenes in R^d: points on curves, surfaces and knots that move, and their true holes.
//!
//! In: a kind and [`SpaceOptions`]. Out: an endless sequence of frames: points with so many coordinates, and the true
//! holes, each with a shortest closed curve around it.
//!
//! ```text
//! kind ─▶ bodies (form, motion, samples) ─▶ points           ─▶ all points, and the difference
//!                                        └▶ ideal holes      ─▶ truth (ids and events)
//! ```
//!
//! A hole here is a class of closed curves of the Vietoris-Rips filtration, by radii: an edge enters at half its
//! length. There a circle of radius r is filled at r times half the root of 3. The curves are those of the shape:
//!
//! | scene | shape | true holes |
//! | --- | --- | --- |
//! | torus | a circle of radius 1 in the middle of a tube of 0.45, which swells by 15% | around the tube: its curve may be anywhere along the orbit of radius 1; around the middle: the inner equator |
//! | trefoil | twice around such a torus with a tube of 0.5, three times around the tube | the knot |
//! | rings3 | 3 circles of radius 0.8 to 1.2 | the circles |
//! | links | 2 circles of radius 1 | the circles |
//! | pinch3 | the boundary of two discs that overlap, touch and part | the boundary, or its two lobes |
//! | circle | radius 1 | the circle |
//! | sphere, cube:D | radius 1; side 1 | none |
//! | delay:D | delay vectors of a sine of amplitude 1, 120 samples a period, lag 3 | the closed curve of a period, if there are so many points |
//!
//! Too few points have other holes than the shape: a torus needs 500, links, a knot and a pinch 200.
//!
//! Invariants: those of [`super`]. A frame has as many points as are asked for, but for those on parts of a curve that
//! are not there while it pinches.
//!
//! Must not know: scenes in the plane but for two discs, formats, clocks.

mod body;
mod cloud;
mod cycle;
mod form;
mod kind;
mod vector;

use body::Body;
use cycle::IdealCycle;
pub use cycle::TrueCycle;
use kind::Content;
pub use kind::SpaceKind;

use super::frame::Frame;
use super::random::Random;
use super::truth::TruthTracker;
use super::{OptionError, check_churn, check_noise};

/// Points of a frame. Fewer are a loose scatter.
pub const POINTS: std::ops::RangeInclusive<u32> = 3..=100_000;

/// The largest number of coordinates of all points of a frame.
const MOST_COORDINATES: u64 = 4_000_000;

/// The scale at which a circle of radius 1 is filled: half the side of its largest triangle.
const FILLED: f64 = 0.866_025_403_784_438_6;

/// A hole around a circle is a true hole from this persistence on, as a share of the smallest radius. Linked rings fill
/// each other earlier than one in the plane.
const SHARE_ABOVE: f64 = 0.2;

/// The parameters of a scene in R^d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceOptions {
    /// The seed of all random numbers.
    pub seed: u64,
    /// Points of a frame: 3 to 100,000.
    pub points: u32,
    /// Each point lies uniformly in a ball around its position on the shape. This is the ball's radius as a share of
    /// the hole's smallest radius: 0 to 0.3. Of a knot: of the tube that it goes around. Delay vectors: each sample is
    /// off by at most this share of the amplitude. A cube has no noise.
    pub noise: f64,
    /// The share of each body's points that is drawn again in every frame: 0.01 to 1. Delay vectors move on by it.
    pub churn: f64,
    /// Whether points come in random order instead of along the shapes.
    pub shuffle: bool,
}

impl Default for SpaceOptions {
    fn default() -> Self {
        Self { seed: 1, points: 500, noise: 0.1, churn: 0.1, shuffle: false }
    }
}

/// A running scene in R^d.
///
/// ```
/// use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene};
///
/// let mut scene = SpaceScene::new(SpaceKind::Torus, SpaceOptions::default())?;
/// let frame = scene.next_frame();
/// assert_eq!((frame.points.len(), frame.points[0].len(), frame.holes.len()), (500, 3, 2));
/// # Ok::<(), hopes::scene::OptionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SpaceScene {
    options: SpaceOptions,
    content: Content,
    /// Each point as it was seen in the previous frame.
    seen: Vec<Option<Vec<f64>>>,
    truth: TruthTracker,
    order: Random,
    number: u64,
}

impl SpaceScene {
    /// A scene before its first frame.
    ///
    /// # Errors
    /// [`OptionError`]: an option is out of its range.
    pub fn new(kind: SpaceKind, options: SpaceOptions) -> Result<Self, OptionError> {
        options.check(kind)?;
        let mut random = Random::new(options.seed);
        let order = random.fork();
        let content = kind.content(options.points, options.noise, &mut random);
        let truth = TruthTracker::new(content.above());
        Ok(Self { options, content, seen: Vec::new(), truth, order, number: 0 })
    }

    /// The smallest radius that a hole ever has. None: there are no true holes.
    pub fn smallest_radius(&self) -> Option<f64> {
        finite(self.content.smallest_radius())
    }

    /// The persistence from which on a hole of the ideal shape is a true hole. None: there are no true holes.
    pub fn above(&self) -> Option<f64> {
        finite(self.content.above())
    }

    /// The next frame. A scene has no end.
    pub fn next_frame(&mut self) -> Frame<Vec<f64>, TrueCycle> {
        if self.number > 0 {
            self.content.churn(self.options.churn);
        }
        self.number += 1;
        let moment = self.number as f64;
        let mut frame = Frame::new(self.number, self.truth.advance(&self.content.cycles(moment)));
        frame.show(&mut self.seen, self.content.points(moment));
        if self.options.shuffle {
            frame.shuffle(&mut self.order);
        }
        frame
    }
}

impl Content {
    fn churn(&mut self, share: f64) {
        match self {
            Self::Bodies(bodies) => bodies.iter_mut().for_each(|body| body.churn(share)),
            Self::Cloud(cloud) => cloud.churn(share),
        }
    }

    fn points(&self, moment: f64) -> Vec<Option<Vec<f64>>> {
        let of_body =
            |body: &Body| body.points(moment).map(|point| point.map(|point| point.to_vec())).collect::<Vec<_>>();
        match self {
            Self::Bodies(bodies) => bodies.iter().flat_map(of_body).collect(),
            Self::Cloud(cloud) => cloud.points().into_iter().map(Some).collect(),
        }
    }

    fn cycles(&self, moment: f64) -> Vec<IdealCycle> {
        match self {
            Self::Bodies(bodies) => bodies.iter().flat_map(|body| body.cycles(moment)).collect(),
            Self::Cloud(cloud) => cloud.cycles(),
        }
    }

    fn smallest_radius(&self) -> f64 {
        match self {
            Self::Bodies(bodies) => bodies.iter().map(Body::smallest_hole).fold(f64::INFINITY, f64::min),
            Self::Cloud(cloud) => cloud.smallest_hole(),
        }
    }

    fn above(&self) -> f64 {
        match self {
            Self::Bodies(bodies) => bodies.iter().map(Body::above).fold(f64::INFINITY, f64::min),
            Self::Cloud(cloud) => cloud.above(),
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

impl SpaceOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`OptionError`]: which option is out of its range.
    pub fn check(&self, kind: SpaceKind) -> Result<(), OptionError> {
        if !POINTS.contains(&self.points) {
            return Err(OptionError::Points(self.points));
        }
        let dimension = kind.dimension();
        if !kind.has_dimension() {
            return Err(OptionError::Dimension(dimension));
        }
        if u64::from(self.points) * dimension as u64 > MOST_COORDINATES {
            return Err(OptionError::Coordinates { points: self.points, dimension });
        }
        check_noise(self.noise)?;
        check_churn(self.churn)
    }
}
