//! The simplified skeleton: a view whose short edges are collapsed as far as no cycle is lost.
//!
//! In: a [`Skeleton`], a [`View`] of it, and a threshold (a radius).
//! Out: a [`Simplified`] graph.
//! Invariants: it has as many components and independent cycles as the view, no loops and no parallel edges; so every
//! cycle keeps at least three edges. An edge of half-length below the threshold is left only where its ends share a
//! neighbour. The result depends on positions (elsewhere than in the plane also on lengths), not on how vertices are
//! numbered; in a space without coordinates it depends on lengths and ids.
//! Must not know: gaps, where the threshold comes from.
//!
//! Cost: O(log m) for each edge whose length changes, of m edges in all. A collapse that moves a vertex changes all
//! edges of that vertex. A hub with nothing but tips around it would therefore cost the square of its degree. But an
//! end of degree 2 does not move a hub, and tips hang on edges of the minimum spanning tree, which leave a vertex at
//! least a sixth of a turn apart. In many dimensions there can be more of them, and a move costs as many steps as there
//! are coordinates.

use std::cmp::{Ordering, Reverse};
use std::collections::{BTreeMap, BinaryHeap};
use std::rc::Rc;

use super::hopes::{Edge, Filtration, Skeleton};
use super::place::{Label, Place, Positions};
use super::view::View;

/// A simplified view: a graph in the space of the skeleton.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simplified {
    /// Where its vertices are, in lexicographic order.
    pub positions: Positions,
    /// Edges as places in `positions`, the smaller end first, in order.
    pub edges: Vec<Edge>,
    /// For each vertex of the skeleton: the place in `positions` of the vertex that it was merged into.
    pub image: Vec<u32>,
}

/// Collapses the shortest edge of a view repeatedly, while its half-length is below `threshold` (a radius).
///
/// The merged vertex is at the midpoint. But if one end has degree 2 and the other has not, it is at the other. An edge
/// whose collapse would make a loop or a parallel edge stays. Edges of equal length are taken in the order of their
/// smaller ends, by position, then of their larger ends. An edge that has an end of which the position has changed is
/// as long as its ends are apart (by Euclid).
///
/// In a space without coordinates the end of larger degree stays, of equal ones the smaller. Edges keep their lengths.
pub fn simplify(skeleton: &Skeleton, view: &View, threshold: f64) -> Simplified {
    let vertices = skeleton.vertices();
    if vertices.is_empty() {
        return Simplified::default();
    }
    let graph = Sorted::new(skeleton, view);
    match (skeleton.filtration(), vertices.dimension()) {
        (Filtration::Alpha, _) => graph.simplified(threshold, Vec::new(), |vertex| vertices.xy(vertex)),
        (Filtration::Rips, 0) => graph.simplified(threshold, graph.half_lengths(skeleton), Label),
        (Filtration::Rips, _) => {
            let place = |vertex: u32| -> Rc<[f64]> { vertices.coordinates(vertex).into() };
            graph.simplified(threshold, graph.half_lengths(skeleton), place)
        }
    }
}

/// The vertices and edges of a view in order of position.
struct Sorted {
    /// The vertices of the skeleton in order of position.
    order: Vec<u32>,
    /// The place of each of them in that order.
    rank: Vec<u32>,
    /// The edges as such places.
    edges: Vec<Edge>,
}

impl Sorted {
    fn new(skeleton: &Skeleton, view: &View) -> Self {
        let vertices = skeleton.vertices();
        let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| vertices.compare(a, b));
        let mut rank = vec![0; vertices.len()];
        for (place, &vertex) in order.iter().enumerate() {
            rank[vertex as usize] = place as u32;
        }
        let edges = view.tree.iter().copied().chain(view.critical_edges(skeleton));
        let mut edges: Vec<Edge> = edges.map(|edge| edge.map(|vertex| rank[vertex as usize])).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        Self { order, rank, edges }
    }

    /// The half-lengths of the edges as the skeleton has them.
    fn half_lengths(&self, skeleton: &Skeleton) -> Vec<Option<f64>> {
        let half_length = |edge: &Edge| {
            let [a, b] = edge.map(|place| self.order[place as usize]);
            Some(skeleton.half_length([a.min(b), a.max(b)]))
        };
        self.edges.iter().map(half_length).collect()
    }

    fn simplified<P: Place>(
        &self,
        threshold: f64,
        half_lengths: Vec<Option<f64>>,
        place: impl Fn(u32) -> P,
    ) -> Simplified {
        let places = self.order.iter().map(|&vertex| place(vertex)).collect();
        let mut graph = Graph::new(places, self.edges.clone(), half_lengths, threshold);
        graph.collapse_short();
        graph.simplified(&self.rank)
    }
}

