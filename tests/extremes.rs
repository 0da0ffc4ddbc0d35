//! The limits: clouds on which triangulation libraries are slow or wrong, and coordinates at the limits of exact
//! arithmetic.
//!
//! Nothing is timed, but a quadratic algorithm would take minutes here.

mod common;

use std::num::NonZeroU64;

use common::by_position::ByPosition;
use common::clouds::{Placement, Point, cases, circle};
use common::skeleton_of;
use hopes::topology::{
    CoordinateError, MAX_COORDINATE, MIN_COORDINATE, Options, Pipeline, Position, Refusal, Skeleton, Window,
};
use proptest::prelude::*;
use proptest::sample::select;

fn stream() -> Pipeline {
    Pipeline::new(Options::default())
}

fn come(pipeline: &mut Pipeline, points: &[Point]) {
    assert_eq!(pipeline.feed_points(points, None), []);
}

fn go(pipeline: &mut Pipeline, points: &[Point]) {
    for &[x, y] in points {
        assert_eq!(pipeline.feed_retraction(x, y), Ok(()));
    }
}

fn frame(pipeline: &mut Pipeline) -> Skeleton {
    pipeline.commit(None);
    let skeleton = pipeline.poll_frame().expect("a frame was committed").skeleton.clone();
    pipeline.check_invariants();
    skeleton
}

/// The numbers of vertices, tree edges and dots.
fn counts(skeleton: &Skeleton) -> (usize, usize, usize) {
    (skeleton.vertices().len(), skeleton.tree().len(), skeleton.dots().len())
}

const MANY: usize = 100_000;

fn line(places: std::ops::Range<usize>) -> Vec<Point> {
    places.map(|i| [i as f64, 2.0 * i as f64]).collect()
}

#[test]
fn a_hundred_thousand_points_on_a_line_in_one_batch_and_in_small_steps() {
    let mut pipeline = stream();
    come(&mut pipeline, &line(0..MANY));
    assert_eq!(counts(&frame(&mut pipeline)), (MANY, MANY - 1, 0));
    for step in 0..10 {
        let from = MANY + 10 * step;
        come(&mut pipeline, &line(from..from + 10));
        go(&mut pipeline, &line(10 * step..10 * (step + 1)));
        assert_eq!(counts(&frame(&mut pipeline)), (MANY, MANY - 1, 0));
    }
}

/// One point beside the line, in its middle or far beyond its ends, nearest or farthest of all; then back.
#[test]
fn a_cloud_of_a_hundred_thousand_points_leaves_a_line_and_returns_to_it() {
    let mut pipeline = stream();
    come(&mut pipeline, &line(0..MANY));
    frame(&mut pipeline);
    let middle = MANY as f64 / 2.0;
    for off in [[middle, 2.0 * middle + 1.0], [-3.0 * MANY as f64, 0.0], [0.0, 1e9], [1.0, -1.0]] {
        come(&mut pipeline, &[off]);
        assert_eq!(counts(&frame(&mut pipeline)).1, MANY);
        // More points on the line, then another point beside it.
        come(&mut pipeline, &line(MANY..MANY + 1));
        assert_eq!(counts(&frame(&mut pipeline)).1, MANY + 1);
        come(&mut pipeline, &[[off[0] + 0.5, off[1]]]);
        assert_eq!(counts(&frame(&mut pipeline)).1, MANY + 2);
        go(&mut pipeline, &[[off[0] + 0.5, off[1]]]);
        go(&mut pipeline, &line(MANY..MANY + 1));
        assert_eq!(counts(&frame(&mut pipeline)).1, MANY);
        go(&mut pipeline, &[off]);
        assert_eq!(counts(&frame(&mut pipeline)), (MANY, MANY - 1, 0));
    }
}

/// A window that slides along a line.
#[test]
fn a_window_slides_along_a_line() {
    let size = 20_000;
    let window = Window::Points(NonZeroU64::new(size as u64).expect("not empty"));
    let mut pipeline = Pipeline::new(Options { window, ..Options::default() });
    come(&mut pipeline, &line(0..size));
    frame(&mut pipeline);
    for step in 0..50 {
        let from = size + 100 * step;
        come(&mut pipeline, &line(from..from + 100));
        assert_eq!(counts(&frame(&mut pipeline)), (size, size - 1, 0));
    }
}

