//! How long the frames of a stream take, stage by stage, as Prometheus histograms.
//!
//! In: durations, from the stream's engine. Out: histograms in seconds, which a scrape reads.
//!
//! Invariants: clones share their numbers.
//!
//! Must not know: how frames are computed, how metrics are written.

use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};

/// Histograms of one stream, in seconds.
#[derive(Clone, Debug)]
pub struct FrameTimes {
    /// From the first point to the published frame, waiting left out.
    pub total: Histogram,
    /// Updating the triangulation.
    pub triangulation: Histogram,
    /// Reducing the filtration to the skeleton.
    pub reduction: Histogram,
    /// Selecting views, encoding their changes and handing them to consumers.
    pub publishing: Histogram,
}

impl Default for FrameTimes {
    /// Nothing was measured yet. Buckets double from 0.1 ms to 26 s.
    fn default() -> Self {
        let histogram = || Histogram::new(exponential_buckets(1e-4, 2.0, 19));
        Self { total: histogram(), triangulation: histogram(), reduction: histogram(), publishing: histogram() }
    }
}
