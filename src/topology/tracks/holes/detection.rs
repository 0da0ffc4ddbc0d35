//! Detections in the plane: dots, each with its hole and the ids of its triangle.
//!
//! In: dots by slots of a cloud.
//! Out: [`Detection`].
//! Invariant: dots of equal persistence are in order of the triangles that name their deaths, by position.
//! Must not know: which detection belongs to which track.

use std::cmp::Ordering;

use crate::topology::cloud::{Cloud, Located, Position, Slot, VertexId};
use crate::topology::skeleton::{Critical, Hole};
use crate::topology::tracks::detection::Detected;

/// A dot of a frame, as a tracker uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// The critical edge and its label.
    pub critical: Critical,
    /// The positions of the ends of the critical edge.
    pub edge: [Position; 2],
    /// The triangle that names the death.
    pub name: [Located<Slot>; 3],
    /// The same triangle by ids, which are never reused.
    pub triangle: [VertexId; 3],
    /// The last point of its hole to be filled.
    pub hole: Hole,
}

impl Detection {
    /// A detection of a dot by slots.
    pub fn new(cloud: &Cloud, critical: Critical, edge: [Slot; 2], triangle: [Slot; 3], hole: Hole) -> Self {
        let position = |slot: Slot| cloud.position(slot);
        let name = triangle.map(|slot| (position(slot), slot));
        Self { critical, edge: edge.map(position), name, triangle: triangle.map(|slot| cloud.id(slot)), hole }
    }
}

impl Detected for Detection {
    type Name = [VertexId; 3];

    fn critical(&self) -> &Critical {
        &self.critical
    }

    fn name(&self) -> [VertexId; 3] {
        self.triangle
    }

    fn by_position(&self, other: &Self) -> Ordering {
        let corners = |detection: &Self| detection.name.map(|site| site.0);
        corners(self).cmp(&corners(other))
    }
}