/// The stamp of an edge that is gone or will never be collapsed.
const SETTLED: u32 = u32::MAX;

/// A graph that shrinks. Vertices and edges are numbered by their first positions, so that the last tie-breaker, the
/// number, does not depend on the numbering of the cloud.
struct Graph<P> {
    threshold: f64,
    places: Vec<P>,
    /// The half-lengths of edges that are not those of their ends' places. Empty in the plane.
    half_lengths: Vec<Option<f64>>,
    /// The neighbours of each remaining vertex, and the edges to them.
    adjacent: Vec<Neighbours>,
    /// The vertex that each vertex was merged into; a remaining vertex names itself.
    merged_into: Vec<u32>,
    /// The ends of each remaining edge.
    ends: Vec<Edge>,
    /// A stamp for each edge, which changes with its length.
    stamps: Vec<u32>,
    /// Edges below the threshold, the shortest first. An entry with an old stamp is void.
    queue: BinaryHeap<Reverse<Candidate>>,
    /// The shortest of these edges, in the order of their ends. Only they are compared by their ends.
    ties: BinaryHeap<Reverse<Tie<P>>>,
    /// Working space: edges whose length has changed.
    changed: Vec<u32>,
}

impl<P: Place> Graph<P> {
    /// A graph without loops and parallel edges: its vertices, and its edges in order, the smaller end first.
    fn new(places: Vec<P>, edges: Vec<Edge>, half_lengths: Vec<Option<f64>>, threshold: f64) -> Self {
        let mut adjacent = vec![Neighbours::default(); places.len()];
        for (index, &[a, b]) in edges.iter().enumerate() {
            adjacent[a as usize].insert(b, index as u32);
            adjacent[b as usize].insert(a, index as u32);
        }
        let mut graph = Self {
            threshold,
            half_lengths,
            adjacent,
            merged_into: (0..places.len() as u32).collect(),
            stamps: vec![0; edges.len()],
            queue: BinaryHeap::new(),
            ties: BinaryHeap::new(),
            changed: Vec::new(),
            places,
            ends: edges,
        };
        let all: Vec<_> = (0..graph.ends.len() as u32).filter_map(|edge| graph.candidate(edge)).map(Reverse).collect();
        graph.queue = all.into();
        graph
    }

    fn collapse_short(&mut self) {
        while let Some(edge) = self.take_shortest() {
            self.stamps[edge as usize] = SETTLED;
            let [a, b] = self.ends[edge as usize];
            // An edge that is skipped once stays: collapsing an edge of a triangle would make the other two parallel.
            // So no edge of the triangle can be collapsed, and its corners stay three joined vertices whatever else is
            // collapsed.
            if !self.share_a_neighbour(a, b) {
                self.collapse(a, b);
            }
        }
    }

    /// Takes the shortest edge below the threshold out of the queue.
    fn take_shortest(&mut self) -> Option<u32> {
        loop {
            self.gather_ties();
            let Reverse(Tie { candidate, .. }) = self.ties.pop()?;
            if self.is_current(candidate) {
                return Some(candidate.edge);
            }
        }
    }

    /// Moves edges that are no longer than the ties from the queue to the ties.
    fn gather_ties(&mut self) {
        while let Some(&Reverse(candidate)) = self.queue.peek() {
            if self.ties.peek().is_some_and(|Reverse(tie)| tie.candidate.scale < candidate.scale) {
                break;
            }
            self.queue.pop();
            if self.is_current(candidate) {
                self.ties.push(Reverse(Tie { candidate, ends: self.ordered_ends(candidate.edge) }));
            }
        }
    }

