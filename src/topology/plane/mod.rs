//! From positions in the plane to a minimum spanning tree and dots.
//!
//! In: a cloud and its changes.
//! Out: tree edges and dots, by sites of a mesh after one pass, by slots and as differences from tiles; boundaries and
//! regions of holes.
//! Must not know: skeletons, ids, views, frames.
//!
//! * One pass: [`delaunay`], [`mesh`], [`filtration`], [`basins`], [`reduction`].
//! * Changes: [`tiles`].
//! * Holes: [`holes`].

pub mod basins;
mod cocircular;
mod curve;
pub mod delaunay;
mod dual;
pub mod elements;
pub mod filtration;
mod flow;
pub mod geometry;
pub mod holes;
mod line;
pub mod mesh;
pub mod reduction;
pub mod tiles;

pub use curve::along_curve;
pub use dual::DualOrder;
