//! The engine of one stream of points in R^d under a metric. Points go in, frames come out, and nothing is computed
//! before it is asked for.
//!
//! In: points and commits.
//! Out: whole [`Frame`]s, or [`Step`]s from frame to frame, rankings and track events.
//! Invariants: a frame shows the cloud as of its commit. Its skeleton is computed once, however often and in whatever
//! views it is asked for. It is computed from scratch, but in warm memory, so it depends on the cloud alone. All points
//! have one dimension. A refused point changes nothing. In a full cloud, the points that leave at the next commit at
//! the latest make room for those that come.
//! Must not know: threads, clocks, formats, the plane.

mod closing;
mod detections;
mod loops;
mod shortening;
mod walks;

use std::sync::Arc;

use detections::FrameCycles;
use walks::{WalkFinder, answers};

use super::check::Contradiction;
use super::held::WholeSkeleton;
use super::one_pass;
use super::progress::Progress;
use super::stage::{Stage, StageHook};
use crate::topology::cloud::{Admission, Cloud, Coordinates, PointError, Refusal, Staging, VertexId, Vertices, Window};
use crate::topology::frames::{Change, Follower, Frame, SimplifiedFollower, Step};
use crate::topology::metric::rips::{MAX_VERTICES, Workspace};
use crate::topology::metric::space::{Metric, Points, SpaceError};
use crate::topology::skeleton::{Ranking, Skeleton};
use crate::topology::tracks::{FrameStamp, SpaceTrackStep, SpaceTracker, TrackId, TrackWalk, WalkAnswer, detect};

/// What a vertex takes in a skeleton: its names, tree edge and dots.
const BYTES_OF_A_VERTEX: usize = 256;

/// The space of a stream, and which points it keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceOptions {
    /// The metric.
    pub metric: Metric,
    /// The number of coordinates of a point. Without it, that of the first point.
    pub dimension: Option<usize>,
    /// The window.
    pub window: Window,
    /// The step of the grid that coordinates are snapped to, if any. It must be positive and finite.
    pub resolution: Option<f64>,
    /// The most distinct points, from 1 to [`MAX_VERTICES`]. Time and memory of a frame grow with their square.
    pub max_vertices: usize,
    /// The scale at which the filtration ends, a radius; none for the whole filtration.
    pub threshold: Option<f64>,
}

impl Default for SpaceOptions {
    fn default() -> Self {
        Self {
            metric: Metric::default(),
            dimension: None,
            window: Window::default(),
            resolution: None,
            max_vertices: 4096,
            threshold: None,
        }
    }
}

/// The engine of one stream in R^d: what [`Pipeline`](super::Pipeline) is in the plane, with the same methods.
///
/// ```
/// use hopes::topology::{SpaceOptions, SpacePipeline, ViewSpec};
///
/// let mut pipeline = SpacePipeline::new(SpaceOptions::default())?;
/// for point in [[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 2.0, 5.0], [0.0, 2.0, 5.0]] {
///     pipeline.feed_point(&point, None)?;
/// }
/// pipeline.commit(None);
/// let frame = pipeline.poll_frame().expect("a frame was committed");
/// let dots = frame.skeleton.dots();
/// assert_eq!(dots.len(), 1);
/// assert_eq!((dots[0].birth, dots[0].death), (1.0, 2f64.sqrt()));
/// assert_eq!(frame.view(ViewSpec::default()).cycles, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SpacePipeline {
    cloud: Cloud<Coordinates>,
    most: usize,
    metric: Metric,
    /// None before the first point, unless it is given.
    dimension: Option<usize>,
    threshold: Option<f64>,
    progress: Progress,
    /// The frame that was computed last.
    whole: Option<Arc<Frame>>,
    /// The change from the frame computed before, if there are followers.
    change: Option<Change>,
    is_followed: bool,
    workspace: Workspace,
    /// The vertices of the space that was swept last, by id, each with its place in it.
    swept: Vec<(VertexId, u32)>,
    questions: Questions,
    stages: StageHook,
}

/// What a tracker asks of the next frame, so that one sweep answers it.
#[derive(Debug, Default)]
struct Questions {
    asked: Vec<TrackWalk>,
    /// Those for the frame that was computed last; none if they were not asked then, or were taken.
    answers: Option<Vec<WalkAnswer>>,
}