/// Clouds for which spade's bulk loading takes minutes, and batches for which ordered insertion takes minutes.
#[test]
fn fifty_thousand_points_on_few_lines() {
    let (count, size) = (50_000, 50_000.0);
    let cross = |i: f64| if i % 2.0 == 0.0 { [i - size / 2.0, 0.0] } else { [0.0, i - size / 2.0] };
    let parallel = |i: f64| [(i / 2.0).floor(), i % 2.0];
    let bent = |i: f64| if i % 2.0 == 0.0 { [i, 0.0] } else { [0.0, i] };
    let shapes: [&dyn Fn(f64) -> Point; 3] = [&cross, &parallel, &bent];
    for shape in shapes {
        let mut pipeline = stream();
        come(&mut pipeline, &(0..count).map(|i| shape(i as f64)).collect::<Vec<_>>());
        assert_eq!(counts(&frame(&mut pipeline)).1, count - 1);
        let far: Vec<Point> = (0..count / 5).map(|i| [5.0 * i as f64, 2.0 * size]).collect();
        come(&mut pipeline, &far);
        assert_eq!(counts(&frame(&mut pipeline)).1, count + far.len() - 1);
        go(&mut pipeline, &far);
        assert_eq!(counts(&frame(&mut pipeline)).1, count - 1);
    }
}

/// Points around a hub, so close to a circle that all are its neighbours.
fn rim(size: usize) -> Vec<Point> {
    (0..size).map(|i| (i as f64 / size as f64 * std::f64::consts::TAU).sin_cos()).map(|(sin, cos)| [cos, sin]).collect()
}

#[test]
fn a_hub_with_twenty_thousand_neighbours_is_inserted_and_removed() {
    let mut pipeline = stream();
    let rim = rim(20_000);
    come(&mut pipeline, &rim);
    let hollow = frame(&mut pipeline);
    assert_eq!(counts(&hollow), (20_000, 19_999, 1), "a circle has one hole");
    for hub in [[0.0, 0.0], [1e-3, 2e-3]] {
        come(&mut pipeline, &[hub]);
        let filled = frame(&mut pipeline);
        assert_eq!(counts(&filled).1, 20_000);
        assert!(filled.largest_death() < 0.6, "the hub fills the hole");
        go(&mut pipeline, &[hub]);
        ByPosition::of(&frame(&mut pipeline)).assert_same(&ByPosition::of(&hollow));
    }
}

/// Hubs that are small enough to be removed vertex by vertex.
#[test]
fn many_hubs_are_inserted_and_removed() {
    let mut pipeline = stream();
    let wheels = 20;
    let at = |wheel: usize| 10.0 * wheel as f64;
    for wheel in 0..wheels {
        let moved: Vec<Point> = rim(500).iter().map(|&[x, y]| [x + at(wheel), y]).collect();
        come(&mut pipeline, &moved);
    }
    let hubs: Vec<Point> = (0..wheels).map(|wheel| [at(wheel), 0.0]).collect();
    let hollow = frame(&mut pipeline);
    for _ in 0..3 {
        come(&mut pipeline, &hubs);
        frame(&mut pipeline);
        go(&mut pipeline, &hubs[..5]);
        frame(&mut pipeline);
        go(&mut pipeline, &hubs[5..]);
        ByPosition::of(&frame(&mut pipeline)).assert_same(&ByPosition::of(&hollow));
    }
}

#[test]
fn clouds_of_no_one_two_and_three_points() {
    let triangle = [[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]];
    for (size, want) in [(0, (0, 0, 0)), (1, (1, 0, 0)), (2, (2, 1, 0)), (3, (3, 2, 1))] {
        let mut pipeline = stream();
        come(&mut pipeline, &triangle[..size]);
        assert_eq!(counts(&frame(&mut pipeline)), want);
        // From more points down to these numbers.
        let more = [[10.0, 0.0], [10.0, 7.0], [-3.0, 5.0], [0.5, -9.0]];
        come(&mut pipeline, &more);
        frame(&mut pipeline);
        go(&mut pipeline, &more);
        assert_eq!(counts(&frame(&mut pipeline)), want);
    }
}

