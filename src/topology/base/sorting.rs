//! Sorting by numeric keys, most of which differ.
//!
//! In: keys of items.
//! Out: the items' places, in order.
//! Invariant: the result is that of a comparison sort by the whole keys, whatever their spread.
//! Must not know: what the items are.

use std::ops::Range;

use super::parallel::{both, is_shared};

/// Below this number of keys a comparison sort is faster than the passes of a radix sort.
const FEW: usize = 256;

/// The number of keys that are sampled to estimate the median.
const SAMPLE: usize = 1000;

/// An integer in the order of the numbers; not for NaN.
#[inline]
pub fn ordinal(value: f64) -> u64 {
    // The bits of positive numbers are in their order, those of negative ones in reverse. Both zeros give one value.
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// The place of a pair among all pairs of numbers below `count`: by the first number, then by the second.
#[inline]
pub fn pair_key([a, b]: [u32; 2], count: usize) -> u64 {
    u64::from(a) * count as u64 + u64::from(b)
}

/// The places of items in increasing order of their first keys, then of their second keys.
///
/// Takes linear time, except for keys that differ by less than 2^-32 of their range.
pub fn in_order(count: usize, first: impl Fn(u32) -> u64, second: impl Fn(u32) -> u64) -> Vec<u32> {
    let mut rough = Rough::new((0..count as u32).map(&first));
    if rough.tied() * 2 > count {
        // On a lattice all edges have two or three lengths. Second keys are therefore computed in the items' own order,
        // where they are near in memory.
        let keys: Vec<u64> = (0..count as u32).map(&second).collect();
        settle(&mut rough, first, |place| keys[place as usize]);
    } else {
        settle(&mut rough, first, second);
    }
    rough.places
}

/// Sorts the runs that a rough sort by the first keys leaves.
fn settle(rough: &mut Rough, first: impl Fn(u32) -> u64, second: impl Fn(u32) -> u64) {
    let Rough { places, runs, is_exact } = rough;
    for run in runs {
        let run = &mut places[run.clone()];
        if *is_exact {
            sort_tied(run, &second);
        } else {
            run.sort_unstable_by_key(|&place| first(place));
            run.chunk_by_mut(|&a, &b| first(a) == first(b)).for_each(|tied| sort_tied(tied, &second));
        }
    }
}

/// Sorts items with equal first keys by their second keys.
fn sort_tied(tied: &mut [u32], second: impl Fn(u32) -> u64) {
    if tied.len() < FEW {
        return tied.sort_unstable_by_key(|&place| second(place));
    }
    let keys: Vec<u64> = tied.iter().map(|&place| second(place)).collect();
    let mut rough = Rough::new(keys.iter().copied());
    for run in rough.runs.iter().filter(|_| !rough.is_exact) {
        rough.places[run.clone()].sort_unstable_by_key(|&tie| keys[tie as usize]);
    }
    let places: Vec<u32> = rough.places.into_iter().map(|tie| tied[tie as usize]).collect();
    tied.copy_from_slice(&places);
}

/// Sorts items by keys.
pub fn sort_by_key<T: Copy, K: radsort::Key + Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    if items.len() < FEW {
        items.sort_unstable_by_key(key);
    } else {
        radsort::sort_by_key(items, key);
    }
}

/// Items sorted by the 32 most significant bits of their keys.
struct Rough {
    places: Vec<u32>,
    /// Places of items whose 32 bits are equal.
    runs: Vec<Range<usize>>,
    /// Whether these bits are the whole key: all items of a run then have equal keys.
    is_exact: bool,
}

impl Rough {
    fn new(keys: impl Iterator<Item = u64> + Clone) -> Self {
        let (low, high) = keys.clone().fold((u64::MAX, 0), |(low, high), key| (low.min(key), high.max(key)));
        let shift = 32 - high.saturating_sub(low).leading_zeros().min(32);
        let mut lost = 0;
        let mut keyed: Vec<(u32, u32)> = keys
            .map(|key| key - low)
            .inspect(|key| lost |= key & ((1 << shift) - 1))
            .zip(0..)
            .map(|(key, place)| ((key >> shift) as u32, place))
            .collect();
        sort_halves(&mut keyed);
        let mut runs = Vec::new();
        let mut start = 0;
        for run in keyed.chunk_by(|a, b| a.0 == b.0) {
            if run.len() > 1 {
                runs.push(start..start + run.len());
            }
            start += run.len();
        }
        Self { places: keyed.into_iter().map(|(_, place)| place).collect(), runs, is_exact: lost == 0 }
    }

    /// The number of items in runs.
    fn tied(&self) -> usize {
        self.runs.iter().map(ExactSizeIterator::len).sum()
    }
}

/// Sorts by the first of each two: the keys below an estimated median and the others at the same time.
fn sort_halves(keyed: &mut Vec<(u32, u32)>) {
    if !is_shared(keyed.len()) {
        return sort_by_key(keyed, |&(key, _)| key);
    }
    let mut sample: Vec<u32> = keyed.iter().step_by(keyed.len() / SAMPLE).map(|&(key, _)| key).collect();
    sample.sort_unstable();
    let middle = sample[sample.len() / 2];
    let mut upper = Vec::with_capacity(keyed.len() / 2);
    let length = keyed.len();
    keyed.retain(|&item| {
        let is_lower = item.0 < middle;
        if !is_lower {
            upper.push(item);
        }
        is_lower
    });
    both(length, || sort_by_key(keyed, |&(key, _)| key), || sort_by_key(&mut upper, |&(key, _)| key));
    keyed.append(&mut upper);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ordinals_are_in_the_order_of_numbers() {
        let numbers = [f64::NEG_INFINITY, -2.0, -1.0, -5e-324, 0.0, 5e-324, 1.0, 2.0, f64::INFINITY];
        assert!(numbers.windows(2).all(|pair| ordinal(pair[0]) < ordinal(pair[1])));
        assert_eq!(ordinal(-0.0), ordinal(0.0));
    }

    fn keys() -> impl Strategy<Value = Vec<u64>> {
        let key = prop_oneof![0..4_u64, any::<u64>(), (1_u64 << 40..1 << 41), Just(u64::MAX)];
        let far_apart = prop::collection::vec(key, 0..2 * FEW);
        let near = prop::collection::vec(1_u64 << 62..(1 << 62) + 1000, 0..2 * FEW);
        prop_oneof![far_apart, near]
    }

    proptest! {
        #[test]
        fn places_are_in_order(first in keys(), second in keys()) {
            let key = |place: u32| (first[place as usize], second.get(place as usize % 7).copied(), place);
            let second = |place: u32| key(place).1.map_or(0, |key| key / 8 * 8) + u64::from(place % 8);
            let key = |place: u32| (key(place).0, second(place));
            let places = in_order(first.len(), |place| key(place).0, second);
            let mut seen = places.clone();
            seen.sort_unstable();
            prop_assert!(seen.into_iter().eq(0..first.len() as u32));
            prop_assert!(places.windows(2).all(|pair| key(pair[0]) <= key(pair[1])));
        }

        #[test]
        fn items_are_in_order(mut items in keys()) {
            let mut want = items.clone();
            want.sort_unstable();
            sort_by_key(&mut items, |&item| item);
            prop_assert_eq!(items, want);
        }
    }
}
