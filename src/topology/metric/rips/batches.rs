//! Pairs in batches of increasing length.
//!
//! In: a space, how far the filtration goes.
//! Out: unsorted pairs of the next batch, packed.
//! Invariants: each pair of finite length comes in exactly one batch. No batch has more than `MOST` pairs, however many
//! lengths are equal: batches end at a length, or between two smaller ends of one length.
//! Must not know: lunes, classes.

use super::packed::{Packed, Scale};
use super::pair::Pair;
use crate::topology::base::at_once;
use crate::topology::metric::space::Distances;

/// At most so many pairs are held at once.
const MOST: usize = if cfg!(test) { 1 << 10 } else { 1 << 22 };

/// Rows that a thread takes at a time.
const STRIPE: usize = 16;

/// A place in the total order: after all pairs of this length whose smaller end is at most `a`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    length: f64,
    a: u32,
}

impl Cut {
    /// After all pairs of a length.
    fn after(length: f64) -> Self {
        Self { length, a: u32::MAX }
    }

    /// The largest length of the pairs of this smaller end that come before it.
    fn bound(self, a: u32) -> f64 {
        if a <= self.a { self.length } else { self.length.next_down() }
    }
}

/// What the batches of a sweep are cut by.
pub struct Batches<'s> {
    space: &'s dyn Distances,
    /// The longest length of the filtration, finite.
    limit: f64,
    /// Lengths of a sample of the pairs, in order.
    quantiles: Vec<f64>,
    /// The largest finite length, once it is known.
    longest: Option<f64>,
    done: Cut,
    taken: usize,
    /// Working space, one list a thread.
    found: Vec<Vec<Packed>>,
}

impl<'s> Batches<'s> {
    /// Batches of all pairs up to a finite length.
    pub fn new(space: &'s dyn Distances, limit: f64, threads: usize) -> Self {
        Self {
            space,
            limit,
            quantiles: sample(space),
            longest: None,
            done: Cut::after(f64::NEG_INFINITY),
            taken: 0,
            found: vec![Vec::new(); threads],
        }
    }

    /// How many pairs came in batches so far.
    pub fn taken(&self) -> usize {
        self.taken
    }

    /// The length up to which all pairs came.
    pub fn done(&self) -> f64 {
        if self.done.a == u32::MAX { self.done.length } else { self.done.length.next_down() }
    }

    /// Whether all pairs came.
    pub fn is_empty(&self) -> bool {
        self.done() >= self.limit
    }

    /// The next batch, of about `wanted` pairs.
    pub fn next(&mut self, wanted: usize, out: &mut Vec<Packed>) {
        let mut up_to = self.target(wanted);
        loop {
            self.collect(up_to);
            if self.found.iter().map(Vec::len).sum::<usize>() <= MOST {
                break;
            }
            up_to = self.nearer(up_to);
        }
        out.clear();
        for found in &self.found {
            out.extend_from_slice(found);
        }
        self.taken += out.len();
        self.done = up_to;
    }

    /// Where about so many pairs end.
    fn target(&self, wanted: usize) -> Cut {
        if self.done.a != u32::MAX {
            return Cut::after(self.done.length);
        }
        let all = pairs(self.space.count());
        if self.taken + wanted >= all {
            return Cut::after(self.limit);
        }
        let share = (self.taken + wanted) as f64 / all as f64;
        let later = self.quantiles.partition_point(|&length| length <= self.done.length);
        let place = later.max((share * self.quantiles.len() as f64) as usize);
        Cut::after(self.quantiles.get(place).map_or(self.limit, |&length| length.min(self.limit)))
    }

    /// A nearer end, where too many pairs were found: by length, or within one length by smaller ends.
    fn nearer(&self, up_to: Cut) -> Cut {
        let step = self.found.iter().map(Vec::len).sum::<usize>() / 1024 + 1;
        let some = self.found.iter().flat_map(|found| found.iter().step_by(step));
        let mut lengths: Vec<f64> = some.map(|pair| pair.pair(self.space).length).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let shorter = lengths[..=lengths.len() / 2].iter().rev().find(|&&length| length < up_to.length);
        shorter.map_or_else(|| self.within(up_to.length), |&length| Cut::after(length))
    }

    /// An end within one length, which most of the next pairs have.
    fn within(&self, length: f64) -> Cut {
        let count = self.space.count();
        let mut row = vec![0.0; count];
        let (mut shorter, mut equal) = (0, vec![0; count]);
        for a in 0..count as u32 {
            let row = &mut row[a as usize + 1..];
            self.space.lengths(a, a + 1, row);
            let after = self.done.bound(a);
            shorter += row.iter().filter(|&&other| other > after && other < length).count();
            equal[a as usize] = row.iter().filter(|&&other| other > after && other == length).count();
        }
        if shorter > MOST / 2 {
            return Cut::after(length.next_down());
        }
        let mut found = shorter;
        let fits = |&(_, here): &(usize, &usize)| {
            found += here;
            found <= MOST
        };
        let last = equal.iter().enumerate().take_while(fits).last();
        let first = equal.iter().position(|&here| here > 0);
        Cut { length, a: last.map(|(a, _)| a).max(first).unwrap_or(count) as u32 }
    }

