//! What a tracker asks of the region that a hole takes up at its birth, whatever space it is in.
//!
//! In: nothing. Out: the trait that a region implements. Invariant: answers depend on positions alone. Must not know: how regions are found.

/// The region of a hole; by default one that is unknown.
pub trait HoleRegion: Clone + Default {
    /// Whether it has not been looked at.
    fn is_unknown(&self) -> bool;
    /// How many vertices are around it.
    fn vertex_count(&self) -> usize;
    /// Its area, islands left out.
    fn area(&self) -> f64;
    /// Whether a point lies in it.
    fn contains(&self, point: [f64; 2]) -> bool;
    /// Whether a point is no farther from it than half of its size.
    fn is_near(&self, point: [f64; 2]) -> bool;
}
