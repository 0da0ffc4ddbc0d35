//! The pure core: from points to the homologically persistent skeleton of their cloud, and to what changed in it.
//!
//! In: points, retractions, event times, commits.
//! Out: frames, steps from frame to frame, track events.
//! Invariants: see [below](#what-holds-throughout).
//! Must not know: clocks, channels, sockets, files, prints.
//!
//! [`Pipeline`] is the engine of one stream in the plane, [`SpacePipeline`] of one in another metric space. The
//! mathematics, an example and a glossary are on the [front page](crate). Terms are those of V. Kurlin, "A
//! one-dimensional homologically persistent skeleton of an unstructured point cloud in any metric space", Computer
//! Graphics Forum 34(5), 2015. All scales are radii.
//!
//! # Rooms
//!
//! From low to high; a room imports lower ones only. `skeleton`, `frames` and `tracks` do not know the plane: what of a
//! hole is planar (its centre, its region) comes in as data. A skeleton may be of any space: its vertices have any
//! number of coordinates, or none where only distances are known. Outside of the plane the lengths of its edges are
//! data too.
//!
//! | room | what it is for |
//! | --- | --- |
//! | `base` | sorting by numeric keys, lists shared between threads (the only file with `rayon`), accurate sums |
//! | `cloud` | which points are there: positions in the plane or in R^d, windows, duplicates, what changed |
//! | `declutter` | which points are outliers, and are left out if that is asked for |
//! | `metric` | tree and dots of any metric space: lengths, the Vietoris-Rips sweep |
//! | `plane` | tree and dots of a cloud: geometry, Delaunay (with `spade`), filtration, reduction, holes, tiles |
//! | `skeleton` | what a skeleton is: dots, tree, gaps, views, cycles, simplification, ranking |
//! | `frames` | from one frame to the next: diffs, changes, the stored diagram, followers |
//! | `tracks` | cycles over time: detections, recognition by holes or by homology classes, assignment (with `pathfinding`), tracker |
//! | `pipeline` | the engine: joins the rooms, and decides between one pass and following changes |
//!
//! # How a frame is computed
//!
//! ```text
//! points ─▶ cloud ─▶ delaunay ─▶ mesh ─▶ filtration ─▶ basins ─▶ reduction ─▶ skeleton ─▶ gaps ─▶ view ─▶ diff
//!         (window)   (spade)          (scales, flow)           (elder rule)   (HoPeS)   (DS, VS)
//! ```
//!
//! 0. **Outliers,** if they are to be left out ([`Options::declutter`]): those of the window are told apart, and set
//!    aside in the cloud. All below sees the other points only.
//! 1. **Delaunay.** A small change is inserted and removed point by point, along a space-filling curve. A large one is
//!    loaded in bulk; or in random rounds if the cloud lies along few lines or in few clumps, where the bulk load of
//!    `spade` is slow. A cloud on one line is stored as a sorted path.
//! 2. **Filtration.** Exact signs decide whether an edge is Gabriel (it is born at half its length) or attached to a
//!    triangle with a right or obtuse angle. Such an edge and such a triangle enter at the same scale and cancel: the
//!    triangle *flows* across the edge. Flows end in triangles that contain their own circumcentre. Only Gabriel edges
//!    (about 2n) and the basins of these triangles (about n) go on.
//! 3. **Reduction.** A union-find on the dual graph, under the elder rule, takes edges by decreasing length. An edge
//!    between two components ends the younger one: a dot. An edge inside one component is in the minimum spanning tree.
//!    Edges are sorted by radix on the 32 bits that distinguish most of them.
//! 4. **Views.** The gaps of the diagram select dots. A view is cut out of the skeleton in linear time; one computation
//!    serves any number of views. The widest gaps are found by buckets. Dots are sorted only when all of them are
//!    listed.
//!
//! # How a change travels
//!
//! Small changes do not take that way. They are followed from the triangulation to the diff, at the cost of what
//! changed.
//!
#![doc = include_str!("../../tests/data/change.svg")]
//!
//! The plane is cut into *tiles*, a binary tree over the vertices: a tile is halved at the median of its vertices,
//! along its longer side, until a hundred are left. The reduction above is done leaf by leaf, then for every second
//! level of the tree on what the tiles below have left, up to the root.
//!
//! 1. **A leaf** stores the *stars* of its vertices: for each vertex the edges to larger positions and the triangles
//!    between them, with their scales, in flat memory. A triangle with edges in other leaves is *open*; so is the outer
//!    face. The reduction resolves every merge whose younger side is closed (a dot) and every loop (a tree edge) for
//!    good. The rest is the tile's *border*: open triangles, the links between them, the largest maximum of each
//!    component.
//! 2. **A change** of the triangulation reports which vertices have new neighbours. Their stars are read again, their
//!    leaves are reduced, then the tiles above, deepest first, as far as borders change. Leaves that exceed their
//!    capacity are halved, small halves become one leaf, and a tile that is out of balance is rebuilt. So the depth
//!    stays logarithmic on any cloud. Tiles of one level are independent, and are reduced in parallel.
//! 3. **The difference** between what the reduced tiles had resolved and what they resolve now is the change of the
//!    tree and of the diagram.
//! 4. **The gaps** come from a diagram whose most persistent dots are sorted. All others are counted in buckets, which
//!    prove that no gap among them is as wide as the wanted ones. If they cannot, more dots are sorted.
//! 5. **A view** filters the change by scale. It looks up further edges only if the scale that the gaps select has
//!    moved; each tile has its edges in order. Checksums are sums, and are updated by differences.
//! 6. **Tracks** are detected among the most persistent dots, which the diagram has in order. The region of a hole is
//!    found in the triangulation, from the triangle that names the death, across edges that come before the critical
//!    edge.
//!
//! Each frame is computed in the way that is estimated to be faster. In tiles, a changed vertex costs as much as about
//! three vertices in one pass (one, where changes are close together), and a touched leaf as much as about sixty. At
//! 100,000 points, tiles are faster up to about 4% of the points replaced in a frame if these are spread, and up to
//! about 30% if they are in one place. One pass computes large changes, and is what `--check` and the tests compare
//! with.
//!
//! # What holds throughout
//!
//! * One total order decides every tie: edges by (scale, smaller end, larger end), triangles by (circumradius,
//!   corners), positions by x, then y. The skeleton depends on the cloud alone, not on the order of arrival, ids or
//!   history.
//! * The same cloud has the same numbers, bit for bit, however it was reached, also where many points lie on one
//!   circle.
//! * What is followed in tiles, of any size and on any number of threads, equals one pass.
//! * Angles, orientations and circles are tested exactly. Which edges are in the skeleton is exact in the lengths as
//!   doubles have them.
//! * Values within 1e-12 of the largest finite death are equal. In the plane, a dot whose persistence is at most 1e-12
//!   of its death is rounding, not topology.