    fn is_current(&self, candidate: Candidate) -> bool {
        self.stamps[candidate.edge as usize] == candidate.stamp
    }

    fn share_a_neighbour(&self, a: u32, b: u32) -> bool {
        let (few, many) = self.by_degree(a, b);
        self.adjacent[few as usize].iter().any(|(neighbour, _)| self.adjacent[many as usize].contains(neighbour))
    }

    /// Merges two neighbours that share no neighbour. The vertex with more edges takes over those of the other, so an
    /// edge moves O(log m) times.
    fn collapse(&mut self, a: u32, b: u32) {
        let place = self.merged_place(a, b);
        let (gone, kept) = self.by_degree(a, b);
        self.merged_into[gone as usize] = kept;
        self.adjacent[kept as usize].remove(gone);
        for (neighbour, edge) in std::mem::take(&mut self.adjacent[gone as usize]).iter() {
            if neighbour != kept {
                self.adjacent[neighbour as usize].remove(gone);
                self.adjacent[neighbour as usize].insert(kept, edge);
                self.adjacent[kept as usize].insert(neighbour, edge);
                self.ends[edge as usize] = [kept, neighbour];
                self.changed.push(edge);
            }
        }
        if self.places[kept as usize] != place {
            self.places[kept as usize] = place;
            self.changed.clear();
            self.changed.extend(self.adjacent[kept as usize].iter().map(|(_, edge)| edge));
        }
        self.measure_changed();
    }

    /// Two vertices, the one with fewer edges first.
    fn by_degree(&self, a: u32, b: u32) -> (u32, u32) {
        if self.degree(a) <= self.degree(b) { (a, b) } else { (b, a) }
    }

    fn merged_place(&self, a: u32, b: u32) -> P {
        let [p, q] = [a, b].map(|vertex| &self.places[vertex as usize]);
        p.merged(q, [a, b].map(|vertex| self.degree(vertex)))
    }

    /// Puts edges whose length has changed in their new places in the queue.
    fn measure_changed(&mut self) {
        while let Some(edge) = self.changed.pop() {
            if self.stamps[edge as usize] != SETTLED {
                self.stamps[edge as usize] += 1;
                if P::HAS_DISTANCES
                    && let Some(stored) = self.half_lengths.get_mut(edge as usize)
                {
                    *stored = None;
                }
                self.queue.extend(self.candidate(edge).map(Reverse));
            }
        }
        if self.queue.len() > 2 * self.ends.len() {
            self.queue.retain(|Reverse(candidate)| self.stamps[candidate.edge as usize] == candidate.stamp);
        }
    }

    /// The current candidate of an edge, if it is below the threshold.
    fn candidate(&self, edge: u32) -> Option<Candidate> {
        let [p, q] = self.ends[edge as usize].map(|vertex| &self.places[vertex as usize]);
        let scale = p.scale(q, self.half_lengths.get(edge as usize).copied().flatten());
        let stamp = self.stamps[edge as usize];
        (P::half_length(scale) < self.threshold).then_some(Candidate { scale: scale.to_bits(), edge, stamp })
    }

    /// The places of the ends of an edge, in order.
    fn ordered_ends(&self, edge: u32) -> [P; 2] {
        let [p, q] = self.ends[edge as usize].map(|vertex| self.places[vertex as usize].clone());
        if p.compare(&q) == Ordering::Greater { [q, p] } else { [p, q] }
    }

    fn degree(&self, vertex: u32) -> usize {
        self.adjacent[vertex as usize].len()
    }

