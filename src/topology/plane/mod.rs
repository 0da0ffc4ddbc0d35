//! From positions in the plane to a minimum spanning tree and dots.

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
pub use dual::Dual;
