//! Detections in R^d: dots, and short cycles of some of them.
//!
//! In: nothing.
//! Out: the types, and the queries of a tracker to the space of a frame.
//! Invariant: dots of equal persistence are in order of their births, then of the ends of their critical edges, by
//! position.
//! Must not know: how cycles and distances are found.

use std::cmp::Ordering;
use std::sync::Arc;

use crate::topology::cloud::{Coordinates, VertexId, compare_coordinates};
use crate::topology::skeleton::{Critical, EdgeId};
use crate::topology::tracks::detection::Detected;

/// A dot of a frame, as a tracker uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct CycleDetection {
    /// The critical edge and its label.
    pub critical: Critical,
    /// The ends of the critical edge, the smaller position first.
    pub ends: [Coordinates; 2],
}

impl Detected for CycleDetection {
    type Name = EdgeId;

    fn critical(&self) -> &Critical {
        &self.critical
    }

    fn name(&self) -> EdgeId {
        self.critical.edge
    }

    fn by_position(&self, other: &Self) -> Ordering {
        let by_end = |end: usize| compare_coordinates(self.ends[end].as_slice(), other.ends[end].as_slice());
        let by_ends = || by_end(0).then_with(|| by_end(1));
        self.critical.birth.total_cmp(&other.critical.birth).then_with(by_ends)
    }
}

/// A cycle of a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackedCycle {
    /// Its vertices, along it. The last one is joined to the first.
    pub vertices: Arc<[(VertexId, Coordinates)]>,
    /// The mean of its vertices.
    pub center: Vec<f64>,
    /// Half the largest distance between two of its vertices.
    pub radius: f64,
}

/// What a tracker asks of the space of a frame.
pub trait CycleSource {
    /// A short cycle of a dot of the frame, which is born with it.
    fn cycle(&self, detection: &CycleDetection) -> TrackedCycle;
    /// A closed walk in the frame as a cycle.
    fn along(&self, walk: &[VertexId]) -> TrackedCycle;
    /// The distance between two points; +infinity if one of them is nowhere in the space.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64;
}
