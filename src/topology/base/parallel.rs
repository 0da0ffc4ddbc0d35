//! Work on long lists, shared between the threads of the current `rayon` pool. The only file of the core that imports
//! `rayon`.
//!
//! In: a length or a list.
//! Out: ranges that make it up, one for each thread, or one alone where sharing does not pay.
//! Invariants: ranges are in order, leave nothing out, and begin at multiples of `GRAIN`. No result may depend on where
//! they begin.
//! Must not know: what is in the lists.

use std::ops::Range;

use rayon::prelude::*;

/// Ranges begin at multiples of this.
const GRAIN: usize = 64;

/// Lists below this length are one part. Sharing them costs as much as it gains, since data has to move between the
/// processors' caches (measured: no gain at 300,000 items, a quarter at 3,000,000). Tests also share short lists.
const FEW: usize = if cfg!(test) { 1 << 10 } else { 1 << 20 };

/// Whether a list is long enough to be shared, and the pool has more than one thread.
pub fn is_shared(length: usize) -> bool {
    length >= FEW && rayon::current_num_threads() > 1
}

/// The ranges of a list, one for each thread.
fn parts(length: usize) -> Vec<Range<usize>> {
    let threads = if is_shared(length) { rayon::current_num_threads() } else { 1 };
    let size = length.div_ceil(threads).next_multiple_of(GRAIN).max(1);
    let starts = (0..length.max(1)).step_by(size);
    starts.map(|start| start..length.min(start + size)).collect()
}

/// The results of `work` on each part of a list, in order.
pub fn in_parts<T: Send>(length: usize, work: impl Fn(Range<usize>) -> T + Sync) -> Vec<T> {
    let parts = parts(length);
    if parts.len() == 1 {
        return parts.into_iter().map(work).collect();
    }
    parts.into_par_iter().with_max_len(1).map(&work).collect()
}

/// Calls `work` on each item of a list.
pub fn for_each<T: Send>(items: &mut [T], work: impl Fn(&mut T) + Sync) {
    if !is_shared(items.len()) {
        return items.iter_mut().for_each(&work);
    }
    items.par_iter_mut().with_min_len(GRAIN * GRAIN).for_each(&work);
}

/// Runs two closures on lists of about this length, on two threads where that pays.
pub fn both<A: Send, B: Send>(length: usize, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if is_shared(length) { rayon::join(a, b) } else { (a(), b()) }
}

/// The number of threads of the current pool.
pub fn thread_count() -> usize {
    rayon::current_num_threads()
}

/// Calls `work` on each worker, with its number, at once. Returns the results in the order of the workers.
pub fn at_once<W: Send, T: Send>(workers: &mut [W], work: impl Fn(usize, &mut W) -> T + Sync) -> Vec<T> {
    if let [alone] = workers {
        return vec![work(0, alone)];
    }
    workers.par_iter_mut().enumerate().with_max_len(1).map(|(number, worker)| work(number, worker)).collect()
}

/// Runs a test on a pool of so many threads.
#[cfg(test)]
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Below this number of items (each some microseconds of work) one thread is faster.
const FEW_ITEMS: usize = 64;

/// The least number of items that are handed to a thread together.
const PIECE: usize = 16;

/// Calls `step` on each item, in any order and on any thread. Items that run at the same time get different workers.
pub fn with_workers<W: Default + Send, T: Send>(
    workers: &mut Vec<W>,
    items: &mut [T],
    step: impl Fn(&mut W, &mut T) + Sync,
) {
    let threads = rayon::current_num_threads();
    let is_alone = items.len() < FEW_ITEMS || threads == 1;
    let pieces = if is_alone { 1 } else { (4 * threads).min(items.len() / PIECE) };
    workers.resize_with(workers.len().max(pieces), W::default);
    if is_alone {
        return items.iter_mut().for_each(|item| step(&mut workers[0], item));
    }
    let pieces = items.par_chunks_mut(items.len().div_ceil(pieces)).zip(workers.par_iter_mut());
    pieces.for_each(|(items, worker)| items.iter_mut().for_each(|item| step(worker, item)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::testing::{Points, lattice, skeleton_of};

    /// Clouds without ties, with nothing but ties, and with some.
    fn long_clouds() -> [(&'static str, Points); 3] {
        // The fractional parts of multiples of an irrational number are spread evenly.
        let spread = |at: u32, step: f64| (f64::from(at) * step).fract();
        let anywhere: Points =
            (0..3000).map(|at| [spread(at, 0.618_033_988_749_894_9), spread(at, 0.414_213_562_373_095_1)]).collect();
        let pixels = anywhere.iter().map(|&[x, y]| [(70.0 * x).floor(), (70.0 * y).floor()]).collect();
        [("anywhere", anywhere), ("lattice", lattice(50, 60)), ("pixels", pixels)]
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        for (name, cloud) in long_clouds() {
            let [alone, two, five] = [1, 2, 5].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| skeleton_of(&cloud))
            });
            assert!(alone.dots().len() + alone.tree().len() > FEW, "{name} is no test");
            assert!(two == alone && five == alone, "{name}");
        }
    }

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
