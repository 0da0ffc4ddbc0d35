//! A stream's engine: points in, frames out, nothing computed before it is asked for.
//!
//! In: batches and commits. Out: [`Frame`]s as a whole, or [`Step`]s from frame to frame. Invariants: a frame shows the cloud as of its commit; however
//! often and in whatever views it is asked for, its skeleton is computed once, in one pass or by following what changed, whichever is faster; both
//! give the same; refused points change nothing. Must not know: threads, clocks, formats.

mod boundaries;
mod check;
mod held;
mod holes;
mod one_pass;
mod reach;
mod stage;
mod tiled;

use std::sync::Arc;

use self::held::{TiledSkeleton, WholeSkeleton};
use self::holes::cached_region;
use self::stage::StageHook;
use super::cloud::{Cloud, Refusal, VertexId, Window};
use super::frames::{Change, Diagram, Follower, Frame, SimplifiedFollower, Step};
use super::plane::basins::Basins;
use super::plane::delaunay::Delaunay;
use super::plane::elements::TileDot;
use super::plane::holes::{Region, RegionCache};
use super::plane::mesh::Mesh;
use super::plane::tiles::{LEAF, Tiles, Touched};
use super::skeleton::Ranking;
use super::tracks::{self, At, Sightings, TrackId, TrackStep, sight};

pub use self::check::Contradiction;
pub use self::stage::Stage;

/// Follows the persistent cycles of one stream.
pub type Tracker = tracks::Tracker<Region>;

/// The share of vertices that a change may touch for tiles to be made, at first.
const WORTH_TILES: f64 = 0.5;

/// What a stream keeps of its points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Which points stay.
    pub window: Window,
    /// Step of the grid that positions snap to, if any; must be positive and finite.
    pub resolution: Option<f64>,
}

/// A stream's engine.
///
/// Methods come in families. `feed_*` change the cloud in hand and answer at once for each point. [`commit`](Self::commit) closes
/// the frame. [`poll_step`](Self::poll_step) tells a [`Follower`] what has changed in its view, at the cost of what changed;
/// [`poll_frame`](Self::poll_frame) gives the newest frame as a whole, if it was not given yet. Either computes the frame, once: commits that
/// nobody polled in between cost no more than their points.
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
    delaunay: Delaunay,
    committed: u64,
    time: Option<f64>,
    points: u64,
    /// The last frame given as a whole.
    newest: Option<Arc<Frame>>,
    /// Number of the frame whose skeleton is held.
    reached: u64,
    /// That frame as a whole, if it is at hand.
    whole: Option<Arc<Frame>>,
    /// Its skeleton in tiles, if it was reached step by step.
    tiles: Option<Tiles>,
    /// Without tiles: the share of vertices that a change may touch for them to be made.
    worth_tiles: f64,
    /// What the last change has touched, in memory that is used again.
    touched: Touched,
    /// The persistence diagram of the tiles' dots, once gaps were asked for.
    diagram: Option<Diagram<TileDot>>,
    /// What turned the frame reached before into this one, if somebody may want to know.
    change: Option<Change>,
    is_followed: bool,
    /// The triangulation and the basins of the last frame that was computed as a whole; the next one is computed in their memory.
    mesh: Mesh,
    basins: Basins,
    /// Regions of holes that somebody has asked for in the frame before, as far as they still are what they were.
    regions: RegionCache,
    leaf: usize,
    /// Whether changes are followed in tiles whatever the effort.
    is_for_tiles_only: bool,
    computed: u64,
    stages: StageHook,
}

impl Pipeline {
    /// An empty stream.
    pub fn new(options: Options) -> Self {
        Self {
            cloud: Cloud::new(options.window, options.resolution),
            delaunay: Delaunay::default(),
            committed: 0,
            time: None,
            points: 0,
            newest: None,
            reached: 0,
            whole: None,
            tiles: None,
            worth_tiles: WORTH_TILES,
            touched: Touched::default(),
            diagram: None,
            change: None,
            is_followed: false,
            mesh: Mesh::default(),
            basins: Basins::default(),
            regions: RegionCache::default(),
            leaf: LEAF,
            is_for_tiles_only: false,
            computed: 0,
            stages: StageHook::default(),
        }
    }

