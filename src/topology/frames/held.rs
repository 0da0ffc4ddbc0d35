//! The queries of a follower to the skeleton that is stored between frames.
//!
//! In: nothing.
//! Out: a trait, which each representation of a skeleton implements; and its answers for a whole skeleton of any space.
//! Invariant: all implementations give the same answers.
//! Must not know: where skeletons come from.

use crate::topology::cloud::Vertices;
use crate::topology::skeleton::{Critical, Selection, Skeleton, TreeEdgeId, ViewSpec, select};

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

impl HeldSkeleton for &Skeleton {
    fn vertex_count(&self) -> usize {
        Skeleton::vertices(self).len()
    }

    fn vertices(&self) -> Vertices {
        Skeleton::vertices(self).clone()
    }

    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId> {
        let is_between = |edge: &TreeEdgeId| low.is_none_or(|low| edge.scale > low) && edge.scale <= high;
        let edge = |(edge, scale)| TreeEdgeId { edge: self.edge_id(edge), scale };
        self.scaled_tree().map(edge).filter(is_between).collect()
    }

    fn dots_down_to(&self, persistence: f64) -> Vec<Critical> {
        let found = self.unsorted_dots().iter().filter(|dot| dot.persistence() >= persistence);
        found.map(|dot| self.critical(dot)).collect()
    }

    fn select(&mut self, spec: ViewSpec) -> Option<Selection> {
        match spec {
            ViewSpec::Derived { k, l } => Some(select(self, k, l)),
            ViewSpec::Full | ViewSpec::Reduced { .. } => None,
        }
    }
}