    /// The remaining graph. `rank` gives the number of each vertex of the skeleton in this graph.
    fn simplified(mut self, rank: &[u32]) -> Simplified {
        let at = |vertex: u32| &self.places[vertex as usize];
        let mut left: Vec<u32> = (0..self.places.len() as u32).filter(|&vertex| self.is_left(vertex)).collect();
        left.sort_by(|&a, &b| at(a).compare(at(b)));
        let positions = P::positions(left.iter().map(|&vertex| at(vertex)));
        let mut place = vec![0; self.places.len()];
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
            let neighbours = self.adjacent[vertex as usize].iter();
            let to = neighbours.map(|(neighbour, _)| [place[vertex as usize], place[neighbour as usize]]);
            edges.extend(to.filter(|[a, b]| a < b));
        }
        edges.sort_unstable();
        edges
    }

    /// The remaining vertex that a vertex was merged into.
    fn root(&mut self, mut vertex: u32) -> u32 {
        while !self.is_left(vertex) {
            let into = self.merged_into[vertex as usize];
            // Halves the path for later calls.
            self.merged_into[vertex as usize] = self.merged_into[into as usize];
            vertex = into;
        }
        vertex
    }
}

/// An edge to collapse, with its length and stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Its length, as [`Place::scale`] gives it. The bits of doubles that are not negative are in the order of the
    /// doubles.
    scale: u64,
    edge: u32,
    stamp: u32,
}

/// One of the shortest edges.
#[derive(Clone, Debug)]
struct Tie<P> {
    candidate: Candidate,
    /// The places of its ends, in order.
    ends: [P; 2],
}

impl<P: Place> Ord for Tie<P> {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.candidate.scale.cmp(&other.candidate.scale))
            .then_with(|| self.ends[0].compare(&other.ends[0]))
            .then_with(|| self.ends[1].compare(&other.ends[1]))
            // Vertices that moved may coincide.
            .then_with(|| self.candidate.cmp(&other.candidate))
    }
}

impl<P: Place> PartialOrd for Tie<P> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<P: Place> PartialEq for Tie<P> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<P: Place> Eq for Tie<P> {}

/// Up to this number, neighbours are searched one by one.
const FEW: usize = 16;

/// The neighbours of a vertex and the edges to them: a short list, which suffices for most vertices, and a tree for the
/// rest.
#[derive(Clone, Debug, Default)]
struct Neighbours {
    few: Vec<(u32, u32)>,
    rest: BTreeMap<u32, u32>,
}

impl Neighbours {
    fn len(&self) -> usize {
        self.few.len() + self.rest.len()
    }

    fn contains(&self, neighbour: u32) -> bool {
        self.few.iter().any(|entry| entry.0 == neighbour) || self.rest.contains_key(&neighbour)
    }

    fn insert(&mut self, neighbour: u32, edge: u32) {
        if self.few.len() < FEW {
            self.few.push((neighbour, edge));
        } else {
            self.rest.insert(neighbour, edge);
        }
    }

    fn remove(&mut self, neighbour: u32) {
        match self.few.iter().position(|entry| entry.0 == neighbour) {
            Some(place) => {
                self.few.swap_remove(place);
            }
            None => {
                self.rest.remove(&neighbour);
            }
        }
    }

    fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.few.iter().copied().chain(self.rest.iter().map(|(&neighbour, &edge)| (neighbour, edge)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::topology::cloud::{VertexId, Vertices, quarter_square};
    use crate::topology::skeleton::{Dot, Killer, ViewSpec};
    use crate::topology::testing::{Points, clouds, clouds_twice, labels, lattice, points_of, skeleton_of};

    type Point = [f64; 2];

    fn simplified(points: &[Point], spec: ViewSpec, threshold: f64) -> Simplified {
        let skeleton = skeleton_of(points);
        simplify(&skeleton, &View::new(&skeleton, spec), threshold)
    }

    #[test]
    fn a_square_becomes_a_triangle_and_no_less() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let whole = simplified(&square, ViewSpec::Full, 0.5);
        assert_eq!(
            whole.positions.planar(),
            [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]],
            "half of 1 is not below 0.5"
        );
        assert_eq!(whole.edges, [[0, 1], [0, 2], [1, 3], [2, 3]]);
        assert_eq!(whole.image, [0, 2, 3, 1]);
        for threshold in [0.51, 10.0, f64::INFINITY] {
            let triangle = simplified(&square, ViewSpec::Full, threshold);
            assert_eq!(
                triangle.positions.planar(),
                [[0.0, 0.5], [1.0, 0.0], [1.0, 1.0]],
                "the smallest of equal edges goes first"
            );
            assert_eq!(triangle.edges, [[0, 1], [0, 2], [1, 2]]);
            assert_eq!(triangle.image, [0, 1, 2, 0]);
        }
    }

