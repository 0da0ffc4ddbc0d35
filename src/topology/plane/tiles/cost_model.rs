//! The estimated cost of following a change in tiles.
//!
//! In: a change that was not applied yet.
//! Out: its cost. The unit is what bulk loading and one pass take for one vertex (0.8 us on the machine where this was
//! measured).
//! Invariant: the estimate itself takes the same time for any change.
//! Must not know: what is decided by it.
//!
//! Each changed vertex has a cost, and so has each touched leaf, however little it changes. Changes that are close
//! together are therefore cheap; changes that are spread over the cloud are not.

use super::tree::Tiles;
use crate::topology::cloud::{Cloud, CloudChange, Slot};

/// The cost of a vertex that appears or vanishes.
const CHANGE: f64 = 3.0;

/// The same beyond [`DENSE`] of them in a leaf: their surroundings are in the cache by then.
const CHANGE_WHERE_DENSE: f64 = 1.1;

const DENSE: f64 = 25.0;

/// The cost of a touched leaf and of the tiles above it.
const LEAF: f64 = 60.0;

/// The number of changed vertices that are sampled to estimate how many leaves they touch.
const SAMPLE: usize = 64;

impl Tiles {
    /// The cost of following a change.
    pub fn cost(&self, cloud: &Cloud, change: &CloudChange) -> f64 {
        let count = change.appeared.len() + change.vanished.len();
        let stride = count.div_ceil(SAMPLE).max(1);
        let sample: Vec<Slot> = change.appeared.iter().chain(&change.vanished).copied().step_by(stride).collect();
        let mut leaves: Vec<u32> = sample.iter().map(|&slot| self.leaf_of(cloud.position(slot))).collect();
        leaves.sort_unstable();
        leaves.dedup();
        let count = count as f64;
        let touched = expected_distinct(sample.len() as f64, leaves.len() as f64, count, self.leaf_count());
        let few = count.min(DENSE * touched);
        touched * LEAF + few * CHANGE + (count - few) * CHANGE_WHERE_DENSE
    }

    fn leaf_count(&self) -> f64 {
        ((self.tiles.len() - self.free.len()) as f64 / 2.0).max(1.0)
    }
}

/// The expected number of distinct leaves, of `all`, that `count` draws touch, if the first `sample` draws touched
/// `different` ones.
fn expected_distinct(sample: f64, different: f64, count: f64, all: f64) -> f64 {
    let expected = |pool: f64, draws: f64| pool * (1.0 - (-draws / pool).exp());
    // The size of the pool that draws come from. It is bisected: the larger the pool, the more draws are distinct.
    let (mut low, mut high) = (different.min(all), all);
    for _ in 0..32 {
        let middle = 0.5 * (low + high);
        if expected(middle, sample) < different { low = middle } else { high = middle }
    }
    expected(high, count)
}

#[cfg(test)]
mod tests {
    use super::expected_distinct;

    #[test]
    fn a_sample_estimates_how_many_leaves_are_touched() {
        assert!((expected_distinct(64.0, 64.0, 2000.0, 1e9) - 2000.0).abs() < 1.0, "all different, of very many");
        assert!((expected_distinct(64.0, 64.0, 2000.0, 1000.0) - 865.0).abs() < 1.0, "all different, of a thousand");
        assert!((expected_distinct(64.0, 10.0, 2000.0, 1000.0) - 10.0).abs() < 0.5, "a few, over and over");
        let of_a_hundred = expected_distinct(64.0, 47.0, 2000.0, 1000.0);
        assert!((90.0..110.0).contains(&of_a_hundred), "{of_a_hundred}");
    }
}
