//! The tree of tiles: what each tile stores, and queries over all tiles.
//!
//! In: slots of a cloud.
//! Out: tree edges and dots of the whole cloud, and lists of tiles to work on.
//! Invariants: each tile lists what it resolved in the total order. The extremes of a tile cover all tiles below it.
//! Must not know: how tiles are reduced, how leaves split.

use super::border::Border;
use super::resolved::Resolved;
use super::split::Split;
use super::star::Stars;
use super::worker::Worker;
use crate::topology::cloud::{Cloud, Located, Slot};
use crate::topology::plane::elements::{TileDot, TreeEdge};

/// The largest number of vertices in a new leaf. Measured: from 60 to 200 there is little difference. Smaller leaves
/// mean more tiles above, larger ones more work in each change.
pub const LEAF: usize = 100;

pub(super) type TileId = u32;

pub(super) const NONE: u32 = u32::MAX;
pub(super) const ROOT: TileId = 0;

/// Only every second level is reduced. A tile between two such levels passes on what its halves leave.
pub(super) const STRIDE: u32 = 2;

/// The tree of tiles over a cloud.
#[derive(Clone, Debug)]
pub struct Tiles {
    pub(super) capacity: usize,
    pub(super) tiles: Vec<Tile>,
    pub(super) free: Vec<TileId>,
    /// The place of each slot's star.
    pub(super) star_places: Vec<StarPlace>,
    pub(super) round: u32,
    pub(super) reduced: usize,
    /// What removed tiles had resolved.
    pub(super) retired: Vec<Resolved>,
    /// One for each piece of work that runs in parallel.
    pub(super) workers: Vec<Worker>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct StarPlace {
    /// Its leaf.
    pub(super) leaf_id: TileId,
    /// The round in which it was last read.
    pub(super) read_in: u32,
}

#[derive(Clone, Debug)]
pub(super) struct Tile {
    pub(super) parent: TileId,
    pub(super) depth: u32,
    /// The number of vertices.
    pub(super) count: usize,
    pub(super) body: Body,
    pub(super) resolved: Resolved,
    pub(super) border: Border,
    /// The largest death that it resolved itself.
    pub(super) own_death: f64,
    /// The largest death in it and below.
    pub(super) last_death: f64,
    /// Half the length of the longest tree edge in it and below, squared.
    pub(super) longest: f64,
    /// The round in which it was last put on a list of tiles.
    pub(super) listed_in: u32,
    /// Whether it has to be reduced.
    pub(super) is_stale: bool,
}

#[derive(Clone, Debug)]
pub(super) enum Body {
    Leaf {
        stars: Stars,
        /// New vertices without stars.
        arrivals: Vec<Located<Slot>>,
    },
    Halves {
        split: Split,
        halves: [TileId; 2],
    },
    Free,
}

impl Tile {
    /// Whether it is not reduced itself, but passes on what its halves leave.
    pub(super) fn is_pass_through(&self) -> bool {
        !self.depth.is_multiple_of(STRIDE) && matches!(self.body, Body::Halves { .. })
    }
}

impl Tiles {
    /// The largest death; 0 without dots.
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

    /// The tree edges longer than one scale and not longer than another, in no order. `is_up_to_low` and
    /// `is_up_to_high` compare a squared scale with them.
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

    /// The number of tiles reduced in the last change.
    pub fn reduced(&self) -> usize {
        self.reduced
    }

    pub(super) fn make_room(&mut self, cloud: &Cloud) {
        self.star_places.resize(cloud.slot_count(), StarPlace { leaf_id: NONE, read_in: 0 });
    }

    pub(super) fn begin_round(&mut self) {
        self.round = self.round.checked_add(1).unwrap_or_else(|| {
            // Every 2^32 rounds all marks are reset.
            self.star_places.iter_mut().for_each(|star| star.read_in = 0);
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

    /// Lists the leaves of vertices whose stars have to be read.
    pub(super) fn list_leaves_of(&mut self, slots: impl Iterator<Item = Slot>, list: &mut Vec<TileId>) {
        for slot in slots {
            let StarPlace { leaf_id, read_in } = &mut self.star_places[slot as usize];
            if *leaf_id != NONE && *read_in != self.round {
                *read_in = self.round;
                let leaf_id = *leaf_id;
                self.list(leaf_id, list);
            }
        }
    }
}
