//! The queries of a follower to the skeleton that is stored between frames.
//!
//! In: nothing.
//! Out: a trait, which each representation of a skeleton implements.
//! Invariant: all implementations give the same answers.
//! Must not know: where skeletons come from.

use crate::topology::cloud::Vertices;
use crate::topology::skeleton::{Critical, Selection, TreeEdgeId, ViewSpec};

/// The current skeleton, in any representation.
pub trait HeldSkeleton {
    /// The number of vertices.
    fn vertex_count(&self) -> usize;
    /// All vertices, by id.
    fn vertices(&self) -> Vertices;
    /// Tree edges that enter after `low` and not after `high`, in no order. Without `low`: all up to `high`.
    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId>;
    /// Dots of at least this persistence, in no order.
    fn dots_down_to(&self, persistence: f64) -> Vec<Critical>;
    /// The selection by gaps, for a derived view.
    fn select(&mut self, spec: ViewSpec) -> Option<Selection>;
}
