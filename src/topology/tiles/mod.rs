//! The tree of tiles: the reduction of a cloud, kept so that a change costs what it touches.
//!
//! In: a [`Cloud`], its [`Delaunay`] triangulation, and what changed in both. Out: a [`Difference`] of the minimum spanning tree and of the dots.
//! The plane is cut into tiles, a binary k-d tree over the vertices: each leaf has about as many, and holds their [`Stars`]. Each leaf and each tile of
//! every second level is reduced, by a [`Workshop`]; it keeps what it resolved and what it leaves to the one above. A change reads the stars it has touched anew,
//! reduces their leaves, and climbs as far as borders change.
//!
//! ```text
//!  change ──▶ dirty vertices ──▶ stars ──▶ leaves ──▶ tiles above, deepest first ──▶ root
//!             (watcher)          (read)    (split, merged,    │ stops where a border
//!                                           rebuilt)          ▼ stays as it was
//!                                                      resolved, old and new ──▶ difference
//! ```
//!
//! Invariants: the skeleton found is that of one pass over everything, bit for bit, whatever the tiles and whatever the number of threads;
//! no tile is deeper than a few times the logarithm of the number of vertices, wherever they lie. Must not know: ids, views.

mod difference;
mod dirt;
mod effort;
mod growth;
mod star;
mod workshop;

use rayon::prelude::*;

pub use self::difference::Difference;
pub use self::dirt::{Dirt, Guide};
use self::growth::Split;
use self::star::{Reader, Stars};
use self::workshop::{Border, Order, Resolved, Workshop};
pub use self::workshop::{TileDot, TreeEdge};
use super::cloud::{Cloud, CloudChange, Slot};
use super::cocircular::Located;
use super::delaunay::Delaunay;
use super::position::Position;

/// How many vertices a leaf has at most when it is made. Measured: from 60 to 200 make little difference; with fewer there is more to do above, with more
/// each change reduces more.
pub const LEAF: usize = 100;

type TileId = u32;

const NONE: u32 = u32::MAX;
const ROOT: TileId = 0;

/// Only every so many levels are reduced: a tile between them hands on what its halves leave.
const STRIDE: u32 = 2;

/// Fewer tiles than this are not worth being handed to other threads.
const FEW: usize = 64;

/// So many tiles are handed over together, at least.
const PIECE: usize = 16;

/// The tree of tiles over a cloud.
#[derive(Clone, Debug)]
pub struct Tiles {
    capacity: usize,
    tiles: Vec<Tile>,
    free: Vec<TileId>,
    /// Of each slot: where its star is.
    whereabouts: Vec<Whereabouts>,
    round: u32,
    reduced: usize,
    /// What tiles that are no more had resolved.
    retired: Vec<Resolved>,
    /// Tools, one set for each piece of work that is done at once.
    workers: Vec<Worker>,
}

#[derive(Clone, Copy, Debug)]
struct Whereabouts {
    /// The leaf.
    home: TileId,
    /// The round in which it was last read anew.
    read_in: u32,
}

/// What becomes of a star in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Stays,
    IsRead,
    Goes,
}

/// Tools to work on tiles with, and what came of it.
#[derive(Clone, Debug, Default)]
struct Worker {
    reader: Reader,
    /// Vertices whose stars are read.
    to_read: Vec<Located<Slot>>,
    /// Of each star that a leaf has: what becomes of it.
    fates: Vec<Fate>,
    stars: Stars,
    workshop: Workshop,
    difference: Difference,
}

#[derive(Clone, Debug)]
struct Tile {
    parent: TileId,
    depth: u32,
    /// Number of vertices.
    count: usize,
    body: Body,
    resolved: Resolved,
    border: Border,
    /// The largest death that it has resolved itself.
    own_death: f64,
    /// The largest death in it and below.
    last_death: f64,
    /// Half the length of the longest tree edge in it and below, squared.
    longest: f64,
    /// The round in which it was last put on the list of tiles to be looked at.
    listed_in: u32,
    /// Whether it has to be reduced.
    is_stale: bool,
}

#[derive(Clone, Debug)]
enum Body {
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
    fn hands_on(&self) -> bool {
        !self.depth.is_multiple_of(STRIDE) && matches!(self.body, Body::Halves { .. })
    }
}

