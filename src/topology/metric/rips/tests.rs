//! Tests of the sweep: against the textbook, on any number of threads, in a workspace that was used.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use proptest::prelude::*;

use super::*;
use crate::topology::base::on_threads;
use crate::topology::metric::space::{Graph, Matrix, Metric, Points};

/// Numbers from a seed: splitmix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: u64) -> u64 {
        self.bits() % end
    }

    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

const KINDS: u32 = 17;

fn matrix(count: usize, mut distance: impl FnMut(usize, usize) -> f64) -> Matrix {
    let pairs = (0..count).flat_map(|a| (0..a).map(move |b| (a, b)));
    let lower: Vec<f64> = pairs.map(|(a, b)| distance(a, b)).collect();
    Matrix::from_lower(count, &lower).unwrap()
}

fn cloud(metric: Metric, dimension: usize, count: usize, mut coordinate: impl FnMut(usize) -> f64) -> Points {
    let coordinates: Vec<f64> = (0..count * dimension).map(|index| coordinate(index % dimension)).collect();
    Points::new(metric, dimension, &coordinates).unwrap()
}

/// A space of a kind: clouds, lattices, lines, circles, strings, graphs, matrices without any structure.
fn space(kind: u32, count: usize, seed: u64) -> Box<dyn Distances> {
    let mut random = Random(seed);
    match kind {
        0 => Box::new(cloud(Metric::Euclidean, 2, count, |_| random.unit())),
        1 => Box::new(cloud(Metric::Euclidean, 3, count, |_| random.unit())),
        2 => Box::new(cloud(Metric::Euclidean, 20, count, |_| random.unit())),
        3 => Box::new(cloud(Metric::Euclidean, 2, count, |_| random.below(5) as f64)),
        4 => Box::new(cloud(Metric::Manhattan, 3, count, |_| random.below(3) as f64)),
        5 => Box::new(cloud(Metric::Chebyshev, 2, count, |_| random.below(6) as f64)),
        6 => Box::new(cloud(Metric::Angular, 3, count, |_| 1.5 - random.below(4) as f64)),
        7 => Box::new(cloud(Metric::Haversine, 2, count, |axis| [360.0, 180.0][axis] * (random.unit() - 0.5))),
        8 => Box::new(cloud(Metric::Euclidean, 1, count, |_| random.below(60) as f64)),
        9 => {
            let ring: Vec<f64> = (0..count).flat_map(|i| circle(i as f64 / count as f64)).collect();
            Box::new(Points::new(Metric::Euclidean, 2, &ring).unwrap())
        }
        10 => {
            let ring: Vec<f64> = (0..count).flat_map(|_| circle(random.unit())).map(|x| x + 0.01).collect();
            Box::new(Points::new(Metric::Euclidean, 2, &ring).unwrap())
        }
        11 => Box::new(matrix(count, |_, _| 1.0 + random.unit())),
        12 => Box::new(matrix(count, |_, _| [0.0, 1.0, 2.0, f64::INFINITY][random.below(4) as usize])),
        13 => Box::new(matrix(count, |_, _| 1.0)),
        14 => {
            let strings: Vec<u64> = (0..count).map(|_| random.below(64)).collect();
            Box::new(matrix(count, |a, b| f64::from((strings[a] ^ strings[b]).count_ones())))
        }
        15 => Box::new(matrix(count, |a, b| {
            let steps = (a - b).min(count + b - a) as f64;
            if steps > 4.0 { f64::INFINITY } else { steps }
        })),
        _ => {
            let ends = |random: &mut Random| random.below(count as u64) as u32;
            let edges: Vec<(u32, u32, f64)> =
                (0..3 * count).map(|i| (ends(&mut random), ends(&mut random), 1.0 + (i % 9) as f64)).collect();
            let mut edges: Vec<_> = edges.into_iter().map(|(a, b, d)| (a.min(b), a.max(b), d)).collect();
            edges.retain(|&(a, b, _)| a != b);
            edges.sort_by_key(|&(a, b, _)| (a, b));
            edges.dedup_by_key(|&mut (a, b, _)| (a, b));
            Box::new(Graph::new(count, &edges).unwrap())
        }
    }
}

fn circle(turn: f64) -> [f64; 2] {
    [(TAU * turn).cos(), (TAU * turn).sin()]
}