    #[test]
    fn branches_and_tips_stay_where_they_are() {
        let arms = [[0.0, 0.0], [1.0, 0.0], [2.9, 0.0], [-1.0, 1.0], [-2.0, 2.5], [-1.0, -1.0], [-2.0, -2.5]];
        let star = simplified(&arms, ViewSpec::Full, 0.8);
        assert_eq!(star.positions.planar(), [[-2.0, -2.5], [-2.0, 2.5], [0.0, 0.0], [2.9, 0.0]]);
        assert_eq!(star.edges, [[0, 2], [1, 2], [2, 3]]);
        let bead = simplified(&[[0.0, 0.0], [3.0, 0.0], [4.0, 0.0]], ViewSpec::Full, 0.6);
        assert_eq!(bead.positions.planar(), [[0.0, 0.0], [4.0, 0.0]]);
    }

    #[test]
    fn lone_vertices_stay() {
        let pairs = [[0.0, 0.0], [1.0, 0.0], [10.0, 0.0], [20.0, 0.0], [21.0, 0.0]];
        let apart = simplified(&pairs, ViewSpec::Reduced { alpha: 1.0 }, f64::INFINITY);
        assert_eq!(apart.positions.planar(), [[0.5, 0.0], [10.0, 0.0], [20.5, 0.0]]);
        assert_eq!((apart.edges, apart.image), (vec![], vec![0, 0, 1, 2, 2]));
    }

    #[test]
    fn clouds_of_at_most_one_point_are_simplified() {
        assert_eq!(simplified(&[], ViewSpec::default(), f64::INFINITY), Simplified::default());
        let one = simplified(&[[1.0, 2.0]], ViewSpec::default(), f64::INFINITY);
        assert_eq!((one.positions.planar(), one.edges, one.image), (&[[1.0, 2.0]][..], vec![], vec![0]));
    }

    #[test]
    fn midpoints_do_not_overflow() {
        let far = crate::topology::MAX_COORDINATE;
        assert_eq!(
            simplified(&[[-far, far], [far, far]], ViewSpec::Full, f64::INFINITY).positions.planar(),
            [[0.0, far]]
        );
    }

    #[test]
    fn theta_keeps_its_two_cycles() {
        let points = points_of(include_str!("../../../tests/cases/theta_n250_e0.03.csv"));
        let skeleton = skeleton_of(&points);
        let view = View::new(&skeleton, ViewSpec::default());
        let vs = view.selection.as_ref().unwrap().vs;
        let at_vs = simplify(&skeleton, &view, vs);
        assert_eq!((cycles(&at_vs), components(&at_vs)), (2, 1));
        assert!(at_vs.edges.len() < view.tree.len() / 2, "{} edges", at_vs.edges.len());
        let least = simplify(&skeleton, &view, f64::INFINITY);
        assert_eq!((least.positions.len(), least.edges.len()), (4, 5), "two triangles that share an edge");
    }

    #[test]
    fn a_lattice_full_of_ties_keeps_its_cycles() {
        let points = lattice(12, 12);
        let left = simplified(&points, ViewSpec::Full, 0.6);
        assert_eq!((cycles(&left), components(&left)), (121, 1));
        assert!(left.edges.len() < 2 * 12 * 11);
    }

    /// A skeleton of edges with their half-lengths, without dots.
    fn tree(vertices: Vertices, edges: &[(Edge, f64)]) -> Skeleton {
        Skeleton::with_lengths(vertices, edges.to_vec(), Vec::new())
    }

    fn simplified_tree(skeleton: &Skeleton, threshold: f64) -> Simplified {
        simplify(skeleton, &View::new(skeleton, ViewSpec::Full), threshold)
    }

