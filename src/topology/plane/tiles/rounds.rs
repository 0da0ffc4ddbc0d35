//! How a change travels through the tree of tiles: stars are read, then leaves and the tiles above them are reduced.
//!
//! In: a [`Cloud`], its [`Delaunay`] triangulation, and the changes of both.
//! Out: a [`Difference`] of the minimum spanning tree and of the dots.
//! Invariants: a tile is reduced after all tiles below it. Tiles of one level are independent and are reduced in
//! parallel.
//! Must not know: ids, views.

use super::border::Border;
use super::difference::Difference;
use super::resolved::{EdgeOrder, Resolved};
use super::star::Stars;
use super::star_reader::StarReader;
use super::touched::Touched;
use super::tree::{Body, NONE, ROOT, STRIDE, StarPlace, Tile, TileId, Tiles};
use super::worker::{StarUpdate, Worker};
use crate::topology::base::with_workers;
use crate::topology::cloud::{Cloud, CloudChange, Located, Position, Slot};
use crate::topology::plane::delaunay::Delaunay;

/// A leaf whose stars are read.
struct ReadJob {
    tile: TileId,
    stars: Stars,
    arrivals: Vec<Located<Slot>>,
}

/// A tile that is reduced.
struct ReduceJob {
    tile: TileId,
    resolved: Resolved,
    border: Border,
    /// The largest death that it resolved.
    own_death: f64,
    /// Whether its border has changed.
    is_changed: bool,
}

impl Tiles {
    /// The tree over all vertices of a cloud, with leaves of at most `capacity` vertices.
    pub fn new(cloud: &Cloud, delaunay: &Delaunay, capacity: usize) -> Self {
        let mut tiles = Self {
            capacity,
            tiles: Vec::new(),
            free: Vec::new(),
            star_places: Vec::new(),
            round: 1,
            reduced: 0,
            retired: Vec::new(),
            workers: vec![Worker::default()],
        };
        tiles.make_room(cloud);
        let root = tiles.new_leaf(NONE, 0);
        let mut sites: Vec<(Position, Slot)> = cloud.vertices().map(|(slot, v)| (v.position, slot)).collect();
        let leaves = tiles.build(root, &mut sites);
        tiles.read_stars(cloud, delaunay, &leaves, false);
        tiles.reduce_above(cloud, &leaves);
        tiles
    }

    /// Follows a change that the triangulation has followed step by step.
    pub fn follow(
        &mut self,
        cloud: &Cloud,
        delaunay: &Delaunay,
        change: &CloudChange,
        touched: &Touched,
    ) -> Difference {
        self.begin_round();
        self.make_room(cloud);
        let mut leaves = Vec::new();
        for &slot in &change.vanished {
            let leaf_id = std::mem::replace(&mut self.star_places[slot as usize].leaf_id, NONE);
            self.list(leaf_id, &mut leaves);
        }
        for &(slot, leaf_id) in &touched.leaves_of_new {
            self.add_arrival(leaf_id, cloud.position(slot), slot);
            self.list(leaf_id, &mut leaves);
        }
        for &slot in &change.appeared {
            // Some new vertices were not searched for: on a line, or at a position that was left and taken again.
            if self.star_places[slot as usize].leaf_id == NONE {
                let leaf_id = self.leaf_of(cloud.position(slot));
                self.add_arrival(leaf_id, cloud.position(slot), slot);
                self.list(leaf_id, &mut leaves);
            }
        }
        self.list_leaves_of(touched.slots(), &mut leaves);
        let mut circle_owners = self.read_stars(cloud, delaunay, &leaves, true);
        circle_owners.retain(|&slot| self.star_places[slot as usize].read_in != self.round);
        self.begin_round();
        let mut again = Vec::new();
        self.list_leaves_of(circle_owners.into_iter(), &mut again);
        self.read_stars(cloud, delaunay, &again, false);
        leaves.extend(again);
        let rebuilt = self.reshape(&mut leaves);
        self.begin_round();
        self.read_stars(cloud, delaunay, &rebuilt, false);
        leaves.extend(rebuilt);
        let mut difference = self.reduce_above(cloud, &leaves);
        for retired in self.retired.drain(..) {
            difference.compare(&EdgeOrder { cloud }, &retired, &Resolved::default());
        }
        difference.cancel();
        difference
    }

    /// Updates the stars of some leaves. Returns the owners of circles of other leaves, whose stars have to be read
    /// again, if they are sought.
    fn read_stars(&mut self, cloud: &Cloud, delaunay: &Delaunay, leaves: &[TileId], seeks_owners: bool) -> Vec<Slot> {
        let mut jobs: Vec<ReadJob> = leaves.iter().map(|&leaf| self.begin_read(leaf)).collect();
        let mut workers = std::mem::take(&mut self.workers);
        with_workers(&mut workers, &mut jobs, |worker, job| {
            worker.reader.seeks_owners = seeks_owners;
            self.read_leaf(delaunay, job, worker);
        });
        for ReadJob { tile, stars, arrivals } in jobs {
            debug_assert!(stars.vertices().all(|(position, slot)| cloud.position(slot) == position));
            let tile = &mut self.tiles[tile as usize];
            tile.count = stars.len();
            tile.is_stale = true;
            tile.body = Body::Leaf { stars, arrivals };
        }
        let circle_owners = workers.iter().flat_map(|worker| worker.reader.circle_owners.iter().copied()).collect();
        workers.iter_mut().for_each(|worker| worker.reader.forget_owners());
        self.workers = workers;
        circle_owners
    }