#[test]
fn a_refilled_cloud_equals_a_new_one() {
    let clouds = [rim(300), line(0..300), circle(65).into_iter().map(|p| p.map(f64::from)).collect(), rim(7)];
    let mut pipeline = stream();
    for cloud in clouds.iter().cycle().take(12) {
        come(&mut pipeline, cloud);
        ByPosition::of(&frame(&mut pipeline)).assert_same(&ByPosition::of(&skeleton_of(cloud)));
        go(&mut pipeline, cloud);
        assert_eq!(counts(&frame(&mut pipeline)), (0, 0, 0));
    }
}

/// A commit without a change gives a frame equal to the previous one.
#[test]
fn idle_commits_repeat_the_frame() {
    let mut pipeline = stream();
    assert_eq!(counts(&frame(&mut pipeline)), (0, 0, 0));
    assert!(pipeline.poll_frame().is_none(), "a frame is given once");
    come(&mut pipeline, &rim(50));
    let first = frame(&mut pipeline);
    assert_eq!(frame(&mut pipeline), first);
}

#[test]
fn integer_clouds_scale_to_both_limits() {
    let cloud: Vec<Point> = circle(65).into_iter().chain(circle(25)).map(|p| p.map(f64::from)).collect();
    let want = ByPosition::of(&skeleton_of(&cloud));
    // 65 is just above 2^6. Coordinates are 0 and 1 to 65 times the scale.
    for scale in [MIN_COORDINATE, 2f64.powi(-100), 2f64.powi(194)] {
        let scaled: Vec<Point> = cloud.iter().map(|p| p.map(|v| v * scale)).collect();
        let ours = ByPosition::of(&skeleton_of(&scaled));
        assert_eq!(ours.tree.len(), want.tree.len());
        let labels = |skeleton: &ByPosition, scale: f64| {
            skeleton.dots.iter().map(|dot| [dot.birth * scale, dot.death * scale]).collect::<Vec<_>>()
        };
        assert_eq!(labels(&ours, 1.0), labels(&want, scale), "scale {scale:e}");
    }
}

/// All magnitudes in one cloud. Some slivers have a radius that no double can hold.
fn extreme_points() -> impl Strategy<Value = Vec<Point>> {
    let extreme = select(vec![0.0, MIN_COORDINATE, -MIN_COORDINATE, 1.0, 1.5, -1.0, MAX_COORDINATE, -MAX_COORDINATE]);
    let any = (any::<bool>(), -142..=200_i32, 0..4_i32)
        .prop_map(|(negative, exponent, quarters)| {
            let magnitude = (1.0 + f64::from(quarters) / 4.0) * 2f64.powi(exponent);
            if negative { -magnitude } else { magnitude }
        })
        .boxed();
    let coordinate = prop_oneof![2 => extreme, 1 => any];
    prop::collection::vec([coordinate.clone(), coordinate], 0..60)
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_limits_of_coordinates_are_valid(points in extreme_points()) {
        let skeleton = skeleton_of(&points);
        prop_assert_eq!(skeleton.tree().len(), skeleton.vertices().len().saturating_sub(1));
        for dot in skeleton.dots() {
            prop_assert!(dot.birth > 0.0 && dot.birth < dot.death && dot.death < f64::INFINITY, "{:?}", dot);
        }
        let reversed: Vec<Point> = points.iter().copied().rev().collect();
        ByPosition::of(&skeleton_of(&reversed)).assert_same(&ByPosition::of(&skeleton));
    }

    /// The limits are those of the triangulation library.
    #[test]
    fn valid_positions_are_those_of_the_triangulation_library(x in any::<u64>().prop_map(f64::from_bits), y in any_exponent()) {
        for value in [x, y] {
            let theirs = spade::validate_coordinate(value);
            let infinite = value.is_infinite();
            prop_assert_eq!(Position::new(value, 0.0).is_ok(), theirs.is_ok(), "{:e}", value);
            prop_assert_eq!(Position::new(0.0, value).is_ok(), theirs.is_ok(), "{:e}", value);
            let ours = match Position::new(value, 1.0) {
                Ok(_) => None,
                Err(CoordinateError::NotFinite { .. }) if infinite => Some(spade::InsertionError::TooLarge),
                Err(CoordinateError::NotFinite { .. }) => Some(spade::InsertionError::NAN),
                Err(CoordinateError::TooLarge { .. }) => Some(spade::InsertionError::TooLarge),
                Err(CoordinateError::TooSmall { .. }) => Some(spade::InsertionError::TooSmall),
            };
            prop_assert_eq!(ours, theirs.err(), "{:e}", value);
        }
    }

    #[test]
    fn invalid_coordinates_are_refused_and_the_rest_is_accepted(
        points in Placement::Uniform.points(1..40),
        bad in prop::collection::vec((any::<prop::sample::Index>(), bad_coordinate(), any::<bool>()), 0..10),
    ) {
        let mut spoilt = points.clone();
        for (index, value, first) in bad {
            index.get_mut(&mut spoilt)[usize::from(!first)] = value;
        }
        let is_bad = |p: &Point| Position::new(p[0], p[1]).is_err();
        let mut pipeline = stream();
        let refused = pipeline.feed_points(&spoilt, None);
        let places: Vec<usize> = (0..spoilt.len()).filter(|&place| is_bad(&spoilt[place])).collect();
        prop_assert_eq!(refused.iter().map(|(place, _)| *place).collect::<Vec<_>>(), places);
        prop_assert!(refused.iter().all(|(_, why)| matches!(why, Refusal::Coordinate(_))));
        let good: Vec<Point> = spoilt.into_iter().filter(|p| !is_bad(p)).collect();
        ByPosition::of(&frame(&mut pipeline)).assert_same(&ByPosition::of(&skeleton_of(&good)));
    }
}

