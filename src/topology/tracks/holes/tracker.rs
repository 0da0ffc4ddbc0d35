//! Tracks in the plane, updated to a frame.
//!
//! In: the detections of a frame, most persistent first, and regions of holes on request.
//! Out: a [`TrackStep`].
//! Invariant: reports depend on the positions of points alone, not on their order or ids.
//! Must not know: how dots and regions are found, formats, hysteresis.
//!
//! If a hole divides, the part with the larger death keeps the id, and the track of the other part names the one that
//! it was split from. If two holes become one, the track with the larger death goes on, and the other one's track names
//! the one that it was merged into.

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::last_seen::LastSeen;
use super::recognition::{Recognized, RecognizedBy, recognize};
use super::state::HoleState;
use crate::topology::skeleton::Hole;
use crate::topology::tracks::detection::{Detected, Detections};
use crate::topology::tracks::track::{FrameStamp, TrackId, TrackStep};
use crate::topology::tracks::tracker::Tracker;

/// The regions that are found again in a frame have this number of vertices together.
const REGION_VERTICES: usize = 256;

/// An event names no other track of less than this share of its persistence: that would be noise.
const NAMED: f64 = 0.25;

/// If a new hole has less than this share of a track's radius, the track's region is not found again: the last one
/// decides.
const SUBSTANTIAL: f64 = 0.25;

impl<R: HoleRegion> Tracker<HoleState<R>> {
    /// The detections of the tracks that were detected in the newest frame, by id.
    pub(crate) fn seen(&self) -> impl Iterator<Item = (TrackId, &Detection)> {
        self.seen_states().map(|(id, state)| (id, &state.detection))
    }

    /// Updates the tracks to a frame.
    pub(crate) fn advance(
        &mut self,
        at: FrameStamp,
        detections: Detections<Detection>,
        mut find_region: impl FnMut(&Detection) -> R,
    ) -> TrackStep {
        let Detections { all, is_selected, left_out } = detections;
        let known: Vec<LastSeen<'_, R>> = self.states.iter().map(|state| state.last_seen(at.number)).collect();
        let Recognized { own, motion } = recognize(&known, &all, &is_selected, &mut find_region);
        let mut is_new = is_selected.clone();
        own.iter().flatten().for_each(|&(place, _)| is_new[place] = false);
        let newcomers: Vec<usize> = (0..all.len()).filter(|&place| is_new[place]).collect();
        // A new dot's parent is found by the holes before this frame; else by the current ones, since holes that divide
        // slowly are still one below the new dot's birth.
        let before: Vec<Option<u64>> = newcomers.iter().map(|&place| self.holder_of(&all[place])).collect();
        for (state, own) in self.states.iter_mut().zip(own) {
            match own {
                Some((place, by)) => {
                    state.see(at, &all[place], by, &motion, is_selected[place]);
                    if by == RecognizedBy::Region {
                        // It was found to recognize the track. The last one may be that of many frames ago.
                        state.refresh_region(at.number, &mut find_region);
                    }
                }
                None => state.miss(&motion),
            }
        }
        self.frame = at.number;
        for (&place, before) in newcomers.iter().zip(before) {
            let new = (all[place].hole, all[place].persistence());
            let parent = before.or_else(|| current_holder(&mut self.states, at.number, new, &mut find_region));
            self.begin(|key| HoleState::new(key, at, all[place].clone(), parent));
        }
        self.drop_void();
        let due = self.states.iter_mut().filter(|state| state.life.is_due(at.number, self.options.confirm));
        due.for_each(|state| state.refresh_region(at.number, &mut find_region));
        let events = self.collect_events(at, HoleState::moved, |states, place| {
            let ended = &states[place].life.track;
            let ended = (ended.hole, ended.persistence());
            current_holder(states, at.number, ended, &mut find_region)
        });
        self.refresh_regions(&mut find_region);
        self.step(at, events, left_out)
    }

