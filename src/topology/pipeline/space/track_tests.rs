//! Tests of tracks in R^d on the engine: lives, splits, mergers, and what decides nothing.

use std::f64::consts::TAU;
use std::num::{NonZeroU32, NonZeroU64};

use proptest::prelude::*;

use super::*;
use crate::topology::skeleton::ViewSpec;
use crate::topology::testing::clouds;
use crate::topology::tracks::{Changed, EventKind, Remember, SpaceTrack, TrackOptions, TrackRule};

type Cloud3 = Vec<[f64; 3]>;

/// A stream whose frames replace each other, and its tracker.
struct Scene {
    pipeline: SpacePipeline,
    tracker: SpaceTracker,
}

impl Scene {
    fn new(rule: TrackRule) -> Self {
        Self::with(
            SpaceOptions::default(),
            TrackOptions { miss: NonZeroU32::new(3).unwrap(), ..TrackOptions::new(rule) },
        )
    }

    fn with(space: SpaceOptions, options: TrackOptions) -> Self {
        let window = Window::Frames(NonZeroU64::MIN);
        let pipeline = SpacePipeline::new(SpaceOptions { window, ..space }).unwrap();
        Self { pipeline, tracker: SpaceTracker::new(options) }
    }

    fn commit<const D: usize>(&mut self, points: &[[f64; D]]) {
        assert_eq!(self.pipeline.feed_points(points, None), []);
        self.pipeline.commit(None);
    }

    fn show<const D: usize>(&mut self, points: &[[f64; D]]) -> SpaceTrackStep {
        self.commit(points);
        self.pipeline.poll_tracks(&mut self.tracker).expect("a frame was committed")
    }

    /// The events of some equal frames, without updates.
    fn hold(&mut self, frames: usize, points: &[[f64; 3]]) -> Vec<(u64, u64, EventKind)> {
        let steps: Vec<SpaceTrackStep> = (0..frames).map(|_| self.show(points)).collect();
        let events = steps.iter().flat_map(|step| &step.events);
        let news = events.filter(|event| !matches!(event.kind, EventKind::Updated(_)));
        news.map(|event| (event.frame, event.track.id.0, event.kind)).collect()
    }
}

/// A circle in a plane that is parallel to none of the axes, around a centre.
fn ring(count: u32, radius: f64, [x, y, z]: [f64; 3]) -> Cloud3 {
    let angle = |index: u32| TAU * f64::from(index) / f64::from(count);
    let place = |angle: f64| [x + radius * angle.cos(), y + 0.6 * radius * angle.sin(), z + 0.8 * radius * angle.sin()];
    (0..count).map(angle).map(place).collect()
}

/// The boundary of two discs of radii 10 and 8 whose centres are this far apart.
fn pair(apart: f64) -> Cloud3 {
    let outside = |point: &&[f64; 3], center: f64, radius: f64| {
        ((point[0] - center).powi(2) + point[1] * point[1] + point[2] * point[2]).sqrt() > radius
    };
    let (big, small) = (ring(63, 10.0, [0.0; 3]), ring(50, 8.0, [apart, 0.0, 0.0]));
    let big = big.iter().filter(|point| outside(point, apart, 8.0));
    big.chain(small.iter().filter(|point| outside(point, 0.0, 10.0))).copied().collect()
}

const ABOVE: TrackRule = TrackRule::Above(3.0);

