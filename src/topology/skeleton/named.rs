//! Elements of a skeleton by the ids of their vertices, which last from frame to frame.
//!
//! In: nothing. Out: the types that frames, tracks and consumers name elements by. Must not know: how skeletons are found, places in lists.

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

/// An edge of the minimum spanning tree and the scale at which it enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeEdgeId {
    /// Its ends.
    pub edge: EdgeId,
    /// Half its length.
    pub scale: f64,
}
