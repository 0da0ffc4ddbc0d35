//! The contrast of a point: whether points that are much closer together are near it.
//!
//! In: the tree of points, changes of their distances.
//! Out: whether a point is contrasted, and which may have become so.
//! Invariant: a change is noticed wherever it can matter.
//! Must not know: R.

use super::search::{Extent, square_distance};
use super::tree::{Entry, NodeId, Tree};
use crate::topology::cloud::{Position, Slot};

/// The square of how many of its own distances from a point the close ones are at most: 1.5.
const NEAR: f64 = 2.25;

/// The square of how many times smaller their distances are: 4.
const CLOSER: f64 = 16.0;

/// The distance of a K-th neighbour that was or is somewhere.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// The leaf of the position.
    pub leaf: NodeId,
    /// Where.
    pub position: Position,
    /// The smaller distance, squared, if it has changed.
    pub reach: f64,
}

/// Whether so many points near this one are much closer together.
fn is_contrasted(tree: &Tree, entry: &Entry, wanted: usize) -> bool {
    tree.has_witnesses(entry.position, NEAR * entry.reach, entry.reach / CLOSER, wanted)
}

/// Which of some points of a leaf are contrasted, by calls of `tell`.
pub fn judge_group(tree: &Tree, group: &[Entry], wanted: usize, mut tell: impl FnMut(&Entry, bool)) {
    let most = group.iter().fold(0.0_f64, |most, entry| most.max(entry.reach));
    let extent = Extent::of(group.iter().map(|entry| entry.position));
    // Hardly any point has much closer ones around, so most groups are done with one search.
    let least = tree.least_reach(extent, NEAR * most, most);
    for entry in group {
        tell(entry, least <= entry.reach / CLOSER && is_contrasted(tree, entry, wanted));
    }
}

/// Calls `visit` on the points, some perhaps more than once, whose contrast events may change.
pub fn near_events(tree: &Tree, mut events: Vec<Event>, mut visit: impl FnMut(Slot)) {
    events.sort_unstable_by_key(|event| event.leaf);
    for group in events.chunk_by(|a, b| a.leaf == b.leaf) {
        let extent = Extent::of(group.iter().map(|event| event.position));
        let least = group.iter().fold(f64::INFINITY, |least, event| least.min(event.reach)) * CLOSER;
        tree.around(extent, NEAR, least, &mut |entry| {
            let matters = |event: &Event| {
                event.reach <= entry.reach / CLOSER
                    && square_distance(entry.position, event.position) <= NEAR * entry.reach
            };
            if group.iter().any(matters) {
                visit(entry.slot);
            }
        });
    }
}
