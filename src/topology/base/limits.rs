//! The limits of numbers whose squares are summed.
//!
//! In: nothing.
//! Out: how many numbers one sum may have, and how large they may be.
//! Must not know: what the numbers mean.

/// The largest number of coordinates of a point.
pub const MAX_DIMENSION: usize = 4096;

/// The largest magnitude of a coordinate outside of the plane: squares of differences of larger ones may overflow when
/// they are summed.
pub const MAX_MAGNITUDE: f64 = 1e150;
