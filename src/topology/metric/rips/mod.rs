//! The Vietoris-Rips filtration of a finite metric space: minimum spanning tree and labelled critical edges.
//!
//! In: [`Distances`], the longest length of the filtration.
//! Out: [`Persistence`]: tree edges, and births with the edges that kill them. On request the classes of closed walks.
//! Invariants: it is exact in the lengths, which are only compared. It depends on the space alone: not on the number of
//! threads, not on what a [`Workspace`] remembers.
//! Must not know: coordinates, skeletons, streams.
//!
//! # Why it is right
//!
//! An edge enters at its length, a triangle with its longest edge. All pairs are in one total order: (length, smaller
//! end, larger end). Let K_i be the flag complex of the first i edges. When the edge ab comes, the new simplices are
//! the joins of ab with the simplices of its *lune*, the vertices c with ac and bc before ab: the lune's flag complex
//! is the link of ab in K_i. So H_k(K_i, K_{i-1}) is the reduced homology of the link in dimension k - 2, and for H_1:
//!
//! * If the lune is empty, ab joins two components (a tree edge) or gives birth to a cycle. Such edges are those of the
//!   relative neighbourhood graph of the total order.
//! * If the lune is connected, nothing happens.
//! * If the lune is in m parts, at most m - 1 classes die: those of the 4-cycles a c b d, with c in the first part and
//!   d in another.
//!
//! The elder rule over these single edges gives unique pairs (birth edge, death edge). Nothing is approximated.
//!
//! # Why it is fast
//!
//! Pairs are packed into 64 bits and sorted bucket by bucket. The graph so far is one row of bits a vertex, so a lune
//! is the intersection of two rows, and one vertex that covers it proves it connected. Only a split lune needs algebra.
//! The class of an edge is found by halving it through vertices of its lune. The sweep ends when nothing is alive and
//! no birth is left, which is known from the pairs beyond, whose lunes are looked at once.

mod batches;
mod classes;
mod forest;
mod graph_bits;
mod halving;
mod longer;
mod lune;
mod neighbours;
mod packed;
mod pair;
mod placement;
mod sweep;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod textbook;
mod walks;

use std::ops::RangeInclusive;

use batches::Batches;
use classes::Classes;
use longer::longer_neighbours;
use lune::Lunes;
use packed::{Buckets, Packed};
use placement::Placement;
use sweep::Sweep;
use walks::classes_of;

pub use packed::MAX_VERTICES;
pub use pair::Pair;
pub use walks::{Class, ClosedWalk};

use super::space::{Distances, Table};
use crate::topology::base::thread_count;

/// Pairs a vertex in the first batch of a space that nothing is known of.
const FIRST: usize = if cfg!(test) { 2 } else { 24 };

/// The least pairs of the first batch of a space that is like the last one.
const LEAST: usize = if cfg!(test) { 16 } else { 1 << 12 };

/// Pairs of any later batch.
const LATER: RangeInclusive<usize> = if cfg!(test) { 1 << 6..=1 << 9 } else { 1 << 18..=1 << 21 };

/// Costly lengths of at most so many vertices are computed once and kept: 64 MiB.
const TABULATED: usize = 1 << 12;

/// Below this many vertices one thread is faster.
const FEW_VERTICES: usize = if cfg!(test) { 8 } else { 1024 };

/// More threads have nothing to do: each of them adds all edges to its own graph.
const MOST_THREADS: usize = 4;

/// What the filtration has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Persistence {
    /// Edges of the minimum spanning tree, in order.
    pub tree: Vec<Pair>,
    /// Critical edges in order, each with the edge whose entry kills its class; none if it lives to the end. Classes
    /// that die at the length of their birth are left out.
    pub critical: Vec<(Pair, Option<Pair>)>,
}

/// What the next sweep of a similar space may use again. It changes no result.
#[derive(Debug, Default)]
pub struct Workspace {
    placement: Placement,
    lunes: Vec<Lunes>,
    batch: Vec<Packed>,
    buckets: Buckets,
    /// Pairs that the last sweep needed.
    needed: usize,
}

impl Workspace {
    /// The next space is another one: `before` gives for each of its vertices which it was in the last one.
    pub fn carry(&mut self, before: &[Option<u32>]) {
        if self.placement.count() > 0 {
            self.placement = self.placement.carried(before);
        }
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.lunes.iter().map(Lunes::bytes).sum::<usize>()
            + self.batch.capacity() * size_of::<Packed>()
            + self.buckets.bytes()
    }
}

/// Computes the filtration up to the length `limit`.
///
/// # Panics
/// If there are more than [`MAX_VERTICES`] vertices.
pub fn persistence(space: &dyn Distances, limit: f64, workspace: &mut Workspace) -> Persistence {
    persistence_and_classes(space, limit, &[], workspace).0
}

/// Computes the filtration up to the length `limit`, and the classes of closed walks; none where a step is no edge.
/// Where a walk's length is beyond the limit, its class is that at the limit.
///
/// # Panics
/// If there are more than [`MAX_VERTICES`] vertices, or a walk has a vertex that is not there.
pub fn persistence_and_classes(
    space: &dyn Distances,
    limit: f64,
    walks: &[ClosedWalk],
    workspace: &mut Workspace,
) -> (Persistence, Vec<Option<Class>>) {
    let count = space.count();
    assert!(count <= MAX_VERTICES, "ends of pairs have 16 bits");
    if count < 2 {
        return (Persistence::default(), classes_of(walks, space, limit, None, None));
    }
    if space.is_costly() && count <= TABULATED {
        return persistence_and_classes(&Table::new(space), limit, walks, workspace);
    }
    let threads = if count < FEW_VERTICES { 1 } else { thread_count().min(MOST_THREADS) };
    let mut run = Run::new(space, limit, threads, std::mem::take(workspace));
    run.remembers = !walks.is_empty();
    let over = run.sweep();
    let classes = classes_of(walks, space, run.limit, run.sweep.as_ref(), over);
    let (persistence, used) = run.finish();
    *workspace = used;
    (persistence, classes)
}

