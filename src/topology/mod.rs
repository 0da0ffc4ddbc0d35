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
//!                   (watcher)  (stars, borders)    (gaps)    (views)
//! ```
//!
//! Persistent cycles are followed over frames by their holes:
//!
//! ```text
//! most persistent dots -> sighting -> recognition -> track (events)
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

mod assignment;
mod basins;
mod change;
mod cloud;
mod cocircular;
mod cycle;
mod delaunay;
mod diagram;
mod diff;
mod filtration;
mod follow;
mod gaps;
mod geometry;
mod held;
mod hole;
mod kept_regions;
mod merge;
mod mesh;
mod parts;
mod pipeline;
mod position;
mod ranking;
mod recognition;
mod reduction;
mod region;
mod sighting;
mod simplified;
mod simplify;
mod skeleton;
mod sorting;
mod stage;
#[cfg(test)]
mod testing;
mod tiles;
mod track;
mod view;
mod window;

pub use cloud::{Cloud, CloudChange, Refusal, Slot, Vertex, VertexId};
pub use cycle::Cycles;
pub use diff::{ApplyError, Checksum, Critical, Diff, EdgeId, Presence, Snapshot};
pub use follow::{Follower, Step};
pub use gaps::{Gap, Margins, Selection, diagonal_gaps, select, vertical_gaps};
pub use pipeline::{Contradiction, Frame, Options, Pipeline};
pub use position::{Axis, CoordinateError, MAX_COORDINATE, MIN_COORDINATE, Position};
pub use ranking::{RankedDot, Ranking};
pub use region::{BoundaryVertex, Region};
pub use simplified::SimplifiedFollower;
pub use simplify::{Simplified, simplify};
pub use skeleton::{DIAGONAL, Dot, Edge, Hole, Skeleton};
pub use stage::Stage;
pub use track::{Changed, Happening, Track, TrackEvent, TrackId, TrackOptions, TrackRule, TrackStep, Tracker};
pub use view::{View, ViewSpec};
pub use window::Window;

/// The stages between the cloud and its skeleton, for those who want to run or to measure them one by one.
pub mod stages {
    pub use super::basins::{Basins, OUTER_BASIN};
    pub use super::delaunay::{Delaunay, Update, along_curve};
    pub use super::filtration::{Filtration, Maximum, Suspect};
    pub use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
    pub use super::reduction::{Elders, Link, Pair, Reduction, TotalOrder, reduce};
}
