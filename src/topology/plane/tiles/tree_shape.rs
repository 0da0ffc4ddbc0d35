//! The shape of the tree of tiles: where vertices live, how leaves split and merge, and how the tree stays in balance.
//!
//! In: counts of vertices. Out: leaves and tiles that have to be reduced again. A tile is halved at the median of its vertices along its longer side,
//! by a total order (one coordinate, then the other), so any cloud can be halved: collinear, clustered or far-flung. A leaf that has outgrown
//! its capacity is halved; halves that have emptied become a leaf; a tile most of whose vertices are in one half is built
//! anew from its vertices, which pays for itself since it takes as many changes to get there. Invariants: every vertex
//! has one leaf; tile 0 is the root; parents know their halves and halves their parent. Must not know: reductions, the triangulation.

use super::split::{Axis, Split};
use super::star::Stars;
use super::tree::{Body, NONE, ROOT, Tile, TileId, Tiles};
use crate::topology::cloud::{Position, Slot};

impl Tiles {
    pub(super) fn new_leaf(&mut self, parent: TileId, depth: u32) -> TileId {
        let tile = Tile {
            parent,
            depth,
            count: 0,
            body: Body::Leaf { stars: Stars::default(), arrivals: Vec::new() },
            resolved: Default::default(),
            border: Default::default(),
            own_death: 0.0,
            last_death: 0.0,
            longest: 0.0,
            listed_in: 0,
            is_stale: true,
        };
        match self.free.pop() {
            Some(id) => {
                self.tiles[id as usize] = tile;
                id
            }
            None => {
                self.tiles.push(tile);
                (self.tiles.len() - 1) as TileId
            }
        }
    }

    /// The leaf that a position is in.
    pub(super) fn leaf_of(&self, position: Position) -> TileId {
        let mut id = ROOT;
        while let Body::Halves { split, halves } = &self.tiles[id as usize].body {
            id = halves[split.half(position)];
        }
        id
    }

    /// A vertex of a leaf near a position, if it has any.
    pub(super) fn near(&self, leaf: TileId, position: Position) -> Option<Slot> {
        match &self.tiles[leaf as usize].body {
            Body::Leaf { stars, .. } => stars.near(position),
            Body::Halves { .. } | Body::Free => None,
        }
    }

    /// Puts a vertex that has come into the leaf that its position is in.
    pub(super) fn welcome(&mut self, id: TileId, position: Position, slot: Slot) {
        if let Body::Leaf { arrivals, .. } = &mut self.tiles[id as usize].body {
            arrivals.push((position, slot));
        }
        self.whereabouts[slot as usize].home = id;
    }

    /// Builds a tile, a leaf so far, from its vertices, which have no stars yet. Gives its leaves.
    pub(super) fn grow(&mut self, tile: TileId, sites: &mut [(Position, Slot)]) -> Vec<TileId> {
        let mut leaves = Vec::new();
        let mut todo = vec![(tile, sites)];
        while let Some((id, sites)) = todo.pop() {
            self.tiles[id as usize].count = sites.len();
            if sites.len() <= self.capacity {
                sites.iter().for_each(|&(_, slot)| self.whereabouts[slot as usize].home = id);
                self.tiles[id as usize].body = Body::Leaf { stars: Stars::default(), arrivals: sites.to_vec() };
                leaves.push(id);
                continue;
            }
            let axis = Axis::longest(sites.iter().map(|site| site.0));
            let middle = sites.len() / 2;
            let by_key = |a: &(Position, Slot), b: &(Position, Slot)| {
                axis.key(a.0).partial_cmp(&axis.key(b.0)).expect("coordinates are numbers")
            };
            let (_, &mut (first, _), _) = sites.select_nth_unstable_by(middle, by_key);
            let halves = self.halve(id, Split { axis, at: axis.key(first) });
            let (first, second) = sites.split_at_mut(middle);
            // The first half goes on the pile last, so it is next: tiles near in the plane are near in memory.
            todo.extend([(halves[1], second), (halves[0], first)]);
        }
        leaves
    }