    #[test]
    fn points_of_space_merge_at_midpoints() {
        let mut corners = Vertices::default();
        let places: [[f64; 3]; 4] = [[9.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [9.0, 2.0, 4.0]];
        (0..).zip(&places).for_each(|(id, place)| corners.push(VertexId(id), place));
        let ladder = tree(corners, &[([1, 2], 0.5), ([0, 2], 4.5), ([0, 3], 20f64.sqrt() * 0.5)]);
        let at = |threshold| simplified_tree(&ladder, threshold);
        let flat = |graph: &Simplified| {
            (0..graph.positions.len() as u32).flat_map(|v| graph.positions.coordinates(v)).copied().collect::<Vec<_>>()
        };
        assert_eq!(flat(&at(0.5)), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 9.0, 0.0, 0.0, 9.0, 2.0, 4.0]);
        let one = at(0.6);
        assert_eq!(
            (flat(&one), &one.image[..]),
            (vec![0.0, 0.0, 1.0, 9.0, 0.0, 0.0, 9.0, 2.0, 4.0], &[1, 0, 0, 2][..]),
            "a bead merges into a tip"
        );
        assert_eq!(one.edges, [[0, 1], [1, 2]]);
        assert_eq!(flat(&at(3.0)), [0.0, 0.0, 1.0, 9.0, 2.0, 4.0]);
        assert_eq!(flat(&at(f64::INFINITY)), [4.5, 1.0, 2.5]);
    }

    /// The half-length that the skeleton has counts, whatever the metric, as long as neither end has moved.
    #[test]
    fn lengths_of_a_skeleton_count_until_an_end_moves() {
        let mut line = Vertices::default();
        [0.0, 12.0, 20.0, 30.0, 40.0].iter().zip(0..).for_each(|(&x, id)| line.push(VertexId(id), &[x]));
        let star = tree(line, &[([0, 2], 0.1), ([1, 2], 1.0), ([2, 3], 1.0), ([3, 4], 3.0)]);
        let first = simplified_tree(&star, 0.5);
        let at = |graph: &Simplified, place| graph.positions.coordinates(place)[0];
        assert_eq!((first.positions.len(), at(&first, 0), at(&first, 1)), (4, 10.0, 12.0));
        assert_eq!(simplified_tree(&star, 2.0).positions.len(), 3, "edges of the vertex that has moved are measured");
    }

    #[test]
    fn of_labels_the_end_of_larger_degree_stays() {
        let star = [([1, 4], 1.0), ([2, 4], 2.0), ([3, 4], 2.5), ([0, 1], 3.0), ([3, 5], 4.0)];
        let star = tree(labels(6), &star);
        let at = |threshold| simplified_tree(&star, threshold);
        let left = at(1.5);
        assert_eq!(left.positions, Positions::Labels(vec![0, 2, 3, 4, 5]));
        assert_eq!(
            (&left.edges[..], &left.image[..]),
            (&[[0, 3], [1, 3], [2, 3], [2, 4]][..], &[0, 3, 1, 2, 3, 4][..])
        );
        assert_eq!(at(2.6).positions, Positions::Labels(vec![0, 3, 5]), "3 and 4 have two neighbours each by then");
        assert_eq!(at(f64::INFINITY).positions, Positions::Labels(vec![3]));
        let pair = tree(labels(2), &[([0, 1], 1.0)]);
        assert_eq!(simplified_tree(&pair, 2.0).positions, Positions::Labels(vec![0]), "of equal ends the smaller");
    }

    #[test]
    fn cycles_of_labels_are_kept() {
        let sides: Vec<(Edge, f64)> = (0..9).map(|vertex| ([vertex, vertex + 1], 1.0)).collect();
        let dot = Dot { birth: 1.5, death: f64::INFINITY, edge: [0, 9], killer: Killer::None };
        let ring = Skeleton::with_lengths(labels(10), sides, vec![dot]);
        let triangle = simplified_tree(&ring, f64::INFINITY);
        assert_eq!((triangle.positions.len(), triangle.edges.len()), (3, 3));
    }