impl SpacePipeline {
    /// A stream without points.
    ///
    /// # Errors
    /// [`SpaceError`] if the dimension is beyond the limits, or does not suit the metric.
    pub fn new(options: SpaceOptions) -> Result<Self, SpaceError> {
        let on_the_sphere = (options.metric == Metric::Haversine).then_some(2);
        let dimension = options.dimension.or(on_the_sphere);
        dimension.map_or(Ok(()), |dimension| options.metric.check_dimension(dimension))?;
        let most = options.max_vertices.clamp(1, MAX_VERTICES);
        Ok(Self {
            cloud: Cloud::new(options.window, options.resolution).with_most(most),
            most,
            metric: options.metric,
            dimension,
            threshold: options.threshold,
            progress: Progress::default(),
            whole: None,
            change: None,
            is_followed: false,
            workspace: Workspace::default(),
            swept: Vec::new(),
            questions: Questions::default(),
            stages: StageHook::default(),
        })
    }

    /// Sets a listener that is called at the begin of each [`Stage`] of every frame that is computed, as
    /// [`Pipeline::set_stage_listener`](super::Pipeline::set_stage_listener) does.
    pub fn set_stage_listener(&mut self, listener: impl Fn(Stage) + Send + Sync + 'static) {
        self.stages = StageHook::new(listener);
    }

    /// The number of coordinates of its points; none before the first point, unless it was given.
    pub fn dimension(&self) -> Option<usize> {
        self.dimension
    }

    /// Fixes the number of coordinates before the first point comes. Where it is fixed already, nothing happens.
    pub fn fix_dimension(&mut self, dimension: usize) {
        if self.metric.check_dimension(dimension).is_ok() {
            self.dimension.get_or_insert(dimension);
        }
    }

    /// Makes room for this number of further points. It saves work later and has no other effect.
    pub fn reserve(&mut self, points: usize) {
        self.cloud.reserve(points.min(self.most));
    }

    /// Adds a point with its event time, if it has one. Returns the vertex at its coordinates.
    ///
    /// # Errors [`Refusal`]: the point is not in the cloud.
    pub fn feed_point(&mut self, point: &[f64], time: Option<f64>) -> Result<VertexId, Refusal> {
        let site = self.site(point)?;
        let slot = self.cloud.insert_site(site, time)?;
        self.dimension = Some(point.len());
        Ok(self.cloud.id(slot))
    }

    /// Adds points of one event time. Returns the refused ones: places in `points`, and why.
    pub fn feed_points<P: AsRef<[f64]>>(&mut self, points: &[P], time: Option<f64>) -> Vec<(usize, Refusal)> {
        let refused = |(place, point): (usize, &P)| Some((place, self.feed_point(point.as_ref(), time).err()?));
        points.iter().enumerate().filter_map(refused).collect()
    }

    /// Has a point of a source wait for the source's commit: see [`Staging`]. Returns the vertex at its coordinates.
    ///
    /// # Errors [`Refusal`]: the point does not wait.
    pub fn stage_point(
        &mut self,
        staging: &mut Staging<Coordinates>,
        point: &[f64],
        time: Option<f64>,
    ) -> Result<VertexId, Refusal> {
        let site = self.site(point)?;
        let vertex = self.cloud.stage_site(staging, site, time)?;
        self.dimension = Some(point.len());
        Ok(vertex)
    }

    /// Has a retraction of a source wait for the source's commit.
    ///
    /// # Errors [`Refusal`], mostly [`Refusal::Absent`].
    pub fn stage_retraction(&mut self, staging: &mut Staging<Coordinates>, point: &[f64]) -> Result<(), Refusal> {
        let site = self.site(point)?;
        self.cloud.stage_retraction_of(staging, site)
    }

    /// Feeds what waits of a source, as [`Pipeline::feed_staged`](super::Pipeline::feed_staged) does. Points beyond the
    /// most distinct ones are refused here.
    pub fn feed_staged(
        &mut self,
        staging: &mut Staging<Coordinates>,
        time: Option<f64>,
        refused: &mut dyn FnMut(usize, Refusal),
    ) -> Admission {
        self.cloud.admit(staging, time, refused)
    }

    /// The newest event time that is believed. Only time windows judge what they are told.
    pub fn event_time(&self) -> Option<f64> {
        self.cloud.event_time()
    }

    /// Forgets what waits of a source that has ended.
    pub fn discard_staged(&mut self, staging: &mut Staging<Coordinates>) {
        self.cloud.discard(staging);
    }

    /// Retracts the oldest point with these coordinates.
    ///
    /// # Errors [`Refusal`], mostly [`Refusal::Absent`].
    pub fn feed_retraction(&mut self, point: &[f64]) -> Result<(), Refusal> {
        let site = self.site(point)?;
        self.cloud.retract_site(site).map(drop)
    }

