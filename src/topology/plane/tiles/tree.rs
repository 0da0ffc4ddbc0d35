//! The tree of tiles: what each tile holds, and what is asked of all of them.
//!
//! In: a cloud's slots. Out: tree edges and dots of the whole, and lists of tiles to work on. Invariants: a tile lists what it resolved in the total order; each extreme of a tile is that of all below it. Must not know:
//! how tiles are reduced, how leaves split.

use super::border::Border;
use super::resolved::Resolved;
use super::split::Split;
use super::star::Stars;
use super::worker::Worker;
use crate::topology::cloud::{Cloud, Located, Slot};
use crate::topology::plane::elements::{TileDot, TreeEdge};

/// How many vertices a leaf has at most when it is made. Measured: from 60 to 200 make little difference; with fewer there is more to do above, with more
/// each change reduces more.
pub const LEAF: usize = 100;

pub(super) type TileId = u32;

pub(super) const NONE: u32 = u32::MAX;
pub(super) const ROOT: TileId = 0;

/// Only every so many levels are reduced: a tile between them hands on what its halves leave.
pub(super) const STRIDE: u32 = 2;

/// The tree of tiles over a cloud.
#[derive(Clone, Debug)]
pub struct Tiles {
    pub(super) capacity: usize,
    pub(super) tiles: Vec<Tile>,
    pub(super) free: Vec<TileId>,
    /// Of each slot: where its star is.
    pub(super) whereabouts: Vec<Whereabouts>,
    pub(super) round: u32,
    pub(super) reduced: usize,
    /// What tiles that are no more had resolved.
    pub(super) retired: Vec<Resolved>,
    /// Tools, one set for each piece of work that is done at once.
    pub(super) workers: Vec<Worker>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Whereabouts {
    /// The leaf.
    pub(super) home: TileId,
    /// The round in which it was last read anew.
    pub(super) read_in: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) parent: TileId,
    pub(super) depth: u32,
    /// Number of vertices.
    pub(super) count: usize,
    pub(super) body: Body,
    pub(super) resolved: Resolved,
    pub(super) border: Border,
    /// The largest death that it has resolved itself.
    pub(super) own_death: f64,
    /// The largest death in it and below.
    pub(super) last_death: f64,
    /// Half the length of the longest tree edge in it and below, squared.
    pub(super) longest: f64,
    /// The round in which it was last put on the list of tiles to be looked at.
    pub(super) listed_in: u32,
    /// Whether it has to be reduced.
    pub(super) is_stale: bool,
}

#[derive(Clone, Debug)]
pub(super) enum Body {
    Leaf {
        stars: Stars,
        /// Vertices that have come and have no star yet.
        arrivals: Vec<Located<Slot>>,
    },
    Halves {
        split: Split,
        halves: [TileId; 2],
    },
    Free,
}

impl Tile {
    /// Whether it is not reduced itself, but hands on what its halves leave.
    pub(super) fn hands_on(&self) -> bool {
        !self.depth.is_multiple_of(STRIDE) && matches!(self.body, Body::Halves { .. })
    }
}

impl Tiles {
    /// The largest death of all dots; 0 without dots.
    pub fn largest_death(&self) -> f64 {
        self.tiles[ROOT as usize].last_death
    }

    /// All edges of the minimum spanning tree, in no order.
    pub fn tree(&self) -> impl Iterator<Item = &TreeEdge> {
        self.tiles.iter().flat_map(|tile| &tile.resolved.tree)
    }

    /// All dots, in no order.
    pub fn dots(&self) -> impl Iterator<Item = &TileDot> {
        self.tiles.iter().flat_map(|tile| &tile.resolved.dots)
    }

    /// Edges of the tree that are longer than one scale and not longer than another, in no order; `is_up_to_*` tells by the squared scale.
    pub fn tree_between(
        &self,
        is_up_to_low: impl Fn(f64) -> bool,
        is_up_to_high: impl Fn(f64) -> bool,
    ) -> Vec<TreeEdge> {
        let mut between = Vec::new();
        let mut todo = vec![ROOT];
        while let Some(id) = todo.pop() {
            let tile = &self.tiles[id as usize];
            if is_up_to_low(tile.longest) {
                continue;
            }
            let tree = &tile.resolved.tree;
            let from = tree.partition_point(|edge| !is_up_to_high(edge.scale));
            let to = tree.partition_point(|edge| !is_up_to_low(edge.scale));
            between.extend_from_slice(&tree[from.min(to)..to]);
            if let Body::Halves { halves, .. } = tile.body {
                todo.extend(halves);
            }
        }
        between
    }

    /// How many tiles were reduced last.
    pub fn reduced(&self) -> usize {
        self.reduced
    }

    pub(super) fn make_room(&mut self, cloud: &Cloud) {
        self.whereabouts.resize(cloud.slot_count(), Whereabouts { home: NONE, read_in: 0 });
    }

    pub(super) fn begin_round(&mut self) {
        self.round = self.round.checked_add(1).unwrap_or_else(|| {
            // Once in 2^32 rounds all marks are wiped.
            self.whereabouts.iter_mut().for_each(|star| star.read_in = 0);
            self.tiles.iter_mut().for_each(|tile| tile.listed_in = 0);
            1
        });
    }

    /// Puts a tile on a list, once a round.
    pub(super) fn list(&mut self, tile: TileId, list: &mut Vec<TileId>) {
        let listed_in = &mut self.tiles[tile as usize].listed_in;
        if *listed_in != self.round {
            *listed_in = self.round;
            list.push(tile);
        }
    }

    /// Lists the leaves of some vertices whose stars have to be read again.
    pub(super) fn list_homes(&mut self, slots: impl Iterator<Item = Slot>, list: &mut Vec<TileId>) {
        for slot in slots {
            let Whereabouts { home, read_in } = &mut self.whereabouts[slot as usize];
            if *home != NONE && *read_in != self.round {
                *read_in = self.round;
                let home = *home;
                self.list(home, list);
            }
        }
    }
}
