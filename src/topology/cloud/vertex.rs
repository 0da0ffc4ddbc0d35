//! Vertices: the distinct sites of a cloud.
//!
//! In: nothing.
//! Out: the types that name a vertex, and the change of a cloud.
//! Must not know: how a cloud stores them.

use super::position::Position;

/// The id of a vertex: never reused in its stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexId(pub u64);

/// The index under which the cloud stores a vertex; reused after the vertex is gone.
pub type Slot = u32;

/// A distinct position of the cloud; outside of the plane another [`Site`](super::Site).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex<S = Position> {
    /// Its id.
    pub id: VertexId,
    /// Its position.
    pub position: S,
}

/// A vertex that waits for a point. It may vanish meanwhile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Awaiting<S> {
    /// Where it is.
    pub position: S,
    /// Its slot.
    pub slot: Slot,
    /// Its id.
    pub vertex: VertexId,
}

/// What commits changed since the last change was taken. Both lists are in order of id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudChange {
    /// Slots of new vertices.
    pub appeared: Vec<Slot>,
    /// Slots of vertices that are gone. They may be reused once the next change is taken.
    pub vanished: Vec<Slot>,
}
