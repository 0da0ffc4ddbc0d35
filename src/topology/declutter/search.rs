//! Searches in the tree of points.
//!
//! In: a point, or a group of positions that change.
//! Out: the distance of its K-th neighbour, how many close points are near it; points whose answers the group may
//! change.
//! Invariants: distances are squares, computed by [`square_distance`] everywhere. What is left out of a search is left
//! out by comparisons that hold for rounded squares too: rounding keeps the order.
//! Must not know: which points are clutter.

use super::tree::{Body, Bounds, Entry, NodeId, ROOT, Tree};
use crate::topology::cloud::{Position, Slot};

/// The squared distance of two positions.
#[inline]
pub fn square_distance(a: Position, b: Position) -> f64 {
    let (dx, dy) = (a.x() - b.x(), a.y() - b.y());
    dx * dx + dy * dy
}

/// The box of some positions.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    low: [f64; 2],
    high: [f64; 2],
}

impl Extent {
    /// The box of some positions.
    pub fn of(positions: impl Iterator<Item = Position>) -> Self {
        let nothing = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        positions.fold(nothing, |mut extent, position| {
            for (axis, v) in position.xy().into_iter().enumerate() {
                extent.low[axis] = extent.low[axis].min(v);
                extent.high[axis] = extent.high[axis].max(v);
            }
            extent
        })
    }

    /// The squared distance of two boxes: at most that of any positions in them.
    #[inline]
    fn square_distance(&self, low: [f64; 2], high: [f64; 2]) -> f64 {
        let [dx, dy] = [0, 1].map(|axis| (self.low[axis] - high[axis]).max(low[axis] - self.high[axis]).max(0.0));
        dx * dx + dy * dy
    }
}

/// The nearest squared distances so far, in order.
struct Nearest<'a> {
    squares: &'a mut [f64],
}

impl Nearest<'_> {
    #[inline]
    fn offer(&mut self, square: f64) {
        let last = self.squares.len() - 1;
        if square >= self.squares[last] {
            return;
        }
        let mut place = last;
        while place > 0 && self.squares[place - 1] > square {
            self.squares[place] = self.squares[place - 1];
            place -= 1;
        }
        self.squares[place] = square;
    }

    #[inline]
    fn farthest(&self) -> f64 {
        self.squares[self.squares.len() - 1]
    }
}

/// A search for points that are close together near a point.
struct Witnesses {
    at: Position,
    /// How near they are, squared.
    within: f64,
    /// The largest reach of a close point.
    closest: f64,
    wanted: usize,
}

impl Tree {
    /// The squared distance of the K-th nearest other point to the one in a slot; infinite if there are not so many.
    /// K is the length of `squares`, which is working memory.
    pub fn reach(&self, at: Position, slot: Slot, squares: &mut [f64]) -> f64 {
        squares.fill(f64::INFINITY);
        let mut nearest = Nearest { squares };
        self.find_nearest(ROOT, at, slot, &mut nearest);
        nearest.farthest()
    }

    fn find_nearest(&self, id: NodeId, at: Position, slot: Slot, nearest: &mut Nearest<'_>) {
        match self.nodes[id as usize].body {
            Body::Leaf { chunk } => {
                for entry in self.chunk(chunk) {
                    if entry.slot != slot {
                        nearest.offer(square_distance(at, entry.position));
                    }
                }
            }
            Body::Halves { axis, at: split, halves } => {
                let beyond = at.xy()[axis] - split[0];
                let first = usize::from(beyond >= 0.0);
                self.find_nearest(halves[first], at, slot, nearest);
                // All of the other half is at least as far as the line between them.
                if beyond * beyond < nearest.farthest() {
                    self.find_nearest(halves[1 - first], at, slot, nearest);
                }
            }
        }
    }

    /// Whether `wanted` points with a reach up to `closest` are within a distance, given by its square.
    pub fn has_witnesses(&self, at: Position, within: f64, closest: f64, wanted: usize) -> bool {
        let mut search = Witnesses { at, within, closest, wanted };
        self.find_witnesses(ROOT, &mut search);
        search.wanted == 0
    }

    fn find_witnesses(&self, id: NodeId, search: &mut Witnesses) {
        let node = &self.nodes[id as usize];
        if node.bounds.least > search.closest || search.wanted == 0 {
            return;
        }
        match node.body {
            Body::Leaf { chunk } => {
                let is_witness = |entry: &&Entry| {
                    entry.reach <= search.closest && square_distance(search.at, entry.position) <= search.within
                };
                let found = self.chunk(chunk).iter().filter(is_witness).count();
                search.wanted = search.wanted.saturating_sub(found);
            }
            Body::Halves { axis, at: split, halves } => {
                let beyond = search.at.xy()[axis] - split[0];
                let first = usize::from(beyond >= 0.0);
                self.find_witnesses(halves[first], search);
                if beyond * beyond <= search.within {
                    self.find_witnesses(halves[1 - first], search);
                }
            }
        }
    }

    /// Calls `visit` on the points that are at most `factor` times their reach (squares of both) away from a group of
    /// positions, or a little farther, and whose reach is at least `least`.
    pub fn around(&self, group: Extent, factor: f64, least: f64, visit: &mut impl FnMut(&Entry)) {
        self.find_around(ROOT, group, factor, least, visit);
    }

    fn find_around(&self, id: NodeId, group: Extent, factor: f64, least: f64, visit: &mut impl FnMut(&Entry)) {
        let node = &self.nodes[id as usize];
        let Bounds { low, high, most, .. } = node.bounds;
        if most < least || group.square_distance(low, high) > factor * most {
            return;
        }
        match node.body {
            Body::Leaf { chunk } => {
                for entry in self.chunk(chunk) {
                    let xy = entry.position.xy();
                    if entry.reach >= least && group.square_distance(xy, xy) <= factor * entry.reach {
                        visit(entry);
                    }
                }
            }
            Body::Halves { halves, .. } => {
                halves.into_iter().for_each(|half| self.find_around(half, group, factor, least, visit));
            }
        }
    }
}
