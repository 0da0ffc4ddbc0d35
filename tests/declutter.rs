//! What the filter of outliers keeps: the holes of five scenes under uniform clutter and under clumps, and the points
//! of scenes without clutter.
//!
//! A hole is kept if its persistence is between 80% and 125% of that without clutter. The bounds are those that the
//! filter promises; the figures themselves are in `benches/README.md`, and are printed by `--nocapture`.

mod common;

use std::f64::consts::TAU;

use common::random::Random;
use hopes::topology::{Declutter, Frame, Options, Pipeline};

type Point = [f64; 2];

/// Clouds of a kind, each with clutter of its own, at each share.
const SEEDS: u64 = 6;

/// Points around holes, each with its centre and its radius.
struct Scene {
    points: Vec<Point>,
    holes: Vec<(Point, f64)>,
}

fn normal(random: &mut Random) -> f64 {
    // Twelve uniform numbers have the variance 1.
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

/// Points of a noisy ring, about evenly spaced, or as dense as `density` says, which is at most 1.
fn ring(random: &mut Random, center: f64, radius: f64, count: u32, density: Option<fn(f64) -> f64>) -> Vec<Point> {
    let turns: Vec<f64> = match density {
        None => (0..count).map(|place| (f64::from(place) + random.unit()) / f64::from(count)).collect(),
        Some(density) => std::iter::repeat_with(|| (random.unit(), random.unit()))
            .filter(|(turn, level)| *level < density(*turn))
            .map(|(turn, _)| turn)
            .take(count as usize)
            .collect(),
    };
    let at = |turn: f64| {
        let (sin, cos) = (turn * TAU).sin_cos();
        let far = radius + 0.03 * normal(random);
        [center + far * cos, far * sin]
    };
    turns.into_iter().map(at).collect()
}

fn rings(random: &mut Random, of: &[(f64, f64, u32)], density: Option<fn(f64) -> f64>) -> Scene {
    let points = of.iter().flat_map(|&(center, radius, count)| ring(random, center, radius, count, density)).collect();
    Scene { points, holes: of.iter().map(|&(center, radius, _)| ([center, 0.0], radius)).collect() }
}

/// Eight rectangles that share their walls.
fn cells(random: &mut Random) -> Scene {
    let (xs, ys) = ([0.0, 2.0, 4.6, 6.3, 8.6], [0.0, 2.2, 4.0]);
    let mut points = Vec::new();
    let mut wall = |from: Point, to: Point, count: u32| {
        for place in 0..count {
            let share = (f64::from(place) + random.unit()) / f64::from(count);
            points.push([0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]) + 0.01 * normal(random)));
        }
    };
    xs.iter().for_each(|&x| wall([x, ys[0]], [x, ys[2]], 80));
    ys.iter().for_each(|&y| wall([xs[0], y], [xs[4], y], 172));
    let holes = xs.windows(2).flat_map(|x| {
        ys.windows(2).map(|y| ([(x[0] + x[1]) / 2.0, (y[0] + y[1]) / 2.0], (x[1] - x[0]).min(y[1] - y[0]) / 2.0))
    });
    Scene { points, holes: holes.collect() }
}

const KINDS: [&str; 5] = ["rings", "sizes", "densities", "cells", "uneven"];

fn scene(kind: &str, random: &mut Random) -> Scene {
    match kind {
        "rings" => rings(random, &[0, 1, 2, 3, 4, 5].map(|place| (4.0 * f64::from(place), 1.0, 150)), None),
        "sizes" => {
            let of = [(0.0, 3.0, 450), (5.0, 1.0, 150), (7.5, 0.5, 75), (9.5, 0.4, 60), (13.0, 2.0, 300)];
            rings(random, &of, None)
        }
        "densities" => {
            let of = [(0.0, 40), (5.0, 80), (10.0, 160), (15.0, 320), (20.0, 640)];
            rings(random, &of.map(|(center, count)| (center, 1.0, count)), None)
        }
        "cells" => cells(random),
        _ => {
            let of = [0, 1, 2, 3, 4, 5].map(|place| (4.0 * f64::from(place), 1.0, 200));
            rings(random, &of, Some(|turn| 0.55 + 0.45 * (turn * TAU).cos()))
        }
    }
}

/// Clutter as a share of the points, in their bounding box and a little around it.
fn clutter(random: &mut Random, points: &[Point], share: f64, is_in_clumps: bool) -> Vec<Point> {
    let count = (share * points.len() as f64).round() as usize;
    let side = |axis: usize| {
        let values = points.iter().map(|point| point[axis]);
        let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
        (low - 0.05 * (high - low), 1.1 * (high - low))
    };
    let sides = [side(0), side(1)];
    let mut clutter: Vec<Point> = Vec::new();
    while clutter.len() < count {
        let at = sides.map(|(low, length)| low + length * random.unit());
        let clump = if is_in_clumps { 2 + (5.0 * random.unit()) as usize } else { 1 };
        let spread = if is_in_clumps { 0.06 } else { 0.0 };
        clutter.extend((0..clump).map(|_| at.map(|v| v + spread * normal(random))));
    }
    clutter.truncate(count);
    clutter
}

