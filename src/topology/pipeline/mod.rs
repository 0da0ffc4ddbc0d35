//! The pipeline: the engine of one stream. Points go in, frames come out, and nothing is computed before it is asked
//! for.
//!
//! In: points and commits.
//! Out: whole [`Frame`]s, or [`Step`]s from frame to frame, rankings and track events.
//! Invariants: a frame shows the cloud as of its commit. Its skeleton is computed once, however often and in whatever
//! views it is asked for. It is computed in one pass or by following what changed, whichever is faster; both give the
//! same. A refused point changes nothing.
//! Must not know: threads, clocks, formats.
//!
//! It joins the rooms below: `plane` finds tree and dots, this room gives them ids and holes, and `skeleton`, `frames`
//! and `tracks` take them as data.

mod boundaries;
mod check;
mod held;
mod holes;
mod memory;
mod one_pass;
mod outliers;
mod progress;
mod reach;
mod rips_pass;
mod space;
mod stage;
mod tiled;

use std::sync::Arc;

use self::held::{TiledSkeleton, WholeSkeleton};
use self::holes::cached_region;
use self::outliers::Outliers;
use self::progress::Progress;
use self::stage::StageHook;
use super::cloud::{Admission, Cloud, Refusal, Staging, VertexId, Window};
use super::declutter::Declutter;
use super::frames::{Change, Diagram, Follower, Frame, SimplifiedFollower, Step};
use super::plane::basins::Basins;
use super::plane::delaunay::Delaunay;
use super::plane::elements::TileDot;
use super::plane::holes::{Region, RegionCache};
use super::plane::mesh::Mesh;
use super::plane::tiles::{LEAF, Tiles, Touched};
use super::skeleton::Ranking;
use super::tracks::{self, Detection, Detections, FrameStamp, HoleState, TrackId, TrackStep, detect};

pub use self::check::Contradiction;
pub use self::outliers::OutlierStep;
pub use self::rips_pass::numbered;
pub use self::space::{SpaceOptions, SpacePipeline};
pub use self::stage::Stage;

/// Tracks the persistent cycles of one stream.
pub type Tracker = tracks::Tracker<HoleState<Region>>;

/// The largest change, as a share of the vertices, for which tiles are made at first.
const TILES_SHARE: f64 = 0.5;

/// Which points a stream keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The window.
    pub window: Window,
    /// The step of the grid that positions are snapped to, if any. It must be positive and finite.
    pub resolution: Option<f64>,
    /// Which points are left out of the skeleton as outliers. They stay in the window; all points count by default.
    pub declutter: Option<Declutter>,
}

/// The engine of one stream.
///
/// Methods come in families. `feed_*` change the cloud and answer at once for each point. [`commit`](Self::commit)
/// closes the frame. [`poll_step`](Self::poll_step) gives a [`Follower`] what changed in its view, at the cost of what
/// changed. [`poll_frame`](Self::poll_frame) gives the newest frame as a whole, if it was not given yet. Each `poll_*`
/// computes the newest frame if that was not done yet; a frame that is never polled costs no more than its points.
///
/// ```
/// use hopes::topology::{Options, Pipeline, ViewSpec};
///
/// let mut pipeline = Pipeline::new(Options::default());
/// for (x, y) in [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)] {
///     pipeline.feed_point(x, y, None)?;
/// }
/// pipeline.commit(None);
/// let frame = pipeline.poll_frame().expect("a frame was committed");
/// let dots = frame.skeleton.dots();
/// assert_eq!(dots.len(), 1);
/// assert_eq!((dots[0].birth, dots[0].death), (1.0, 2f64.sqrt()));
/// assert_eq!(frame.view(ViewSpec::default()).cycles, 1);
/// # Ok::<(), hopes::topology::Refusal>(())
/// ```
#[derive(Clone, Debug)]
pub struct Pipeline {
    cloud: Cloud,
    /// Tells outliers from other points, if that is asked for. They are set aside in the cloud.
    outliers: Option<Box<Outliers>>,
    delaunay: Delaunay,
    progress: Progress,
    /// The frame that was computed last as a whole, if it is stored so.
    whole: Option<Arc<Frame>>,
    /// Its skeleton in tiles, if it was computed step by step.
    tiles: Option<Tiles>,
    /// Without tiles: the largest change, as a share of the vertices, for which they are made.
    tiles_share: f64,
    /// The stars that the last change touched; its memory is reused.
    touched: Touched,
    /// The diagram of the tiles' dots, once gaps were asked for.
    diagram: Option<Diagram<TileDot>>,
    /// The change from the frame computed before, if there are followers.
    change: Option<Change>,
    is_followed: bool,
    /// The mesh and the basins of the last frame that was computed in one pass. The memory of the mesh is reused.
    mesh: Mesh,
    basins: Basins,
    /// Regions of holes that were used in the last frame and have not changed.
    regions: RegionCache,
    leaf_capacity: usize,
    /// Whether changes are followed in tiles whatever their cost.
    always_tiles: bool,
    stages: StageHook,
}