#[test]
fn a_ring_is_announced_followed_and_ended() {
    let mut scene = Scene::new(ABOVE);
    let circle = |x: f64| ring(40, 10.0, [x, 5.0, 0.0]);
    assert_eq!(scene.hold(4, &circle(0.0)), [(2, 1, EventKind::Born)]);
    let step = scene.show(&circle(1.0));
    let [event] = &step.events[..] else { panic!("one event: {step:?}") };
    assert_eq!(event.kind, EventKind::Updated(Changed { center: true, birth: false, death: false }));
    let SpaceTrack { age, center, radius, velocity, birth, death, .. } = &event.track;
    let near = |value: f64, expected: f64| (value - expected).abs() < 0.35;
    assert!(near(center[0], 1.0) && near(center[1], 5.0) && near(center[2], 0.0), "{center:?}");
    assert!(near(velocity[0], 0.5) && near(*radius, 10.0) && *age == 5, "{event:?}");
    assert!((birth - 10.0 * (TAU / 80.0).sin()).abs() < 1e-9 && near(*death, 8.66), "{event:?}");
    let cycles = scene.pipeline.track_cycles(&scene.tracker);
    assert!(cycles.len() == 1 && cycles[0].0 == event.track.id && (5..=40).contains(&cycles[0].1.len()), "{cycles:?}");
    assert_eq!(scene.hold(4, &[[0.0; 3]]), [(8, 1, EventKind::Died)]);
    assert_eq!(scene.tracker.alive().count(), 0);
}

#[test]
fn one_frame_is_no_track_and_a_short_gap_ends_none() {
    let mut scene = Scene::new(ABOVE);
    let circle = ring(40, 10.0, [0.0; 3]);
    let flash = [circle.clone(), ring(40, 10.0, [50.0, 0.0, 0.0])].concat();
    assert_eq!(scene.hold(2, &circle).len(), 1);
    assert_eq!(scene.hold(1, &flash), []);
    assert_eq!(scene.hold(2, &[[0.0; 3]]), []);
    assert_eq!(scene.hold(3, &circle), []);
}

#[test]
fn a_ring_that_pinches_keeps_its_id_and_its_part_names_it() {
    let mut scene = Scene::new(ABOVE);
    assert_eq!(scene.hold(3, &pair(14.0)), [(2, 1, EventKind::Born)]);
    let split = EventKind::Split { from: TrackId(1) };
    assert_eq!(scene.hold(4, &pair(17.9)), [(5, 2, split)]);
    let [big, small] = [1, 2].map(|id| scene.tracker.alive().find(|track| track.id == TrackId(id)).unwrap().clone());
    assert!(big.death > small.death && small.center[0] > 14.0 && big.center[0] < 4.0, "{big:?} {small:?}");
    let mut told = Vec::new();
    for at in 1..7 {
        told.extend(scene.hold(1, &pair(17.9 - 0.65 * f64::from(at))));
    }
    told.extend(scene.hold(4, &pair(14.0)));
    let kinds: Vec<_> = told.iter().map(|&(_, id, kind)| (id, kind)).collect();
    assert_eq!(kinds, [(2, EventKind::Merged { into: TrackId(1) })]);
    assert_eq!(scene.tracker.alive().count(), 1);
}

#[test]
fn a_track_out_of_the_selection_goes_on() {
    let mut scene = Scene::new(TrackRule::Top(NonZeroU32::MIN));
    let (large, small) = (ring(40, 10.0, [0.0; 3]), ring(40, 8.0, [40.0, 0.0, 0.0]));
    assert_eq!(scene.hold(3, &small), [(2, 1, EventKind::Born)]);
    let both = [large, small.clone()].concat();
    assert_eq!(scene.hold(4, &both), [(5, 2, EventKind::Born), (6, 1, EventKind::Unselected)]);
    assert_eq!(scene.hold(4, &small), [(9, 1, EventKind::Reselected { gone: 0 }), (10, 2, EventKind::Died)]);
}

#[test]
fn a_track_that_is_remembered_comes_back_under_its_id() {
    let circle = |x: f64| ring(40, 10.0, [x, 5.0, 0.0]);
    for (remember, comes_back) in [(Remember::Frames(9), true), (Remember::Frames(3), false)] {
        let miss = NonZeroU32::new(3).unwrap();
        let options = TrackOptions { miss, remember, ..TrackOptions::new(ABOVE) };
        let mut scene = Scene::with(SpaceOptions::default(), options);
        assert_eq!(scene.hold(4, &circle(0.0)), [(2, 1, EventKind::Born)]);
        let gone = scene.hold(5, &[[0.0; 3]]);
        let back = scene.hold(3, &circle(1.0));
        if comes_back {
            assert_eq!(gone, [(7, 1, EventKind::Unselected)]);
            assert_eq!(back, [(11, 1, EventKind::Reselected { gone: 5 })]);
        } else {
            assert_eq!(gone, [(7, 1, EventKind::Unselected), (8, 1, EventKind::Died)]);
            assert_eq!(back, [(11, 2, EventKind::Born)]);
        }
    }
}

