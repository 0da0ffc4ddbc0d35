//! How much memory a pipeline takes.
//!
//! In: the pipeline. Out: estimates in bytes, in constant time.
//!
//! Invariants: they count what stays from frame to frame. They are for random points and lattices; measured as resident
//! memory, so with what the allocator keeps for the next frame.
//!
//! Must not know: what the memory is limited to.

use super::Pipeline;

/// What a vertex takes in a triangulation whose skeleton was computed in one pass: triangulation, mesh, skeleton.
const ONE_PASS: usize = 640;

/// What a vertex takes in a triangulation whose skeleton is kept in tiles.
const TILED: usize = 960;

/// What a vertex takes in the filter of outliers.
const FILTERED: usize = 160;

impl Pipeline {
    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let outliers = self.outliers.as_ref().map_or(0, |outliers| outliers.bytes());
        self.cloud.bytes() + outliers + self.delaunay.vertex_count() * self.bytes_of_a_vertex()
    }

    /// About how many bytes more it takes once its newest frame is computed.
    pub fn bytes_to_compute(&self) -> usize {
        let more = self.cloud.vertex_count().saturating_sub(self.delaunay.vertex_count());
        more * (self.bytes_of_a_vertex() + self.filter_bytes_of_a_vertex())
    }

    fn bytes_of_a_vertex(&self) -> usize {
        if self.tiles.is_some() { TILED } else { ONE_PASS }
    }

    /// What a vertex takes in the filter, if there is one.
    fn filter_bytes_of_a_vertex(&self) -> usize {
        self.outliers.as_ref().map_or(0, |_| FILTERED)
    }
}
