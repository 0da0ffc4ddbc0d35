//! Live clouds: many frames of small changes, in tiles of a few vertices. Each frame is compared with recomputation
//! from scratch.

mod common;

use std::num::NonZeroU64;

use common::random::Random;
use hopes::topology::{Follower, Options, Pipeline, Snapshot, Step, ViewSpec, Window};

type Point = [f64; 2];

/// A stream with a window of points, with small tiles, and a view that is followed.
struct Live {
    pipeline: Pipeline,
    follower: Follower,
}

impl Live {
    fn new(points: u64, leaf: usize) -> Self {
        let window = Window::Points(NonZeroU64::new(points).expect("not zero"));
        let pipeline = Pipeline::new(Options { window, ..Options::default() }).with_leaf(leaf);
        Self { pipeline, follower: Follower::new(ViewSpec::default()) }
    }

    fn step(&mut self, points: &[Point]) -> Step {
        self.pipeline.feed_points(points, None);
        self.pipeline.commit(None);
        self.pipeline.poll_step(&mut self.follower).expect("a frame was committed")
    }

    #[track_caller]
    fn check(&mut self) {
        assert_eq!(self.pipeline.check(&self.follower), Ok(()));
        self.pipeline.check_invariants();
    }
}

/// Frames of a few points each. `at` makes a point from its number.
fn frames(count: usize, size: usize, mut at: impl FnMut(usize) -> Point) -> impl Iterator<Item = Vec<Point>> {
    (0..count).map(move |frame| (0..size).map(|index| at(frame * size + index)).collect())
}

#[track_caller]
fn run(window: u64, leaf: usize, frames: impl Iterator<Item = Vec<Point>>) -> Live {
    let mut live = Live::new(window, leaf);
    let (mut in_tiles, mut all) = (0, 0);
    for frame in frames {
        live.step(&frame);
        live.check();
        in_tiles += usize::from(live.pipeline.tiles_reduced() > 0);
        all += 1;
    }
    assert!(3 * in_tiles > all, "only {in_tiles} of {all} frames were followed in tiles");
    live
}

#[test]
fn tiles_follow_a_moving_cloud() {
    let mut random = Random::new(1);
    let live = run(400, 4, frames(600, 10, |number| [random.unit() + number as f64 * 0.02, random.unit()]));
    assert!(live.pipeline.tile_depth() <= 14, "{} levels of tiles for 400 vertices", live.pipeline.tile_depth());
}

#[test]
fn a_cloud_that_gathers_in_a_point_and_spreads_again() {
    let mut random = Random::new(2);
    let size = |number: usize| (-8.0 * (number as f64 / 1000.0).sin()).exp();
    let live = run(300, 3, frames(500, 8, |number| [random.unit() * size(number), random.unit() * size(number)]));
    assert!(live.pipeline.tile_depth() <= 16, "{} levels", live.pipeline.tile_depth());
}

#[test]
fn points_on_a_growing_lattice() {
    let mut random = Random::new(3);
    let side = |number: usize| 4.0 + (number / 500) as f64;
    run(250, 4, frames(400, 10, |number| [0, 1].map(|_| (random.unit() * side(number)).floor())));
}

#[test]
fn some_points_leave_a_line() {
    let mut random = Random::new(4);
    let off = |number: usize, unit: f64| if number / 300 % 2 == 1 && unit < 0.1 { 3.0 } else { 0.0 };
    run(120, 3, frames(300, 6, |number| [(random.unit() * 500.0).floor(), off(number, random.unit())]));
}

#[test]
fn far_flung_points_among_near_ones() {
    let mut random = Random::new(5);
    run(200, 4, frames(300, 5, |_| [0, 1].map(|_| (random.unit() * 40.0 - 20.0).exp2() * (random.unit() - 0.5))));
}

