//! Live clouds with vertices of very high degree, which come, go and move: spirals, fans, combs, rings with hubs, large
//! circles, near lines. Each frame is compared with recomputation from scratch.

mod common;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use common::clouds::{Point, cases, circle, distinct};
use hopes::topology::{Follower, Options, Pipeline, ViewSpec};
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// A cloud without its hubs, and hubs that see most of it.
#[derive(Clone, Debug)]
struct Family {
    cloud: Vec<Point>,
    hubs: Vec<Point>,
}

fn on_circle(turns: f64, radius: f64) -> Point {
    let (sin, cos) = (turns * TAU).sin_cos();
    [radius * cos, radius * sin]
}

const NAMES: [&str; 8] = ["spiral", "turns", "fan", "comb", "ring", "circle", "near line", "line"];

/// A family of `n` points. A hub of most of them has a degree of about `n`.
fn family(name: &str, n: usize) -> Family {
    let share = |i: usize| i as f64 / n as f64;
    let points = |at: &dyn Fn(usize) -> Point| (0..n).map(at).collect::<Vec<_>>();
    let centre = vec![[0.0, 0.0], [0.1, 0.0], [-0.1, 0.05]];
    let (cloud, hubs) = match name {
        "spiral" => (points(&|i| on_circle(0.95 * share(i), 1.0 + 0.3 * share(i))), centre),
        "turns" => (points(&|i| on_circle(5.0 * share(i), 1.0 + share(i))), centre),
        "fan" => (points(&|i| [2.0 * share(i) - 1.0, share(i) * share(i)]), vec![[0.0, -20.0], [0.0, 30.0]]),
        "comb" => (points(&|i| [(i / 9) as f64, (i % 9) as f64]), vec![[5.0, -1e5], [6.0, 1e5]]),
        "ring" => (points(&|i| on_circle(0.618 * i as f64, 1.0 + 1e-7 * share(i))), centre),
        "circle" => {
            let circle = circle(65).into_iter().map(|point| point.map(f64::from));
            (circle.collect(), vec![[0.0, 0.0], [1.0, 0.0], [200.0, 0.0]])
        }
        "near line" => (points(&|i| [i as f64, 1e-9 * (0.618 * i as f64).fract()]), vec![[9.0, 1e9], [9.0, -7.0]]),
        _ => (points(&|i| [i as f64, 0.0]), vec![[9.0, 10.0], [50.0, -3.0]]),
    };
    Family { cloud, hubs }
}

/// A stream in small tiles, and what is in it.
struct Live {
    pipeline: Pipeline,
    follower: Follower,
    points: BTreeMap<[u64; 2], Point>,
}

impl Live {
    fn new(cloud: &[Point]) -> Self {
        let pipeline = Pipeline::new(Options::default()).with_leaf(3);
        let mut live = Self { pipeline, follower: Follower::new(ViewSpec::default()), points: BTreeMap::new() };
        distinct(cloud).into_iter().for_each(|point| live.flip(point));
        live.check();
        live
    }

    /// Retracts a point that is there, or inserts one that is not.
    fn flip(&mut self, point: Point) {
        let key = point.map(f64::to_bits);
        if self.points.remove(&key).is_some() {
            assert_eq!(self.pipeline.feed_retraction(point[0], point[1]), Ok(()));
        } else {
            self.points.insert(key, point);
            self.pipeline.feed_point(point[0], point[1], None).expect("a valid point");
        }
    }

    /// Commits and compares a frame. Returns whether it was followed in tiles.
    fn check(&mut self) -> bool {
        self.pipeline.commit(None);
        self.pipeline.poll_step(&mut self.follower).expect("a frame was committed");
        assert_eq!(self.pipeline.check(&self.follower), Ok(()));
        self.pipeline.check_invariants();
        self.pipeline.tiles_reduced() > 0
    }
}

/// A frame: hubs that come or go, and points of the cloud that do.
type Flips = (Vec<Index>, Vec<Index>);

fn flips() -> impl Strategy<Value = Flips> {
    let few = || prop::collection::vec(any::<Index>(), 0..3);
    (few(), few())
}

proptest! {
    #![proptest_config(cases(120))]

    /// With 40 points hubs are removed step by step, with 200 the triangulation is rebuilt.
    #[test]
    fn hubs_come_and_go(
        (name, n) in (select(&NAMES[..]), select(&[40_usize, 200][..])),
        frames in prop::collection::vec(flips(), 1..12),
    ) {
        let Family { cloud, hubs } = family(name, n);
        let mut live = Live::new(&cloud);
        for (of_hubs, of_cloud) in frames {
            of_hubs.iter().for_each(|index| live.flip(*index.get(&hubs)));
            of_cloud.iter().for_each(|index| live.flip(*index.get(&cloud)));
            live.check();
        }
    }
}

/// The next vertex of high degree is made by the removal of the last one.
#[test]
fn a_spiral_is_eaten_from_its_inner_end() {
    let mut live = Live::new(&family("spiral", 120).cloud);
    for point in family("spiral", 120).cloud.iter().take(100) {
        live.flip(*point);
        live.check();
    }
}

/// Tiles are given up when a removal would take too long, and made again by the next frame.
#[test]
fn tiles_come_back_after_a_removal_in_bulk() {
    let Family { cloud, hubs } = family("spiral", 300);
    let mut live = Live::new(&cloud);
    let frame = |live: &mut Live, point: Point| {
        live.flip(point);
        live.check()
    };
    for _ in 0..3 {
        assert!(frame(&mut live, hubs[0]), "insertions take linear time");
        assert!(!frame(&mut live, hubs[0]), "a removal of degree 285 is no step");
        assert!(frame(&mut live, cloud[150]), "a point amid others has few neighbours");
        assert!(frame(&mut live, cloud[150]));
    }
}