    /// Finds the pairs up to a cut. A thread that has found too many stops.
    fn collect(&mut self, up_to: Cut) {
        let is_first = self.longest.is_none();
        if is_first && up_to.length == self.limit {
            self.longest = Some(longest(self.space));
        }
        let end = if up_to.length == self.limit { self.longest.unwrap_or(self.limit) } else { up_to.length };
        let scale = Scale::new(self.done.length, end.min(up_to.length));
        let (space, done, threads) = (self.space, self.done, self.found.len());
        let far = at_once(&mut self.found, |own, found| {
            found.clear();
            let mut rows = Rows::new(space);
            let mut far = 0.0_f64;
            for a in (0..space.count()).filter(|a| a / STRIPE % threads == own) {
                let row = rows.pairs(a as u32, done, up_to, &scale);
                let is_full = found.len() > MOST;
                if !is_full {
                    found.extend_from_slice(row);
                }
                if is_first {
                    far = rows.longest(far);
                } else if is_full {
                    break;
                }
            }
            far
        });
        if is_first && self.longest.is_none() {
            self.longest = Some(far.into_iter().fold(0.0, f64::max));
        }
    }
}

/// One row of lengths at a time.
struct Rows<'s> {
    space: &'s dyn Distances,
    row: Vec<f64>,
    packed: Vec<Packed>,
    here: usize,
}

impl<'s> Rows<'s> {
    fn new(space: &'s dyn Distances) -> Self {
        let count = space.count();
        Self { space, row: vec![0.0; count], packed: vec![Packed::default(); count], here: 0 }
    }

    /// The pairs of a smaller end between two cuts.
    fn pairs(&mut self, a: u32, done: Cut, up_to: Cut, scale: &Scale) -> &[Packed] {
        self.here = self.row.len() - a as usize - 1;
        let row = &mut self.row[..self.here];
        self.space.lengths(a, a + 1, row);
        let (after, last) = (done.bound(a), up_to.bound(a));
        let mut found = 0;
        for (&length, b) in row.iter().zip(a + 1..) {
            // Written in any case, and kept by counting: which pairs fit is hard to predict.
            self.packed[found] = scale.pack(length, a, b);
            found += usize::from(length > after && length <= last);
        }
        &self.packed[..found]
    }

    /// The largest finite length of the last row, if it is larger than `far`.
    fn longest(&self, far: f64) -> f64 {
        let row = &self.row[..self.here];
        row.iter().fold(far, |far, &length| if length > far && length < f64::INFINITY { length } else { far })
    }
}

/// The number of pairs of so many vertices.
fn pairs(count: usize) -> usize {
    count * count.saturating_sub(1) / 2
}

/// The largest finite length.
fn longest(space: &dyn Distances) -> f64 {
    let mut rows = Rows::new(space);
    let none = Cut::after(f64::NEG_INFINITY);
    (0..space.count() as u32).fold(0.0, |far, a| {
        rows.pairs(a, none, none, &Scale::new(0.0, 0.0));
        rows.longest(far)
    })
}

/// Lengths of pairs that are spread evenly over all, in order.
fn sample(space: &dyn Distances) -> Vec<f64> {
    const SAMPLES: u64 = 8192;
    let count = space.count() as u64;
    // Multiples of two irrational numbers, as fractions of 2^32: no two vertices are preferred together.
    let spread = |number: u64, step: u64| (number.wrapping_mul(step) >> 32) & 0xffff_ffff;
    let pair = |number: u64| {
        let a = (spread(number, 0x9e37_79b9_7f4a_7c15) * count) >> 32;
        let b = (a + 1 + ((spread(number, 0xd1b5_4a32_d192_ed03) * (count - 1)) >> 32)) % count;
        Pair::new(0.0, a as u32, b as u32)
    };
    let mut lengths: Vec<f64> = (1..=SAMPLES).map(pair).map(|pair| space.length(pair.a, pair.b)).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::metric::space::Matrix;

    /// Each pair of finite length comes once, in batches in order, none of them too large.
    fn check(space: &Matrix, wanted: usize, threads: usize) {
        let mut batches = Batches::new(space, f64::MAX, threads);
        let (mut all, mut batch): (Vec<Pair>, Vec<Packed>) = (Vec::new(), Vec::new());
        while !batches.is_empty() {
            batches.next(wanted, &mut batch);
            assert!(batch.len() <= MOST);
            let mut pairs: Vec<Pair> = batch.iter().map(|pair| pair.pair(space)).collect();
            pairs.sort_unstable_by(Pair::order);
            all.extend(pairs);
        }
        assert!(all.is_sorted_by(|x, y| x.before(y)));
        let finite = (0..space.count() as u32).flat_map(|b| (0..b).map(move |a| (a, b)));
        assert_eq!(all.len(), finite.filter(|&(a, b)| space.length(a, b).is_finite()).count());
        assert_eq!(all.len(), batches.taken());
    }

    #[test]
    fn batches_are_complete_in_order_and_bounded_whatever_is_equal() {
        let matrix = |count: usize, length: fn(usize) -> f64| {
            let lower: Vec<f64> = (0..count * (count - 1) / 2).map(length).collect();
            Matrix::from_lower(count, &lower).unwrap()
        };
        let spaces = [
            matrix(120, |_| 1.0),
            matrix(120, |pair| (pair * 7919 % 10_007) as f64),
            matrix(120, |pair| if pair % 5000 == 0 { 0.0 } else { 2.0 }),
            matrix(120, |pair| (pair % 3) as f64),
            matrix(120, |pair| if pair % 3 == 0 { f64::INFINITY } else { (pair % 7) as f64 }),
            matrix(120, |_| f64::INFINITY),
            matrix(2, |_| 0.0),
        ];
        for space in &spaces {
            for (wanted, threads) in [(1, 1), (100, 1), (100, 2), (1_000_000, 3)] {
                check(space, wanted, threads);
            }
        }
    }
}
