//! The simplified skeleton: a view with its short edges collapsed, as far as no cycle is lost.
//!
//! In: a [`Skeleton`], a [`View`] of it, and a threshold (a radius). Out: a [`Simplified`] graph. Invariants: it has as many
//! components and as many independent cycles as the view, no loops and no parallel edges, so every cycle keeps at least three
//! edges; an edge of half-length below the threshold is left only where its ends share a neighbour; the answer depends on
//! the positions alone, not on how vertices are numbered. Must not know: gaps, and where the threshold comes from.
//!
//! Cost: O(log m) for each edge whose length changes, of m in all. A collapse that moves a vertex pays for all of that vertex'
//! edges, which are few where it can happen often: an end of degree 2 does not move the other one, and two edges of a
//! minimum spanning tree that meet are at least a sixth of a turn apart.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};

use super::skeleton::{Edge, Skeleton};
use super::view::View;

type Point = [f64; 2];

/// A graph in the plane that is simpler than the view it was made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simplified {
    /// Where the vertices are, in order (x, then y).
    pub positions: Vec<Point>,
    /// Edges as places in `positions`, the smaller end first, in order.
    pub edges: Vec<Edge>,
    /// Of each vertex of the skeleton: the place in `positions` of the vertex that it has become part of.
    pub image: Vec<u32>,
}

/// Collapses the shortest edge of a view, again and again, while its half-length is below `threshold` (a radius).
///
/// The merged vertex sits at the midpoint, except that an end of degree other than 2 beats an end of degree 2 and stays where
/// it is. An edge whose collapse would make a loop or a parallel edge stays. Edges of equal length go in the order of
/// their smaller ends, by x, then y, then of their larger ends.
pub fn simplify(skeleton: &Skeleton, view: &View, threshold: f64) -> Simplified {
    let vertices = skeleton.vertices();
    let mut by_position: Vec<u32> = (0..vertices.len() as u32).collect();
    by_position.sort_unstable_by_key(|&vertex| vertices[vertex as usize].position);
    let mut rank = vec![0; vertices.len()];
    for (place, &vertex) in by_position.iter().enumerate() {
        rank[vertex as usize] = place as u32;
    }
    let positions = by_position.iter().map(|&vertex| vertices[vertex as usize].position.xy()).collect();
    let edges = view.tree.iter().copied().chain(view.critical_edges(skeleton));
    let edges = edges.map(|edge| edge.map(|vertex| rank[vertex as usize])).collect();
    let mut graph = Graph::new(positions, edges, threshold);
    graph.collapse_short();
    graph.simplified(&rank)
}

/// The stamp of an edge that is gone, or that will never be collapsed.
const SETTLED: u32 = u32::MAX;

/// A graph that shrinks. Its vertices and edges are numbered by their first positions, so that the last resort of every tie,
/// the number, means the same in every numbering of the cloud.
struct Graph {
    threshold: f64,
    positions: Vec<Point>,
    /// Of each vertex that is left: its neighbours, and the edges to them.
    adjacent: Vec<BTreeMap<u32, u32>>,
    /// Of each vertex: the one that it was merged into; itself, if it is left.
    merged_into: Vec<u32>,
    /// Of each edge that is left: its ends.
    ends: Vec<Edge>,
    /// Of each edge: changes whenever its length does.
    stamps: Vec<u32>,
    /// Edges below the threshold, the shortest first; those with an old stamp are void.
    queue: BinaryHeap<Reverse<Candidate>>,
    /// Working space: edges whose length has changed.
    changed: Vec<u32>,
}

impl Graph {
    /// A graph without loops and parallel edges, on vertices in order of position.
    fn new(positions: Vec<Point>, mut edges: Vec<Edge>, threshold: f64) -> Self {
        for edge in &mut edges {
            edge.sort_unstable();
        }
        edges.sort_unstable();
        let mut adjacent = vec![BTreeMap::new(); positions.len()];
        for (index, &[a, b]) in edges.iter().enumerate() {
            adjacent[a as usize].insert(b, index as u32);
            adjacent[b as usize].insert(a, index as u32);
        }
        let mut graph = Self {
            threshold,
            adjacent,
            merged_into: (0..positions.len() as u32).collect(),
            stamps: vec![0; edges.len()],
            queue: BinaryHeap::new(),
            changed: Vec::new(),
            positions,
            ends: edges,
        };
        let all: Vec<_> = (0..graph.ends.len() as u32).filter_map(|edge| graph.candidate(edge)).map(Reverse).collect();
        graph.queue = all.into();
        graph
    }

    fn collapse_short(&mut self) {
        while let Some(Reverse(Candidate { edge, stamp, .. })) = self.queue.pop() {
            if self.stamps[edge as usize] != stamp {
                continue;
            }
            self.stamps[edge as usize] = SETTLED;
            let [a, b] = self.ends[edge as usize];
            // Skipped once, skipped for good: collapsing any edge of a triangle would make the other two parallel, so none of
            // the three can ever go, and whatever else is collapsed leaves the triangle's corners three vertices, joined.
            if !self.share_a_neighbour(a, b) {
                self.collapse(a, b);
            }
        }
    }

    fn share_a_neighbour(&self, a: u32, b: u32) -> bool {
        let (few, many) = self.by_degree(a, b);
        self.adjacent[few as usize].keys().any(|neighbour| self.adjacent[many as usize].contains_key(neighbour))
    }

