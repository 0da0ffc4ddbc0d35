//! Theorem 9 by brute force: at every scale, no graph with the components and the cycles of the union of discs is
//! shorter than HoPeS(C; alpha).
//!
//! The union of discs of radius alpha is represented by its nerve: an edge where two discs meet, a triangle where three
//! do. A graph of such edges has the topology of the union if it has as many components and its cycles span H1 = Z1 /
//! B1 of the nerve, over GF(2). For at most seven points all 2^21 graphs are tried.

mod common;

use common::clouds::{Placement, Point, cases, distinct};
use common::naive::{circumradius, half_length, scalar_product};
use common::skeleton_of;
use hopes::topology::{Skeleton, View, ViewSpec};
use proptest::prelude::*;

/// A set of edges of a graph on few points, one bit for each.
type Edges = u32;

/// The union of discs of one radius.
struct Discs {
    points: usize,
    /// Pairs that meet, by indices of points.
    edges: Vec<[usize; 2]>,
    lengths: Vec<f64>,
    /// A basis of the boundaries of triples that meet.
    boundaries: Span,
}

impl Discs {
    fn new(points: &[Point], alpha: f64) -> Self {
        let n = points.len();
        let pairs = || (0..n).flat_map(move |a| (a + 1..n).map(move |b| [a, b]));
        let at = |pair: [usize; 2]| pair.map(|p| points[p]);
        let edges: Vec<[usize; 2]> = pairs().filter(|&pair| half_length(at(pair)) <= alpha).collect();
        let bit = |pair: [usize; 2]| edges.iter().position(|&edge| edge == pair).map(|place| 1 << place);
        let mut boundaries = Span::default();
        for [a, b] in pairs() {
            for c in b + 1..n {
                if meeting_radius([a, b, c].map(|p| points[p])) <= alpha {
                    let sides = [[a, b], [b, c], [a, c]].map(|side| bit(side).expect("three discs meet, so two do"));
                    boundaries.add(sides.iter().fold(0, |sum, side| sum ^ side));
                }
            }
        }
        let lengths = edges.iter().map(|&edge| 2.0 * half_length(at(edge))).collect();
        Self { points: n, edges, lengths, boundaries }
    }

    fn all(&self) -> Edges {
        (1 << self.edges.len()) - 1
    }

    /// Components of a graph, and its fundamental cycles.
    fn components_and_cycles(&self, graph: Edges) -> (usize, Vec<Edges>) {
        // Of each point: its component, and the path to the first point of the component.
        let mut label: [usize; 7] = std::array::from_fn(|point| point);
        let mut path: [Edges; 7] = [0; 7];
        let (mut components, mut cycles) = (self.points, Vec::new());
        for (place, &[a, b]) in self.edges.iter().enumerate().filter(|(place, _)| graph >> place & 1 == 1) {
            let closed = path[a] ^ path[b] ^ 1 << place;
            let [keep, give] = [label[a], label[b]];
            if keep == give {
                cycles.push(closed);
                continue;
            }
            components -= 1;
            for point in (0..self.points).filter(|&point| label[point] == give) {
                path[point] ^= closed;
            }
            label.iter_mut().filter(|label| **label == give).for_each(|label| *label = keep);
        }
        (components, cycles)
    }

    /// The rank of a graph's cycles in H1.
    fn rank(&self, cycles: &[Edges]) -> usize {
        let mut span = self.boundaries.clone();
        cycles.iter().filter(|&&cycle| span.add(cycle)).count()
    }

    fn length(&self, graph: Edges) -> f64 {
        self.lengths.iter().enumerate().filter(|(place, _)| graph >> place & 1 == 1).map(|(_, length)| length).sum()
    }

    /// Lengths of all graphs.
    fn lengths_of_all(&self) -> Vec<f64> {
        let mut lengths = Vec::with_capacity(1 << self.edges.len());
        lengths.push(0.0);
        for length in &self.lengths {
            for graph in 0..lengths.len() {
                lengths.push(lengths[graph] + length);
            }
        }
        lengths
    }
}

/// The radius at which three discs have a common point. It is the radius of the smallest disc around their centres.
fn meeting_radius([a, b, c]: [Point; 3]) -> f64 {
    let sides = [(a, [b, c]), (b, [a, c]), (c, [a, b])];
    let across = sides.into_iter().find(|&(apex, side)| scalar_product(apex, side) <= 0.0);
    across.map_or_else(|| circumradius([a, b, c]), |(_, side)| half_length(side))
}

/// A vector space over GF(2) with a basis of different leading bits.
#[derive(Clone, Default)]
struct Span {
    basis: [Edges; 32],
}

impl Span {
    /// Adds a vector. Returns whether it was not in the space before.
    fn add(&mut self, mut vector: Edges) -> bool {
        while vector != 0 {
            let held = &mut self.basis[vector.ilog2() as usize];
            if *held == 0 {
                *held = vector;
                return true;
            }
            vector ^= *held;
        }
        false
    }
}