/// Random bits close to the limits.
fn any_exponent() -> impl Strategy<Value = f64> {
    let limit = select(vec![MIN_COORDINATE, MAX_COORDINATE]);
    (limit, -3..=3_i64, any::<bool>()).prop_map(|(limit, ulps, negative)| {
        let near = f64::from_bits(limit.to_bits().wrapping_add_signed(ulps));
        if negative { -near } else { near }
    })
}

fn bad_coordinate() -> impl Strategy<Value = f64> {
    select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e61, -1e300, 1e-43, -f64::MIN_POSITIVE, 5e-324])
}

#[test]
fn event_times_that_are_not_finite_are_refused() {
    let size = NonZeroU64::new(5).expect("not 0");
    for window in [Window::All, Window::Points(size), Window::Frames(size), Window::Time(2.0)] {
        for known in [None, Some(7.0)] {
            let mut pipeline = Pipeline::new(Options { window, ..Options::default() });
            if let Some(time) = known {
                assert_eq!(pipeline.feed_point(1.0, 2.0, Some(time)).map(drop), Ok(()));
            }
            let before = pipeline.point_count();
            for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let refusal = pipeline.feed_point(0.0, 0.0, Some(time)).expect_err("no time");
                assert!(matches!(refusal, Refusal::TimeNotFinite(_)), "{window:?}: {refusal}");
                let refusal = pipeline.feed_time(time).expect_err("no time");
                assert!(matches!(refusal, Refusal::TimeNotFinite(_)), "{window:?}: {refusal}");
            }
            assert_eq!(pipeline.point_count(), before);
        }
    }
}

#[test]
fn a_time_window_refuses_points_without_time_and_late_points() {
    let mut pipeline = Pipeline::new(Options { window: Window::Time(2.0), ..Options::default() });
    assert_eq!(pipeline.feed_point(0.0, 0.0, None), Err(Refusal::NoTime));
    assert_eq!(pipeline.feed_point(0.0, 0.0, Some(10.0)).map(drop), Ok(()));
    assert_eq!(pipeline.feed_point(1.0, 0.0, None).map(drop), Ok(()), "as of the newest time");
    assert_eq!(pipeline.feed_point(2.0, 0.0, Some(8.0)).map(drop), Ok(()), "just in time");
    assert_eq!(pipeline.feed_point(3.0, 0.0, Some(7.5)), Err(Refusal::TooLate { time: 7.5, oldest: 8.0 }));
    assert_eq!(counts(&frame(&mut pipeline)), (3, 2, 0));
    assert_eq!(pipeline.feed_time(10.5), Ok(()));
    assert_eq!(counts(&frame(&mut pipeline)), (2, 1, 0));
}