    /// Quadratic time would take minutes here.
    #[test]
    fn a_hub_of_many_spokes_is_quick() {
        let spokes = 100_000_u32;
        let mut positions = vec![[-1.0, 0.0]];
        let mut edges = Vec::new();
        for spoke in 0..spokes {
            let y = f64::from(spoke);
            positions.push([0.0, y / f64::from(spokes)]);
            edges.push([0, 1 + spoke]);
            edges.push([1 + spoke, 1 + spokes + spoke]);
        }
        positions.extend((0..spokes).map(|spoke| [9.0, f64::from(spoke)]));
        let identity: Vec<u32> = (0..positions.len() as u32).collect();
        edges.sort_unstable();
        let mut graph = Graph::new(positions, edges, Vec::new(), 1.0);
        graph.collapse_short();
        let star = graph.simplified(&identity);
        assert_eq!(star.positions.planar()[0], [-1.0, 0.0]);
        assert_eq!((star.positions.len(), star.edges.len()), (1 + spokes as usize, spokes as usize));
        assert!(star.edges.iter().all(|edge| edge[0] == 0));
    }

    #[test]
    fn a_long_path_is_quick() {
        let count = 100_000_u32;
        let positions: Points = (0..count).map(|index| [f64::from(index), f64::from(index % 7) / 10.0]).collect();
        let identity: Vec<u32> = (0..count).collect();
        let edges = (1..count).map(|index| [index - 1, index]).collect();
        let mut graph = Graph::new(positions, edges, Vec::new(), f64::INFINITY);
        graph.collapse_short();
        let point = graph.simplified(&identity);
        assert_eq!((point.positions.len(), point.edges.len()), (1, 0));
        assert!(point.image.iter().all(|&place| place == 0));
    }

    fn components(graph: &Simplified) -> usize {
        let mut of: Vec<usize> = (0..graph.positions.len()).collect();
        let mut count = of.len();
        for edge in &graph.edges {
            let [a, b] = edge.map(|vertex| of[vertex as usize]);
            if a != b {
                of.iter_mut().filter(|component| **component == b).for_each(|component| *component = a);
                count -= 1;
            }
        }
        count
    }

    fn cycles(graph: &Simplified) -> usize {
        graph.edges.len() + components(graph) - graph.positions.len()
    }

    fn share_a_neighbour(edges: &[Edge], [a, b]: Edge) -> bool {
        let neighbours = |vertex: u32| -> Vec<u32> {
            let around = edges.iter().filter(|edge| edge.contains(&vertex));
            around.map(|&[a, b]| if a == vertex { b } else { a }).collect()
        };
        neighbours(a).iter().any(|neighbour| neighbours(b).contains(neighbour))
    }

    /// The definition, word by word: every edge is measured again for each collapse.
    fn by_definition(mut positions: Points, mut edges: Vec<Edge>, threshold: f64) -> (Points, Vec<Edge>) {
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        let mut is_left = vec![true; positions.len()];
        loop {
            let at = |vertex: u32| positions[vertex as usize];
            let key = |&[a, b]: &Edge| {
                let mut ends = [at(a), at(b)];
                ends.sort_by(Point::compare);
                (quarter_square(at(a), at(b)), ends)
            };
            let compare = |e: &&Edge, f: &&Edge| key(e).partial_cmp(&key(f)).unwrap();
            let short =
                edges.iter().filter(|edge| key(edge).0.sqrt() < threshold && !share_a_neighbour(&edges, **edge));
            let Some(&[a, b]) = short.min_by(compare) else { break };
            let is_passed = |vertex: u32| edges.iter().filter(|edge| edge.contains(&vertex)).count() == 2;
            positions[a as usize] = match [is_passed(a), is_passed(b)] {
                [true, false] => at(b),
                [false, true] => at(a),
                _ => [at(a)[0].midpoint(at(b)[0]), at(a)[1].midpoint(at(b)[1])],
            };
            is_left[b as usize] = false;
            edges.iter_mut().flatten().filter(|end| **end == b).for_each(|end| *end = a);
            edges.retain(|[a, b]| a != b);
        }
        let ends = |edge: Edge| edge.map(|vertex| positions[vertex as usize]);
        let mut lines: Vec<[Point; 2]> = edges.iter().copied().map(ends).collect();
        lines.iter_mut().for_each(|line| line.sort_by(Point::compare));
        lines.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut order: Vec<u32> = (0..positions.len() as u32).filter(|&vertex| is_left[vertex as usize]).collect();
        order.sort_by(|&a, &b| Point::compare(&positions[a as usize], &positions[b as usize]));
        let place = |vertex: u32| order.iter().position(|&other| other == vertex).unwrap() as u32;
        let mut edges: Vec<Edge> = edges.iter().map(|edge| edge.map(place)).collect();
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        (order.iter().map(|&vertex| positions[vertex as usize]).collect(), edges)
    }

