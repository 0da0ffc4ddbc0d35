//! The class of an edge, closed by the tree, as a sum of births.
//!
//! In: an edge of the graph so far.
//! Out: births added to a sum.
//! Invariants: any vertex of an edge's lune gives two edges that come before it, and whose classes add up to its class,
//! since the three make a triangle. Relative-neighbourhood edges have no lune: they are in the tree, which is zero, or
//! a birth. So halving ends there.
//! Must not know: which births are alive.

use std::sync::atomic::{AtomicU64, Ordering};

use super::classes::toggle;
use super::graph_bits::GraphBits;
use super::neighbours::{Neighbour, Neighbours};
use super::pair::Pair;
use super::placement::Placement;
use crate::topology::metric::space::Distances;

/// About so many vertices of a lune are tried: halves of nearly half the length are short enough.
const TRIED: usize = 32;

/// Edges whose middles are remembered, at most: a quarter of a MiB.
const REMEMBERED: usize = if cfg!(test) { 1 << 3 } else { 1 << 15 };

/// The same for each vertex of a small space.
const OF_A_VERTEX: usize = 32;

/// Middles of edges that were found before. A vertex that is in the lune of an edge stays there: which edges come
/// before it does not change. Of edges that fall on one place, the last is remembered.
#[derive(Debug)]
pub struct Middles(Vec<AtomicU64>);

impl Middles {
    /// None, of a space of so many vertices.
    pub fn new(count: usize) -> Self {
        let places = (OF_A_VERTEX * count).next_power_of_two().clamp(2, REMEMBERED);
        Self((0..places).map(|_| AtomicU64::new(u64::MAX)).collect())
    }

    /// The middle of an edge, else what `find` finds. Vertices have two bytes.
    #[inline]
    fn get(&self, a: u32, b: u32, find: impl FnOnce() -> u32) -> u32 {
        let name = u64::from(a.min(b)) << 16 | u64::from(a.max(b));
        let hash = name.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let place = &self.0[(hash >> (64 - self.0.len().trailing_zeros())) as usize];
        let held = place.load(Ordering::Relaxed);
        if held >> 16 == name {
            return (held & 0xffff) as u32;
        }
        let middle = find();
        place.store(name << 16 | u64::from(middle), Ordering::Relaxed);
        middle
    }
}

/// What the class of an edge is found in.
#[derive(Clone, Copy)]
pub struct Halving<'s> {
    /// Lengths.
    pub space: &'s dyn Distances,
    /// Where vertices stand in the rows of the graph.
    pub placement: &'s Placement,
    /// All edges up to some length.
    pub graph: &'s GraphBits,
    /// The relative-neighbourhood edges among them.
    pub neighbours: &'s Neighbours,
    /// What was found before.
    pub middles: &'s Middles,
}

impl Halving<'_> {
    /// Adds the class of the edge of `i` and `j`, closed by the tree.
    pub fn add(&self, i: u32, j: u32, total: &mut [u64]) {
        let mut edges = vec![(i, j)];
        while let Some((a, b)) = edges.pop() {
            match self.neighbours.get(a, b) {
                Some(Neighbour::Tree) => {}
                Some(Neighbour::Birth(birth)) => toggle(total, birth),
                None => {
                    let c = self.middles.get(a, b, || self.middle(a, b));
                    edges.extend([(a, c), (c, b)]);
                }
            }
        }
    }

    /// The vertex of the lune that halves the edge best: of some of each word first, then of all.
    fn middle(&self, a: u32, b: u32) -> u32 {
        let edge = Pair::new(self.space.length(a, b), a, b);
        let (row_a, row_b) = (self.graph.row(self.placement.place(a)), self.graph.row(self.placement.place(b)));
        let words = row_a.iter().zip(row_b).filter(|(x, y)| *x & *y != 0).count().max(1);
        let found = self.best(edge, row_a, row_b, TRIED.div_ceil(words)).or_else(|| self.best(edge, row_a, row_b, 64));
        found.expect("an edge that is no relative-neighbourhood edge has a vertex in its lune")
    }

    /// The best vertex of about so many of each word.
    fn best(&self, edge: Pair, row_a: &[u64], row_b: &[u64], most: usize) -> Option<u32> {
        let mut best: Option<(f64, u32)> = None;
        for (word, (x, y)) in row_a.iter().zip(row_b).enumerate() {
            let mut common = x & y;
            let step = (common.count_ones() as usize).div_ceil(most);
            while common != 0 {
                let c = self.placement.vertex(word as u32 * 64 + common.trailing_zeros());
                (0..step).for_each(|_| common &= common.wrapping_sub(1));
                if let Some(longer) = self.longer_half(edge, c)
                    && best.is_none_or(|(length, _)| longer < length)
                {
                    best = Some((longer, c));
                }
            }
        }
        best.map(|(_, c)| c)
    }

    /// The length of the longer half, if `c` is in the lune of the edge.
    #[inline]
    fn longer_half(&self, edge: Pair, c: u32) -> Option<f64> {
        if c == edge.a || c == edge.b {
            return None;
        }
        let [ac, bc] = edge.ends().map(|end| self.space.length(end, c));
        let longer = ac.max(bc);
        let is_in_lune = longer < edge.length
            || longer == edge.length
                && Pair::new(ac, edge.a, c).before(&edge)
                && Pair::new(bc, edge.b, c).before(&edge);
        is_in_lune.then_some(longer)
    }
}