/// Integer points on few circles. Nearly every triangle shares its circle with others, also in other tiles.
#[test]
fn circles_across_tiles() {
    let circle = common::clouds::circle(65);
    let mut random = Random::new(6);
    run(
        90,
        2,
        frames(500, 4, |_| {
            let [x, y] = circle[(random.unit() * circle.len() as f64) as usize];
            let shift = |unit: f64| (unit * 2.0).floor() * 65.0;
            [f64::from(x) + shift(random.unit()), f64::from(y) + shift(random.unit())]
        }),
    );
}

/// More dots than are sorted: buckets find the widest gaps, and where those are not enough, more dots are sorted.
#[test]
fn gaps_among_many_dots() {
    let mut random = Random::new(7);
    let mut live = Live::new(6_000, 24);
    for frame in frames(60, 300, |_| [random.unit(), random.unit()]) {
        live.step(&frame);
        live.check();
    }
    // All holes become equal.
    let side = 80;
    for frame in frames(30, 300, |number| [(number % side) as f64 / 10.0, (number / side) as f64 / 10.0]) {
        live.step(&frame);
        live.check();
    }
}

/// The result does not depend on the size of tiles or on the number of threads.
#[test]
fn tiles_and_threads_do_not_matter() {
    let said = |leaf: usize, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut random = Random::new(8);
            let mut live = Live::new(4_000, leaf);
            let steps = frames(40, 200, |_| [random.unit(), (random.unit() * 50.0).floor() / 50.0]);
            steps.map(|frame| format!("{:?}", live.step(&frame))).collect::<Vec<_>>()
        })
    };
    let alone = said(64, 1);
    for (leaf, threads) in [(64, 2), (64, 8), (3, 2), (17, 1), (100_000, 2)] {
        assert!(said(leaf, threads) == alone, "leaves of {leaf}, {threads} threads");
    }
}

#[test]
fn a_late_follower_gets_the_whole_view() {
    let mut random = Random::new(9);
    let mut live = run(200, 8, frames(20, 10, |_| [random.unit(), random.unit()]));
    let mut late = Follower::new(ViewSpec::Full);
    let step = live.pipeline.poll_step(&mut late).expect("it knows no frame yet");
    let frame = live.pipeline.poll_frame().expect("no follower was polled yet");
    let whole = Snapshot::new(&frame.skeleton, &frame.view(ViewSpec::Full));
    assert_eq!((step.from, step.number), (0, 20));
    assert_eq!(Snapshot::default().apply(&step.diff), Ok(whole));
    assert_eq!(live.pipeline.poll_step(&mut late), None);
}

/// The largest vertex has no edges of its own, so its tile leaves nothing. The level above must be updated when two
/// halves become such a tile.
#[test]
fn tiles_that_leave_nothing() {
    let column = [
        0.0,
        4.826942858904237,
        2.4658413158642736,
        8.764446789450353,
        5.315734728683405,
        7.860249979203333,
        7.930287812268892,
        9.672140269426258,
        7.897382609343283,
        2.8255147823416715,
        3.0931747845455573,
        1.0829212029441257,
        9.127653530895643,
        7.722426356268858,
        3.8215429598181805,
        9.539926801628026,
        3.870465263552553,
        3.0,
    ];
    let off = [
        [141.75, 229.25],
        [137.25, 221.75],
        [138.0, 223.0],
        [10.5, 10.5],
        [11.25, 11.75],
        [105.0, 168.0],
        [12.0, 13.0],
    ];
    let mut points: Vec<Point> = column.iter().map(|&y| [0.0, y]).collect();
    points.extend(off);
    let mut live =
        Live { pipeline: Pipeline::new(Options::default()).with_leaf(3), follower: Follower::new(ViewSpec::default()) };
    live.step(&points);
    let goings = [&[][..], &[1, 2], &[7, 3, 23], &[18, 20]];
    for going in goings {
        let gone: Vec<Point> = going.iter().map(|&index: &usize| points[index]).collect();
        assert_eq!(live.pipeline.feed_retractions(&gone), []);
        live.step(&[]);
        live.check();
    }
}
