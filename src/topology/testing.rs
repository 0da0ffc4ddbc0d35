//! Shared by unit tests: clouds of every kind, test cases, skeletons from scratch.

use proptest::prelude::*;

use super::{Options, Pipeline, Skeleton, VertexId, Vertices};

/// The points of a cloud; may repeat.
pub(super) type Points = Vec<[f64; 2]>;

/// The skeleton of a cloud from scratch.
pub(super) fn skeleton_of(points: &[[f64; 2]]) -> Skeleton {
    let mut pipeline = Pipeline::new(Options::default());
    assert_eq!(pipeline.feed_points(points, None), []);
    pipeline.commit(None);
    pipeline.poll_frame().expect("a frame was committed").skeleton.clone()
}

/// Vertices without coordinates.
pub(super) fn labels(count: u64) -> Vertices {
    (0..count).map(|id| (VertexId(id), &[][..])).collect()
}

/// The points of a CSV file.
pub(super) fn points_of(csv: &str) -> Points {
    csv.lines().map(|line| line.split_once(',').unwrap()).map(|(x, y)| [x, y].map(|v| v.parse().unwrap())).collect()
}

/// A lattice of unit squares.
pub(super) fn lattice(columns: u32, rows: u32) -> Points {
    (0..columns * rows).map(|index| [f64::from(index % columns), f64::from(index / columns)]).collect()
}

/// Points on a circle around the origin.
pub(super) fn ring(count: u32, radius: f64) -> Points {
    let angle = |index: u32| std::f64::consts::TAU * f64::from(index) / f64::from(count);
    (0..count).map(|index| [radius * angle(index).cos(), radius * angle(index).sin()]).collect()
}

/// Small clouds: scattered, around a ring, and on integers, which makes ties, circles, lines and duplicates.
pub(super) fn clouds() -> impl Strategy<Value = Points> {
    let scattered = (0.0..1.0, 0.0..1.0).prop_map(|(x, y)| [x, y]);
    let around =
        (0.0..std::f64::consts::TAU, 0.8..1.2).prop_map(|(angle, r): (f64, f64)| [r * angle.cos(), r * angle.sin()]);
    let on_grid = |side: i32| (0..side, 0..side).prop_map(|(x, y)| [f64::from(x), f64::from(y)]);
    prop_oneof![
        prop::collection::vec(scattered, 0..60),
        prop::collection::vec(around, 0..60),
        prop::collection::vec(on_grid(5), 0..40),
        prop::collection::vec(on_grid(12), 0..80),
    ]
}

/// A cloud, and the same in another order.
pub(super) fn clouds_twice() -> impl Strategy<Value = (Points, Points)> {
    clouds().prop_flat_map(|points| (Just(points.clone()), Just(points).prop_shuffle()))
}