fn check(space: &dyn Distances, limit: f64) {
    let expected = textbook::persistence(space, limit);
    for threads in [1, 2, 3] {
        on_threads(threads, || {
            let mut workspace = Workspace::default();
            assert_eq!(persistence(space, limit, &mut workspace), expected, "{threads} threads");
            assert_eq!(persistence(space, limit, &mut workspace), expected, "again, on {threads} threads");
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1200, ..ProptestConfig::default() })]

    #[test]
    fn tree_births_and_deaths_are_those_of_the_textbook(
        kind in 0..KINDS,
        count in 1..28_usize,
        seed: u64,
        share in 0.0..2.0,
    ) {
        let space = space(kind, count, seed);
        check(&*space, f64::INFINITY);
        if share < 1.0 && space.count() > 1 {
            let last = space.count() as u32 - 1;
            let limit: f64 = share * space.length(0, last);
            if limit.is_finite() {
                check(&*space, limit);
            }
        }
    }

    #[test]
    fn what_a_frame_remembers_changes_nothing(kind in 0..11_u32, count in 20..60_usize, seeds: [u64; 4]) {
        let mut workspace = Workspace::default();
        let mut before = 0;
        for seed in seeds {
            let space = space(kind, count, seed);
            let now = space.count();
            // Some vertices are the same, some are new; which is of no importance.
            let carried: Vec<Option<u32>> = (0..now as u32).map(|v| (v % 3 > 0 && (v as usize) < before).then_some(v)).collect();
            workspace.carry(&carried);
            before = now;
            let expected = persistence(&*space, f64::INFINITY, &mut Workspace::default());
            prop_assert_eq!(persistence(&*space, f64::INFINITY, &mut workspace), expected);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 34, ..ProptestConfig::default() })]

    #[test]
    fn larger_spaces_are_those_of_the_textbook(kind in 0..KINDS, count in 66..90_usize, seed: u64) {
        check(&*space(kind, count, seed), f64::INFINITY);
    }
}

/// The edges of a closed walk that it takes an odd number of times.
fn odd_edges(walk: &[u32]) -> BTreeSet<[u32; 2]> {
    let mut odd = BTreeSet::new();
    for (&u, &v) in walk.iter().zip(walk.iter().cycle().skip(1)).filter(|(u, v)| u != v) {
        let edge = [u.min(v), u.max(v)];
        if !odd.remove(&edge) {
            odd.insert(edge);
        }
    }
    odd
}

/// The path between two vertices in a tree.
fn tree_path(tree: &[Pair], from: u32, to: u32) -> Vec<u32> {
    let mut paths = vec![vec![from]];
    while let Some(path) = paths.pop() {
        let last = path[path.len() - 1];
        if last == to {
            return path;
        }
        let next = tree.iter().filter_map(|edge| match edge.ends() {
            [a, b] if a == last => Some(b),
            [a, b] if b == last => Some(a),
            _ => None,
        });
        paths.extend(next.filter(|next| !path.contains(next)).map(|next| [&path[..], &[next]].concat()));
    }
    panic!("{from} and {to} are in one component");
}