/// A leaf whose stars are to be read.
struct Reading {
    tile: TileId,
    stars: Stars,
    arrivals: Vec<Located<Slot>>,
}

/// A tile that is to be reduced.
struct Reducing {
    tile: TileId,
    resolved: Resolved,
    border: Border,
    /// The largest death that it resolves.
    own_death: f64,
    /// Whether its border is not what it was.
    is_changed: bool,
}

impl Tiles {
    /// The tree over all vertices of a cloud; leaves of at most so many vertices.
    pub fn new(cloud: &Cloud, delaunay: &Delaunay, capacity: usize) -> Self {
        let mut tiles = Self {
            capacity,
            tiles: Vec::new(),
            free: Vec::new(),
            whereabouts: Vec::new(),
            round: 1,
            reduced: 0,
            retired: Vec::new(),
            workers: vec![Worker::default()],
        };
        tiles.make_room(cloud);
        let root = tiles.new_leaf(NONE, 0);
        let mut sites: Vec<(Position, Slot)> = cloud.vertices().map(|(slot, v)| (v.position, slot)).collect();
        let leaves = tiles.grow(root, &mut sites);
        tiles.read_stars(cloud, delaunay, &leaves);
        tiles.reduce_above(cloud, &leaves);
        tiles
    }

    /// Follows a change that the triangulation has followed step by step.
    pub fn follow(&mut self, cloud: &Cloud, delaunay: &Delaunay, change: &CloudChange, dirt: &Dirt) -> Difference {
        self.begin_round();
        self.make_room(cloud);
        let mut leaves = Vec::new();
        for &slot in &change.vanished {
            let home = std::mem::replace(&mut self.whereabouts[slot as usize].home, NONE);
            self.list(home, &mut leaves);
        }
        for &(slot, home) in &dirt.homes {
            self.welcome(home, cloud.position(slot), slot);
            self.list(home, &mut leaves);
        }
        for &slot in &change.appeared {
            // Not all were searched for: on a line, or where others have gone.
            if self.whereabouts[slot as usize].home == NONE {
                let home = self.leaf_of(cloud.position(slot));
                self.welcome(home, cloud.position(slot), slot);
                self.list(home, &mut leaves);
            }
        }
        self.list_homes(dirt.slots(), &mut leaves);
        let mut concerned = self.read_stars(cloud, delaunay, &leaves);
        concerned.retain(|&slot| self.whereabouts[slot as usize].read_in != self.round);
        self.begin_round();
        let mut again = Vec::new();
        self.list_homes(concerned.into_iter(), &mut again);
        self.read_stars(cloud, delaunay, &again);
        leaves.extend(again);
        let rebuilt = self.reshape(&mut leaves);
        self.begin_round();
        self.read_stars(cloud, delaunay, &rebuilt);
        leaves.extend(rebuilt);
        let mut difference = self.reduce_above(cloud, &leaves);
        for retired in self.retired.drain(..) {
            difference.compare(&Order { cloud }, &retired, &Resolved::default());
        }
        difference.cancel();
        difference
    }

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

    fn make_room(&mut self, cloud: &Cloud) {
        self.whereabouts.resize(cloud.slot_count(), Whereabouts { home: NONE, read_in: 0 });
    }

    fn begin_round(&mut self) {
        self.round = self.round.checked_add(1).unwrap_or_else(|| {
            // Once in 2^32 rounds all marks are wiped.
            self.whereabouts.iter_mut().for_each(|star| star.read_in = 0);
            self.tiles.iter_mut().for_each(|tile| tile.listed_in = 0);
            1
        });
    }

    /// Puts a tile on a list, once a round.
    fn list(&mut self, tile: TileId, list: &mut Vec<TileId>) {
        let listed_in = &mut self.tiles[tile as usize].listed_in;
        if *listed_in != self.round {
            *listed_in = self.round;
            list.push(tile);
        }
    }

    /// Lists the leaves of some vertices whose stars have to be read again.
    fn list_homes(&mut self, slots: impl Iterator<Item = Slot>, list: &mut Vec<TileId>) {
        for slot in slots {
            let Whereabouts { home, read_in } = &mut self.whereabouts[slot as usize];
            if *home != NONE && *read_in != self.round {
                *read_in = self.round;
                let home = *home;
                self.list(home, list);
            }
        }
    }

