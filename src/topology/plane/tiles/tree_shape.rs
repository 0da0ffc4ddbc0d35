//! The shape of the tree of tiles: where vertices are stored, how leaves split and merge, how the tree is balanced.
//!
//! In: vertices and their numbers.
//! Out: leaves and tiles that have to be reduced again.
//! Invariants: every vertex is in one leaf. Tile 0 is the root. Parents and halves refer to each other.
//! Must not know: reductions, the triangulation.
//!
//! A tile is halved at the median of its vertices along its longer side, in a total order (one coordinate, then the
//! other). So any cloud can be halved: collinear, clustered or far-flung. A leaf that exceeds its capacity is halved.
//! Two small halves become one leaf. A tile with most of its vertices in one half is rebuilt from its vertices; it
//! takes as many changes to get there, so this pays off.

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

    /// The leaf of a position.
    pub(super) fn leaf_of(&self, position: Position) -> TileId {
        let mut id = ROOT;
        while let Body::Halves { split, halves } = &self.tiles[id as usize].body {
            id = halves[split.half(position)];
        }
        id
    }

    /// A vertex of a leaf near a position; none in an empty leaf.
    pub(super) fn near(&self, leaf: TileId, position: Position) -> Option<Slot> {
        match &self.tiles[leaf as usize].body {
            Body::Leaf { stars, .. } => stars.near(position),
            Body::Halves { .. } | Body::Free => None,
        }
    }

    /// Adds a new vertex to a leaf.
    pub(super) fn add_arrival(&mut self, id: TileId, position: Position, slot: Slot) {
        if let Body::Leaf { arrivals, .. } = &mut self.tiles[id as usize].body {
            arrivals.push((position, slot));
        }
        self.star_places[slot as usize].leaf_id = id;
    }

    /// Builds a tile, which is a leaf so far, from vertices without stars. Returns the new leaves.
    pub(super) fn build(&mut self, tile: TileId, sites: &mut [(Position, Slot)]) -> Vec<TileId> {
        let mut leaves = Vec::new();
        let mut todo = vec![(tile, sites)];
        while let Some((id, sites)) = todo.pop() {
            self.tiles[id as usize].count = sites.len();
            if sites.len() <= self.capacity {
                sites.iter().for_each(|&(_, slot)| self.star_places[slot as usize].leaf_id = id);
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
            // The first half is pushed last, so it is next: tiles near in the plane are near in memory.
            todo.extend([(halves[1], second), (halves[0], first)]);
        }
        leaves
    }

    /// Gives a tile two halves, which are empty leaves.
    fn halve(&mut self, id: TileId, split: Split) -> [TileId; 2] {
        let depth = self.tiles[id as usize].depth + 1;
        let halves = [(); 2].map(|()| self.new_leaf(id, depth));
        self.tiles[id as usize].body = Body::Halves { split, halves };
        self.note_new_shape(id);
        halves
    }

    /// Marks a tile of a new shape as stale, or drops its results if it is not reduced any more.
    fn note_new_shape(&mut self, id: TileId) {
        let tile = &mut self.tiles[id as usize];
        tile.is_stale = !tile.is_pass_through();
        if tile.is_pass_through() {
            self.retired.push(std::mem::take(&mut tile.resolved));
            tile.border = Default::default();
            tile.own_death = 0.0;
        }
        // The tile above is always stale: a new leaf may leave as little as a tile that is not reduced, which is
        // nothing.
        self.mark_above(id);
    }

    /// Marks the next reduced tile above as stale, because what this one leaves has changed.
    pub(super) fn mark_above(&mut self, id: TileId) {
        let mut above = self.tiles[id as usize].parent;
        while above != NONE && self.tiles[above as usize].is_pass_through() {
            above = self.tiles[above as usize].parent;
        }
        if above != NONE {
            self.tiles[above as usize].is_stale = true;
        }
    }

    /// Splits large leaves, merges small ones and rebuilds unbalanced tiles; updates counts. `leaves` is updated to the
    /// leaves that have to be reduced. Returns the leaves whose stars have to be read.
    pub(super) fn reshape(&mut self, leaves: &mut Vec<TileId>) -> Vec<TileId> {
        let mut rebuilt = Vec::new();
        for place in 0..leaves.len() {
            self.split_leaf(leaves[place], leaves);
        }
        let mut unbalanced = Vec::new();
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
                unbalanced.push(id);
            }
        }
        for &id in unbalanced.iter().filter(|&&id| !self.is_below(id, &unbalanced)).collect::<Vec<_>>() {
            let mut sites = self.take_vertices_below(id);
            rebuilt.extend(self.build(id, &mut sites));
        }
        leaves.retain(|&id| matches!(self.tiles[id as usize].body, Body::Leaf { .. }));
        rebuilt
    }

    /// Whether a tile is below one of some tiles.
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
                stars.vertices().for_each(|(_, slot)| self.star_places[slot as usize].leaf_id = half);
                let tile = &mut self.tiles[half as usize];
                tile.count = stars.len();
                tile.body = Body::Leaf { stars, arrivals: Vec::new() };
            }
            todo.extend(halves);
            leaves.extend(halves);
        }
    }

    /// Turns a tile with two small halves into a leaf.
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
            self.star_places[star.center.slot as usize].leaf_id = id;
            all.push(star);
        }
        self.tiles[id as usize].body = Body::Leaf { stars: all, arrivals: Vec::new() };
        self.note_new_shape(id);
    }

    /// Removes a tile from the tree; what it resolved is retired.
    fn release(&mut self, id: TileId) -> Body {
        let tile = &mut self.tiles[id as usize];
        self.retired.push(std::mem::take(&mut tile.resolved));
        tile.border = Default::default();
        self.free.push(id);
        std::mem::replace(&mut tile.body, Body::Free)
    }

    /// Removes all tiles below a tile, and returns their vertices.
    fn take_vertices_below(&mut self, id: TileId) -> Vec<(Position, Slot)> {
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

    /// The number of levels below the root.
    pub fn depth(&self) -> usize {
        let used = self.tiles.iter().filter(|tile| !matches!(tile.body, Body::Free));
        used.map(|tile| tile.depth as usize).max().unwrap_or(0)
    }

    /// Panics when the tree is inconsistent. For tests.
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
                    assert!(stars.vertices().all(|(_, slot)| self.star_places[slot as usize].leaf_id == id as TileId));
                    leaves += stars.len();
                }
                Body::Free => {}
            }
            assert!(!tile.is_stale);
        }
        assert_eq!(leaves, self.tiles[ROOT as usize].count);
    }
}
