//! Pairs packed into 64 bits, and how they are sorted.
//!
//! In: pairs of one batch, whose lengths lie between two bounds.
//! Out: the same pairs in the total order.
//! Invariants: a key of 32 bits never decreases with the length. Pairs that keys do not tell apart are compared by
//! their lengths and ends. So the order is exact, and almost all of it is done on integers.
//! Must not know: filtrations.

use super::pair::Pair;
use crate::topology::metric::space::Distances;

/// Both ends have 16 bits.
pub const MAX_VERTICES: usize = 1 << 16;

/// A pair of vertices under the key of its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Packed(u64);

impl Packed {
    #[inline]
    fn key(self) -> u32 {
        (self.0 >> 32) as u32
    }

    /// The smaller and the larger end.
    #[inline]
    pub fn ends(self) -> [u32; 2] {
        [u32::from((self.0 >> 16) as u16), u32::from(self.0 as u16)]
    }

    /// The pair with its length.
    pub fn pair(self, space: &dyn Distances) -> Pair {
        let [a, b] = self.ends();
        Pair::new(space.length(a, b), a, b)
    }
}

/// From the lengths of a batch to keys.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    base: f64,
    factor: f64,
}

impl Scale {
    /// For lengths from `low` to `high`.
    pub fn new(low: f64, high: f64) -> Self {
        let base = low.max(0.0);
        let factor = f64::from(u32::MAX) / (high - base);
        Self { base, factor: if factor.is_finite() && factor > 0.0 { factor } else { 0.0 } }
    }

    /// Packs a pair, the smaller end first. The cast saturates, so lengths outside stay in order as well.
    #[inline]
    pub fn pack(&self, length: f64, a: u32, b: u32) -> Packed {
        let key = ((length - self.base) * self.factor) as u32;
        Packed(u64::from(key) << 32 | u64::from(a) << 16 | u64::from(b))
    }
}

/// Pairs in buckets by the first bits of their keys.
#[derive(Debug, Default)]
pub struct Buckets {
    pairs: Vec<Packed>,
    ends: Vec<usize>,
    /// How many bits of the key a bucket shares.
    shared: u32,
    spare: Vec<Packed>,
}

/// The pairs that fit the caches while they are sorted and swept.
const BUCKET: std::ops::RangeInclusive<usize> = 2048..=16384;

impl Buckets {
    /// About how many bytes they take.
    pub fn bytes(&self) -> usize {
        (self.pairs.capacity() + self.spare.capacity()) * size_of::<Packed>()
            + self.ends.capacity() * size_of::<usize>()
    }

    /// Puts pairs into buckets. Those of one key keep their order.
    pub fn fill(&mut self, pairs: &[Packed]) {
        let size = (pairs.len() / 16).clamp(*BUCKET.start(), *BUCKET.end());
        let bits = (pairs.len() / size).max(1).ilog2();
        let bucket = |pair: &Packed| (u64::from(pair.key()) >> (32 - bits)) as usize;
        self.ends.clear();
        self.ends.resize((1 << bits) + 1, 0);
        for pair in pairs {
            self.ends[bucket(pair) + 1] += 1;
        }
        for number in 0..1 << bits {
            self.ends[number + 1] += self.ends[number];
        }
        self.pairs.resize(pairs.len().max(self.pairs.len()), Packed::default());
        for pair in pairs {
            let next = &mut self.ends[bucket(pair)];
            self.pairs[*next] = *pair;
            *next += 1;
        }
        // What was the beginning of each bucket is its end now.
        self.ends.pop();
        self.shared = bits;
    }

    /// How many buckets there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The pairs of a bucket in the total order.
    pub fn sorted(&mut self, number: usize, space: &dyn Distances) -> &[Packed] {
        let start = if number == 0 { 0 } else { self.ends[number - 1] };
        let bucket = &mut self.pairs[start..self.ends[number]];
        sort(bucket, self.shared, &mut self.spare, space);
        bucket
    }
}

/// Below this many pairs, comparing is faster than counting digits.
const FEW: usize = 64;

/// Bits of a digit.
const DIGIT: u32 = 9;

/// Digits of one place of a key.
const DIGITS: usize = 1 << DIGIT;

/// Sorts pairs that share the first bits of their keys: by the two digits after these, then exactly.
fn sort(pairs: &mut [Packed], shared: u32, spare: &mut Vec<Packed>, space: &dyn Distances) {
    let exactly = |x: &Packed, y: &Packed| {
        let lengths = || x.pair(space).order(&y.pair(space));
        x.key().cmp(&y.key()).then_with(lengths)
    };
    if pairs.len() < FEW {
        return pairs.sort_unstable_by(exactly);
    }
    let shift = 64 - (shared + 2 * DIGIT).min(32);
    spare.resize(pairs.len().max(spare.len()), Packed::default());
    let spare = &mut spare[..pairs.len()];
    by_digit(pairs, spare, shift);
    by_digit(spare, pairs, shift + DIGIT);
    for run in pairs.chunk_by_mut(|x, y| x.0 >> shift == y.0 >> shift) {
        if run.len() > 1 {
            run.sort_unstable_by(exactly);
        }
    }
}

/// Moves pairs in order of one digit; those of one digit keep their order.
fn by_digit(from: &[Packed], to: &mut [Packed], shift: u32) {
    let digit = |pair: &Packed| (pair.0 >> shift) as usize & (DIGITS - 1);
    let mut next = [0_u32; DIGITS];
    for pair in from {
        next[digit(pair)] += 1;
    }
    let mut start = 0;
    for next in &mut next {
        (*next, start) = (start, start + *next);
    }
    for pair in from {
        let next = &mut next[digit(pair)];
        to[*next as usize] = *pair;
        *next += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::metric::space::Matrix;

    #[test]
    fn pairs_are_sorted_exactly_also_where_keys_are_equal() {
        // Lengths with many ties, and lengths that differ in the last bits only.
        for levels in [1_u64, 3, 1 << 40] {
            let count = 200_u32;
            let mut state = levels;
            let mut length = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                1.0 + ((state >> 20) % levels) as f64 * f64::EPSILON
            };
            let lower: Vec<f64> = (0..count as usize * (count as usize - 1) / 2).map(|_| length()).collect();
            let space = Matrix::from_lower(count as usize, &lower).unwrap();
            let scale = Scale::new(1.0, 1.0 + levels as f64 * f64::EPSILON);
            let all = (0..count).flat_map(|b| (0..b).map(move |a| (a, b)));
            let packed: Vec<Packed> = all.map(|(a, b)| scale.pack(space.length(a, b), a, b)).collect();
            let mut buckets = Buckets::default();
            buckets.fill(&packed);
            let mut sorted: Vec<Pair> = Vec::new();
            for number in 0..buckets.count() {
                sorted.extend(buckets.sorted(number, &space).iter().map(|pair| pair.pair(&space)));
            }
            assert_eq!(sorted.len(), packed.len());
            assert!(sorted.is_sorted_by(|x, y| x.before(y)), "{levels}");
        }
    }
}
