//! What it would take to follow a change step by step, against building everything anew.
//!
//! In: a change that has not been made yet. Out: its effort, in units of what bulk loading and one pass take for one vertex (about 0.8 us where this was
//! measured). Steps take so long for each change, and so long for each leaf that is touched, however little: where changes lie close together they are
//! cheap, where they are spread over the cloud they are not. Invariant: the estimate costs the same for any change. Must
//! not know: what is done about it.

use super::tree::Tiles;
use crate::topology::cloud::{Cloud, CloudChange, Slot};

/// Each vertex that comes or goes.
const CHANGE: f64 = 3.0;

/// The same where there are more of them to a leaf than [`CROWD`]: what is around them is at hand by then.
const CHANGE_IN_CROWD: f64 = 1.1;

const CROWD: f64 = 25.0;

/// Each leaf that is touched, and what is above it.
const LEAF: f64 = 60.0;

/// So many changes tell how close together all are.
const SAMPLE: usize = 64;

impl Tiles {
    /// What following a change would take.
    pub fn cost(&self, cloud: &Cloud, change: &CloudChange) -> f64 {
        let count = change.appeared.len() + change.vanished.len();
        let stride = count.div_ceil(SAMPLE).max(1);
        let sample: Vec<Slot> = change.appeared.iter().chain(&change.vanished).copied().step_by(stride).collect();
        let mut leaves: Vec<u32> = sample.iter().map(|&slot| self.leaf_of(cloud.position(slot))).collect();
        leaves.sort_unstable();
        leaves.dedup();
        let count = count as f64;
        let touched = touched(sample.len() as f64, leaves.len() as f64, count, self.leaf_count());
        let few = count.min(CROWD * touched);
        touched * LEAF + few * CHANGE + (count - few) * CHANGE_IN_CROWD
    }

    fn leaf_count(&self) -> f64 {
        ((self.tiles.len() - self.free.len()) as f64 / 2.0).max(1.0)
    }
}

/// How many of `all` are expected to be among `count` draws, if there were so many different ones in the first `sample`.
fn touched(sample: f64, different: f64, count: f64, all: f64) -> f64 {
    let expected = |pool: f64, draws: f64| pool * (1.0 - (-draws / pool).exp());
    // How many of them are drawn from; it is bisected, since the more there are, the more are different.
    let (mut low, mut high) = (different.min(all), all);
    for _ in 0..32 {
        let middle = 0.5 * (low + high);
        if expected(middle, sample) < different { low = middle } else { high = middle }
    }
    expected(high, count)
}

#[cfg(test)]
mod tests {
    use super::touched;

    #[test]
    fn a_sample_tells_how_many_are_touched() {
        assert!((touched(64.0, 64.0, 2000.0, 1e9) - 2000.0).abs() < 1.0, "all different, of very many");
        assert!((touched(64.0, 64.0, 2000.0, 1000.0) - 865.0).abs() < 1.0, "all different, of a thousand");
        assert!((touched(64.0, 10.0, 2000.0, 1000.0) - 10.0).abs() < 0.5, "a few, over and over");
        let of_a_hundred = touched(64.0, 47.0, 2000.0, 1000.0);
        assert!((90.0..110.0).contains(&of_a_hundred), "{of_a_hundred}");
    }
}