    fn begin_read(&mut self, leaf: TileId) -> ReadJob {
        match std::mem::replace(&mut self.tiles[leaf as usize].body, Body::Free) {
            Body::Leaf { stars, arrivals } => ReadJob { tile: leaf, stars, arrivals },
            Body::Halves { .. } | Body::Free => unreachable!("only leaves have stars"),
        }
    }

    fn read_leaf(&self, delaunay: &Delaunay, job: &mut ReadJob, worker: &mut Worker) {
        let ReadJob { tile, stars: old, arrivals } = job;
        let Worker { reader, to_read, updates, stars, .. } = worker;
        arrivals.sort_unstable();
        let mut coming = arrivals.drain(..).peekable();
        to_read.clear();
        updates.clear();
        for vertex in old.vertices() {
            to_read.extend(std::iter::from_fn(|| coming.next_if(|arrival| arrival < &vertex)));
            let update = self.star_update(vertex.1, *tile);
            updates.push(update);
            if update == StarUpdate::Read {
                to_read.push(vertex);
            }
        }
        to_read.extend(coming);
        reader.look_around(delaunay, to_read);
        let mut reads = to_read.iter().copied().enumerate().peekable();
        stars.clear();
        for (star, &update) in old.iter().zip(&*updates) {
            if update == StarUpdate::Keep {
                while let Some((place, vertex)) = reads.next_if(|read| read.1.0 < star.center.position) {
                    reader.read(delaunay, place, vertex, stars);
                }
                stars.push(star);
            }
        }
        reads.for_each(|(place, vertex)| reader.read(delaunay, place, vertex, stars));
        old.copy_from(stars);
    }

    /// What to do with the star of a vertex in a leaf.
    fn star_update(&self, slot: Slot, leaf: TileId) -> StarUpdate {
        let StarPlace { leaf_id, read_in } = self.star_places[slot as usize];
        if leaf_id != leaf {
            StarUpdate::Drop
        } else if read_in == self.round {
            StarUpdate::Read
        } else {
            StarUpdate::Keep
        }
    }

    /// Reduces some leaves and the tiles above them, deepest first.
    fn reduce_above(&mut self, cloud: &Cloud, leaves: &[TileId]) -> Difference {
        let mut reduced = 0;
        let mut levels = self.levels_above(leaves);
        let mut workers = std::mem::take(&mut self.workers);
        while let Some(level) = levels.pop() {
            let mut jobs: Vec<ReduceJob> = level.iter().filter_map(|&tile| self.begin_reduce(tile)).collect();
            reduced += jobs.len();
            with_workers(&mut workers, &mut jobs, |worker, job| self.reduce(cloud, job, worker));
            jobs.into_iter().for_each(|job| self.install(job));
            level.into_iter().for_each(|tile| self.note_extremes(tile));
        }
        self.reduced = reduced;
        let mut total = Difference::default();
        workers.iter_mut().for_each(|worker| total.take(&mut worker.difference));
        self.workers = workers;
        total
    }

    fn begin_reduce(&mut self, tile: TileId) -> Option<ReduceJob> {
        let Tile { resolved, border, is_stale, .. } = &mut self.tiles[tile as usize];
        std::mem::take(is_stale).then(|| {
            let (resolved, border) = (std::mem::take(resolved), std::mem::take(border));
            ReduceJob { tile, resolved, border, own_death: 0.0, is_changed: false }
        })
    }

    fn reduce(&self, cloud: &Cloud, job: &mut ReduceJob, worker: &mut Worker) {
        let Worker { reduction, difference, .. } = worker;
        let tile = &self.tiles[job.tile as usize];
        match &tile.body {
            Body::Leaf { stars, .. } => reduction.reduce_leaf(cloud, stars, job.tile == ROOT),
            Body::Halves { halves, .. } => {
                let mut parts = Vec::with_capacity(1 << STRIDE);
                halves.iter().for_each(|&half| self.gather_parts(half, &mut parts));
                reduction.reduce_parts(cloud, parts.iter().copied(), job.tile == ROOT);
            }
            Body::Free => unreachable!("a freed tile is on no list"),
        }
        difference.compare(&EdgeOrder { cloud }, &job.resolved, &reduction.resolved);
        job.own_death = reduction.resolved.dots.iter().map(|dot| dot.death).fold(0.0, f64::max);
        job.is_changed = job.border != reduction.border;
        job.resolved.copy_from(&reduction.resolved);
        job.border.copy_from(&reduction.border);
    }

    /// The borders of the nearest reduced tiles at or below this one.
    fn gather_parts<'a>(&'a self, id: TileId, parts: &mut Vec<&'a Border>) {
        let tile = &self.tiles[id as usize];
        match &tile.body {
            Body::Halves { halves, .. } if tile.is_pass_through() => {
                halves.iter().for_each(|&half| self.gather_parts(half, parts));
            }
            _ => parts.push(&tile.border),
        }
    }

    fn install(&mut self, job: ReduceJob) {
        let tile = &mut self.tiles[job.tile as usize];
        tile.own_death = job.own_death;
        tile.resolved = job.resolved;
        tile.border = job.border;
        if job.is_changed {
            self.mark_above(job.tile);
        }
    }

    /// Updates the extremes of a tile from its own and its halves'.
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

    /// Panics when a star differs from the triangulation. For tests.
    pub fn check_stars(&self, delaunay: &Delaunay) {
        let mut reader = StarReader::default();
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