impl Pipeline {
    /// A stream without points.
    pub fn new(options: Options) -> Self {
        Self {
            cloud: Cloud::new(options.window, options.resolution),
            outliers: options.declutter.map(Outliers::boxed),
            delaunay: Delaunay::default(),
            progress: Progress::default(),
            whole: None,
            tiles: None,
            tiles_share: TILES_SHARE,
            touched: Touched::default(),
            diagram: None,
            change: None,
            is_followed: false,
            mesh: Mesh::default(),
            basins: Basins::default(),
            regions: RegionCache::default(),
            leaf_capacity: LEAF,
            always_tiles: false,
            stages: StageHook::default(),
        }
    }

    /// Sets a listener that is called at the begin of each [`Stage`] of every frame that is computed, on the thread
    /// that polls the frame. So a caller with a clock can split a frame's time into triangulation and reduction. It
    /// replaces the listener before. Clones of the pipeline report to the same listener. Without one, nothing is
    /// called.
    ///
    /// ```
    /// use std::sync::{Arc, Mutex};
    ///
    /// use hopes::topology::{Options, Pipeline, Stage};
    ///
    /// let mut pipeline = Pipeline::new(Options::default());
    /// let seen = Arc::new(Mutex::new(Vec::new()));
    /// let log = Arc::clone(&seen);
    /// // A caller with a clock notes the time beside the stage.
    /// pipeline.set_stage_listener(move |stage| log.lock().unwrap().push(stage));
    /// pipeline.feed_points(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.5]], None);
    /// pipeline.commit(None);
    /// pipeline.poll_frame();
    /// assert_eq!(*seen.lock().unwrap(), [Stage::Triangulation, Stage::Reduction, Stage::Done]);
    /// ```
    pub fn set_stage_listener(&mut self, listener: impl Fn(Stage) + Send + Sync + 'static) {
        self.stages = StageHook::new(listener);
    }

    /// Makes room for this number of further points. It saves work later and has no other effect.
    pub fn reserve(&mut self, points: usize) {
        self.cloud.reserve(points);
    }