    /// Makes one vertex of two neighbours that share none. The one with more edges takes over those of the other, so that an
    /// edge changes hands O(log m) times.
    fn collapse(&mut self, a: u32, b: u32) {
        let position = self.merged_position(a, b);
        let (gone, kept) = self.by_degree(a, b);
        self.merged_into[gone as usize] = kept;
        self.adjacent[kept as usize].remove(&gone);
        for (neighbour, edge) in std::mem::take(&mut self.adjacent[gone as usize]) {
            if neighbour != kept {
                self.adjacent[neighbour as usize].remove(&gone);
                self.adjacent[neighbour as usize].insert(kept, edge);
                self.adjacent[kept as usize].insert(neighbour, edge);
                self.ends[edge as usize] = [kept, neighbour];
                self.changed.push(edge);
            }
        }
        if self.positions[kept as usize] != position {
            self.positions[kept as usize] = position;
            self.changed.clear();
            self.changed.extend(self.adjacent[kept as usize].values());
        }
        self.measure_changed();
    }

    /// Two vertices, the one with fewer edges first.
    fn by_degree(&self, a: u32, b: u32) -> (u32, u32) {
        if self.degree(a) <= self.degree(b) { (a, b) } else { (b, a) }
    }

    fn merged_position(&self, a: u32, b: u32) -> Point {
        let [p, q] = [a, b].map(|vertex| self.positions[vertex as usize]);
        match [a, b].map(|vertex| self.degree(vertex) == 2) {
            [true, false] => q,
            [false, true] => p,
            [true, true] | [false, false] => [p[0].midpoint(q[0]), p[1].midpoint(q[1])],
        }
    }

    /// Puts edges of a new length in their new place in the queue.
    fn measure_changed(&mut self) {
        while let Some(edge) = self.changed.pop() {
            if self.stamps[edge as usize] != SETTLED {
                self.stamps[edge as usize] += 1;
                self.queue.extend(self.candidate(edge).map(Reverse));
            }
        }
        if self.queue.len() > 2 * self.ends.len() {
            self.queue.retain(|Reverse(candidate)| self.stamps[candidate.edge as usize] == candidate.stamp);
        }
    }

    /// An edge as it is now, if it is below the threshold.
    fn candidate(&self, edge: u32) -> Option<Candidate> {
        let [p, q] = self.ends[edge as usize].map(|vertex| self.positions[vertex as usize]);
        let scale = half_length_squared(p, q);
        let ends = if compare_points(&p, &q) == Ordering::Greater { [q, p] } else { [p, q] };
        let stamp = self.stamps[edge as usize];
        (scale.sqrt() < self.threshold).then_some(Candidate { scale, ends, edge, stamp })
    }

    fn degree(&self, vertex: u32) -> usize {
        self.adjacent[vertex as usize].len()
    }

    /// What is left; `rank` gives the number here of each vertex of the skeleton.
    fn simplified(mut self, rank: &[u32]) -> Simplified {
        let at = |vertex: u32| self.positions[vertex as usize];
        let mut left: Vec<u32> = (0..self.positions.len() as u32).filter(|&vertex| self.is_left(vertex)).collect();
        left.sort_by(|&a, &b| compare_points(&at(a), &at(b)));
        let positions = left.iter().map(|&vertex| at(vertex)).collect();
        let mut place = vec![0; self.positions.len()];
        for (index, &vertex) in left.iter().enumerate() {
            place[vertex as usize] = index as u32;
        }
        let edges = self.edges_left(&left, &place);
        let image = rank.iter().map(|&vertex| place[self.root(vertex) as usize]).collect();
        Simplified { positions, edges, image }
    }

    fn is_left(&self, vertex: u32) -> bool {
        self.merged_into[vertex as usize] == vertex
    }

    fn edges_left(&self, left: &[u32], place: &[u32]) -> Vec<Edge> {
        let mut edges: Vec<Edge> = Vec::new();
        for &vertex in left {
            let neighbours = self.adjacent[vertex as usize].keys();
            let to = neighbours.map(|&neighbour| [place[vertex as usize], place[neighbour as usize]]);
            edges.extend(to.filter(|[a, b]| a < b));
        }
        edges.sort_unstable();
        edges
    }

    /// The vertex that another one has become part of.
    fn root(&mut self, mut vertex: u32) -> u32 {
        while !self.is_left(vertex) {
            let into = self.merged_into[vertex as usize];
            // Halves the path for those who come after.
            self.merged_into[vertex as usize] = self.merged_into[into as usize];
            vertex = into;
        }
        vertex
    }
}

/// An edge that is to be collapsed, as it was when its stamp was new.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Half its length, squared.
    scale: f64,
    /// Where its ends are, in order.
    ends: [Point; 2],
    edge: u32,
    stamp: u32,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        let [p, q] = &self.ends;
        let [r, s] = &other.ends;
        (self.scale.total_cmp(&other.scale))
            .then_with(|| compare_points(p, r))
            .then_with(|| compare_points(q, s))
            // Vertices that have moved may lie on one another.
            .then_with(|| (self.edge, self.stamp).cmp(&(other.edge, other.stamp)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// By x, then y.
fn compare_points(p: &Point, q: &Point) -> Ordering {
    p[0].total_cmp(&q[0]).then_with(|| p[1].total_cmp(&q[1]))
}

/// As for positions of the cloud, bit for bit: an edge that has not moved is below a threshold exactly when its scale in the
/// skeleton is. (Midpoints are no such positions: they may come nearer to 0 than those are allowed to.)
fn half_length_squared(p: Point, q: Point) -> f64 {
    let (dx, dy) = (p[0] - q[0], p[1] - q[1]);
    (dx * dx + dy * dy) * 0.25
}
