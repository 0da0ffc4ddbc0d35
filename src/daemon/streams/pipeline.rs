//! The engine of a stream, in the plane or in any other space, behind one face.
//!
//! In: points of any dimension, commits, followers.
//! Out: what the core's pipelines give.
//! Invariants: a point of another dimension than the stream's is refused like any other point that cannot be used. What
//! waits of a source waits for the stream that it was made for.
//! Must not know: queues, replies, connections.

use hopes::topology::spaces::{Metric, SpaceError};
use hopes::topology::{
    Admission, Contradiction, Coordinates, Follower, Options, Pipeline, PointError, Ranking, Refusal, Region,
    SimplifiedFollower, SpaceOptions, SpacePipeline, SpaceTrackStep, SpaceTracker, Stage, Staging, Step, TrackId,
    TrackStep, Tracker, VertexId, Window,
};

use super::input::Point;

/// The space of a stream, and which points it keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PipelineOptions {
    /// Which points stay.
    pub window: Window,
    /// The step of the grid that positions are snapped to, if any.
    pub resolution: Option<f64>,
    /// The space, if it is not the plane.
    pub space: Option<SpaceRule>,
}

/// A metric space of points, by its Vietoris-Rips filtration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceRule {
    /// The metric.
    pub metric: Metric,
    /// The number of coordinates of a point. Without it, that of the first point.
    pub dimension: Option<usize>,
    /// The most distinct points.
    pub max_vertices: usize,
}

impl SpaceRule {
    /// The number of coordinates of a point, if it is known before the first one.
    pub fn known_dimension(self) -> Option<usize> {
        self.dimension.or((self.metric == Metric::Haversine).then_some(2))
    }

    fn options(self, window: Window, resolution: Option<f64>) -> SpaceOptions {
        let Self { metric, dimension, max_vertices } = self;
        SpaceOptions { metric, dimension, window, resolution, max_vertices, threshold: None }
    }
}

/// The engine of a stream.
pub enum AnyPipeline {
    /// In the plane.
    Plane(Box<Pipeline>),
    /// In R^d.
    Space(Box<SpacePipeline>),
}

/// What waits of one source.
#[derive(Debug)]
pub enum Waiting {
    /// Points of the plane.
    Plane(Staging),
    /// Points of R^d.
    Space(Staging<Coordinates>),
}

/// Calls the same of either engine.
macro_rules! either {
    ($any:expr, $name:ident => $call:expr) => {
        match $any {
            AnyPipeline::Plane($name) => $call,
            AnyPipeline::Space($name) => $call,
        }
    };
}

impl AnyPipeline {
    /// A stream without points.
    ///
    /// # Errors
    /// The dimension does not suit the metric.
    pub fn new(options: PipelineOptions) -> Result<Self, SpaceError> {
        let PipelineOptions { window, resolution, space } = options;
        Ok(match space {
            None => Self::Plane(Box::new(Pipeline::new(Options { window, resolution, ..Options::default() }))),
            Some(rule) => Self::Space(Box::new(SpacePipeline::new(rule.options(window, resolution))?)),
        })
    }

    /// Nothing that waits, for a source of this stream.
    pub fn waiting(&self) -> Waiting {
        match self {
            Self::Plane(_) => Waiting::Plane(Staging::default()),
            Self::Space(_) => Waiting::Space(Staging::default()),
        }
    }

    /// Sets what is called at the begin of each stage of a frame.
    pub fn set_stage_listener(&mut self, listener: impl Fn(Stage) + Send + Sync + 'static) {
        either!(self, pipeline => pipeline.set_stage_listener(listener));
    }

    /// Fixes the number of coordinates of a point, if it is not fixed.
    pub fn fix_dimension(&mut self, dimension: u32) {
        if let Self::Space(pipeline) = self {
            pipeline.fix_dimension(dimension as usize);
        }
    }