/// One sweep.
struct Run<'s> {
    space: &'s dyn Distances,
    limit: f64,
    threads: usize,
    /// Whether classes will be asked for.
    remembers: bool,
    batches: Batches<'s>,
    batch: Vec<Packed>,
    buckets: Buckets,
    sweep: Option<Sweep<'s>>,
    /// What the last sweep used: how many pairs, where vertices stood, graphs.
    before: (usize, Placement, Vec<Lunes>),
    /// Relative-neighbourhood edges longer than all that were there when they were looked for, and how many births
    /// there are with them.
    rest: Option<(Vec<Pair>, usize)>,
    /// Pairs up to the last birth or death.
    needed: usize,
}

impl<'s> Run<'s> {
    fn new(space: &'s dyn Distances, limit: f64, threads: usize, used: Workspace) -> Self {
        let Workspace { placement, lunes, batch, buckets, needed } = used;
        // Pairs of infinite length are never joined.
        let limit = limit.min(f64::MAX);
        Self {
            space,
            limit,
            threads,
            remembers: false,
            batches: Batches::new(space, limit, threads),
            batch,
            buckets,
            sweep: None,
            before: (needed, placement, lunes),
            rest: None,
            needed: 0,
        }
    }

    /// Sweeps. If it ends before the limit since nothing is alive from there on, returns the length up to which all
    /// pairs were added.
    fn sweep(&mut self) -> Option<f64> {
        while !self.batches.is_empty() {
            let is_first = self.sweep.is_none();
            let taken = self.batches.taken();
            self.batches.next(self.wanted(is_first), &mut self.batch);
            let end = self.batches.done();
            self.buckets.fill(&self.batch);
            self.begin();
            let mut swept = taken;
            for number in 0..self.buckets.count() {
                let is_last = number + 1 == self.buckets.count();
                let Some(longest) = self.add(number, &mut swept) else { continue };
                // All pairs of one length are in one bucket.
                if !is_first && !is_last && self.is_over(longest) {
                    return Some(longest);
                }
            }
            if self.is_over(end) {
                return Some(end);
            }
        }
        None
    }

    /// Pairs of the next batch.
    fn wanted(&self, is_first: bool) -> usize {
        match self.before.0 {
            0 if is_first => FIRST * self.space.count(),
            before if is_first => (before + before / 16).clamp(LEAST, *LATER.end()),
            _ => self.batches.taken().clamp(*LATER.start(), *LATER.end()),
        }
    }

    /// Begins the sweep, when the first batch is there.
    fn begin(&mut self) {
        if self.sweep.is_some() {
            return;
        }
        let (count, (_, placement, lunes)) = (self.space.count(), std::mem::take(&mut self.before));
        let placement = if placement.count() == count {
            placement
        } else {
            self.batch.sort_unstable();
            Placement::along(count, self.batch.iter().map(|pair| pair.ends()))
        };
        self.sweep = Some(Sweep::new(self.space, placement, lunes, self.threads, Classes::new(self.remembers)));
    }

    /// Adds the pairs of a bucket, and their number to `swept`. Returns the longest length; none without pairs.
    fn add(&mut self, bucket: usize, swept: &mut usize) -> Option<f64> {
        let sweep = self.sweep.as_mut()?;
        let pairs = self.buckets.sorted(bucket, self.space);
        let before = (sweep.births().len(), sweep.classes().alive());
        sweep.add(pairs);
        *swept += pairs.len();
        if before.1 > 0 || sweep.births().len() > before.0 {
            self.needed = *swept;
        }
        Some(pairs.last()?.pair(self.space).length)
    }

    /// Whether nothing is alive and no birth is left, after all pairs up to the length `done`. What is left is looked
    /// for once, when nothing is alive for the first time.
    fn is_over(&mut self, done: f64) -> bool {
        let Some(sweep) = &self.sweep else { return false };
        if sweep.classes().alive() > 0 {
            return false;
        }
        if self.rest.is_none() {
            let rest = longer_neighbours(self.space, sweep, done, self.limit, self.threads);
            let mut forest = sweep.forest().clone();
            let births = rest.iter().filter(|pair| !forest.join(pair.a, pair.b)).count();
            self.rest = Some((rest, sweep.births().len() + births));
        }
        self.rest.as_ref().is_some_and(|&(_, births)| births == sweep.births().len())
    }

    fn finish(self) -> (Persistence, Workspace) {
        let Some(sweep) = self.sweep else { return Default::default() };
        let mut tree = sweep.tree().to_vec();
        let mut forest = sweep.forest().clone();
        let rest = self.rest.map(|(rest, _)| rest).unwrap_or_default();
        tree.extend(rest.into_iter().filter(|pair| forest.join(pair.a, pair.b)));
        let critical = sweep.births().iter().copied().zip(sweep.deaths().iter().copied());
        let lives = |&(birth, death): &(Pair, Option<Pair>)| death.is_none_or(|death| death.length > birth.length);
        let persistence = Persistence { tree, critical: critical.filter(lives).collect() };
        let (placement, lunes) = sweep.into_workspace();
        let needed = self.needed;
        (persistence, Workspace { placement, lunes, batch: self.batch, buckets: self.buckets, needed })
    }
}
