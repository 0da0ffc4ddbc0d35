//! A stream's engine: points in, frames out, nothing computed before it is asked for.
//!
//! In: batches and commits. Out: [`Frame`]s as a whole, or [`Step`]s from frame to frame. Invariants: a frame shows the cloud as of its commit; however
//! often and in whatever views it is asked for, its skeleton is computed once, in one pass or by following what changed, whichever is faster; both
//! give the same; refused points change nothing. Must not know: threads, clocks, formats.

use std::collections::HashMap;
use std::sync::Arc;

use thiserror::Error;

use super::basins::Basins;
use super::change::{self, Change, Tree};
use super::cloud::{Cloud, CloudChange, Refusal, Slot, VertexId};
use super::cocircular::Located;
use super::delaunay::{Delaunay, Update};
use super::diagram::Diagram;
use super::diff::Snapshot;
use super::filtration::Filtration;
use super::follow::{Follower, Step};
use super::held::{HeldTiles, HeldWhole};
use super::hole;
use super::kept_regions::KeptRegions;
use super::mesh::Mesh;
use super::ranking::Ranking;
use super::reduction::Link;
use super::region::Region;
use super::sighting::{Sighting, Sightings, sight};
use super::simplified::SimplifiedFollower;
use super::skeleton::{Dot, Skeleton};
use super::stage::{Stage, StageHook};
use super::tiles::{Dirt, Guide, LEAF, Tiles};
use super::track::{At, TrackId, TrackStep, Tracker};
use super::view::{View, ViewSpec};
use super::window::Window;

/// What is held of a frame is not what its cloud gives: a fault of this library.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("frame {frame} contradicts recomputation from scratch: {what}; please report it with the input")]
pub struct Contradiction {
    /// The frame.
    pub frame: u64,
    /// What differs.
    pub what: String,
}

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

/// One closed frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Counts commits, from 1.
    pub number: u64,
    /// The time given at its commit.
    pub time: Option<f64>,
    /// Points in the window, duplicates among them.
    pub points: u64,
    /// The skeleton of the cloud.
    pub skeleton: Skeleton,
}

