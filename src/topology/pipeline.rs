//! A stream's engine: points in, frames out, nothing computed before it is asked for.
//!
//! In: batches and commits. Out: [`Frame`]s. Invariants: a frame shows the cloud as of its commit; however often and in whatever
//! views it is asked for, its skeleton is computed once; refused points change nothing. Must not know: threads, clocks, formats.

use std::sync::Arc;

use super::basins::Basins;
use super::cloud::{Cloud, CloudChange, Refusal};
use super::delaunay::Delaunay;
use super::filtration::Filtration;
use super::skeleton::Skeleton;
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
    change: CloudChange,
    committed: u64,
    time: Option<f64>,
    newest: Option<Arc<Frame>>,
    computed: u64,
}

impl Pipeline {
    /// An empty stream.
    pub fn new(options: Options) -> Self {
        Self {
            cloud: Cloud::new(options.window, options.resolution),
            delaunay: Delaunay::default(),
            change: CloudChange::default(),
            committed: 0,
            time: None,
            newest: None,
            computed: 0,
        }
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

    /// Closes the frame in hand.
    pub fn commit(&mut self, time: Option<f64>) -> u64 {
        let change = self.cloud.commit();
        self.change = change;
        self.committed += 1;
        self.time = time;
        self.committed
    }

    /// The newest committed frame, unless it was given already.
    pub fn poll_frame(&mut self) -> Option<Arc<Frame>> {
        let shown = self.newest.as_ref().map_or(0, |frame| frame.number);
        if shown == self.committed { None } else { Some(self.compute()) }
    }

    fn compute(&mut self) -> Arc<Frame> {
        self.delaunay.apply(&self.cloud, &self.change);
        let mesh = self.delaunay.mesh();
        let filtration = Filtration::new(&mesh);
        let basins = Basins::new(&mesh, &filtration);
        let skeleton = Skeleton::new(&self.cloud, &mesh, &filtration, &basins);
        self.computed += 1;
        let frame = Arc::new(Frame { number: self.committed, time: self.time, points: self.cloud.point_count(), skeleton });
        self.newest = Some(Arc::clone(&frame));
        frame
    }
}