/// A scale between any two consecutive scales at which a pair or a triple meets, and one beyond.
fn scales(points: &[Point]) -> Vec<f64> {
    let n = points.len();
    let mut scales = vec![0.0];
    for a in 0..n {
        for b in a + 1..n {
            scales.push(half_length([points[a], points[b]]));
            scales.extend((b + 1..n).map(|c| meeting_radius([a, b, c].map(|p| points[p]))));
        }
    }
    scales.sort_by(f64::total_cmp);
    let largest = 2.0 * scales.last().expect("there is scale 0") + 1e-30;
    scales.push(largest);
    let apart = |pair: &&[f64]| pair[1] - pair[0] > 1e-9 * largest;
    scales.windows(2).filter(apart).map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0).filter(|v| v.is_finite()).collect()
}

fn assert_optimal(points: &[Point], skeleton: &Skeleton, alpha: f64) {
    let discs = Discs::new(points, alpha);
    let view = View::new(skeleton, ViewSpec::Reduced { alpha });
    let place = |v: u32| {
        let at = skeleton.vertices().xy(v);
        points.iter().position(|&p| p == at).expect("a point of the cloud")
    };
    let ours = view.tree.iter().copied().chain(view.critical_edges(skeleton)).fold(0, |graph, edge| {
        let mut ends = edge.map(place);
        ends.sort_unstable();
        graph | 1 << discs.edges.iter().position(|&edge| edge == ends).expect("short edges only")
    });

    let (components, all_cycles) = discs.components_and_cycles(discs.all());
    let betti = discs.rank(&all_cycles);
    let (our_components, our_cycles) = discs.components_and_cycles(ours);
    assert_eq!((our_components, view.components), (components, components), "components at {alpha}");
    assert_eq!((our_cycles.len(), view.cycles), (betti, betti), "as many cycles as the union has holes, at {alpha}");
    assert_eq!(discs.rank(&our_cycles), betti, "the cycles go around the holes, at {alpha}");

    let our_length = discs.length(ours);
    let fewest = (points.len() - components + betti) as u32;
    for (graph, length) in (0..).zip(discs.lengths_of_all()) {
        let graph: Edges = graph;
        if length < our_length * (1.0 - 1e-12) && graph.count_ones() >= fewest {
            let (its_components, its_cycles) = discs.components_and_cycles(graph);
            let shows_all = its_components == components && discs.rank(&its_cycles) == betti;
            assert!(!shows_all, "at {alpha}, {graph:b} of {:?} is shorter: {length} < {our_length}", discs.edges);
        }
    }
}

fn assert_optimal_at_all_scales(cloud: &[Point]) -> usize {
    let points = distinct(cloud);
    let skeleton = skeleton_of(&points);
    for alpha in scales(&points) {
        assert_optimal(&points, &skeleton, alpha);
    }
    skeleton.dots().len()
}

/// Few points, mostly on a ring, so that there are holes.
fn tiny_clouds(most: usize) -> impl Strategy<Value = Vec<Point>> {
    let crowded = prop::collection::vec([0..3_i32, 0..3_i32].prop_map(|p| p.map(f64::from)), 0..=most);
    let ring = prop::collection::vec((0.0..std::f64::consts::TAU, 0.8..1.2), 4..=most);
    let ring = ring.prop_map(|points| points.into_iter().map(|(t, r)| [r * t.cos(), r * t.sin()]).collect());
    prop_oneof![
        2 => Placement::Uniform.points(0..=most),
        1 => Placement::Lattice.points(0..=most),
        1 => Placement::Circles(5).points(0..=most),
        2 => crowded,
        3 => ring,
    ]
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn no_shorter_graph_has_the_topology_of_six_points(cloud in tiny_clouds(6)) {
        assert_optimal_at_all_scales(&cloud);
    }
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn no_shorter_graph_has_the_topology_of_seven_points(cloud in tiny_clouds(7)) {
        assert_optimal_at_all_scales(&cloud);
    }
}

/// Two holes of different sizes, and ties everywhere.
#[test]
fn no_shorter_graph_has_two_holes() {
    let two_squares = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [5.0, 0.0], [5.0, 2.0]];
    assert_eq!(assert_optimal_at_all_scales(&two_squares), 2);
    let house = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [2.0, 7.0]];
    assert_eq!(assert_optimal_at_all_scales(&house), 2);
    let hexagon_with_a_centre =
        [[4.0, 0.0], [2.0, 3.5], [-2.0, 3.5], [-4.0, 0.0], [-2.0, -3.5], [2.0, -3.5], [0.5, 0.0]];
    assert!(assert_optimal_at_all_scales(&hexagon_with_a_centre) > 2);
}