fn frame(points: &[Point], declutter: Option<Declutter>) -> std::sync::Arc<Frame> {
    let mut pipeline = Pipeline::new(Options { declutter, ..Options::default() });
    assert!(pipeline.feed_points(points, None).is_empty());
    pipeline.commit(None);
    pipeline.poll_frame().expect("a frame was committed")
}

/// The persistence of the most persistent dot in each hole.
fn persistences(frame: &Frame, holes: &[(Point, f64)]) -> Vec<f64> {
    let found: Vec<(f64, Point)> = (frame.skeleton.dots().iter())
        .filter_map(|dot| Some((dot.persistence(), frame.skeleton.hole(dot)?.center)))
        .collect();
    let most = |&(center, radius): &(Point, f64)| {
        let is_in = |at: Point| (at[0] - center[0]).hypot(at[1] - center[1]) < 0.6 * radius;
        found.iter().filter(|(_, at)| is_in(*at)).map(|(persistence, _)| *persistence).fold(0.0, f64::max)
    };
    holes.iter().map(most).collect()
}

/// The share of holes that are kept, and the largest share of true points that were left out.
fn kept(kind: &str, share: f64, is_in_clumps: bool, rule: Option<Declutter>) -> (f64, f64) {
    let (mut kept, mut holes, mut lost) = (0, 0, 0.0_f64);
    for seed in 0..SEEDS {
        let mut random = Random::new(1000 * seed + (1e4 * share) as u64 + u64::from(is_in_clumps));
        let scene = scene(kind, &mut random);
        let clean = persistences(&frame(&scene.points, None), &scene.holes);
        let clutter = clutter(&mut random, &scene.points, share, is_in_clumps);
        let found = frame(&[&scene.points[..], &clutter].concat(), rule);
        let vertices = found.skeleton.vertices();
        let stay = (0..vertices.len() as u32).filter(|&vertex| scene.points.contains(&vertices.xy(vertex))).count();
        lost = lost.max(1.0 - stay as f64 / scene.points.len() as f64);
        let now = persistences(&found, &scene.holes);
        kept += clean.iter().zip(&now).filter(|(clean, now)| (0.8..=1.25).contains(&(*now / *clean))).count();
        holes += clean.len();
    }
    (f64::from(kept as u32) / f64::from(holes as u32), lost)
}

#[test]
fn holes_are_kept_under_clutter() {
    let rule = Some(Declutter::default());
    for (share, least, without) in [(0.01, 0.95, 0.95), (0.02, 0.9, 0.9), (0.05, 0.9, 0.6), (0.1, 0.85, 0.35)] {
        let of = |rule| KINDS.map(|kind| kept(kind, share, false, rule).0);
        let (filtered, bare) = (of(rule), of(None));
        let mean = |of: [f64; 5]| of[..4].iter().sum::<f64>() / 4.0;
        println!("clutter {share}: {KINDS:?} {filtered:.2?} mean {:.3}, without {bare:.2?}", mean(filtered));
        assert!(mean(filtered) >= least, "{share}: {filtered:?}");
        assert!(mean(bare) <= without, "{share}: the scenes need no filter: {bare:?}");
    }
}

#[test]
fn true_points_stay_where_there_is_no_clutter() {
    for kind in KINDS {
        let (kept, lost) = kept(kind, 0.0, false, Some(Declutter::default()));
        println!("no clutter: {kind} keeps {kept:.2}, loses {lost:.4}");
        let is_even = ["rings", "sizes", "cells"].contains(&kind);
        assert!(lost <= if is_even { 0.0 } else { 0.005 }, "{kind} loses {lost}");
        assert!(kept >= 0.9, "{kind} keeps {kept}");
    }
    let mut random = Random::new(3);
    let uniform: Vec<Point> = (0..3000).map(|_| random.point()).collect();
    let disc: Vec<Point> = uniform.iter().copied().filter(|[x, y]| (x - 0.5).hypot(y - 0.5) < 0.5).collect();
    let lattice: Vec<Point> = (0..900).map(|at| [f64::from(at % 30), f64::from(at / 30)]).collect();
    let line: Vec<Point> = (0..500).map(|at| [f64::from(at), 0.5 * f64::from(at)]).collect();
    for (name, points) in [("uniform", uniform), ("disc", disc), ("lattice", lattice), ("line", line)] {
        let report = frame(&points, Some(Declutter::default())).decluttered.expect("it was asked for");
        assert!(report.filtered * 500 <= points.len(), "{name}: {report:?}");
    }
}

#[test]
fn few_clumps_are_left_out() {
    for share in [0.02, 0.05] {
        let shares = KINDS.map(|kind| kept(kind, share, true, Some(Declutter::default())).0);
        println!("clumps {share}: {KINDS:?} {shares:.2?}");
        assert!(shares.iter().sum::<f64>() / 5.0 >= 0.7, "{share}: {shares:?}");
    }
}