    /// Has a listener called at the begin of each [`Stage`] of every frame that is computed, on the thread that polls the frame. A caller
    /// with a clock can so split a frame's time into triangulation and reduction. It replaces the listener before; a clone of
    /// the pipeline reports to the same one. Without a listener nothing is called.
    ///
    /// ```
    /// use std::sync::{Arc, Mutex};
    /// use std::time::Instant;
    ///
    /// use hopes::topology::{Options, Pipeline, Stage};
    ///
    /// let mut pipeline = Pipeline::new(Options::default());
    /// let began = Arc::new(Mutex::new(Vec::new()));
    /// let log = Arc::clone(&began);
    /// pipeline.set_stage_listener(move |stage| log.lock().unwrap().push((stage, Instant::now())));
    /// pipeline.feed_points(&[[0.0, 0.0], [2.0, 0.0], [1.0, 1.5]], None);
    /// pipeline.commit(None);
    /// pipeline.poll_frame();
    /// let began = began.lock().unwrap();
    /// let [(Stage::Triangulation, start), (Stage::Reduction, middle), (Stage::Done, end)] = began[..] else { panic!() };
    /// println!("triangulation {:?}, reduction {:?}", middle - start, end - middle);
    /// ```
    pub fn set_stage_listener(&mut self, listener: impl Fn(Stage) + Send + Sync + 'static) {
        self.stages = StageHook::new(listener);
    }

    /// Makes room for so many more points at once; less work later, no other effect.
    pub fn reserve(&mut self, points: usize) {
        self.cloud.reserve(points);
    }

    /// Adds a point with its event time, if it has one, and tells the vertex that it is on.
    ///
    /// # Errors
    /// [`Refusal`]: the point was left out.
    pub fn feed_point(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, Refusal> {
        self.cloud.insert(x, y, time).map(|slot| self.cloud.id(slot))
    }

    /// Adds many points of one event time, and says which were refused: places in `points`, and why.
    pub fn feed_points(&mut self, points: &[[f64; 2]], time: Option<f64>) -> Vec<(usize, Refusal)> {
        self.cloud.reserve(points.len());
        let refused = |(index, &[x, y]): (usize, &[f64; 2])| Some((index, self.cloud.insert(x, y, time).err()?));
        points.iter().enumerate().filter_map(refused).collect()
    }

    /// Takes back the oldest point at a position.
    ///
    /// # Errors
    /// [`Refusal::NotThere`] above all.
    pub fn feed_retraction(&mut self, x: f64, y: f64) -> Result<(), Refusal> {
        self.cloud.retract(x, y).map(drop)
    }

    /// Takes back many points, and says which were not there: places in `points`, and why.
    pub fn feed_retractions(&mut self, points: &[[f64; 2]]) -> Vec<(usize, Refusal)> {
        let refused = |(index, &[x, y]): (usize, &[f64; 2])| Some((index, self.cloud.retract(x, y).err()?));
        points.iter().enumerate().filter_map(refused).collect()
    }

    /// Moves event time forward without a point: what is too old for a time window leaves.
    ///
    /// # Errors
    /// [`Refusal::TimeNotFinite`].
    pub fn feed_time(&mut self, time: f64) -> Result<(), Refusal> {
        self.cloud.advance_time(time)
    }

    /// Closes the frame in hand; `time` is what it shall carry. Gives its number.
    pub fn commit(&mut self, time: Option<f64>) -> u64 {
        self.cloud.commit();
        self.committed += 1;
        self.time = time;
        self.points = self.cloud.point_count();
        self.committed
    }

    /// The newest committed frame as a whole, unless it was given already. Takes time in proportion to the cloud; those who want to
    /// know what changed [`follow`](Self::poll_step) it.
    pub fn poll_frame(&mut self) -> Option<Arc<Frame>> {
        let given = self.newest.as_ref().map_or(0, |frame| frame.number);
        (given < self.committed).then(|| {
            self.reach();
            let frame = self.frame();
            self.newest = Some(Arc::clone(&frame));
            frame
        })
    }

    /// What has changed in a view up to the newest committed frame, unless the follower has been told already. After the frame's own
    /// cost, which is shared by all followers, it takes time in proportion to what it says.
    pub fn poll_step(&mut self, follower: &mut Follower) -> Option<Step> {
        if follower.frame() >= self.committed {
            return None;
        }
        self.is_followed = true;
        self.reach();
        let change = self.change.as_ref().filter(|change| follower.frame() > 0 && change.from == follower.frame());
        let number = self.reached;
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
        (step.time, step.points) = (self.time, self.points);
        Some(step)
    }

    /// What has changed in a simplified view up to the newest committed frame, unless the follower has been told already. Takes time in
    /// proportion to the cloud: one edge that changes can change how all others collapse.
    pub fn poll_simplified(&mut self, follower: &mut SimplifiedFollower) -> Option<Step> {
        if follower.frame() >= self.committed {
            return None;
        }
        self.reach();
        let frame = self.frame();
        Some(follower.advance(&frame))
    }

    /// The most persistent dots of the newest committed frame, so many at the most, with their holes. Takes time in proportion to all dots.
    pub fn poll_dots(&mut self, most: usize) -> Ranking {
        self.reach();
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => tiled::ranking(self.reached, &self.cloud, tiles, most),
            (None, Some(frame)) => one_pass::ranking(self.reached, &frame.skeleton, most),
            (None, None) => Ranking::default(),
        }
    }

