//! What knows nothing of topology: sorting by numbers, sharing lists between threads, sums.
//!
//! In: numbers, ranges, closures. Out: the same in order, in parts, added up. The lowest floor: it imports no other room.

mod parallel;
mod sorting;
mod sum;

pub use parallel::{both, for_each, in_parts, with_workers};
pub use sorting::{in_order, ordinal, pair_key, sort_by_key};
pub use sum::compensated_sum;
