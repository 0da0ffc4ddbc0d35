//! Vertices: the distinct positions of a cloud, and how they come and go.
//!
//! In: nothing. Out: the types that name a vertex. Must not know: how a cloud keeps them.

use super::position::Position;

/// Names a vertex for as long as its stream lives; never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexId(pub u64);

/// Where the cloud keeps a vertex; reused once the vertex is gone.
pub type Slot = u32;

/// A distinct position of the cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Its name.
    pub id: VertexId,
    /// Where it is.
    pub position: Position,
}

/// What commits changed since the change taken before. Both lists are in order of id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CloudChange {
    /// Slots of vertices that were not there then.
    pub appeared: Vec<Slot>,
    /// Slots of vertices that are gone; they may be reused once the next change is taken.
    pub vanished: Vec<Slot>,
}
