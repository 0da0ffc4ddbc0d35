//! Frames of a stream as messages: those of the plane, or those of a space.
//!
//! In: steps, diffs and rankings of the core, and the shape of their stream. Out: messages.
//!
//! Invariants: numbers go over bit by bit. Messages of a space have the dimension of their stream, and 0 before its
//! first point.
//!
//! Must not know: bytes, who is sent a message.

use hopes::topology::{Critical, Diff, EdgeId, RankedDot, Ranking, Step, Vertices};
use hopes_protocol as wire;

/// Which messages a stream's frames are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Those of the plane.
    Plane,
    /// Those of a space.
    Space {
        /// Its metric.
        metric: wire::Metric,
        /// The number of coordinates of its points; 0 before the first one.
        dimension: u32,
    },
}

impl Shape {
    /// The number of coordinates of a point.
    pub fn dimension(self) -> u32 {
        match self {
            Self::Plane => 2,
            Self::Space { dimension, .. } => dimension,
        }
    }
}

/// The numbers of the frame that a step leads to.
pub fn frame_info(view: wire::View, step: &Step, rejected: u64) -> wire::FrameInfo {
    let selection = step.selection.as_ref();
    wire::FrameInfo {
        number: step.number,
        time: step.time.filter(|time| time.is_finite()),
        points: step.points,
        vertices: step.vertices as u64,
        rejected,
        view,
        ds: selection.and_then(|selection| selection.ds).filter(|ds| ds.is_finite()),
        vs: selection.map(|selection| selection.vs).filter(|vs| vs.is_finite()),
        components: step.components as u64,
        cycles: step.cycles as u64,
    }
}

/// The change of a view from one frame to another.
pub fn diff(
    (stream, shape): (u32, Shape),
    from: u64,
    frame: wire::FrameInfo,
    diff: &Diff,
    checksum: u64,
) -> wire::Message {
    let vertices_removed = diff.vertices_removed.iter().map(|id| id.0).collect();
    let edges_added = diff.tree_added.iter().map(edge).collect();
    let edges_removed = diff.tree_removed.iter().map(edge).collect();
    let critical_set = diff.critical_set.iter().map(critical).collect();
    let critical_removed = diff.critical_removed.iter().map(edge).collect();
    match shape {
        Shape::Plane => wire::Diff {
            stream,
            from,
            frame,
            vertices_added: planar(&diff.vertices_added),
            vertices_removed,
            edges_added,
            edges_removed,
            critical_set,
            critical_removed,
            checksum,
        }
        .into(),
        Shape::Space { dimension, .. } => wire::SpaceDiff {
            stream,
            from,
            frame,
            dimension,
            ids_added: ids(&diff.vertices_added),
            coordinates_added: diff.vertices_added.all_coordinates().to_vec(),
            vertices_removed,
            edges_added,
            edges_removed,
            critical_set,
            critical_removed,
            checksum,
        }
        .into(),
    }
}

/// A step from nothing, as a whole.
pub fn snapshot(
    (stream, shape): (u32, Shape),
    cause: wire::Cause,
    frame: wire::FrameInfo,
    step: &Step,
) -> wire::Message {
    debug_assert_eq!(step.from, 0, "a snapshot starts from nothing");
    let (diff, checksum) = (&step.diff, step.checksum.0);
    // Vertices first: lists that are freed in other orders leave more holes between what is held for consumers.
    let edges = || diff.tree_added.iter().map(edge).collect();
    let critical = || diff.critical_set.iter().map(critical).collect();
    match shape {
        Shape::Plane => {
            let vertices = planar(&diff.vertices_added);
            let (edges, critical) = (edges(), critical());
            wire::Snapshot { stream, cause, frame, vertices, edges, critical, checksum }.into()
        }
        Shape::Space { metric, dimension } => {
            let (ids, coordinates) = (ids(&diff.vertices_added), diff.vertices_added.all_coordinates().to_vec());
            let (edges, critical) = (edges(), critical());
            wire::SpaceSnapshot { stream, cause, frame, metric, dimension, ids, coordinates, edges, critical, checksum }
                .into()
        }
    }
}

/// About how many bytes a snapshot of a frame has on the wire.
pub fn snapshot_size(frame: &wire::FrameInfo, shape: Shape) -> u64 {
    // An id has about four bytes.
    let of_vertex = 4 + 8 * u64::from(shape.dimension());
    of_vertex * frame.vertices + 8 * frame.vertices.saturating_sub(frame.components) + 24 * frame.cycles
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Dots {
    /// Of the plane.
    Plane(Vec<wire::Dot>),
    /// Of a space.
    Space(Vec<wire::SpaceDot>),
}

impl Dots {
    /// Those of a ranking.
    pub fn new(shape: Shape, ranking: &Ranking) -> Self {
        match shape {
            Shape::Plane => {
                let dot = |ranked: &RankedDot| {
                    let ((a, b, birth, death), hole) = (critical(&ranked.critical), ranked.hole?);
                    Some(wire::Dot { edge: (a, b), birth, death, center: hole.center.into(), radius: hole.radius })
                };
                // In the plane, each has a hole.
                Self::Plane(ranking.dots.iter().filter_map(dot).collect())
            }
            Shape::Space { .. } => Self::Space(ranking.dots.iter().map(space_dot).collect()),
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::Plane(dots) => dots.len(),
            Self::Space(dots) => dots.len(),
        }
    }

    /// The bytes that they take.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Plane(dots) => size_of_val(dots.as_slice()),
            Self::Space(dots) => size_of_val(dots.as_slice()),
        }
    }

    /// Whether the first `most` of them are the same as the first of others.
    pub fn are_same(&self, other: &Self, most: usize) -> bool {
        match (self, other) {
            (Self::Plane(own), Self::Plane(other)) => top(own, most) == top(other, most),
            (Self::Space(own), Self::Space(other)) => top(own, most) == top(other, most),
            _ => false,
        }
    }

    /// The first `most` of them, of so many in a frame of a stream, as a message.
    pub fn message(&self, stream: u32, frame: u64, total: u64, most: usize) -> wire::Message {
        match self {
            Self::Plane(dots) => wire::Dots { stream, frame, total, dots: top(dots, most).to_vec() }.into(),
            Self::Space(dots) => wire::SpaceDots { stream, frame, total, dots: top(dots, most).to_vec() }.into(),
        }
    }
}

fn top<T>(dots: &[T], most: usize) -> &[T] {
    &dots[..most.min(dots.len())]
}

fn space_dot(ranked: &RankedDot) -> wire::SpaceDot {
    let (a, b, birth, death) = critical(&ranked.critical);
    let death = Some(death).filter(|death| death.is_finite());
    wire::SpaceDot { edge: (a, b), birth, death, death_edge: ranked.death_edge.as_ref().map(edge) }
}

fn planar(vertices: &Vertices) -> Vec<wire::Vertex> {
    vertices.ids().iter().zip(vertices.positions()).map(|(id, [x, y])| (id.0, x, y)).collect()
}

fn ids(vertices: &Vertices) -> Vec<u64> {
    vertices.ids().iter().map(|id| id.0).collect()
}

fn edge([a, b]: &EdgeId) -> wire::Edge {
    (a.0, b.0)
}

/// A critical edge: its ends, birth and death.
fn critical(critical: &Critical) -> wire::Critical {
    let [a, b] = critical.edge;
    (a.0, b.0, critical.birth, critical.death)
}
