//! A stream's engine: points in, frames out, nothing computed before it is asked for.
//!
//! In: batches and commits. Out: [`Frame`]s. Invariants: a frame shows the cloud as of its commit; however often and in whatever
//! views it is asked for, its skeleton is computed once; refused points change nothing. Must not know: threads, clocks, formats.

use std::collections::HashMap;
use std::sync::Arc;

use super::basins::Basins;
use super::cloud::{Cloud, Refusal, VertexId};
use super::delaunay::Delaunay;
use super::filtration::Filtration;
use super::hole::Holes;
use super::mesh::Mesh;
use super::skeleton::{Dot, Skeleton};
use super::view::{View, ViewSpec};
use super::window::Window;

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
/// the frame. [`poll_frame`](Self::poll_frame) gives the newest frame, if it was not given yet, and computes it: commits that
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
    newest: Option<Arc<Frame>>,
    /// The newest frame's triangulation and basins; the next one is computed in their memory.
    mesh: Mesh,
    basins: Basins,
    computed: u64,
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
            mesh: Mesh::default(),
            basins: Basins::default(),
            computed: 0,
        }
    }

    /// Makes room for so many more points at once; less work later, no other effect.
    pub fn reserve(&mut self, points: usize) {
        self.cloud.reserve(points);
    }

    /// Adds a point with its event time, if it has one.
    ///
    /// # Errors
    /// [`Refusal`]: the point was left out.
    pub fn feed_point(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<(), Refusal> {
        self.cloud.insert(x, y, time).map(drop)
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

    /// The newest committed frame, unless it was given already.
    pub fn poll_frame(&mut self) -> Option<Arc<Frame>> {
        let given = self.newest.as_ref().map_or(0, |frame| frame.number);
        (given < self.committed).then(|| self.compute())
    }

    /// The boundaries, at birth, of the holes of some dots of the newest frame that was given: see [`Holes::boundary`].
    ///
    /// Takes linear time once, and then time in proportion to the holes. Dots of another frame have no walks.
    pub fn hole_boundaries(&self, dots: &[Dot]) -> Vec<Vec<Vec<u32>>> {
        let mut rank = vec![0; self.cloud.slot_count()];
        let vertices = self.newest.iter().flat_map(|frame| frame.skeleton.vertices()).map(|vertex| vertex.id);
        let places: HashMap<VertexId, u32> = vertices.zip(0..).collect();
        for &slot in self.mesh.slots() {
            rank[slot as usize] = places.get(&self.cloud.id(slot)).copied().unwrap_or(u32::MAX);
        }
        let holes = Holes::new(&self.mesh, &self.basins, &rank);
        dots.iter().map(|dot| holes.boundary(dot)).collect()
    }

    /// The newest frame that was given.
    pub fn newest(&self) -> Option<&Arc<Frame>> {
        self.newest.as_ref()
    }

    /// How many skeletons were computed so far.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// Points in the window, duplicates and those of the frame in hand among them.
    pub fn point_count(&self) -> u64 {
        self.cloud.point_count()
    }

    fn compute(&mut self) -> Arc<Frame> {
        let change = self.cloud.take_change();
        self.delaunay.apply(&self.cloud, &change);
        self.delaunay.read_into(&mut self.mesh);
        let (basins, links) = Basins::contract(&self.mesh, Filtration::new(&self.mesh));
        let skeleton = Skeleton::new(&self.cloud, &self.mesh, &basins, links);
        self.basins = basins;
        self.computed += 1;
        let frame = Frame { number: self.committed, time: self.time, points: self.points, skeleton };
        let frame = Arc::new(frame);
        self.newest = Some(Arc::clone(&frame));
        frame
    }

    /// Panics when the engine contradicts itself. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        self.cloud.check_invariants();
        if self.newest.as_ref().is_some_and(|frame| frame.number == self.committed) {
            self.delaunay.check_invariants(&self.cloud);
        }
    }
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