    /// Brings the stars of some leaves up to date. Gives vertices of other leaves that this concerns.
    fn read_stars(&mut self, cloud: &Cloud, delaunay: &Delaunay, leaves: &[TileId]) -> Vec<Slot> {
        let mut readings: Vec<Reading> = leaves.iter().map(|&leaf| self.begin_reading(leaf)).collect();
        let mut workers = std::mem::take(&mut self.workers);
        in_parallel(&mut workers, &mut readings, |worker, reading| self.read_leaf(delaunay, reading, worker));
        for Reading { tile, stars, arrivals } in readings {
            debug_assert!(stars.vertices().all(|(position, slot)| cloud.position(slot) == position));
            let tile = &mut self.tiles[tile as usize];
            tile.count = stars.len();
            tile.is_stale = true;
            tile.body = Body::Leaf { stars, arrivals };
        }
        let concerned = workers.iter_mut().flat_map(|worker| worker.reader.concerned.drain(..)).collect();
        self.workers = workers;
        concerned
    }

    fn begin_reading(&mut self, leaf: TileId) -> Reading {
        match std::mem::replace(&mut self.tiles[leaf as usize].body, Body::Free) {
            Body::Leaf { stars, arrivals } => Reading { tile: leaf, stars, arrivals },
            Body::Halves { .. } | Body::Free => unreachable!("only leaves have stars"),
        }
    }

    fn read_leaf(&self, delaunay: &Delaunay, reading: &mut Reading, worker: &mut Worker) {
        let Reading { tile, stars: old, arrivals } = reading;
        let Worker { reader, to_read, fates, stars, .. } = worker;
        arrivals.sort_unstable();
        let mut coming = arrivals.drain(..).peekable();
        to_read.clear();
        fates.clear();
        for vertex in old.vertices() {
            to_read.extend(std::iter::from_fn(|| coming.next_if(|arrival| arrival < &vertex)));
            let fate = self.fate(vertex.1, *tile);
            fates.push(fate);
            if fate == Fate::IsRead {
                to_read.push(vertex);
            }
        }
        to_read.extend(coming);
        reader.look_around(delaunay, to_read);
        let mut reads = to_read.iter().copied().enumerate().peekable();
        stars.clear();
        for (star, &fate) in old.iter().zip(&*fates) {
            if fate == Fate::Stays {
                while let Some((place, vertex)) = reads.next_if(|read| read.1.0 < star.center.position) {
                    reader.read(delaunay, place, vertex, stars);
                }
                stars.push(star);
            }
        }
        reads.for_each(|(place, vertex)| reader.read(delaunay, place, vertex, stars));
        old.copy_from(stars);
    }

    /// What becomes of the star of a vertex in a leaf.
    fn fate(&self, slot: Slot, leaf: TileId) -> Fate {
        let Whereabouts { home, read_in } = self.whereabouts[slot as usize];
        if home != leaf {
            Fate::Goes
        } else if read_in == self.round {
            Fate::IsRead
        } else {
            Fate::Stays
        }
    }

    /// Reduces leaves and what is above them, deepest first.
    fn reduce_above(&mut self, cloud: &Cloud, leaves: &[TileId]) -> Difference {
        let mut reduced = 0;
        let mut levels = self.levels_above(leaves);
        let mut workers = std::mem::take(&mut self.workers);
        while let Some(level) = levels.pop() {
            let mut jobs: Vec<Reducing> = level.iter().filter_map(|&tile| self.begin_reducing(tile)).collect();
            reduced += jobs.len();
            in_parallel(&mut workers, &mut jobs, |worker, job| self.reduce(cloud, job, worker));
            jobs.into_iter().for_each(|job| self.install(job));
            level.into_iter().for_each(|tile| self.note_extremes(tile));
        }
        self.reduced = reduced;
        let mut total = Difference::default();
        workers.iter_mut().for_each(|worker| total.take(&mut worker.difference));
        self.workers = workers;
        total
    }

