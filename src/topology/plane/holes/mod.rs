//! What is planar of a dot's hole: its boundary at birth, the region inside, and a cache of regions.

mod boundary;
mod region;
mod region_cache;

pub use boundary::boundary;
pub use region::{BoundaryVertex, Region};
pub use region_cache::RegionCache;