    /// Adds a point with its event time.
    ///
    /// # Errors [`Refusal`].
    pub fn feed_point(&mut self, point: Point, time: Option<f64>) -> Result<VertexId, Refusal> {
        match self {
            Self::Plane(pipeline) => planar(point).and_then(|[x, y]| pipeline.feed_point(x, y, time)),
            Self::Space(pipeline) => point.with_coordinates(|point| pipeline.feed_point(point, time)),
        }
    }

    /// Retracts the oldest point at a position.
    ///
    /// # Errors [`Refusal`].
    pub fn feed_retraction(&mut self, point: Point) -> Result<(), Refusal> {
        match self {
            Self::Plane(pipeline) => planar(point).and_then(|[x, y]| pipeline.feed_retraction(x, y)),
            Self::Space(pipeline) => point.with_coordinates(|point| pipeline.feed_retraction(point)),
        }
    }

    /// Has a point of a source wait for the source's commit.
    ///
    /// # Errors [`Refusal`].
    pub fn stage_point(&mut self, waiting: &mut Waiting, point: Point, time: Option<f64>) -> Result<VertexId, Refusal> {
        match (self, waiting) {
            (Self::Plane(pipeline), Waiting::Plane(staging)) => {
                planar(point).and_then(|[x, y]| pipeline.stage_point(staging, x, y, time))
            }
            (Self::Space(pipeline), Waiting::Space(staging)) => {
                point.with_coordinates(|point| pipeline.stage_point(staging, point, time))
            }
            _ => unreachable!("{MADE_HERE}"),
        }
    }

    /// Has a retraction of a source wait for the source's commit.
    ///
    /// # Errors [`Refusal`].
    pub fn stage_retraction(&mut self, waiting: &mut Waiting, point: Point) -> Result<(), Refusal> {
        match (self, waiting) {
            (Self::Plane(pipeline), Waiting::Plane(staging)) => {
                planar(point).and_then(|[x, y]| pipeline.stage_retraction(staging, x, y))
            }
            (Self::Space(pipeline), Waiting::Space(staging)) => {
                point.with_coordinates(|point| pipeline.stage_retraction(staging, point))
            }
            _ => unreachable!("{MADE_HERE}"),
        }
    }

    /// Feeds what waits of a source, at its commit with a time.
    pub fn feed_staged(
        &mut self,
        waiting: &mut Waiting,
        time: Option<f64>,
        refused: &mut dyn FnMut(usize, Refusal),
    ) -> Admission {
        match (self, waiting) {
            (Self::Plane(pipeline), Waiting::Plane(staging)) => pipeline.feed_staged(staging, time, refused),
            (Self::Space(pipeline), Waiting::Space(staging)) => pipeline.feed_staged(staging, time, refused),
            _ => unreachable!("{MADE_HERE}"),
        }
    }

    /// Forgets what waits of a source that has ended.
    pub fn discard_staged(&mut self, waiting: &mut Waiting) {
        match (self, waiting) {
            (Self::Plane(pipeline), Waiting::Plane(staging)) => pipeline.discard_staged(staging),
            (Self::Space(pipeline), Waiting::Space(staging)) => pipeline.discard_staged(staging),
            _ => unreachable!("{MADE_HERE}"),
        }
    }

    /// The newest event time that is believed.
    pub fn event_time(&self) -> Option<f64> {
        either!(self, pipeline => pipeline.event_time())
    }

    /// Moves event time forward without a point.
    ///
    /// # Errors [`Refusal::TimeNotFinite`].
    pub fn feed_time(&mut self, time: f64) -> Result<(), Refusal> {
        either!(self, pipeline => pipeline.feed_time(time))
    }

    /// Closes the frame with a time. Returns its number.
    pub fn commit(&mut self, time: Option<f64>) -> u64 {
        either!(self, pipeline => pipeline.commit(time))
    }

    /// What changed in a view up to the newest frame.
    pub fn poll_step(&mut self, follower: &mut Follower) -> Option<Step> {
        either!(self, pipeline => pipeline.poll_step(follower))
    }

