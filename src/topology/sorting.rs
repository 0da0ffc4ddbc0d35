//! Sorting by numbers, where most of them differ.
//!
//! In: a key for each of some items, and how items with nearly equal keys compare. Out: the items' places, in order. Invariants: the
//! result is the one that the exact comparison has, whatever the keys' spread; the comparison must agree with the keys and must not call
//! two items equal. Must not know: what the items are.

use std::cmp::Ordering;

/// Below so many keys a comparison sort is at once as good as the passes of a radix sort.
const FEW: usize = 256;

/// A number's place among all numbers but NaN, as an integer.
#[inline]
pub fn ordinal(value: f64) -> u64 {
    // The bits of positive numbers are in their order; those of negative ones are in reverse. Zeros are one value.
    let bits = (value + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// Places of items in increasing order of their keys; `settle` sorts the runs of items whose keys are too near to each other, or equal.
///
/// Keys are sorted by the 32 most telling bits of their range, in linear time; what these do not tell apart is settled.
pub fn in_order(keys: impl Iterator<Item = u64> + Clone, mut settle: impl FnMut(&mut [u32])) -> Vec<u32> {
    let (low, high) = keys.clone().fold((u64::MAX, 0), |(low, high), key| (low.min(key), high.max(key)));
    let shift = 32 - high.saturating_sub(low).leading_zeros().min(32);
    let mut keyed: Vec<(u32, u32)> = keys.zip(0..).map(|(key, place)| (((key - low) >> shift) as u32, place)).collect();
    if keyed.len() < FEW {
        keyed.sort_unstable();
    } else {
        radsort::sort_by_key(&mut keyed, |&(key, _)| key);
    }
    let mut places: Vec<u32> = keyed.iter().map(|&(_, place)| place).collect();
    let mut start = 0;
    for run in keyed.chunk_by(|a, b| a.0 == b.0) {
        if run.len() > 1 {
            settle(&mut places[start..start + run.len()]);
        }
        start += run.len();
    }
    places
}

/// The same, with runs settled by a comparison.
pub fn in_order_by(keys: impl Iterator<Item = u64> + Clone, mut compare: impl FnMut(u32, u32) -> Ordering) -> Vec<u32> {
    in_order(keys, |run| run.sort_unstable_by(|&a, &b| compare(a, b)))
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
        fn places_are_in_order(keys in keys()) {
            let compare = |a: u32, b: u32| (keys[a as usize], a).cmp(&(keys[b as usize], b));
            let places = in_order_by(keys.iter().copied(), compare);
            prop_assert_eq!(places.len(), keys.len());
            prop_assert!(places.windows(2).all(|pair| compare(pair[0], pair[1]).is_lt()));
        }
    }
}
