//! What the filter of outliers says of itself.
//!
//! In: nothing.
//! Out: [`Decluttered`].
//! Must not know: how outliers are found, formats.

/// How a cloud was filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decluttered {
    /// The number of distinct positions that were left out as outliers.
    pub filtered: usize,
    /// K: how many neighbours a point needs.
    pub neighbours: u32,
    /// R: how far its K-th neighbour is at most. Infinite if no clutter was found.
    pub radius: f64,
    /// The largest distance of a K-th neighbour among the points that stay; infinite without K neighbours.
    pub rho: f64,
    /// How many lone clutter points are expected to stay.
    pub expected: f64,
    /// Whether the certificate holds, by its premise: R was given, or at most 0.1 such points were asked for and are
    /// expected.
    pub is_certified: bool,
}
