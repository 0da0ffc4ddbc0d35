//! Adding edges one at a time: what each does to components and cycles.
//!
//! In: pairs in the total order.
//! Out: tree edges, births, deaths.
//! Invariants: an edge with an empty lune joins two components or gives birth. One with a connected lune changes
//! nothing. One whose lune is in m parts ends at most m - 1 classes: those of the 4-cycles through both its ends, one
//! vertex of the first part and one of another. The youngest birth of a class dies. All threads have the same graph, so
//! the result does not depend on their number.
//! Must not know: where pairs come from, when to stop.

use super::classes::{Classes, Total};
use super::forest::Forest;
use super::halving::{Halving, Middles};
use super::lune::{Lune, Lunes};
use super::neighbours::{Neighbour, Neighbours};
use super::packed::Packed;
use super::pair::Pair;
use super::placement::Placement;
use crate::topology::base::at_once;
use crate::topology::metric::space::Distances;

/// Pairs that a thread takes at a time.
const RUN: usize = if cfg!(test) { 8 } else { 256 };

/// Below this many pairs one thread is faster.
const FEW: usize = if cfg!(test) { 16 } else { 2048 };

/// The filtration so far.
pub struct Sweep<'s> {
    space: &'s dyn Distances,
    placement: Placement,
    /// One graph a thread, all the same.
    lunes: Vec<Lunes>,
    forest: Forest,
    neighbours: Neighbours,
    tree: Vec<Pair>,
    births: Vec<Pair>,
    deaths: Vec<Option<Pair>>,
    classes: Classes,
    middles: Middles,
}

impl<'s> Sweep<'s> {
    /// Before the first edge. Graphs may be those of another sweep of as many vertices. Classes may have to remember
    /// what births became.
    pub fn new(
        space: &'s dyn Distances,
        placement: Placement,
        mut lunes: Vec<Lunes>,
        threads: usize,
        classes: Classes,
    ) -> Self {
        let count = space.count();
        lunes.retain(|lunes| lunes.graph().count() == count);
        lunes.iter_mut().for_each(Lunes::clear);
        lunes.resize_with(threads, || Lunes::new(count));
        Self {
            space,
            placement,
            lunes,
            forest: Forest::new(count),
            neighbours: Neighbours::default(),
            tree: Vec::new(),
            births: Vec::new(),
            deaths: Vec::new(),
            classes,
            middles: Middles::new(count),
        }
    }

    /// Edges of the minimum spanning tree so far, in order.
    pub fn tree(&self) -> &[Pair] {
        &self.tree
    }

    /// Births so far, in order.
    pub fn births(&self) -> &[Pair] {
        &self.births
    }

    /// The death of each birth so far.
    pub fn deaths(&self) -> &[Option<Pair>] {
        &self.deaths
    }

    /// The components so far.
    pub fn forest(&self) -> &Forest {
        &self.forest
    }

    /// Classes so far.
    pub fn classes(&self) -> &Classes {
        &self.classes
    }

    /// How the class of an edge is found.
    pub fn halving(&self) -> Halving<'_> {
        Halving {
            space: self.space,
            placement: &self.placement,
            graph: self.lunes[0].graph(),
            neighbours: &self.neighbours,
            middles: &self.middles,
        }
    }

    /// What the next sweep may use again.
    pub fn into_workspace(self) -> (Placement, Vec<Lunes>) {
        (self.placement, self.lunes)
    }

    /// Adds edges, which are in order and come after all so far.
    pub fn add(&mut self, pairs: &[Packed]) {
        if self.lunes.len() == 1 || pairs.len() < FEW {
            self.add_one_by_one(pairs);
        } else {
            self.add_in_runs(pairs);
        }
    }

    fn add_one_by_one(&mut self, pairs: &[Packed]) {
        for &pair in pairs {
            let [a, b] = pair.ends().map(|end| self.placement.place(end));
            let lune = self.lunes[0].lune(a, b);
            self.take(pair, &lune);
            self.lunes[0].join(a, b);
        }
        for lunes in &mut self.lunes[1..] {
            for pair in pairs {
                let [a, b] = pair.ends().map(|end| self.placement.place(end));
                lunes.join(a, b);
            }
        }
    }

    /// Every thread adds all edges to its graph, and asks for the lunes of some.
    fn add_in_runs(&mut self, pairs: &[Packed]) {
        let (placement, threads) = (&self.placement, self.lunes.len());
        let found = at_once(&mut self.lunes, |own, lunes| {
            let mut found: Vec<(usize, Lune)> = Vec::new();
            for (number, pair) in pairs.iter().enumerate() {
                let [a, b] = pair.ends().map(|end| placement.place(end));
                if number / RUN % threads == own {
                    match lunes.lune(a, b) {
                        Lune::Whole => {}
                        lune => found.push((number, lune)),
                    }
                }
                lunes.join(a, b);
            }
            found
        });
        let mut found: Vec<(usize, Lune)> = found.into_iter().flatten().collect();
        found.sort_unstable_by_key(|&(number, _)| number);
        for (number, lune) in found {
            self.take(pairs[number], &lune);
        }
    }

    fn take(&mut self, pair: Packed, lune: &Lune) {
        match lune {
            Lune::Whole => {}
            Lune::Empty => self.take_neighbour(pair.pair(self.space)),
            Lune::Split(parts) => self.take_split(pair, parts),
        }
    }

    /// An edge with an empty lune.
    fn take_neighbour(&mut self, edge: Pair) {
        let what = if self.forest.join(edge.a, edge.b) {
            self.tree.push(edge);
            Neighbour::Tree
        } else {
            self.births.push(edge);
            self.deaths.push(None);
            self.classes.bear();
            Neighbour::Birth(self.births.len() as u32 - 1)
        };
        self.neighbours.insert(edge.a, edge.b, what);
    }

    /// An edge whose lune is in parts, of each of which one vertex is given.
    fn take_split(&mut self, pair: Packed, parts: &[u32]) {
        if self.classes.alive() == 0 {
            return;
        }
        let first = self.path(pair, parts[0]);
        for &part in &parts[1..] {
            let mut total = self.path(pair, part);
            for (total, first) in total.iter_mut().zip(&first) {
                *total ^= first;
            }
            self.classes.settle(&mut total);
            if let Some(birth) = self.classes.kill(&mut total) {
                self.deaths[birth as usize] = Some(pair.pair(self.space));
            }
        }
    }

    /// The class of the path from one end of an edge to the other through a vertex of its lune.
    fn path(&self, pair: Packed, through: u32) -> Total {
        let ([a, b], c) = (pair.ends(), self.placement.vertex(through));
        let mut total = self.classes.zero();
        self.halving().add(a, c, &mut total);
        self.halving().add(c, b, &mut total);
        total
    }
}
