//! The outliers of a pipeline: told apart when a frame is computed, and set aside in the cloud.
//!
//! In: the change of the cloud.
//! Out: the change of the points that pass; the outliers, whole or from frame to frame.
//! Invariants: outliers keep their slots and ids, so a point that comes back from among them is the vertex that it was.
//! Nothing is computed for a frame that nobody asks for.
//! Must not know: how outliers are told apart, triangulations.

use super::Pipeline;
use super::check::Contradiction;
use crate::topology::cloud::{Cloud, CloudChange, Slot, VertexId, Vertices};
use crate::topology::declutter::{Declutter, Decluttered, Filter};

/// The outliers of a stream.
#[derive(Clone, Debug)]
pub(super) struct Outliers {
    rule: Declutter,
    filter: Filter,
    /// Their change from the frame computed before.
    change: OutlierStep,
}

/// What changed among the outliers between two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutlierStep {
    /// The number of the frame it leads to.
    pub number: u64,
    /// The number of the frame it starts from; 0 if all outliers are new.
    pub from: u64,
    /// New outliers, by id.
    pub added: Vertices,
    /// Outliers that are gone, or pass now.
    pub removed: Vec<VertexId>,
}

impl Outliers {
    pub fn boxed(rule: Declutter) -> Box<Self> {
        Box::new(Self { rule, filter: Filter::new(rule), change: OutlierStep::default() })
    }

    /// Follows a change of the cloud between two frames. Returns the change of the points that pass.
    pub fn follow(&mut self, cloud: &mut Cloud, change: &CloudChange, [from, number]: [u64; 2]) -> CloudChange {
        let sides = self.filter.follow(cloud, change);
        // What has vanished from the window has left its place in the cloud by itself.
        sides.passing.appeared.iter().for_each(|&slot| cloud.set_aside(slot, false));
        sides.outliers.appeared.iter().for_each(|&slot| cloud.set_aside(slot, true));
        let removed = sides.outliers.vanished.iter().map(|&slot| cloud.id(slot)).collect();
        self.change = OutlierStep { number, from, added: vertices(cloud, &sides.outliers.appeared), removed };
        sides.passing
    }

    pub fn report(&self) -> Decluttered {
        self.filter.report()
    }

    pub fn bytes(&self) -> usize {
        self.filter.bytes()
    }

    /// Their slots, by id.
    fn slots(&self, cloud: &Cloud) -> Vec<Slot> {
        let mut slots = self.filter.outliers();
        slots.sort_unstable_by_key(|&slot| cloud.id(slot));
        slots
    }

    /// Compares them with those of a filter that knows nothing of earlier frames.
    pub fn check(&self, cloud: &Cloud, frame: u64) -> Result<(), Contradiction> {
        let mut filter = Filter::new(self.rule);
        let all = CloudChange { appeared: cloud.all_vertices().map(|(slot, _)| slot).collect(), ..Default::default() };
        let wanted = filter.follow(cloud, &all);
        let (told, report) = (self.slots(cloud), self.report());
        if (&told, report) == (&wanted.outliers.appeared, filter.report()) {
            return Ok(());
        }
        let what = format!(
            "it has {} outliers, by {report:?}, and should have {}, by {:?}",
            told.len(),
            wanted.outliers.appeared.len(),
            filter.report()
        );
        Err(Contradiction { frame, what })
    }
}

impl Pipeline {
    /// What changed among the outliers from a frame to the newest one. If `from` is not the frame that was computed
    /// before it, all of its outliers are new. Takes time in proportion to the answer; of all outliers, in proportion
    /// to the cloud.
    ///
    /// ```
    /// use hopes::topology::{Declutter, Options, Pipeline};
    ///
    /// let mut pipeline = Pipeline::new(Options { declutter: Some(Declutter::default()), ..Options::default() });
    /// let ring = |i: u32| [(f64::from(i) * 0.1).cos(), (f64::from(i) * 0.1).sin()];
    /// pipeline.feed_points(&(0..63).map(ring).collect::<Vec<_>>(), None);
    /// pipeline.feed_point(0.1, 0.2, None)?;
    /// pipeline.commit(None);
    /// let frame = pipeline.poll_frame().expect("a frame was committed");
    /// assert_eq!((frame.points, frame.skeleton.vertices().len()), (64, 63));
    /// assert_eq!(frame.decluttered.map(|report| report.filtered), Some(1));
    /// assert_eq!(pipeline.poll_outliers(0).added.xy(0), [0.1, 0.2]);
    /// # Ok::<(), hopes::topology::Refusal>(())
    /// ```
    pub fn poll_outliers(&mut self, from: u64) -> OutlierStep {
        self.reach();
        let number = self.progress.reached;
        let Some(outliers) = self.outliers.as_deref().filter(|_| from < number) else {
            return OutlierStep { number, from, ..OutlierStep::default() };
        };
        if (outliers.change.from, outliers.change.number) == (from, number) {
            return outliers.change.clone();
        }
        let added = vertices(&self.cloud, &outliers.slots(&self.cloud));
        OutlierStep { number, from: 0, added, removed: Vec::new() }
    }
}

fn vertices(cloud: &Cloud, slots: &[Slot]) -> Vertices {
    slots.iter().map(|&slot| cloud.vertex(slot)).collect()
}
