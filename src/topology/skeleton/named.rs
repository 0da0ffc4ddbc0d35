//! Elements of a skeleton by the ids of their vertices, which are valid over frames.
//!
//! In: nothing.
//! Out: the types by which frames, tracks and consumers name elements.
//! Must not know: places in lists, how skeletons are found.

use crate::topology::cloud::VertexId;

/// An edge by the ids of its ends, the smaller first.
pub type EdgeId = [VertexId; 2];

/// A critical edge with its label; scales are radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// The edge.
    pub edge: EdgeId,
    /// Half its length.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
}

/// An edge of the minimum spanning tree, and the scale at which it enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeEdgeId {
    /// Its ends.
    pub edge: EdgeId,
    /// Half its length.
    pub scale: f64,
}
