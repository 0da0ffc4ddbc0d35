//! The cycles of tracks, as questions to a later frame.
//!
//! In: nothing.
//! Out: the questions and the answers.
//! Must not know: how they are answered.

use std::sync::Arc;

use crate::topology::cloud::{Coordinates, VertexId};
use crate::topology::skeleton::EdgeId;

/// A question: where is the cycle of a track in another frame, and what is it the sum of?
#[derive(Clone, Debug)]
pub struct TrackWalk {
    /// The vertices of the cycle when it was last seen.
    pub vertices: Arc<[(VertexId, Coordinates)]>,
    /// The birth of its dot then.
    pub birth: f64,
    /// The death of its dot then.
    pub death: f64,
    /// Whether it is known to die with its dot, and so is a cycle of no other one that lives longer.
    pub is_own: bool,
}

/// Questions are equal if they are of one cycle in one frame.
impl PartialEq for TrackWalk {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.vertices, &other.vertices) && (self.birth, self.death) == (other.birth, other.death)
    }
}

/// An answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WalkAnswer {
    /// The cycle in the other frame, shortened there: a closed walk of its vertices.
    pub vertices: Vec<VertexId>,
    /// The critical edges of the dots that the cycle is the sum of, at the geometric mean of birth and death. None if
    /// it is no cycle there.
    pub dots: Option<Vec<EdgeId>>,
}
