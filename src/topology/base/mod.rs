//! Tools that know nothing of topology: sorting by numeric keys, sharing lists between threads, accurate sums, numbers
//! as text.
//!
//! In: numbers, ranges, closures.
//! Out: places in order, parts of lists, sums.
//! Invariants: the lowest room; it imports no other.
//! Must not know: what the numbers mean.

mod exact;
mod limits;
mod parallel;
mod sorting;
mod sum;

pub use exact::Exact;
pub use limits::{MAX_DIMENSION, MAX_MAGNITUDE};
#[cfg(test)]
pub use parallel::on_threads;
pub use parallel::{at_once, both, for_each, in_parts, thread_count, with_workers};
pub use sorting::{in_order, ordinal, pair_key, sort_by_key};
pub use sum::compensated_sum;