    fn specs() -> impl Strategy<Value = ViewSpec> {
        prop_oneof![
            Just(ViewSpec::Full),
            Just(ViewSpec::default()),
            (0.0..3.0).prop_map(|alpha| ViewSpec::Reduced { alpha }),
        ]
    }

    fn thresholds() -> impl Strategy<Value = f64> {
        prop_oneof![0.0..0.3, 0.3..3.0, Just(0.5), Just(0.51), Just(f64::INFINITY), Just(f64::NAN)]
    }

    proptest! {
        #[test]
        fn topology_is_kept(points in clouds(), spec in specs(), threshold in thresholds()) {
            let skeleton = skeleton_of(&points);
            let view = View::new(&skeleton, spec);
            let simple = simplify(&skeleton, &view, threshold);
            prop_assert_eq!((cycles(&simple), components(&simple)), (view.cycles, view.components));
            prop_assert!(simple.edges.iter().all(|[a, b]| a < b), "no loops, the smaller end first");
            prop_assert!(simple.edges.is_sorted_by(|a, b| a < b), "in order, and no parallel edges");
            prop_assert!(simple.positions.planar().is_sorted());
            for &edge in &simple.edges {
                let [p, q] = edge.map(|vertex| simple.positions.planar()[vertex as usize]);
                let short = quarter_square(p, q).sqrt() < threshold;
                prop_assert!(!short || share_a_neighbour(&simple.edges, edge), "{edge:?} is left at {threshold}");
            }
        }

        #[test]
        fn images_of_edges_are_the_simplified_edges(points in clouds(), spec in specs(), threshold in thresholds()) {
            let skeleton = skeleton_of(&points);
            let view = View::new(&skeleton, spec);
            let simple = simplify(&skeleton, &view, threshold);
            prop_assert_eq!(simple.image.len(), skeleton.vertices().len());
            let edges = view.tree.iter().copied().chain(view.critical_edges(&skeleton));
            let mut left: Vec<Edge> = edges.map(|edge| edge.map(|vertex| simple.image[vertex as usize])).collect();
            left.retain(|[a, b]| a != b);
            left.iter_mut().for_each(|edge| edge.sort_unstable());
            left.sort_unstable();
            prop_assert_eq!(left, simple.edges);
        }

        #[test]
        fn oracle_is_the_definition(points in clouds(), spec in specs(), threshold in thresholds()) {
            let skeleton = skeleton_of(&points);
            let view = View::new(&skeleton, spec);
            let simple = simplify(&skeleton, &view, threshold);
            let mut positions: Points = skeleton.vertices().positions().collect();
            let place_of: Vec<Point> = positions.clone();
            positions.sort_by(Point::compare);
            let rank = |vertex: u32| positions.iter().position(|p| *p == place_of[vertex as usize]).unwrap() as u32;
            let edges = view.tree.iter().copied().chain(view.critical_edges(&skeleton)).map(|edge| edge.map(rank));
            let expected = by_definition(positions.clone(), edges.collect(), threshold);
            prop_assert_eq!((simple.positions.planar(), simple.edges), (&expected.0[..], expected.1));
        }

        #[test]
        fn numbering_does_not_matter((points, shuffled) in clouds_twice(), spec in specs(), threshold in thresholds()) {
            let [a, b] = [points, shuffled].map(|points| simplified(&points, spec, threshold));
            prop_assert_eq!((a.positions, a.edges), (b.positions, b.edges));
        }
    }
}