impl Frame {
    /// A part of the frame's skeleton.
    pub fn view(&self, spec: ViewSpec) -> View {
        View::new(&self.skeleton, spec)
    }
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
    dirt: Dirt,
    /// The persistence diagram of the tiles' dots, once gaps were asked for.
    diagram: Option<Diagram>,
    /// What turned the frame reached before into this one, if somebody may want to know.
    change: Option<Change>,
    is_followed: bool,
    /// The triangulation and the basins of the last frame that was computed as a whole; the next one is computed in their memory.
    mesh: Mesh,
    basins: Basins,
    /// Regions of holes that somebody has asked for in the frame before, as far as they still are what they were.
    regions: KeptRegions,
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
            dirt: Dirt::default(),
            diagram: None,
            change: None,
            is_followed: false,
            mesh: Mesh::default(),
            basins: Basins::default(),
            regions: KeptRegions::default(),
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
                let mut held = HeldTiles { cloud: &self.cloud, tiles, diagram: &mut self.diagram };
                follower.advance(number, &mut held, change)
            }
            (None, Some(frame)) => {
                follower.advance(number, &mut HeldWhole { cloud: &self.cloud, skeleton: &frame.skeleton }, change)
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
            (Some(tiles), _) => Ranking::of_tiles(self.reached, &self.cloud, tiles, most),
            (None, Some(frame)) => Ranking::of_skeleton(self.reached, &frame.skeleton, most),
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
        Some(
            tracker.advance(at, sightings, |sighting| regions.get(sighting, || find_region(cloud, delaunay, sighting))),
        )
    }

    /// The regions that the holes of a tracker's tracks take up at their births, by id; without those that are not there in the newest frame. Takes time in proportion to
    /// the regions that something has touched since they were asked for in the frame before, and to all that were not.
    pub fn track_regions(&mut self, tracker: &Tracker) -> Vec<(TrackId, Region)> {
        if tracker.frame() != self.reached {
            return Vec::new();
        }
        let Self { regions, cloud, delaunay, .. } = self;
        let mut region = |sighting| regions.get(sighting, || find_region(cloud, delaunay, sighting));
        tracker.seen().map(|(id, sighting)| (id, region(sighting))).collect()
    }

    /// What a tracker looks at.
    fn sight(&mut self, tracker: &Tracker) -> Sightings {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => {
                let mut held = HeldTiles { cloud: &self.cloud, tiles, diagram: &mut self.diagram };
                sight(tracker.options().rule, tracker.looks_for(), &mut held)
            }
            (None, Some(frame)) => {
                let mut held = HeldWhole { cloud: &self.cloud, skeleton: &frame.skeleton };
                sight(tracker.options().rule, tracker.looks_for(), &mut held)
            }
            (None, None) => unreachable!("a frame that was reached is held"),
        }
    }

    /// The boundaries, at birth, of the holes of some dots of the newest frame that was given, as closed walks along edges of the alpha complex at that scale.
    ///
    /// A walk is given as places in [`Skeleton::vertices`], without its first vertex at the end. The first walk is the outer one and runs
    /// counter-clockwise; the others run clockwise around islands in the hole. A walk begins at its smallest vertex by position; it passes a vertex more than
    /// once where the boundary touches itself. Takes linear time once, and then time in proportion to the holes. Dots of another frame have no walks.
    pub fn hole_boundaries(&self, dots: &[Dot]) -> Vec<Vec<Vec<u32>>> {
        let is_newest = |frame: &&Arc<Frame>| frame.number == self.reached && self.reached == self.committed;
        let Some(frame) = self.newest.as_ref().filter(is_newest) else {
            return vec![Vec::new(); dots.len()];
        };
        let slots: HashMap<VertexId, Slot> = self.cloud.vertices().map(|(slot, vertex)| (vertex.id, slot)).collect();
        let vertices = frame.skeleton.vertices();
        let mut rank = vec![0; self.cloud.slot_count()];
        for (vertex, place) in vertices.iter().zip(0..) {
            rank[slots[&vertex.id] as usize] = place;
        }
        let site = |place: u32| vertices.get(place as usize).map(|vertex| (vertex.position, slots[&vertex.id]));
        let walks = |dot: &Dot| {
            let [Some(a), Some(b), Some(c)] = dot.triangle.map(site) else { return None };
            let [Some(from), Some(to)] = dot.edge.map(site) else { return None };
            hole::boundary(&self.delaunay, [a, b, c], [from.0, to.0])
        };
        let ranks = |walk: Vec<Located<Slot>>| walk.into_iter().map(|(_, slot)| rank[slot as usize]).collect();
        dots.iter().map(|dot| walks(dot).unwrap_or_default().into_iter().map(ranks).collect()).collect()
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

    /// Compares what is held of the newest frame with what one pass over its cloud gives, and a follower of it with the view of that.
    ///
    /// # Errors
    /// [`Contradiction`]: the first difference.
    pub fn check(&mut self, follower: &Follower) -> Result<(), Contradiction> {
        self.reach();
        let mut delaunay = Delaunay::default();
        let all = CloudChange { appeared: self.cloud.vertices().map(|(slot, _)| slot).collect(), ..Default::default() };
        delaunay.apply(&self.cloud, &all);
        let mesh = delaunay.mesh();
        let (basins, links) = Basins::contract(&mesh, Filtration::new(&mesh));
        let reference = Skeleton::new(&self.cloud, &mesh, &basins, links);
        let frame = self.frame();
        frame.skeleton.compare(&reference).map_or(Ok(()), |what| Err(Contradiction { frame: self.reached, what }))?;
        let view = View::new(&reference, follower.spec());
        let snapshot = Snapshot::new(&reference, &view);
        let shown = (follower.edges(), follower.cycles(), follower.checksum());
        let wanted = (view.tree.len(), view.cycles, snapshot.checksum());
        if follower.frame() == self.reached && shown != wanted {
            let what = format!("the view's edges, cycles and checksum are {shown:?}, and should be {wanted:?}");
            return Err(Contradiction { frame: self.reached, what });
        }
        Ok(())
    }

    /// Brings what is held to the newest committed frame.
    fn reach(&mut self) {
        if self.reached == self.committed {
            return;
        }
        self.stages.begin(Stage::Triangulation);
        let change = self.cloud.take_change();
        let is_for_tiles = self.is_for_tiles(&change);
        self.dirt.clear();
        let mut guide = Guide::new(self.tiles.as_ref().filter(|_| is_for_tiles), &mut self.dirt);
        let by = if is_for_tiles { Update::Stepwise } else { Delaunay::faster(&self.cloud, &change) };
        let update = self.delaunay.apply_by(by, &self.cloud, &change, &mut guide);
        self.disturb_regions(&change, update);
        self.stages.begin(Stage::Reduction);
        let told = self.is_followed.then(|| Change::of_cloud(self.reached, &self.cloud, &change));
        self.reached = self.committed;
        self.computed += 1;
        self.change = match &mut self.tiles {
            Some(tiles) if is_for_tiles && update == Update::Stepwise => {
                self.whole = None;
                let difference = tiles.follow(&self.cloud, &self.delaunay, &change, &self.dirt);
                if let Some(diagram) = &mut self.diagram {
                    diagram.follow(&difference, |dot| change::critical(&self.cloud, dot));
                }
                told.map(|told| told.with_difference(&self.cloud, &difference))
            }
            _ => {
                // What is held now goes before the new is made, but for what has to be compared.
                let (tiles, whole) = (self.tiles.take(), self.whole.take());
                let gathered = told.as_ref().and(tiles).map(|tiles| Tree::of_tiles(&self.cloud, &tiles));
                self.diagram = None;
                if is_for_tiles && update == Update::Stepwise {
                    self.tiles = Some(Tiles::new(&self.cloud, &self.delaunay, self.leaf));
                } else {
                    self.compute_whole();
                }
                let old = gathered.or_else(|| whole.as_deref().map(|frame| Tree::Whole(&frame.skeleton)));
                told.map(|told| told.with_trees(&old.unwrap_or(Tree::Empty), &self.tree()))
            }
        };
        self.stages.begin(Stage::Done);
    }

    /// Lets go of regions that a change may have changed.
    fn disturb_regions(&mut self, change: &CloudChange, update: Update) {
        let Self { regions, cloud, .. } = self;
        match update {
            // Most streams are not tracked: their frames pay nothing for this.
            _ if regions.is_empty() => {}
            // So much has changed that hardly any region is untouched.
            Update::Bulk => regions.clear(),
            // A slot that was emptied in this change still says what it held.
            Update::Stepwise => {
                let slots = change.appeared.iter().chain(&change.vanished);
                regions.disturb(&slots.map(|&slot| cloud.position(slot)).collect::<Vec<_>>());
            }
        }
    }

    /// Whether a change is worth being followed in tiles, rather than computed in one pass.
    fn is_for_tiles(&mut self, change: &CloudChange) -> bool {
        let vertices = self.cloud.vertex_count() as f64;
        let share = (change.appeared.len() + change.vanished.len()) as f64 / vertices;
        let is_worth_it = match &self.tiles {
            _ if self.is_for_tiles_only => return Delaunay::faster(&self.cloud, change) == Update::Stepwise,
            Some(tiles) => tiles.effort(&self.cloud, change) <= vertices,
            // Tiles have to be made first. Where they were given up, only much smaller changes are worth another try.
            None => share <= self.worth_tiles,
        };
        if self.tiles.is_some() && !is_worth_it {
            self.worth_tiles = share / 2.0;
        }
        is_worth_it
    }

    /// The tree that is held.
    fn tree(&self) -> Tree<'_> {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => Tree::of_tiles(&self.cloud, tiles),
            (None, Some(frame)) => Tree::Whole(&frame.skeleton),
            (None, None) => Tree::Empty,
        }
    }

    /// One pass over everything.
    fn compute_whole(&mut self) {
        let links = self.contract();
        let skeleton = Skeleton::new(&self.cloud, &self.mesh, &self.basins, links);
        self.whole = Some(Arc::new(self.frame_of(skeleton)));
    }

    fn contract(&mut self) -> Vec<Link> {
        self.delaunay.read_into(&mut self.mesh);
        let (basins, links) = Basins::contract(&self.mesh, Filtration::new(&self.mesh));
        self.basins = basins;
        links
    }

    fn frame_of(&self, skeleton: Skeleton) -> Frame {
        Frame { number: self.committed, time: self.time, points: self.points, skeleton }
    }

    /// The frame that is held, as a whole.
    fn frame(&mut self) -> Arc<Frame> {
        if let (None, Some(tiles)) = (&self.whole, &self.tiles) {
            self.whole = Some(Arc::new(self.frame_of(Skeleton::of_tiles(&self.cloud, tiles))));
        }
        Arc::clone(self.whole.as_ref().expect("a frame that was reached is held"))
    }

    #[cfg(test)]
    pub(super) fn forget_regions(&mut self) {
        self.regions.clear();
    }

    #[cfg(test)]
    pub(super) fn kept_regions(&self) -> usize {
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

    /// Panics when the engine contradicts itself. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        self.cloud.check_invariants();
        if self.reached == self.committed {
            self.delaunay.check_invariants(&self.cloud);
            if let Some(tiles) = &self.tiles {
                tiles.check_shape();
                tiles.check_stars(&self.delaunay);
            }
        }
    }
}

/// The region of a hole, if it is there.
fn find_region(cloud: &Cloud, delaunay: &Delaunay, sighting: &Sighting) -> Option<Region> {
    let walks = hole::boundary(delaunay, sighting.name, sighting.edge)?;
    Some(Region::new(walks, |slot| cloud.id(slot)))
}

#[cfg(test)]
mod tests {
    use super::*;

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