    /// What changed in a simplified view up to the newest frame.
    pub fn poll_simplified(&mut self, follower: &mut SimplifiedFollower) -> Option<Step> {
        either!(self, pipeline => pipeline.poll_simplified(follower))
    }

    /// The events of a tracker's tracks up to the newest frame; none in a space.
    pub fn poll_tracks(&mut self, tracker: &mut Tracker) -> Option<TrackStep> {
        if let Self::Plane(pipeline) = self { pipeline.poll_tracks(tracker) } else { None }
    }

    /// The same in a space; none in the plane.
    pub fn poll_space_tracks(&mut self, tracker: &mut SpaceTracker) -> Option<SpaceTrackStep> {
        if let Self::Space(pipeline) = self { pipeline.poll_tracks(tracker) } else { None }
    }

    /// The regions of the holes of a tracker's tracks; none in a space.
    pub fn track_regions(&mut self, tracker: &Tracker) -> Vec<(TrackId, Region)> {
        if let Self::Plane(pipeline) = self { pipeline.track_regions(tracker) } else { Vec::new() }
    }

    /// The cycles of a tracker's tracks in a space; none in the plane.
    pub fn track_cycles(&self, tracker: &SpaceTracker) -> Vec<(TrackId, Vec<VertexId>)> {
        if let Self::Space(pipeline) = self { pipeline.track_cycles(tracker) } else { Vec::new() }
    }

    /// The most persistent dots of the newest frame.
    pub fn poll_dots(&mut self, most: usize) -> Ranking {
        either!(self, pipeline => pipeline.poll_dots(most))
    }

    /// The number of the newest frame.
    pub fn committed(&self) -> u64 {
        either!(self, pipeline => pipeline.committed())
    }

    /// The number of skeletons computed so far.
    pub fn computed(&self) -> u64 {
        either!(self, pipeline => pipeline.computed())
    }

    /// The number of distinct positions.
    pub fn vertex_count(&self) -> usize {
        either!(self, pipeline => pipeline.vertex_count())
    }

    /// The number of points in the window.
    pub fn point_count(&self) -> u64 {
        either!(self, pipeline => pipeline.point_count())
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        either!(self, pipeline => pipeline.bytes())
    }

    /// About how many bytes more it takes once its newest frame is computed.
    pub fn bytes_to_compute(&self) -> usize {
        either!(self, pipeline => pipeline.bytes_to_compute())
    }

    /// Compares the newest frame with one from scratch, and a follower with its view.
    ///
    /// # Errors [`Contradiction`].
    pub fn check(&mut self, follower: &Follower) -> Result<(), Contradiction> {
        either!(self, pipeline => pipeline.check(follower))
    }
}

/// What waits was made by [`AnyPipeline::waiting`] of the stream that it waits for.
const MADE_HERE: &str = "what waits is of the stream's own space";

impl Waiting {
    /// Points that wait.
    pub fn point_count(&self) -> u64 {
        match self {
            Self::Plane(staging) => staging.point_count(),
            Self::Space(staging) => staging.point_count(),
        }
    }

    /// The newest event time of points that wait.
    pub fn newest_time(&self) -> Option<f64> {
        match self {
            Self::Plane(staging) => staging.newest_time(),
            Self::Space(staging) => staging.newest_time(),
        }
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        match self {
            Self::Plane(staging) => staging.is_empty(),
            Self::Space(staging) => staging.is_empty(),
        }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Plane(staging) => staging.bytes(),
            Self::Space(staging) => staging.bytes(),
        }
    }
}

/// The coordinates of a point in the plane.
fn planar(point: Point) -> Result<[f64; 2], Refusal> {
    match point {
        Point::Plane(x, y) => Ok([x, y]),
        Point::Space(&[x, y]) => Ok([x, y]),
        Point::Space(other) => Err(PointError::OtherDimension { found: other.len(), expected: 2 }.into()),
    }
}