mod base;
mod cloud;
mod declutter;
mod frames;
mod metric;
mod pipeline;
mod plane;
mod skeleton;
#[cfg(test)]
mod testing;
mod tracks;

pub use base::Exact;
pub use cloud::{
    Admission, Axis, CONFIRMING, Cloud, CloudChange, Confirmation, CoordinateError, Coordinates, FirstCoordinates,
    MAX_COORDINATE, MIN_COORDINATE, PointError, Position, Refusal, Restart, Site, Slot, Staging, Vertex, VertexId,
    Vertices, Window,
};
pub use declutter::{Declutter, DeclutterError, Decluttered, MAX_NEIGHBOURS};
pub use frames::{ApplyError, Checksum, Diff, Follower, Frame, Presence, SimplifiedFollower, Snapshot, Step};
pub use pipeline::{
    Contradiction, Options, OutlierStep, Pipeline, SpaceOptions, SpacePipeline, Stage, Tracker, numbered,
};
pub use plane::elements::DIAGONAL;
pub use plane::holes::{BoundaryVertex, Region};
pub use skeleton::{
    Critical, Cycles, Dot, Edge, EdgeId, Filtration, Gap, Hole, Killer, Margins, Positions, RankedDot, Ranking,
    Selection, ShortestCycles, Simplified, Skeleton, View, ViewSpec, diagonal_gaps, select, simplify, vertical_gaps,
};
pub use tracks::{
    Changed, EventKind, Remember, SpaceTrack, SpaceTrackEvent, SpaceTrackStep, SpaceTracker, Track, TrackEvent,
    TrackId, TrackOptions, TrackRule, TrackStep,
};

/// Finite metric spaces, of which [`Skeleton::of_space`] makes skeletons.
pub mod spaces {
    pub use super::metric::rips::{
        Class, ClosedWalk, MAX_VERTICES, Pair, Persistence, Workspace, persistence, persistence_and_classes,
    };
    pub use super::metric::space::{
        Distances, EARTH_RADIUS, Graph, Landmarks, MAX_DIMENSION, Matrix, Metric, Points, Space, SpaceError, landmarks,
    };
}

/// The stages between the cloud and its skeleton, to run or to measure them one by one.
pub mod stages {
    pub use super::declutter::{Filter as OutlierFilter, Sides};
    pub use super::plane::along_curve;
    pub use super::plane::basins::{Basins, OUTER_BASIN};
    pub use super::plane::delaunay::{Delaunay, Update};
    pub use super::plane::filtration::{Filtration, Maximum, Suspect};
    pub use super::plane::mesh::{Mesh, MeshEdge, OUTER_FACE};
    pub use super::plane::reduction::{Elders, Link, Pair, Reduction, TotalOrder, reduce};
}