    /// Gives a tile two halves, empty leaves so far.
    fn halve(&mut self, id: TileId, split: Split) -> [TileId; 2] {
        let depth = self.tiles[id as usize].depth + 1;
        let halves = [(); 2].map(|()| self.new_leaf(id, depth));
        self.tiles[id as usize].body = Body::Halves { split, halves };
        self.note_new_shape(id);
        halves
    }

    /// Sees to it that a tile with a new shape is reduced, or forgets its reduction if it is one that hands on.
    fn note_new_shape(&mut self, id: TileId) {
        let tile = &mut self.tiles[id as usize];
        tile.is_stale = !tile.hands_on();
        if tile.hands_on() {
            self.retired.push(std::mem::take(&mut tile.resolved));
            tile.border = Default::default();
            tile.own_death = 0.0;
        }
        // What is above has to be told in any case: a leaf may leave as little as a tile that hands on, which is nothing.
        self.mark_above(id);
    }

    /// Says that what a tile leaves has changed.
    pub(super) fn mark_above(&mut self, id: TileId) {
        let mut above = self.tiles[id as usize].parent;
        while above != NONE && self.tiles[above as usize].hands_on() {
            above = self.tiles[above as usize].parent;
        }
        if above != NONE {
            self.tiles[above as usize].is_stale = true;
        }
    }

    /// Splits leaves that have outgrown their capacity, merges those that have emptied, rebuilds what is out of balance. Counts are right then.
    /// Leaves that come of it go on the list, and those that are none any more off it. Gives leaves whose stars have to be read.
    pub(super) fn reshape(&mut self, leaves: &mut Vec<TileId>) -> Vec<TileId> {
        let mut rebuilt = Vec::new();
        for place in 0..leaves.len() {
            self.split_leaf(leaves[place], leaves);
        }
        let mut lopsided = Vec::new();
        let levels = self.levels_above(leaves);
        for id in levels.into_iter().rev().flatten() {
            let Body::Halves { halves, .. } = self.tiles[id as usize].body else { continue };
            let counts = halves.map(|half| self.tiles[half as usize].count);
            let count = counts[0] + counts[1];
            self.tiles[id as usize].count = count;
            if count <= self.capacity / 2 {
                self.merge(id, halves);
                leaves.push(id);
            } else if 4 * counts[0].max(counts[1]) > 3 * count + 2 * self.capacity {
                lopsided.push(id);
            }
        }
        for &id in lopsided.iter().filter(|&&id| !self.is_below(id, &lopsided)).collect::<Vec<_>>() {
            let mut sites = self.uproot(id);
            rebuilt.extend(self.grow(id, &mut sites));
        }
        leaves.retain(|&id| matches!(self.tiles[id as usize].body, Body::Leaf { .. }));
        rebuilt
    }

    /// Whether some tile is above another one.
    fn is_below(&self, id: TileId, tiles: &[TileId]) -> bool {
        let above = std::iter::successors(Some(self.tiles[id as usize].parent), |&id| {
            (id != NONE).then(|| self.tiles[id as usize].parent)
        });
        above.take_while(|&id| id != NONE).any(|id| tiles.contains(&id))
    }

    fn split_leaf(&mut self, leaf: TileId, leaves: &mut Vec<TileId>) {
        let mut todo = vec![leaf];
        while let Some(id) = todo.pop() {
            let Body::Leaf { stars, .. } = &mut self.tiles[id as usize].body else { continue };
            if 2 * stars.len() <= 3 * self.capacity {
                continue;
            }
            let stars = std::mem::take(stars);
            let axis = Axis::longest(stars.vertices().map(|(position, _)| position));
            let mut keys: Vec<[f64; 2]> = stars.vertices().map(|(position, _)| axis.key(position)).collect();
            let middle = keys.len() / 2;
            let by_key = |a: &[f64; 2], b: &[f64; 2]| a.partial_cmp(b).expect("coordinates are numbers");
            let (_, &mut at, _) = keys.select_nth_unstable_by(middle, by_key);
            let split = Split { axis, at };
            let mut parts = [Stars::default(), Stars::default()];
            stars.iter().for_each(|star| parts[split.half(star.center.position)].push(star));
            let halves = self.halve(id, split);
            for (half, stars) in halves.into_iter().zip(parts) {
                stars.vertices().for_each(|(_, slot)| self.whereabouts[slot as usize].home = half);
                let tile = &mut self.tiles[half as usize];
                tile.count = stars.len();
                tile.body = Body::Leaf { stars, arrivals: Vec::new() };
            }
            todo.extend(halves);
            leaves.extend(halves);
        }
    }

