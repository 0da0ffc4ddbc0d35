//! A snapshot of a space, laid out in the plane.
//!
//! In: a snapshot. Out: one whose vertices have two coordinates: their own, or their first two principal components.
//!
//! Invariants: nothing but positions is changed.
//!
//! Must not know: formats, how components are found.

use hopes::topology::{VertexId, Vertices};
use hopes_protocol::{Snapshot, SpaceSnapshot};

use crate::daemon::metric;
use crate::formats::layout::{Layout, Shape};

/// The snapshot in the plane.
pub fn laid_out(snapshot: &SpaceSnapshot) -> Snapshot {
    let points = snapshot.coordinates.chunks_exact((snapshot.dimension as usize).max(1));
    let vertices: Vertices = snapshot.ids.iter().map(|&id| VertexId(id)).zip(points).collect();
    let layout = Layout::<2>::new(&vertices, Shape::Points(metric(snapshot.metric)), None);
    Snapshot {
        stream: snapshot.stream,
        cause: snapshot.cause,
        frame: snapshot.frame.clone(),
        vertices: snapshot.ids.iter().zip(layout.places()).map(|(&id, &[x, y])| (id, x, y)).collect(),
        edges: snapshot.edges.clone(),
        critical: snapshot.critical.clone(),
        checksum: snapshot.checksum,
    }
}
