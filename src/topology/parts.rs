//! Work on long lists, shared out between the threads of the current pool.
//!
//! In: a length. Out: ranges that make it up, one for each thread, or one alone where sharing would not pay. Invariants: ranges are in order, leave nothing
//! out, and begin at multiples of [`GRAIN`]; what is computed must not depend on where they begin. Must not know: what is in the lists.

use std::ops::Range;

use rayon::prelude::*;

/// Parts begin at multiples of this.
const GRAIN: usize = 64;

/// Shorter lists are one part.
const FEW: usize = 1 << 15;

/// Whether a list is long enough, and there is anybody, to share it with.
pub fn is_shared(length: usize) -> bool {
    length >= FEW && rayon::current_num_threads() > 1
}

/// Ranges of a list of some length, one for each thread.
fn parts(length: usize) -> Vec<Range<usize>> {
    let threads = if is_shared(length) { rayon::current_num_threads() } else { 1 };
    let size = length.div_ceil(threads).next_multiple_of(GRAIN).max(1);
    let starts = (0..length.max(1)).step_by(size);
    starts.map(|start| start..length.min(start + size)).collect()
}

/// What comes of each part of a list, in order.
pub fn in_parts<T: Send>(length: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let parts = parts(length);
    if parts.len() == 1 {
        return parts.into_iter().map(work).collect();
    }
    parts.into_par_iter().with_max_len(1).map(&work).collect()
}

/// Does something with each item of a list.
pub fn for_each<T: Send>(items: &mut [T], work: impl Fn(&mut T) + Sync) {
    if !is_shared(items.len()) {
        return items.iter_mut().for_each(&work);
    }
    items.par_iter_mut().with_min_len(GRAIN * GRAIN).for_each(&work);
}

/// Does two things, on two threads if there are two.
pub fn both<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if rayon::current_num_threads() == 1 { (a(), b()) } else { rayon::join(a, b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_up_the_whole() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        for length in [0, 1, FEW - 1, FEW, FEW + 1, 3 * FEW, 3 * FEW + GRAIN] {
            let parts = pool.install(|| parts(length));
            assert_eq!(parts.len(), if length < FEW { 1 } else { 3 });
            assert_eq!((parts[0].start, parts[parts.len() - 1].end), (0, length));
            assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].end % GRAIN == 0));
        }
    }
}
