//! Searches in the tree of points.
//!
//! In: a point, or a group of positions that change.
//! Out: the distance of its K-th neighbour, how many close points are near it; points whose answers the group may
//! change.
//! Invariants: distances are squares, computed by [`square_distance`] everywhere. What is left out of a search is left
//! out by comparisons that hold for rounded squares too: rounding keeps the order.
//! Must not know: which points are clutter.

use super::tree::{Body, Bounds, Entry, NodeId, ROOT, Tree};
use crate::topology::cloud::Position;

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

/// Working memory for reaches.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    squares: Vec<f64>,
    around: Vec<NodeId>,
    reaches: Vec<f64>,
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
    /// The squared distances of the K-th nearest other points to some of a leaf, infinite where there are not so many.
    /// Bounding boxes must be right. All of them share a search for the leaves around.
    pub fn reaches<'a>(&self, leaf: NodeId, group: &[Entry], neighbours: usize, work: &'a mut Workspace) -> &'a [f64] {
        let Workspace { squares, around, reaches } = work;
        squares.clear();
        squares.resize(neighbours * group.len(), f64::INFINITY);
        reaches.clear();
        around.clear();
        let mut farthest = 0.0_f64;
        for (entry, squares) in group.iter().zip(squares.chunks_exact_mut(neighbours)) {
            let mut nearest = Nearest { squares };
            self.offer_leaf(leaf, entry, &mut nearest);
            farthest = farthest.max(nearest.farthest());
        }
        if farthest == f64::INFINITY {
            // In a leaf of few points the search starts without a bound.
            reaches.extend(group.iter().zip(squares.chunks_exact_mut(neighbours)).map(|(entry, squares)| {
                squares.fill(f64::INFINITY);
                let mut nearest = Nearest { squares };
                self.find_nearest(ROOT, entry, &mut nearest);
                nearest.farthest()
            }));
            return reaches;
        }
        let extent = Extent::of(group.iter().map(|entry| entry.position));
        self.find_leaves(ROOT, extent, farthest, around);
        reaches.extend(group.iter().zip(squares.chunks_exact_mut(neighbours)).map(|(entry, squares)| {
            let mut nearest = Nearest { squares };
            for &other in around.iter().filter(|&&other| other != leaf) {
                if self.square_distance_to(other, entry.position) < nearest.farthest() {
                    self.offer_leaf(other, entry, &mut nearest);
                }
            }
            nearest.farthest()
        }));
        reaches
    }

    #[inline]
    fn offer_leaf(&self, leaf: NodeId, entry: &Entry, nearest: &mut Nearest<'_>) {
        for other in self.leaf_entries(leaf) {
            if other.slot != entry.slot {
                nearest.offer(square_distance(entry.position, other.position));
            }
        }
    }

    #[inline]
    fn square_distance_to(&self, id: NodeId, position: Position) -> f64 {
        let Bounds { low, high, .. } = self.nodes[id as usize].bounds;
        let xy = position.xy();
        Extent { low: xy, high: xy }.square_distance(low, high)
    }

    /// The leaves that are nearer to a box than a distance, given by its square.
    fn find_leaves(&self, id: NodeId, extent: Extent, within: f64, leaves: &mut Vec<NodeId>) {
        let node = &self.nodes[id as usize];
        if extent.square_distance(node.bounds.low, node.bounds.high) >= within {
            return;
        }
        match node.body {
            Body::Leaf { .. } => leaves.push(id),
            Body::Halves { halves, .. } => {
                halves.into_iter().for_each(|half| self.find_leaves(half, extent, within, leaves));
            }
        }
    }

    fn find_nearest(&self, id: NodeId, entry: &Entry, nearest: &mut Nearest<'_>) {
        match self.nodes[id as usize].body {
            Body::Leaf { .. } => self.offer_leaf(id, entry, nearest),
            Body::Halves { axis, at: split, halves } => {
                let beyond = entry.position.xy()[axis] - split[0];
                let first = usize::from(beyond >= 0.0);
                self.find_nearest(halves[first], entry, nearest);
                // All of the other half is at least as far as the line between them.
                if beyond * beyond < nearest.farthest() {
                    self.find_nearest(halves[1 - first], entry, nearest);
                }
            }
        }
    }

    /// The least reach of the points within a distance of a box, given by its square; `most` if none is less.
    pub fn least_reach(&self, extent: Extent, within: f64, most: f64) -> f64 {
        let mut least = most;
        self.find_least(ROOT, extent, within, &mut least);
        least
    }

    fn find_least(&self, id: NodeId, extent: Extent, within: f64, least: &mut f64) {
        let node = &self.nodes[id as usize];
        if node.bounds.least >= *least || extent.square_distance(node.bounds.low, node.bounds.high) > within {
            return;
        }
        match node.body {
            Body::Leaf { .. } => {
                for entry in self.leaf_entries(id) {
                    let xy = entry.position.xy();
                    if entry.reach < *least && extent.square_distance(xy, xy) <= within {
                        *least = entry.reach;
                    }
                }
            }
            Body::Halves { halves, .. } => {
                halves.into_iter().for_each(|half| self.find_least(half, extent, within, least));
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
            Body::Leaf { .. } => {
                let is_witness = |entry: &&Entry| {
                    entry.reach <= search.closest && square_distance(search.at, entry.position) <= search.within
                };
                let found = self.leaf_entries(id).iter().filter(is_witness).count();
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
            Body::Leaf { .. } => {
                for entry in self.leaf_entries(id) {
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