#[test]
fn noise_takes_over_no_ring() {
    let mut scene = Scene::new(TrackRule::Top(NonZeroU32::new(3).unwrap()));
    let squares = |shift: f64| -> Cloud3 {
        let square = |x: f64| [[x, 0.0, 1.0], [x + 1.0, 0.0, 1.0], [x + 1.0, 1.0, 1.0], [x, 1.0, 1.0]];
        [square(10.0 + shift), square(-10.5 + shift)].concat()
    };
    let circle = ring(40, 10.0, [0.0; 3]);
    scene.hold(3, &[circle, squares(0.0)].concat());
    let ring = scene.tracker.alive().find(|track| track.radius > 5.0).unwrap().id;
    // The ring is gone, and small squares stay where it was.
    let step = (0..4).map(|at| scene.show(&squares(0.1 * f64::from(at)))).last().unwrap();
    assert!(step.alive.len() > 1 && step.alive.iter().all(|track| track.id != ring), "{step:?}");
}

#[test]
fn a_cycle_that_never_dies_is_tracked() {
    let space = SpaceOptions { threshold: Some(4.0), ..SpaceOptions::default() };
    let mut scene = Scene::with(space, TrackOptions::new(ABOVE));
    assert_eq!(scene.hold(3, &ring(40, 10.0, [0.0; 3])), [(2, 1, EventKind::Born)]);
    assert_eq!(scene.hold(3, &ring(40, 10.0, [1.0, 0.0, 0.0])), []);
    let track = scene.tracker.alive().next().unwrap();
    assert!(track.death == f64::INFINITY && (track.center[0] - 1.0).abs() < 0.5, "{track:?}");
}

#[test]
fn tracks_go_around_the_earth() {
    let space = SpaceOptions { metric: Metric::Haversine, ..SpaceOptions::default() };
    let mut scene = Scene::with(space, TrackOptions::new(TrackRule::Above(100_000.0)));
    let around = |x: f64| -> Vec<[f64; 2]> {
        let angle = (0..30).map(|index| TAU * f64::from(index) / 30.0);
        angle.map(|angle| [x + 10.0 * angle.cos(), 10.0 * angle.sin()]).collect()
    };
    let steps: Vec<SpaceTrackStep> = (0..5).map(|at| scene.show(&around(f64::from(at)))).collect();
    let [track] = &steps[4].alive[..] else { panic!("{:?}", steps[4]) };
    // A degree is 111 km.
    assert!((track.radius / 1.11e6 - 1.0).abs() < 0.05 && track.age == 5, "{track:?}");
}

#[test]
fn a_frame_that_a_follower_asked_for_has_the_same_tracks() {
    let frames: Vec<Cloud3> =
        (0..8).map(|at| [pair(14.0 + 0.5 * f64::from(at)), ring(9, 2.0, [40.0; 3])].concat()).collect();
    let mut plain = Scene::new(ABOVE);
    let mut followed = Scene::new(ABOVE);
    let mut follower = Follower::new(ViewSpec::Full);
    let mut second = SpaceTracker::new(*followed.tracker.options());
    for (points, number) in frames.iter().zip(1..) {
        let expected = plain.show(points);
        followed.commit(points);
        followed.pipeline.poll_step(&mut follower).unwrap();
        assert_eq!(followed.pipeline.poll_tracks(&mut followed.tracker), Some(expected.clone()));
        assert_eq!(followed.pipeline.poll_tracks(&mut followed.tracker), None);
        // A second tracker has its own questions.
        if number != 4 {
            let step = followed.pipeline.poll_tracks(&mut second).unwrap();
            assert!(number > 4 || step == expected, "{step:?}");
        }
        assert_eq!((followed.pipeline.computed(), plain.pipeline.computed()), (number, number));
    }
}