    /// Makes a leaf of a tile with two small halves.
    fn merge(&mut self, id: TileId, halves: [TileId; 2]) {
        let mut all = Stars::default();
        let [first, second] = halves.map(|half| match self.release(half) {
            Body::Leaf { stars, .. } => stars,
            Body::Halves { .. } | Body::Free => unreachable!("a half of a small tile is smaller, so a leaf by now"),
        });
        let (mut first, mut second) = (first.iter().peekable(), second.iter().peekable());
        loop {
            let next = match (first.peek(), second.peek()) {
                (Some(a), Some(b)) if a.center.position < b.center.position => first.next(),
                (Some(_), None) => first.next(),
                _ => second.next(),
            };
            let Some(star) = next else { break };
            self.whereabouts[star.center.slot as usize].home = id;
            all.push(star);
        }
        self.tiles[id as usize].body = Body::Leaf { stars: all, arrivals: Vec::new() };
        self.note_new_shape(id);
    }

    /// Takes a tile out of the tree. What it had resolved is retired.
    fn release(&mut self, id: TileId) -> Body {
        let tile = &mut self.tiles[id as usize];
        self.retired.push(std::mem::take(&mut tile.resolved));
        tile.border = Default::default();
        self.free.push(id);
        std::mem::replace(&mut tile.body, Body::Free)
    }

    /// Takes everything below a tile away, and gives its vertices.
    fn uproot(&mut self, id: TileId) -> Vec<(Position, Slot)> {
        let mut sites = Vec::with_capacity(self.tiles[id as usize].count);
        let Body::Halves { halves, .. } = self.tiles[id as usize].body else { return sites };
        let mut todo = halves.to_vec();
        while let Some(id) = todo.pop() {
            match self.release(id) {
                Body::Leaf { stars, .. } => sites.extend(stars.vertices()),
                Body::Halves { halves, .. } => todo.extend(halves),
                Body::Free => {}
            }
        }
        sites
    }

    /// Some leaves and all tiles above them, by depth.
    pub(super) fn levels_above(&mut self, leaves: &[TileId]) -> Vec<Vec<TileId>> {
        self.begin_round();
        let mut levels: Vec<Vec<TileId>> = Vec::new();
        for &leaf in leaves {
            let mut id = leaf;
            while id != NONE {
                let tile = &mut self.tiles[id as usize];
                if std::mem::replace(&mut tile.listed_in, self.round) == self.round {
                    break;
                }
                let depth = tile.depth as usize;
                if levels.len() <= depth {
                    levels.resize_with(depth + 1, Vec::new);
                }
                levels[depth].push(id);
                id = tile.parent;
            }
        }
        levels
    }

    /// Levels below the root.
    pub fn depth(&self) -> usize {
        let used = self.tiles.iter().filter(|tile| !matches!(tile.body, Body::Free));
        used.map(|tile| tile.depth as usize).max().unwrap_or(0)
    }

    /// Panics when the tree contradicts itself. For tests.
    pub fn check_shape(&self) {
        let mut leaves = 0;
        for (id, tile) in self.tiles.iter().enumerate().filter(|(_, tile)| !matches!(tile.body, Body::Free)) {
            match &tile.body {
                Body::Halves { halves, .. } => {
                    let count: usize = halves.iter().map(|&half| self.tiles[half as usize].count).sum();
                    assert_eq!(tile.count, count);
                    assert!(halves.iter().all(|&half| self.tiles[half as usize].parent == id as TileId));
                }
                Body::Leaf { stars, arrivals } => {
                    assert!(arrivals.is_empty() && tile.count == stars.len());
                    assert!(stars.vertices().all(|(_, slot)| self.whereabouts[slot as usize].home == id as TileId));
                    leaves += stars.len();
                }
                Body::Free => {}
            }
            assert!(!tile.is_stale);
        }
        assert_eq!(leaves, self.tiles[ROOT as usize].count);
    }
}