    /// Moves event time forward without a point. Points before the time window leave.
    ///
    /// # Errors [`Refusal::TimeNotFinite`].
    pub fn feed_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.cloud.advance_time(time)
    }

    /// Closes the frame with a time. Returns the number of the frame.
    pub fn commit(&mut self, time: Option<f64>) -> u64 {
        self.cloud.commit();
        self.progress.commit(time, self.cloud.point_count())
    }

    /// The newest frame as a whole, unless it was given before.
    pub fn poll_frame(&mut self) -> Option<Arc<Frame>> {
        (!self.progress.is_given()).then(|| {
            let frame = self.reach();
            self.progress.give(frame)
        })
    }

    /// What changed in a view up to the newest frame, unless the follower is up to date. The computation of the frame
    /// is shared by all followers.
    pub fn poll_step(&mut self, follower: &mut Follower) -> Option<Step> {
        if follower.frame() >= self.progress.committed {
            return None;
        }
        self.is_followed = true;
        let frame = self.reach();
        let change = self.change.as_ref().filter(|change| follower.frame() > 0 && change.from == follower.frame());
        let mut step = follower.advance(frame.number, &mut &frame.skeleton, change);
        (step.time, step.points) = (frame.time, frame.points);
        Some(step)
    }

    /// What changed in a simplified view up to the newest frame, unless the follower is up to date.
    pub fn poll_simplified(&mut self, follower: &mut SimplifiedFollower) -> Option<Step> {
        (follower.frame() < self.progress.committed).then(|| follower.advance(&self.reach()))
    }

    /// The most persistent dots of the newest frame, at most `most`. Takes time in proportion to all dots.
    pub fn poll_dots(&mut self, most: usize) -> Ranking {
        if self.progress.committed == 0 {
            return Ranking::default();
        }
        let frame = self.reach();
        one_pass::ranking(frame.number, &frame.skeleton, most)
    }

    /// The events of a tracker's tracks up to the newest frame, unless the tracker is up to date. The computation of
    /// the frame is shared, and answers what the tracker asks of it. That is known before, if the frame is first asked
    /// for here or if this was the last tracker to be updated; else the frame is swept again.
    pub fn poll_tracks(&mut self, tracker: &mut SpaceTracker) -> Option<SpaceTrackStep> {
        if tracker.frame() >= self.progress.committed {
            return None;
        }
        let walks = tracker.walks();
        let is_asked = self.questions.answers.is_some() && self.questions.asked == walks;
        if !(self.progress.is_reached() && is_asked) {
            self.questions = Questions { asked: walks, answers: None };
            if self.progress.is_reached() {
                self.sweep();
            }
        }
        let frame = self.reach();
        let answers = self.questions.answers.take().unwrap_or_default();
        let mut held = WholeSkeleton { cloud: &self.cloud, skeleton: &frame.skeleton };
        let detections = detect(tracker.options().rule, tracker.search_bounds(), &mut held);
        let at = FrameStamp { number: frame.number, time: frame.time };
        let cycles = FrameCycles::new(self.metric, &self.cloud, &frame.skeleton, &self.swept);
        let step = tracker.advance(at, detections, &answers, &cycles);
        self.questions.asked = tracker.walks();
        Some(step)
    }

    /// The cycles of a tracker's tracks by the ids of their vertices, by track, without tracks that are not detected in
    /// the newest frame. A cycle is closed: its last vertex is joined to the first.
    pub fn track_cycles(&self, tracker: &SpaceTracker) -> Vec<(TrackId, Vec<VertexId>)> {
        if tracker.frame() != self.progress.reached {
            return Vec::new();
        }
        tracker.seen().map(|(id, cycle)| (id, cycle.vertices.iter().map(|(id, _)| *id).collect())).collect()
    }

    /// The newest frame that was given as a whole.
    pub fn newest(&self) -> Option<&Arc<Frame>> {
        self.progress.given()
    }

    /// The number of skeletons computed so far.
    pub fn computed(&self) -> u64 {
        self.progress.computed
    }

    /// The number of the newest frame; 0 before the first commit.
    pub fn committed(&self) -> u64 {
        self.progress.committed
    }

    /// The number of distinct points, including those that are not committed yet.
    pub fn vertex_count(&self) -> usize {
        self.cloud.used_count()
    }

    /// The number of points in the window, including duplicates and those that are not committed yet.
    pub fn point_count(&self) -> u64 {
        self.cloud.point_count()
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.cloud.bytes() + self.workspace.bytes() + self.swept.len() * self.bytes_of_a_vertex()
    }

    /// About how many bytes more it takes once its newest frame is computed.
    pub fn bytes_to_compute(&self) -> usize {
        let (old, new) = (self.swept.len(), self.cloud.vertex_count());
        let of_graph = (new * new).saturating_sub(old * old) / 4;
        new.saturating_sub(old) * self.bytes_of_a_vertex() + of_graph
    }

    fn bytes_of_a_vertex(&self) -> usize {
        BYTES_OF_A_VERTEX + self.dimension.unwrap_or(0) * size_of::<f64>()
    }

    /// Compares the newest frame with the skeleton of its cloud from scratch, and a follower with the view of that.
    ///
    /// # Errors [`Contradiction`]: the first difference.
    pub fn check(&mut self, follower: &Follower) -> Result<(), Contradiction> {
        let frame = self.reach();
        let (points, names) = self.space();
        let reference = Skeleton::of_space(&points, &names, self.threshold, &mut Workspace::default());
        frame.check(&reference, follower)
    }

    /// Panics when the pipeline is inconsistent. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        self.cloud.check_invariants();
    }

    /// A point of the stream's space.
    fn site(&self, point: &[f64]) -> Result<Coordinates, Refusal> {
        if let Some(expected) = self.dimension.filter(|&expected| expected != point.len()) {
            return Err(PointError::OtherDimension { found: point.len(), expected }.into());
        }
        let site = self.cloud.place_of(Coordinates::new(point)?)?;
        match self.metric.check_point(0, site.as_slice()) {
            Err(SpaceError::Latitude { value, .. }) => Err(PointError::Latitude(value).into()),
            Err(_) => Err(PointError::NoDirection.into()),
            Ok(()) => Ok(site),
        }
    }

    /// Computes the newest frame, unless that was done.
    fn reach(&mut self) -> Arc<Frame> {
        match &self.whole {
            Some(frame) if self.progress.is_reached() => Arc::clone(frame),
            _ => self.compute(),
        }
    }

    fn compute(&mut self) -> Arc<Frame> {
        self.stages.begin(Stage::Triangulation);
        // Slots of vertices that are gone become free.
        self.cloud.take_change();
        if self.questions.answers.is_some() {
            // Nobody took them: the tracker is gone.
            self.questions = Questions::default();
        }
        self.stages.begin(Stage::Reduction);
        let before = self.progress.begin();
        let skeleton = self.sweep();
        let old = self.whole.take();
        self.change = (self.is_followed.then_some(()).and(old.as_deref()))
            .map(|old| Change::between(before, &old.skeleton, &skeleton));
        let frame = Arc::new(self.progress.frame_of(skeleton));
        self.whole = Some(Arc::clone(&frame));
        self.stages.begin(Stage::Done);
        frame
    }

    /// The skeleton of the cloud as of its last commit. What a tracker asks of it is answered in the same sweep.
    fn sweep(&mut self) -> Skeleton {
        let (points, names) = self.space();
        self.carry(&names);
        let mut finder = WalkFinder::new(&points, &self.swept, self.threshold);
        let asked = finder.ask(&self.questions.asked, self.progress.committed);
        let (skeleton, classes) =
            Skeleton::with_classes(&points, &names, self.threshold, &asked.walks, &mut self.workspace);
        self.questions.answers = Some(answers(&names, asked, classes, &skeleton));
        skeleton
    }

    /// The cloud as of its last commit as a space, and the names of the space's vertices.
    fn space(&self) -> (Points, Vertices) {
        let vertices: Vertices = self.cloud.vertices().map(|(_, vertex)| vertex).collect();
        let dimension = self.dimension.unwrap_or(1);
        let points = Points::new(self.metric, dimension, vertices.all_coordinates())
            .expect("each point was checked when it came");
        let names = points.rows().iter().map(|&row| (vertices.id(row), vertices.coordinates(row))).collect();
        (points, names)
    }

    /// Tells the workspace which vertex of the space that comes was which in the last one.
    fn carry(&mut self, names: &Vertices) {
        let swept = &self.swept;
        let place_of = |id: &VertexId| Some(swept[swept.binary_search_by_key(id, |&(id, _)| id).ok()?].1);
        let before: Vec<Option<u32>> = names.ids().iter().map(place_of).collect();
        self.workspace.carry(&before);
        self.swept = names.ids().iter().copied().zip(0..).collect();
        self.swept.sort_unstable();
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod track_tests;