/// A walk of random steps along edges up to a length, closed by the steps back along the tree, so that it is there.
fn closed_walk(space: &dyn Distances, tree: &[Pair], length: f64, random: &mut Random) -> ClosedWalk {
    let count = space.count() as u64;
    let start = random.below(count) as u32;
    let mut vertices = vec![start];
    for _ in 0..random.below(3 * count) {
        let (last, next) = (vertices[vertices.len() - 1], random.below(count) as u32);
        if space.length(last, next) <= length {
            vertices.push(next);
        }
    }
    let back = tree_path(tree, vertices[vertices.len() - 1], start);
    vertices.extend(&back[1..]);
    ClosedWalk { vertices, length }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    #[test]
    fn a_walk_is_the_sum_of_its_births(kind in 0..KINDS, count in 2..24_usize, seed: u64, stops: bool) {
        let space = space(kind, count, seed);
        let count = space.count() as u64;
        let mut random = Random(seed);
        let pick = |random: &mut Random| space.length(random.below(count) as u32, random.below(count) as u32);
        let limit = if stops { pick(&mut random) } else { f64::INFINITY };
        let plain = persistence(&*space, limit, &mut Workspace::default());
        let lengths: Vec<f64> = (0..12).map(|_| pick(&mut random)).filter(|length| length.is_finite()).collect();
        let walks: Vec<ClosedWalk> =
            lengths.iter().map(|&length| closed_walk(&*space, &plain.tree, length.min(limit), &mut random)).collect();
        let (found, classes) = persistence_and_classes(&*space, limit, &walks, &mut Workspace::default());
        prop_assert_eq!(&found, &plain);
        for (walk, class) in walks.iter().zip(classes) {
            let Some(Class { births, .. }) = class else { panic!("{walk:?} is there") };
            let mut cycle = odd_edges(&walk.vertices);
            for birth in births {
                let alive = |&(other, death): &(Pair, Option<Pair>)| {
                    other == birth && death.is_none_or(|death| death.length > walk.length)
                };
                prop_assert!(birth.length <= walk.length && found.critical.iter().any(alive));
                let closed = odd_edges(&tree_path(&found.tree, birth.a, birth.b));
                cycle = cycle.symmetric_difference(&closed).copied().collect();
            }
            prop_assert!(textbook::is_boundary(&*space, walk.length, cycle));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn a_walk_lives_as_long_as_its_dots(kind in 0..KINDS, count in 2..24_usize, seed: u64) {
        let space = space(kind, count, seed);
        let count = space.count() as u64;
        let mut random = Random(seed);
        let pick = |random: &mut Random| space.length(random.below(count) as u32, random.below(count) as u32);
        let plain = persistence(&*space, f64::INFINITY, &mut Workspace::default());
        let mut lengths: Vec<f64> = (0..9).map(|_| pick(&mut random)).filter(|length| length.is_finite()).collect();
        lengths.sort_by(f64::total_cmp);
        let Some(&first) = lengths.first() else { return Ok(()) };
        let ClosedWalk { vertices, .. } = closed_walk(&*space, &plain.tree, first, &mut random);
        let walks: Vec<ClosedWalk> =
            lengths.iter().map(|&length| ClosedWalk { vertices: vertices.clone(), length }).collect();
        let (_, classes) = persistence_and_classes(&*space, f64::INFINITY, &walks, &mut Workspace::default());
        let mut left = classes[0].clone().expect("it is there").dots;
        for (walk, class) in walks.iter().zip(classes) {
            let class = class.expect("it is there");
            let death = |dot: &Pair| plain.critical.iter().find(|(birth, _)| birth == dot).expect("it is a dot").1;
            left.retain(|dot| death(dot).is_none_or(|death| death.length > walk.length));
            prop_assert_eq!(&class.dots, &left);
            prop_assert_eq!(class.births.is_empty(), left.is_empty());
        }
    }
}

#[test]
fn walks_with_long_steps_have_no_class() {
    let square = Points::new(Metric::Euclidean, 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    let walk = |vertices: &[u32], length| ClosedWalk { vertices: vertices.to_vec(), length };
    let walks = [
        walk(&[0, 1, 3, 2], 1.0),
        walk(&[0, 1, 3, 2], 0.9),
        walk(&[0, 1, 2], 1.5),
        walk(&[0, 1, 3, 2], 2.0),
        walk(&[0, 1, 3, 2, 2, 0, 1, 3, 2, 0], 1.0),
        walk(&[], 0.0),
        walk(&[3], 0.0),
    ];
    let of = |limit| persistence_and_classes(&square, limit, &walks, &mut Workspace::default()).1;
    let birth = vec![Pair::new(1.0, 2, 3)];
    let (one, zero) = (Some(Class { births: birth.clone(), dots: birth }), Some(Class::default()));
    assert_eq!(of(f64::INFINITY), [&one, &None, &None, &zero, &zero, &zero, &zero].map(Clone::clone));
    assert_eq!(of(1.5), [&one, &None, &None, &one, &zero, &zero, &zero].map(Clone::clone));
    assert_eq!(of(0.5), [&None, &None, &None, &None, &None, &zero, &zero].map(Clone::clone));
}

#[test]
fn the_square_and_the_hexagon() {
    let square = Points::new(Metric::Euclidean, 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]).unwrap();
    let found = persistence(&square, f64::INFINITY, &mut Workspace::default());
    assert_eq!(found.tree.len(), 3);
    let [(birth, Some(death))] = found.critical[..] else { panic!("{found:?}") };
    assert_eq!((birth, death), (Pair::new(1.0, 2, 3), Pair::new(2.0, 0, 3)));
    let stopped = persistence(&square, 1.5, &mut Workspace::default());
    assert_eq!(stopped.critical, [(Pair::new(1.0, 2, 3), None)]);
    let none = persistence(&square, 0.5, &mut Workspace::default());
    assert_eq!(none, Persistence::default());
}