    /// Adds a point with its event time, if it has one. Returns the vertex at its position.
    ///
    /// # Errors [`Refusal`]: the point is not in the cloud.
    pub fn feed_point(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, Refusal> {
        self.cloud.insert(x, y, time).map(|slot| self.cloud.id(slot))
    }

    /// Adds points of one event time. Returns the refused ones: places in `points`, and why.
    pub fn feed_points(&mut self, points: &[[f64; 2]], time: Option<f64>) -> Vec<(usize, Refusal)> {
        self.cloud.reserve(points.len());
        let refused = |(index, &[x, y]): (usize, &[f64; 2])| Some((index, self.cloud.insert(x, y, time).err()?));
        points.iter().enumerate().filter_map(refused).collect()
    }

    /// Has a point of a source wait for the source's commit: see [`Staging`]. Returns the vertex at its position.
    ///
    /// # Errors [`Refusal`]: the point does not wait.
    pub fn stage_point(
        &mut self,
        staging: &mut Staging,
        x: f64,
        y: f64,
        time: Option<f64>,
    ) -> Result<VertexId, Refusal> {
        self.cloud.stage(staging, x, y, time)
    }

    /// Has a retraction of a source wait for the source's commit.
    ///
    /// # Errors [`Refusal`], mostly [`Refusal::NotThere`].
    pub fn stage_retraction(&mut self, staging: &mut Staging, x: f64, y: f64) -> Result<(), Refusal> {
        self.cloud.stage_retraction(staging, x, y)
    }

    /// Feeds what waits of a source, in order, at its commit with a time. Points without a time of their own are of the
    /// commit's; where it has none, of the newest time known. Calls `refused` for what is refused by now, with its
    /// place in what was staged: points outside the time window, and retractions of what is gone.
    ///
    /// In a time window, a time that jumps ahead by more than the window, or back out of it, is believed when other
    /// sources confirm it, or its own over a commit and [`CONFIRMING`](crate::topology::CONFIRMING) points. Until then
    /// it moves nothing. Points that are fed without waiting are believed as they come.
    pub fn feed_staged(
        &mut self,
        staging: &mut Staging,
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
    pub fn discard_staged(&mut self, staging: &mut Staging) {
        self.cloud.discard(staging);
    }

    /// Retracts the oldest point at a position.
    ///
    /// # Errors [`Refusal`], mostly [`Refusal::NotThere`].
    pub fn feed_retraction(&mut self, x: f64, y: f64) -> Result<(), Refusal> {
        self.cloud.retract(x, y).map(drop)
    }

    /// Retracts points. Returns the refused ones: places in `points`, and why.
    pub fn feed_retractions(&mut self, points: &[[f64; 2]]) -> Vec<(usize, Refusal)> {
        let refused = |(index, &[x, y]): (usize, &[f64; 2])| Some((index, self.cloud.retract(x, y).err()?));
        points.iter().enumerate().filter_map(refused).collect()
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

    /// The newest frame as a whole, unless it was given before. Takes time in proportion to the cloud;
    /// [`poll_step`](Self::poll_step) gives what changed.
    pub fn poll_frame(&mut self) -> Option<Arc<Frame>> {
        (!self.progress.is_given()).then(|| {
            self.reach();
            let frame = self.frame();
            self.progress.give(frame)
        })
    }

    /// What changed in a view up to the newest frame, unless the follower is up to date. The computation of the frame
    /// is shared by all followers; beyond it, this takes time in proportion to the answer.
    pub fn poll_step(&mut self, follower: &mut Follower) -> Option<Step> {
        if follower.frame() >= self.progress.committed {
            return None;
        }
        self.is_followed = true;
        self.reach();
        let change = self.change.as_ref().filter(|change| follower.frame() > 0 && change.from == follower.frame());
        let number = self.progress.reached;
        let mut step = match (&self.tiles, &self.whole) {
            (Some(tiles), _) => {
                let mut held = TiledSkeleton { cloud: &self.cloud, tiles, diagram: &mut self.diagram };
                follower.advance(number, &mut held, change)
            }
            (None, Some(frame)) => {
                follower.advance(number, &mut WholeSkeleton { cloud: &self.cloud, skeleton: &frame.skeleton }, change)
            }
            (None, None) => unreachable!("a frame that was reached is held"),
        };
        (step.time, step.points) = (self.progress.time, self.progress.points);
        step.decluttered = self.progress.decluttered;
        Some(step)
    }

    /// What changed in a simplified view up to the newest frame, unless the follower is up to date. Takes time in
    /// proportion to the cloud, since one changed edge can change how all others collapse.
    pub fn poll_simplified(&mut self, follower: &mut SimplifiedFollower) -> Option<Step> {
        if follower.frame() >= self.progress.committed {
            return None;
        }
        self.reach();
        let frame = self.frame();
        Some(follower.advance(&frame))
    }

    /// The most persistent dots of the newest frame, at most `most`, with their holes. Takes time in proportion to all
    /// dots.
    pub fn poll_dots(&mut self, most: usize) -> Ranking {
        self.reach();
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => tiled::ranking(self.progress.reached, &self.cloud, tiles, most),
            (None, Some(frame)) => one_pass::ranking(self.progress.reached, &frame.skeleton, most),
            (None, None) => Ranking::default(),
        }
    }

    /// The events of a tracker's tracks up to the newest frame, unless the tracker is up to date. The computation of
    /// the frame is shared; beyond it, this takes time in proportion to the detections. The detections of a full or a
    /// reduced view are all its dots.
    pub fn poll_tracks(&mut self, tracker: &mut Tracker) -> Option<TrackStep> {
        if tracker.frame() >= self.progress.committed {
            return None;
        }
        self.reach();
        let detections = self.detect(tracker);
        let at = FrameStamp { number: self.progress.reached, time: self.progress.time };
        let Self { regions, cloud, delaunay, .. } = self;
        Some(tracker.advance(at, detections, |detection| cached_region(regions, cloud, delaunay, detection)))
    }

    /// The regions at birth of the holes of a tracker's tracks, by id, without tracks that are not detected in the
    /// newest frame. Takes time in proportion to the regions that have changed since the last frame, and to those that
    /// were not asked for in it.
    pub fn track_regions(&mut self, tracker: &Tracker) -> Vec<(TrackId, Region)> {
        if tracker.frame() != self.progress.reached {
            return Vec::new();
        }
        let Self { regions, cloud, delaunay, .. } = self;
        let mut region = |detection| cached_region(regions, cloud, delaunay, detection);
        tracker.seen().map(|(id, detection)| (id, region(detection))).collect()
    }

    /// The detections of a tracker.
    fn detect(&mut self, tracker: &Tracker) -> Detections<Detection> {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => {
                let mut held = TiledSkeleton { cloud: &self.cloud, tiles, diagram: &mut self.diagram };
                detect(tracker.options().rule, tracker.search_bounds(), &mut held)
            }
            (None, Some(frame)) => {
                let mut held = WholeSkeleton { cloud: &self.cloud, skeleton: &frame.skeleton };
                detect(tracker.options().rule, tracker.search_bounds(), &mut held)
            }
            (None, None) => unreachable!("a frame that was reached is held"),
        }
    }

    /// The newest frame that was given as a whole.
    pub fn newest(&self) -> Option<&Arc<Frame>> {
        self.progress.given()
    }

    /// The number of skeletons computed so far.
    pub fn computed(&self) -> u64 {
        self.progress.computed
    }

    /// The number of tiles reduced for the last computed frame; 0 after one pass.
    pub fn tiles_reduced(&self) -> usize {
        self.tiles.as_ref().map_or(0, Tiles::reduced)
    }

    /// The number of the newest frame; 0 before the first commit.
    pub fn committed(&self) -> u64 {
        self.progress.committed
    }

    /// The number of distinct positions, including those that are not committed yet.
    pub fn vertex_count(&self) -> usize {
        self.cloud.used_count()
    }

    /// The number of points in the window, including duplicates and those that are not committed yet.
    pub fn point_count(&self) -> u64 {
        self.cloud.point_count()
    }

    #[cfg(test)]
    pub(super) fn forget_regions(&mut self) {
        self.regions.clear();
    }

    #[cfg(test)]
    pub(super) fn cached_regions(&self) -> usize {
        self.regions.count()
    }

    /// The number of levels of tiles below the root. For tests.
    #[doc(hidden)]
    pub fn tile_depth(&self) -> usize {
        self.tiles.as_ref().map_or(0, Tiles::depth)
    }

    /// Sets the capacity of leaves, and follows every change in tiles whatever its cost. Small leaves give deep trees
    /// for small clouds. For tests.
    #[doc(hidden)]
    pub fn with_leaf(mut self, leaf_capacity: usize) -> Self {
        (self.leaf_capacity, self.always_tiles) = (leaf_capacity, true);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::ViewSpec;

    fn pipeline_of(points: &[[f64; 2]]) -> Pipeline {
        let mut pipeline = Pipeline::new(Options::default());
        pipeline.feed_points(points, None);
        pipeline.commit(None);
        pipeline
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn a_frame_is_computed_once_and_only_when_asked_for() {
        let mut pipeline = pipeline_of(&SQUARE);
        pipeline.feed_points(&[[5.0, 5.0]], None);
        pipeline.commit(Some(7.0));
        assert_eq!(pipeline.computed(), 0);
        let frame = pipeline.poll_frame().unwrap();
        assert_eq!((frame.number, frame.time, frame.points), (2, Some(7.0), 5));
        for spec in [ViewSpec::Full, ViewSpec::default(), ViewSpec::Reduced { alpha: 1.0 }] {
            frame.view(spec);
        }
        assert!(pipeline.poll_frame().is_none());
        assert_eq!(pipeline.computed(), 1);
    }

    #[test]
    fn a_frame_shows_the_cloud_as_of_its_commit() {
        let mut pipeline = pipeline_of(&SQUARE);
        pipeline.feed_points(&[[5.0, 5.0]], None);
        assert_eq!(pipeline.feed_retraction(0.0, 0.0), Ok(()));
        let frame = pipeline.poll_frame().unwrap();
        assert_eq!((frame.skeleton.vertices().len(), frame.points), (4, 4));
        pipeline.check_invariants();
    }

    #[test]
    fn holes_of_the_newest_frame_have_boundaries() {
        let mut pipeline = pipeline_of(&SQUARE);
        let frame = pipeline.poll_frame().unwrap();
        assert_eq!(pipeline.hole_boundaries(frame.skeleton.dots()), [[[0, 1, 2, 3]]]);
    }
}
