//! Relative-neighbourhood edges longer than all edges so far.
//!
//! In: a sweep, and the length it has come to.
//! Out: those pairs, in order. They are the rest of the tree and the births to come.
//! Invariants: it is exact: what rules a pair out is a vertex of its lune, or that it is known.
//! Must not know: classes.
//!
//! Most pairs are ruled out by a relative neighbour of one of their ends: these are near, and in many directions. They
//! are compared with whole blocks of pairs at once. What is left is asked for common neighbours in the graph so far,
//! then for any vertex.

use super::halving::Halving;
use super::pair::Pair;
use super::sweep::Sweep;
use crate::topology::base::at_once;
use crate::topology::metric::space::Distances;

/// Pairs that are compared at once.
const BLOCK: usize = 64;

/// Relative neighbours of a vertex that are compared with blocks of pairs.
const WITNESSES: usize = 8;

/// Rows that a thread takes at a time.
const STRIPE: usize = 16;

/// The pairs longer than `done`, up to `limit`, whose lune is empty.
pub fn longer_neighbours(space: &dyn Distances, sweep: &Sweep, done: f64, limit: f64, threads: usize) -> Vec<Pair> {
    let near = relative_neighbours(space.count(), sweep);
    let mut workers = vec![(); threads];
    let found = at_once(&mut workers, |own, ()| {
        let mut search = Search::new(space, &near, sweep.halving());
        let mut found = Vec::new();
        for a in (0..space.count()).filter(|a| a / STRIPE % threads == own) {
            search.begin_row(a as u32);
            found.extend(search.candidates(a as u32, done, limit).filter(|&pair| search.has_empty_lune(pair)));
        }
        found
    });
    let mut found: Vec<Pair> = found.into_iter().flatten().collect();
    found.sort_unstable_by(Pair::order);
    found
}

/// For each vertex its relative neighbours so far, the farthest first.
fn relative_neighbours(count: usize, sweep: &Sweep) -> Vec<Vec<u32>> {
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut edges: Vec<&Pair> = sweep.tree().iter().chain(sweep.births()).collect();
    edges.sort_unstable_by(|x, y| y.order(x));
    for edge in edges {
        near[edge.a as usize].push(edge.b);
        near[edge.b as usize].push(edge.a);
    }
    near
}

struct Search<'s> {
    space: &'s dyn Distances,
    near: &'s [Vec<u32>],
    so_far: Halving<'s>,
    row: Vec<f64>,
    other: Vec<f64>,
    /// All vertices, so that a few of them are from everywhere: their order is by position, and a lune is in one place.
    scattered: Vec<u32>,
    /// 1 for pairs that are ruled out.
    is_out: Vec<u8>,
}

impl<'s> Search<'s> {
    fn new(space: &'s dyn Distances, near: &'s [Vec<u32>], so_far: Halving<'s>) -> Self {
        let count = space.count();
        let (row, other, is_out) = (vec![0.0; count], vec![0.0; BLOCK], vec![0; count]);
        Self { space, near, so_far, row, other, scattered: scattered(count), is_out }
    }

    /// Rules out pairs of `a` with larger vertices, by relative neighbours of `a`.
    fn begin_row(&mut self, a: u32) {
        let count = self.row.len();
        let first = a as usize + 1;
        self.space.lengths(a, a + 1, &mut self.row[first..]);
        self.is_out[first..].fill(0);
        for start in (first..count).step_by(BLOCK) {
            let end = (start + BLOCK).min(count);
            for &c in self.near[a as usize].iter().take(WITNESSES) {
                let other = &mut self.other[..end - start];
                self.space.lengths(c, start as u32, other);
                let mut all = 1;
                for ((is_out, ab), bc) in self.is_out[start..end].iter_mut().zip(&self.row[start..end]).zip(other) {
                    // That ac is shorter too is checked by `candidates`: it is at most `done`. A known pair is ruled
                    // out by itself, where c is b.
                    *is_out |= u8::from(*bc < *ab);
                    all &= *is_out;
                }
                if all == 1 {
                    break;
                }
            }
        }
    }

    /// What is left of the row, longer than all edges so far.
    fn candidates(&self, a: u32, done: f64, limit: f64) -> impl Iterator<Item = Pair> + use<'_, 's> {
        let rest = self.row.iter().zip(&self.is_out).enumerate().skip(a as usize + 1);
        let left = rest.filter(move |&(_, (&length, &is_out))| is_out == 0 && length > done && length <= limit);
        left.map(move |(b, (&length, _))| Pair::new(length, a, b as u32))
    }

    fn has_empty_lune(&self, pair: Pair) -> bool {
        let Pair { length, a, b } = pair;
        if self.near[b as usize].iter().any(|&c| self.space.length(a, c) < length) {
            return false;
        }
        let [row_a, row_b] = [a, b].map(|end| self.so_far.graph.row(self.so_far.placement.place(end)));
        if row_a.iter().zip(row_b).any(|(x, y)| x & y != 0) {
            return false;
        }
        let is_in_lune = |c: u32| {
            c != a
                && c != b
                && Pair::new(self.space.length(a, c), a, c).before(&pair)
                && Pair::new(self.space.length(b, c), b, c).before(&pair)
        };
        !self.scattered.iter().any(|&c| is_in_lune(c))
    }
}

/// The numbers below `count`, in steps of about the golden section of it.
fn scattered(count: usize) -> Vec<u32> {
    let coprime = |&step: &usize| {
        let (mut a, mut b) = (step, count);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let step = (count * 5 / 8..).find(coprime).unwrap_or(1);
    (0..count).map(|place| (place * step % count) as u32).collect()
}
