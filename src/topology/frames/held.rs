//! What a follower asks of the skeleton that is held between frames.
//!
//! In: nothing. Out: the trait that every way to hold a skeleton implements. Invariant: all implementations give the same answers. Must not know: where
//! skeletons come from.

use crate::topology::cloud::Vertex;
use crate::topology::skeleton::{Critical, Selection, TreeEdgeId, ViewSpec};

/// A skeleton as it is held now, asked for parts of it.
pub trait HeldSkeleton {
    /// Number of vertices.
    fn vertex_count(&self) -> usize;
    /// All vertices, by id.
    fn vertices(&self) -> Vec<Vertex>;
    /// Tree edges that enter after one scale and not after another one, in no order; all up to the second, if there is no first.
    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId>;
    /// Dots of at least this persistence, in no order.
    fn dots_down_to(&self, persistence: f64) -> Vec<Critical>;
    /// What gaps select.
    fn select(&mut self, spec: ViewSpec) -> Option<Selection>;
}