/// Frames that follow each other: small clouds and rings, a part of which stays.
fn frames() -> impl Strategy<Value = Vec<Cloud3>> {
    let rings = prop::collection::vec((8..30_u32, 0.2..1.5, -2.0..2.0), 0..3).prop_map(|rings| {
        rings.into_iter().flat_map(|(count, radius, x)| ring(count, radius, [x, 0.0, 0.0])).collect::<Cloud3>()
    });
    let flat = clouds().prop_map(|points| points.into_iter().map(|[x, y]| [x, y, 0.5]).collect::<Cloud3>());
    let cloud = (flat, rings).prop_map(|(flat, rings)| [flat, rings].concat());
    prop::collection::vec((cloud, 0..4_usize, 1..4_usize), 1..5).prop_map(|steps| {
        let mut frames: Vec<Cloud3> = Vec::new();
        for (cloud, share, times) in steps {
            for _ in 0..times {
                let stay = frames.last().map_or(&[][..], |last| &last[..last.len() * share / 4]);
                frames.push([stay, &cloud[..]].concat());
            }
        }
        frames
    })
}

fn rules() -> impl Strategy<Value = TrackRule> {
    prop_oneof![
        (0.01..0.5).prop_map(TrackRule::Above),
        (1..9_u32).prop_map(|most| TrackRule::Top(NonZeroU32::new(most).unwrap())),
        Just(TrackRule::View(ViewSpec::Full)),
        Just(TrackRule::View(ViewSpec::Derived { k: NonZeroU32::MIN, l: NonZeroU32::MIN })),
    ]
}

/// Every track begins once and ends once. It has events in between only.
fn check_lives(living: &mut Vec<TrackId>, step: &SpaceTrackStep) {
    for event in &step.events {
        let id = event.track.id;
        match event.kind {
            EventKind::Born | EventKind::Split { .. } => {
                assert!(!living.contains(&id));
                living.push(id);
            }
            EventKind::Merged { .. } | EventKind::Died => living.retain(|other| *other != id),
            _ => assert!(living.contains(&id)),
        }
        if let EventKind::Split { from: other } | EventKind::Merged { into: other } = event.kind {
            assert!(living.contains(&other) && other != id);
        }
    }
    assert_eq!(step.alive.iter().map(|track| track.id).collect::<Vec<_>>(), *living);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(150) })]

    /// Neither the order of points, nor ids, nor who asks first decides anything.
    #[test]
    fn tracks_depend_on_positions_alone((frames, seed) in (frames(), any::<u64>()), rule in rules()) {
        let mut scene = Scene::new(rule);
        let mut other = Scene::new(rule);
        let mut follower = Follower::new(ViewSpec::Full);
        let mut living = Vec::new();
        for points in frames {
            let step = scene.show(&points);
            check_lives(&mut living, &step);
            let mut shuffled = points.clone();
            shuffled.rotate_left(seed as usize % points.len().max(1));
            shuffled.reverse();
            other.commit(&shuffled);
            other.pipeline.poll_step(&mut follower);
            let again = other.pipeline.poll_tracks(&mut other.tracker);
            prop_assert_eq!(again.as_ref(), Some(&step));
            let frame = scene.pipeline.poll_frame().expect("a frame was committed");
            let cycles = scene.pipeline.track_cycles(&scene.tracker);
            for (id, cycle) in &cycles {
                let track = step.alive.iter().find(|track| track.id == *id).expect("it is alive");
                let dots = frame.skeleton.dots();
                prop_assert!(dots.iter().any(|dot| (dot.birth, dot.death) == (track.birth, track.death)));
                let ids = frame.skeleton.vertices().ids();
                prop_assert!(cycle.len() >= 3 && cycle.iter().all(|id| ids.binary_search(id).is_ok()));
            }
        }
    }
}
