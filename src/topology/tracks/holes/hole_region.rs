//! The queries of a tracker to the region of a hole, in any space.
//!
//! In: nothing.
//! Out: a trait, which regions implement.
//! Invariant: answers depend on positions alone.
//! Must not know: how regions are found.

/// The region of a hole. The default value is an unknown region.
pub trait HoleRegion: Clone + Default {
    /// Whether it was never found.
    fn is_unknown(&self) -> bool;
    /// The number of vertices of its boundary.
    fn vertex_count(&self) -> usize;
    /// Its area, without islands.
    fn area(&self) -> f64;
    /// Whether it contains a point.
    fn contains(&self, point: [f64; 2]) -> bool;
    /// Whether a point is at most half of its size away from it.
    fn is_near(&self, point: [f64; 2]) -> bool;
}
