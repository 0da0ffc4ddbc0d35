//! The planar part of a dot's hole: its boundary at birth, the region inside, and a cache of regions.
//!
//! In: a dot's name and critical edge, the triangulation.
//! Out: closed walks and regions.
//! Must not know: tracks, frames, views.

mod boundary;
mod region;
mod region_cache;

pub use boundary::boundary;
pub use region::{BoundaryVertex, Region};
pub use region_cache::RegionCache;