    fn begin_reducing(&mut self, tile: TileId) -> Option<Reducing> {
        let Tile { resolved, border, is_stale, .. } = &mut self.tiles[tile as usize];
        std::mem::take(is_stale).then(|| {
            let (resolved, border) = (std::mem::take(resolved), std::mem::take(border));
            Reducing { tile, resolved, border, own_death: 0.0, is_changed: false }
        })
    }

    fn reduce(&self, cloud: &Cloud, job: &mut Reducing, worker: &mut Worker) {
        let Worker { workshop, difference, .. } = worker;
        let tile = &self.tiles[job.tile as usize];
        match &tile.body {
            Body::Leaf { stars, .. } => workshop.reduce_leaf(cloud, stars, job.tile == ROOT),
            Body::Halves { halves, .. } => {
                let mut parts = Vec::with_capacity(1 << STRIDE);
                halves.iter().for_each(|&half| self.gather_parts(half, &mut parts));
                workshop.reduce_parts(cloud, parts.iter().copied(), job.tile == ROOT);
            }
            Body::Free => unreachable!("a freed tile is on no list"),
        }
        difference.compare(&Order { cloud }, &job.resolved, &workshop.resolved);
        job.own_death = workshop.resolved.dots.iter().map(|dot| dot.death).fold(0.0, f64::max);
        job.is_changed = job.border != workshop.border;
        job.resolved.copy_from(&workshop.resolved);
        job.border.copy_from(&workshop.border);
    }

    /// The borders of the nearest tiles, at or below this one, that are reduced.
    fn gather_parts<'a>(&'a self, id: TileId, parts: &mut Vec<&'a Border>) {
        let tile = &self.tiles[id as usize];
        match &tile.body {
            Body::Halves { halves, .. } if tile.hands_on() => {
                halves.iter().for_each(|&half| self.gather_parts(half, parts));
            }
            _ => parts.push(&tile.border),
        }
    }

    fn install(&mut self, job: Reducing) {
        let tile = &mut self.tiles[job.tile as usize];
        tile.own_death = job.own_death;
        tile.resolved = job.resolved;
        tile.border = job.border;
        if job.is_changed {
            self.mark_above(job.tile);
        }
    }

    /// Brings up to date what is known of a tile and all below it, whose halves are.
    fn note_extremes(&mut self, id: TileId) {
        let tile = &self.tiles[id as usize];
        let mut last_death = tile.own_death;
        let mut longest = tile.resolved.tree.first().map_or(0.0, |edge| edge.scale);
        if let Body::Halves { halves, .. } = &tile.body {
            for half in halves.map(|half| &self.tiles[half as usize]) {
                last_death = last_death.max(half.last_death);
                longest = longest.max(half.longest);
            }
        }
        let tile = &mut self.tiles[id as usize];
        (tile.last_death, tile.longest) = (last_death, longest);
    }

    /// Panics when a star is not what the triangulation shows. For tests.
    pub fn check_stars(&self, delaunay: &Delaunay) {
        let mut reader = Reader::default();
        for tile in &self.tiles {
            let Body::Leaf { stars, .. } = &tile.body else { continue };
            let mut fresh = Stars::default();
            let vertices: Vec<Located<Slot>> = stars.vertices().collect();
            reader.look_around(delaunay, &vertices);
            for (place, &vertex) in vertices.iter().enumerate() {
                reader.read(delaunay, place, vertex, &mut fresh);
            }
            for (held, seen) in stars.iter().zip(fresh.iter()) {
                assert_eq!(held, seen);
            }
        }
    }
}

/// Does a step of work on each of some items, in any order and on any thread.
fn in_parallel<T: Send>(workers: &mut Vec<Worker>, items: &mut [T], step: impl Fn(&mut Worker, &mut T) + Sync) {
    let threads = rayon::current_num_threads();
    if items.len() < FEW || threads == 1 {
        return items.iter_mut().for_each(|item| step(&mut workers[0], item));
    }
    let pieces = (4 * threads).min(items.len() / PIECE);
    workers.resize_with(workers.len().max(pieces), Worker::default);
    let pieces = items.par_chunks_mut(items.len().div_ceil(pieces)).zip(workers.par_iter_mut());
    pieces.for_each(|(items, worker)| items.iter_mut().for_each(|item| step(worker, item)));
}