    /// What has happened to a tracker's tracks up to the newest committed frame, unless it has been told already. After the frame's own cost, which is shared, it takes
    /// time in proportion to the dots that it looks at; tracking the dots of a full or a reduced view looks at all of them.
    pub fn poll_tracks(&mut self, tracker: &mut Tracker) -> Option<TrackStep> {
        if tracker.frame() >= self.committed {
            return None;
        }
        self.reach();
        let sightings = self.sight(tracker);
        let at = At { number: self.reached, time: self.time };
        let Self { regions, cloud, delaunay, .. } = self;
        Some(tracker.advance(at, sightings, |sighting| cached_region(regions, cloud, delaunay, sighting)))
    }

    /// The regions that the holes of a tracker's tracks take up at their births, by id; without those that are not there in the newest frame. Takes time in proportion to
    /// the regions that something has touched since they were asked for in the frame before, and to all that were not.
    pub fn track_regions(&mut self, tracker: &Tracker) -> Vec<(TrackId, Region)> {
        if tracker.frame() != self.reached {
            return Vec::new();
        }
        let Self { regions, cloud, delaunay, .. } = self;
        let mut region = |sighting| cached_region(regions, cloud, delaunay, sighting);
        tracker.seen().map(|(id, sighting)| (id, region(sighting))).collect()
    }

    /// What a tracker looks at.
    fn sight(&mut self, tracker: &Tracker) -> Sightings {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => {
                let mut held = TiledSkeleton { cloud: &self.cloud, tiles, diagram: &mut self.diagram };
                sight(tracker.options().rule, tracker.looks_for(), &mut held)
            }
            (None, Some(frame)) => {
                let mut held = WholeSkeleton { cloud: &self.cloud, skeleton: &frame.skeleton };
                sight(tracker.options().rule, tracker.looks_for(), &mut held)
            }
            (None, None) => unreachable!("a frame that was reached is held"),
        }
    }

    /// The newest frame that was given.
    pub fn newest(&self) -> Option<&Arc<Frame>> {
        self.newest.as_ref()
    }

    /// How many skeletons were computed so far.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// How many tiles were reduced for the newest frame that was reached; 0 if it was computed in one pass.
    pub fn tiles_reduced(&self) -> usize {
        self.tiles.as_ref().map_or(0, Tiles::reduced)
    }

    /// Number of the newest committed frame; 0 before the first.
    pub fn committed(&self) -> u64 {
        self.committed
    }

    /// Distinct positions, those of the frame in hand among them.
    pub fn vertex_count(&self) -> usize {
        self.cloud.used_count()
    }

    /// Points in the window, duplicates and those of the frame in hand among them.
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

    /// Levels of tiles below the whole cloud. For tests.
    #[doc(hidden)]
    pub fn tile_depth(&self) -> usize {
        self.tiles.as_ref().map_or(0, Tiles::depth)
    }

    /// With tiles of another size, which are followed whatever the effort: small ones make deep trees of small clouds. For tests.
    #[doc(hidden)]
    pub fn with_leaf(mut self, leaf: usize) -> Self {
        (self.leaf, self.is_for_tiles_only) = (leaf, true);
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