    /// Finds the regions again of holes that have grown, then those that were not found for the longest time. A large
    /// region waits until the budget of several frames suffices.
    fn refresh_regions(&mut self, find_region: &mut impl FnMut(&Detection) -> R) {
        let frame = self.frame;
        let is_due = |state: &&mut HoleState<R>| state.life.is_detected() && state.region_frame < frame;
        let mut due: Vec<&mut HoleState<R>> = self.states.iter_mut().filter(is_due).collect();
        due.sort_unstable_by_key(|state| (!state.has_grown(), state.region_frame, state.life.key));
        self.shared += REGION_VERTICES;
        for state in due {
            let Some(left) = self.shared.checked_sub(state.region.vertex_count().max(1)) else { return };
            state.refresh_region(frame, find_region);
            self.shared = left;
        }
        self.shared = 0;
    }

    /// The announced track whose last region contains the centre of a new dot; the smallest, if there are several.
    fn holder_of(&self, new: &Detection) -> Option<u64> {
        let holds = |state: &&HoleState<R>| is_named(state, new.persistence()) && state.holds(new.hole.center);
        smallest(self.announced().filter(holds))
    }
}

/// The same among the tracks that are detected, with their current regions.
fn current_holder<R: HoleRegion>(
    states: &mut [HoleState<R>],
    frame: u64,
    (hole, persistence): (Hole, f64),
    find_region: &mut impl FnMut(&Detection) -> R,
) -> Option<u64> {
    let point = hole.center;
    let may_hold = |state: &HoleState<R>| state.life.is_detected() && is_named(state, persistence);
    let is_near = |state: &&mut HoleState<R>| {
        let is_small = hole.radius < SUBSTANTIAL * state.life.track.hole.radius;
        may_hold(state) && !is_small && state.is_near(point)
    };
    states.iter_mut().filter(is_near).for_each(|state| state.refresh_region(frame, find_region));
    let holds = |state: &&HoleState<R>| may_hold(state) && state.holds(point);
    smallest(states.iter().filter(holds))
}

/// Whether an event of a track with some persistence may name this one.
fn is_named<R>(state: &HoleState<R>, persistence: f64) -> bool {
    state.life.track.persistence() >= NAMED * persistence
}

