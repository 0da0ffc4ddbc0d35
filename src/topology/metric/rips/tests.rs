//! Tests of the sweep: against the textbook, on any number of threads, in a workspace that was used.

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
