//! The pure core: from points to the homologically persistent skeleton of their cloud, and to what changed in it.
//!
//! Data flows one way, one file a stage:
//!
//! ```text
//! points -> cloud -> delaunay -> mesh -> filtration -> basins -> reduction -> skeleton -> gaps -> view -> diff
//!          (window)  (spade)            (flow, scales)          (elder rule) (HoPeS)   (DS, VS)
//! ```
//!
//! That is one pass over a whole cloud. Small changes are followed from the triangulation to the diff, at the cost of what changed:
//!
//! ```text
//! change of cloud -> delaunay -> tiles -> change -> diagram -> follow -> step (diff, checksum)
//!                   (observer)  (stars, borders)    (gaps)    (views)
//! ```
//!
//! Persistent cycles are followed over frames by their holes:
//!
//! ```text
//! most persistent dots -> detection -> recognition -> track (events)
//!                                    (assignment)    (hole, region)
//! ```
//!
//! [`Pipeline`] runs them all, and chooses. Nothing here knows a clock, a channel, a socket, a file or a print; those that know of threads are
//! `tiles`, which reduces on the current `rayon` pool, and `parts`, which shares long lists out on it; and the only file that imports the triangulation library is `delaunay`. The terms are those of V. Kurlin, "A one-dimensional homologically
//! persistent skeleton of an unstructured point cloud in any metric space", Computer Graphics Forum 34(5), 2015. All scales
//! at the interface are radii.
//!
//! What holds throughout:
//!
//! * One total order decides every tie: edges by (scale, smaller end, larger end), triangles by (circumradius, corners), positions
//!   by x, then y. So a skeleton depends on the cloud alone, not on the order of arrival, ids or history.
//! * Angles, orientations and circles are tested exactly; which edges are in the skeleton is exact in the lengths as doubles have them.
//! * The same cloud has the same numbers, bit for bit, however it was reached.

mod base;
mod cloud;
mod frames;
mod pipeline;
mod plane;
mod skeleton;
#[cfg(test)]
mod testing;
mod tracks;

pub use cloud::{
    Axis, Cloud, CloudChange, CoordinateError, MAX_COORDINATE, MIN_COORDINATE, Position, Refusal, Slot, Vertex,
    VertexId, Window,
};
pub use frames::{ApplyError, Checksum, Diff, Follower, Frame, Presence, SimplifiedFollower, Snapshot, Step};
pub use pipeline::{Contradiction, Options, Pipeline, Stage, Tracker};
pub use plane::elements::DIAGONAL;
pub use plane::holes::{BoundaryVertex, Region};
pub use skeleton::{
    Critical, Cycles, Dot, Edge, EdgeId, Gap, Hole, Margins, RankedDot, Ranking, Selection, Simplified, Skeleton, View,
    ViewSpec, diagonal_gaps, select, simplify, vertical_gaps,
};
pub use tracks::{Changed, EventKind, Track, TrackEvent, TrackId, TrackOptions, TrackRule, TrackStep};

/// The stages between the cloud and its skeleton, for those who want to run or to measure them one by one.
pub mod stages {
    pub use super::plane::along_curve;
    pub use super::plane::basins::{Basins, OUTER_BASIN};
    pub use super::plane::delaunay::{Delaunay, Update};
    pub use super::plane::filtration::{Filtration, Maximum, Suspect};
    pub use super::plane::mesh::{Mesh, MeshEdge, OUTER_FACE};
    pub use super::plane::reduction::{Elders, Link, Pair, Reduction, TotalOrder, reduce};
}