fn smallest<'a, R: 'a>(states: impl Iterator<Item = &'a HoleState<R>>) -> Option<u64> {
    states.min_by(|a, b| a.life.track.area.total_cmp(&b.life.track.area)).map(|state| state.life.key)
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroU32;

    use proptest::prelude::*;

    use super::*;
    use crate::topology::testing::{Points, clouds, ring};
    use crate::topology::{
        Changed, EventKind, Options, Pipeline, Remember, Track, TrackOptions, TrackRule, Tracker, ViewSpec, Window,
    };

    /// A stream whose frames replace each other, and its tracker.
    struct Scene {
        pipeline: Pipeline,
        tracker: Tracker,
    }

    impl Scene {
        fn new(rule: TrackRule) -> Self {
            let window = Window::Frames(std::num::NonZeroU64::MIN);
            let pipeline = Pipeline::new(Options { window, ..Options::default() });
            let miss = NonZeroU32::new(3).unwrap();
            Self { pipeline, tracker: Tracker::new(TrackOptions { miss, ..TrackOptions::new(rule) }) }
        }

        fn show(&mut self, points: &[[f64; 2]]) -> TrackStep {
            assert_eq!(self.pipeline.feed_points(points, None), []);
            let time = 0.5 * self.pipeline.committed() as f64;
            self.pipeline.commit(Some(time));
            self.pipeline.poll_tracks(&mut self.tracker).expect("a frame was committed")
        }

        /// The events of some equal frames, without updates.
        fn hold(&mut self, frames: usize, points: &[[f64; 2]]) -> Vec<(u64, u64, EventKind)> {
            let steps: Vec<TrackStep> = (0..frames).map(|_| self.show(points)).collect();
            let events = steps.iter().flat_map(|step| &step.events);
            let news = events.filter(|event| !matches!(event.kind, EventKind::Updated(_)));
            news.map(|event| (event.frame, event.track.id.0, event.kind)).collect()
        }
    }

    fn moved(points: &[[f64; 2]], [dx, dy]: [f64; 2]) -> Points {
        points.iter().map(|[x, y]| [x + dx, y + dy]).collect()
    }

    /// The border of two discs of radii 10 and 8 whose centres are this far apart.
    fn pair(apart: f64) -> Points {
        let (big, small) = (ring(63, 10.0), moved(&ring(50, 8.0), [apart, 0.0]));
        let outside = |point: &&[f64; 2], center: f64, radius: f64| (point[0] - center).hypot(point[1]) > radius;
        let big = big.iter().filter(|point| outside(point, apart, 8.0));
        big.chain(small.iter().filter(|point| outside(point, 0.0, 10.0))).copied().collect()
    }

    const ABOVE: TrackRule = TrackRule::Above(3.0);

    #[test]
    fn a_ring_is_announced_followed_and_ended() {
        let mut scene = Scene::new(ABOVE);
        let circle = ring(40, 10.0);
        assert_eq!(scene.hold(4, &circle), [(2, 1, EventKind::Born)]);
        let step = scene.show(&moved(&circle, [1.0, 0.0]));
        let [event] = &step.events[..] else { panic!("one event: {step:?}") };
        assert_eq!(event.kind, EventKind::Updated(Changed { center: true, birth: false, death: false }));
        let Track { id, age, hole, velocity, .. } = event.track;
        assert_eq!((id, age), (TrackId(1), 5));
        assert!((hole.center[0] - 1.0).abs() < 1e-9 && (velocity[0] - 0.5).abs() < 1e-9, "{hole:?} {velocity:?}");
        assert!((step.alive[0].area - 40.0 / 2.0 * 100.0 * (std::f64::consts::TAU / 40.0).sin()).abs() < 1e-9);
        let regions = scene.pipeline.track_regions(&scene.tracker);
        assert_eq!((regions.len(), regions[0].0, regions[0].1.boundary()[0].len()), (1, id, 40));
        assert_eq!(scene.hold(4, &[[0.0, 0.0]]), [(8, 1, EventKind::Died)]);
        assert_eq!(scene.tracker.alive().count(), 0);
    }

    #[test]
    fn one_frame_is_no_track_and_a_short_gap_ends_none() {
        let mut scene = Scene::new(ABOVE);
        let circle = ring(40, 10.0);
        let flash = [circle.clone(), moved(&circle, [50.0, 0.0])].concat();
        assert_eq!(scene.hold(2, &circle).len(), 1);
        assert_eq!(scene.hold(1, &flash), []);
        assert_eq!(scene.hold(2, &[[0.0, 0.0]]), []);
        assert_eq!(scene.hold(3, &circle), []);
    }

    #[test]
    fn a_hole_that_divides_keeps_its_id_and_its_part_names_it() {
        let mut scene = Scene::new(ABOVE);
        assert_eq!(scene.hold(3, &pair(14.0)), [(2, 1, EventKind::Born)]);
        let split = EventKind::Split { from: TrackId(1) };
        assert_eq!(scene.hold(4, &pair(17.9)), [(5, 2, split)]);
        let [big, small] = [1, 2].map(|id| *scene.tracker.alive().find(|track| track.id == TrackId(id)).unwrap());
        assert!(big.hole.radius > 9.5 && (7.5..8.5).contains(&small.hole.radius), "{big:?} {small:?}");
        let merged = EventKind::Merged { into: TrackId(1) };
        assert_eq!(scene.hold(4, &pair(14.0)), [(10, 2, merged)]);
    }

    #[test]
    fn a_hole_whose_larger_part_changes_sides_is_the_same() {
        let mut scene = Scene::new(ABOVE);
        let swap = |points: Points| points.into_iter().map(|[x, y]| [14.0 - x, y]).collect::<Points>();
        assert_eq!(scene.hold(3, &pair(14.0)).len(), 1);
        assert_eq!(scene.hold(3, &swap(pair(14.0))), []);
    }

    #[test]
    fn a_track_out_of_the_selection_goes_on() {
        let mut scene = Scene::new(TrackRule::Top(NonZeroU32::MIN));
        let (large, small) = (ring(40, 10.0), moved(&ring(40, 8.0), [40.0, 0.0]));
        assert_eq!(scene.hold(3, &small), [(2, 1, EventKind::Born)]);
        let both = [large, small.clone()].concat();
        assert_eq!(scene.hold(4, &both), [(5, 2, EventKind::Born), (6, 1, EventKind::Unselected)]);
        assert_eq!(scene.hold(4, &small), [(9, 1, EventKind::Reselected { gone: 0 }), (10, 2, EventKind::Died)]);
    }

    #[test]
    fn a_track_that_is_remembered_comes_back_under_its_id() {
        let circle = ring(40, 10.0);
        let small = ring(20, 4.0);
        for (remember, lasting) in [(Remember::Frames(9), 9), (Remember::Time(4.5), 9), (Remember::Frames(3), 3)] {
            let mut scene = Scene::new(TrackRule::Above(1.0));
            scene.tracker.options.remember = remember;
            assert_eq!(scene.hold(3, &circle), [(2, 1, EventKind::Born)]);
            // It drifts, and goes on to drift while it is hidden.
            for step in 1..=3 {
                scene.show(&moved(&circle, [f64::from(step) * 2.0, 0.0]));
            }
            let news = scene.hold(5, &[[0.0, 0.0]]);
            let back = scene.hold(3, &moved(&circle, [19.0, 0.0]));
            if lasting > 5 {
                assert_eq!(news, [(9, 1, EventKind::Unselected)], "{remember:?}");
                assert_eq!(back, [(13, 1, EventKind::Reselected { gone: 5 })]);
                assert_eq!(scene.hold(4, &small), [(16, 2, EventKind::Born), (17, 1, EventKind::Unselected)]);
                let gone = scene.hold(12, &small);
                assert_eq!(gone, [(24, 1, EventKind::Died)], "it is too long ago");
            } else {
                assert_eq!(news, [(9, 1, EventKind::Unselected), (10, 1, EventKind::Died)]);
                assert_eq!(back, [(13, 2, EventKind::Born)]);
            }
        }
    }

    #[test]
    fn all_frames_without_a_hole_count_until_it_is_back() {
        let mut scene = Scene::new(ABOVE);
        scene.tracker.options.remember = Remember::Frames(20);
        let circle = ring(40, 10.0);
        assert_eq!(scene.hold(3, &circle).len(), 1);
        assert_eq!(scene.hold(5, &[[0.0, 0.0]]).len(), 1);
        // One frame is too few to be back.
        assert_eq!(scene.hold(1, &circle), []);
        assert_eq!(scene.hold(2, &[[0.0, 0.0]]), []);
        assert_eq!(scene.hold(2, &circle), [(13, 1, EventKind::Reselected { gone: 7 })]);
    }

    #[test]
    fn what_is_remembered_takes_nothing_from_tracks_that_are_there() {
        let mut scene = Scene::new(ABOVE);
        scene.tracker.options.remember = Remember::Frames(100);
        let circle = ring(40, 10.0);
        let both = [circle.clone(), moved(&circle, [40.0, 0.0])].concat();
        assert_eq!(scene.hold(3, &both).len(), 2);
        let [left, right] = [-1.0, 1.0].map(|side| {
            let is_there = |track: &&Track| (track.hole.center[0] - 20.0) * side > 0.0;
            scene.tracker.alive().find(is_there).expect("two tracks").id.0
        });
        assert_eq!(scene.hold(6, &circle), [(6, right, EventKind::Unselected)]);
        // The left one moves to where the right one was.
        for step in 1..=40 {
            let step = scene.show(&moved(&circle, [f64::from(step), 0.0]));
            assert!(step.events.iter().all(|event| event.track.id.0 == left), "{step:?}");
        }
    }

    #[test]
    fn changes_below_delta_are_not_reported() {
        let mut scene = Scene::new(ABOVE);
        scene.tracker.options.delta = 1.0;
        let circle = ring(40, 10.0);
        scene.hold(2, &circle);
        let reported: Vec<usize> =
            (1..=7).map(|step| scene.show(&moved(&circle, [f64::from(step) * 0.4, 0.0])).events.len()).collect();
        assert_eq!(reported, [0, 0, 1, 0, 0, 1, 0]);
    }

    #[test]
    fn a_frame_is_reported_once_and_skipped_frames_count() {
        let mut scene = Scene::new(ABOVE);
        let circle = ring(40, 10.0);
        scene.show(&circle);
        assert_eq!(scene.pipeline.poll_tracks(&mut scene.tracker), None);
        scene.pipeline.feed_points(&circle, None);
        scene.pipeline.commit(None);
        let step = scene.show(&circle);
        assert_eq!((step.number, step.events[0].kind, step.events[0].track.age), (3, EventKind::Born, 3));
    }

    /// The last point of an annulus to be filled may be anywhere on a circle, from the first frame on.
    #[test]
    fn an_annulus_is_announced_though_its_centre_jumps() {
        let mut scene = Scene::new(ABOVE);
        let turned = |angle: f64| -> Points {
            let (sin, cos) = angle.sin_cos();
            // A dent inwards on one side of the outer ring leaves the widest place on the other.
            let dented = |[x, y]: [f64; 2]| if x < 0.0 { [0.96 * x, y] } else { [x, y] };
            let rings = [ring(126, 20.0).into_iter().map(dented).collect(), ring(40, 6.0)].concat();
            rings.into_iter().map(|[x, y]| [cos * x - sin * y, sin * x + cos * y]).collect()
        };
        let first = scene.show(&turned(0.0));
        assert_eq!(first.events, []);
        let second = scene.show(&turned(2.5));
        let born: Vec<f64> = second.events.iter().map(|event| event.track.hole.radius.round()).collect();
        assert_eq!(born, [7.0, 6.0], "{second:?}");
        let third = scene.show(&turned(5.0));
        assert!(third.events.iter().all(|event| matches!(event.kind, EventKind::Updated(_))), "{third:?}");
        assert_eq!(third.alive.len(), 2);
    }

    /// Rings that jump, some close to each other, in clouds of every kind. A part of the points changes between frames.
    fn frames() -> impl Strategy<Value = Vec<Points>> {
        let circle = (8..30_u32, 0.2..1.5, -2.0..2.0, -2.0..2.0);
        let circles = prop::collection::vec(circle, 0..4).prop_map(|circles| {
            circles
                .into_iter()
                .flat_map(|(count, radius, x, y)| moved(&ring(count, radius), [x, y]))
                .collect::<Points>()
        });
        let cloud = (clouds(), circles).prop_map(|(cloud, circles)| [cloud, circles].concat());
        prop::collection::vec((cloud, 0..4_usize, 1..4_usize), 1..6).prop_map(|steps| {
            let mut frames: Vec<Points> = Vec::new();
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
        let ranks = (1..4_u32, 1..3_u32).prop_map(|(k, l)| [k, l].map(|rank| NonZeroU32::new(rank).unwrap()));
        prop_oneof![
            (0.01..0.5).prop_map(TrackRule::Above),
            (1..9_u32).prop_map(|most| TrackRule::Top(NonZeroU32::new(most).unwrap())),
            ranks.prop_map(|[k, l]| TrackRule::View(ViewSpec::Derived { k, l })),
            Just(TrackRule::View(ViewSpec::Full)),
        ]
    }

    /// Every track begins once and ends once. It has events in between only. Living tracks are those that have begun
    /// and not ended.
    fn check_lives(living: &mut Vec<TrackId>, step: &TrackStep) {
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
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        /// Neither the order of points nor the way in which skeletons are found decides anything. Cached regions equal
        /// found ones.
        #[test]
        fn tracks_depend_on_positions_alone((frames, seed) in (frames(), any::<u64>()), rule in rules()) {
            let mut scene = Scene::new(rule);
            let mut other = Scene::new(rule);
            other.pipeline = other.pipeline.with_leaf(6);
            let mut living = Vec::new();
            for points in frames {
                let step = scene.show(&points);
                check_lives(&mut living, &step);
                let mut shuffled = points.clone();
                shuffled.rotate_left(seed as usize % points.len().max(1));
                shuffled.reverse();
                prop_assert_eq!(&other.show(&shuffled), &step);
                let frame = scene.pipeline.poll_frame().expect("a frame was committed");
                for (id, region) in scene.pipeline.track_regions(&scene.tracker) {
                    let track = step.alive.iter().find(|track| track.id == id).expect("it is alive");
                    let is_its = |dot: &&crate::topology::Dot| {
                        (dot.birth, dot.death, frame.skeleton.hole(dot)) == (track.birth, track.death, Some(track.hole))
                    };
                    prop_assert!(frame.skeleton.dots().iter().any(|dot| is_its(&dot)));
                    prop_assert!(region.area() > 0.0 && region.contains(track.hole.center));
                    let state = scene.tracker.states.iter().find(|state| state.life.track.id == id).expect("it lives");
                    if state.region_frame == step.number {
                        prop_assert_eq!((&state.region, track.area), (&region, region.area()));
                    }
                }
            }
        }
    }
}
