//! Points that wait for their source's commit: frames are those of a stream that is fed at the commit only. Windows of
//! time have tests of their own.

mod common;
#[path = "staging/time_windows.rs"]
mod time_windows;

use std::collections::HashMap;
use std::sync::Arc;

use common::by_position::ByPosition;
use common::clouds::cases;
use common::model::Kept;
use hopes::topology::{Frame, Options, Pipeline, Refusal, Staging};
use proptest::prelude::*;

const SOURCES: usize = 3;

#[derive(Clone, Copy, Debug)]
enum Act {
    Point([f64; 2], Option<f64>),
    Retract([f64; 2]),
    Commit,
    /// The source ends without a commit.
    Abandon,
}

/// Acts, each of a source.
fn acts() -> impl Strategy<Value = Vec<(usize, Act)>> {
    // Few positions, so that sources meet at some.
    let place = [0..5_i32, 0..4_i32].prop_map(|place| place.map(f64::from));
    let act = prop_oneof![
        12 => (place.clone(), prop::option::weighted(0.7, (0..12_i32).prop_map(f64::from)))
            .prop_map(|(place, time)| Act::Point(place, time)),
        4 => place.prop_map(Act::Retract),
        2 => Just(Act::Commit),
        1 => Just(Act::Abandon),
    ];
    prop::collection::vec((0..SOURCES, act), 1..120)
}

fn windows() -> impl Strategy<Value = Kept> {
    prop_oneof![Just(Kept::All), (1..12_u64).prop_map(Kept::Points), (1..4_u64).prop_map(Kept::Frames),]
}

fn pipeline(kept: Kept) -> Pipeline {
    Pipeline::new(Options { window: kept.window(), ..Options::default() })
}

/// Feeds a pipeline directly. Returns why it is refused, if it is.
fn feed(pipeline: &mut Pipeline, act: Act) -> Option<Refusal> {
    match act {
        Act::Point([x, y], time) => pipeline.feed_point(x, y, time).err(),
        Act::Retract([x, y]) => pipeline.feed_retraction(x, y).err(),
        Act::Commit | Act::Abandon => None,
    }
}

fn stage(pipeline: &mut Pipeline, staging: &mut Staging, act: Act) -> Option<Refusal> {
    match act {
        Act::Point([x, y], time) => pipeline.stage_point(staging, x, y, time).err(),
        Act::Retract([x, y]) => pipeline.stage_retraction(staging, x, y).err(),
        Act::Commit | Act::Abandon => None,
    }
}

fn assert_same_frames(ours: &mut Pipeline, theirs: &mut Pipeline) -> Arc<Frame> {
    assert_eq!(ours.commit(None), theirs.commit(None));
    let (ours, theirs) = (ours.poll_frame().unwrap(), theirs.poll_frame().unwrap());
    assert_eq!(ours.points, theirs.points);
    ByPosition::of(&ours.skeleton).assert_same(&ByPosition::of(&theirs.skeleton));
    ours
}

proptest! {
    #![proptest_config(cases(400))]

    #[test]
    fn a_frame_has_what_its_sources_have_committed(kept in windows(), acts in acts()) {
        let (mut staged, mut direct) = (pipeline(kept), pipeline(kept));
        let mut stagings: Vec<Staging> = vec![Staging::default(); SOURCES];
        let mut waiting: Vec<Vec<Act>> = vec![Vec::new(); SOURCES];
        for (source, act) in acts {
            match act {
                Act::Commit => {
                    let refused = staged.feed_staged(&mut stagings[source], None, &mut |_, _| {}).refused;
                    let fed = std::mem::take(&mut waiting[source]).into_iter();
                    let expected = fed.filter_map(|act| feed(&mut direct, act)).count();
                    // Points that leave a window of points while they wait are not fed, and so not refused.
                    if !matches!(kept, Kept::Points(_)) {
                        prop_assert_eq!(refused, expected as u64);
                    }
                    prop_assert!(stagings[source].is_empty());
                    assert_same_frames(&mut staged, &mut direct);
                }
                Act::Abandon => {
                    staged.discard_staged(&mut stagings[source]);
                    waiting[source].clear();
                }
                _ if stage(&mut staged, &mut stagings[source], act).is_none() => waiting[source].push(act),
                _ => {}
            }
            staged.check_invariants();
        }
        // Nothing is left of what was never committed.
        stagings.iter_mut().for_each(|staging| staged.discard_staged(staging));
        assert_same_frames(&mut staged, &mut direct);
        prop_assert_eq!(staged.point_count(), direct.point_count());
        prop_assert_eq!(staged.vertex_count(), direct.vertex_count());
    }

    #[test]
    fn a_source_alone_has_the_answers_of_a_stream_that_is_fed_at_once(
        kept in windows().prop_filter("a window of points moves while it is fed", |kept| !matches!(kept, Kept::Points(_))),
        acts in acts(),
    ) {
        let (mut staged, mut direct) = (pipeline(kept), pipeline(kept));
        let mut staging = Staging::default();
        let mut told = Vec::new();
        for (_, act) in acts {
            match act {
                Act::Point([x, y], time) => {
                    let ours = staged.stage_point(&mut staging, x, y, time);
                    prop_assert_eq!(ours.map(drop), direct.feed_point(x, y, time).map(drop));
                    told.extend(ours.map(|id| ([x, y], id)));
                }
                Act::Retract([x, y]) => {
                    prop_assert_eq!(staged.stage_retraction(&mut staging, x, y), direct.feed_retraction(x, y));
                }
                Act::Commit | Act::Abandon => {
                    staged.feed_staged(&mut staging, None, &mut |_, _| {});
                    let frame = assert_same_frames(&mut staged, &mut direct);
                    let ids: HashMap<_, _> = told.drain(..).map(|([x, y], id)| ([x, y].map(f64::to_bits), id)).collect();
                    let vertices = frame.skeleton.vertices();
                    for (&id, at) in vertices.ids().iter().zip(vertices.positions()) {
                        let told = ids.get(&at.map(f64::to_bits));
                        prop_assert!(told.is_none_or(|&told| told == id), "{:?} was told as {:?}", id, told);
                    }
                }
            }
        }
    }
}

#[test]
fn a_vertex_that_vanishes_while_a_point_waits_for_it_is_another_one_afterwards() {
    let mut pipeline = pipeline(Kept::Frames(1));
    let (mut first, mut second) = (Staging::default(), Staging::default());
    let before = pipeline.stage_point(&mut first, 1.0, 2.0, None).unwrap();
    pipeline.feed_staged(&mut first, None, &mut |_, _| {});
    pipeline.commit(None);
    // The vertex is there, and goes with the next frame.
    assert_eq!(pipeline.stage_point(&mut second, 1.0, 2.0, None), Ok(before));
    pipeline.commit(None);
    assert_eq!(pipeline.poll_frame().unwrap().points, 0);
    pipeline.feed_staged(&mut second, None, &mut |_, _| {});
    pipeline.commit(None);
    let frame = pipeline.poll_frame().unwrap();
    assert_eq!(frame.skeleton.vertices().len(), 1);
    assert_ne!(frame.skeleton.vertices().id(0), before, "an id is never used again");
}

#[test]
fn points_of_a_long_run_that_would_leave_at_once_do_not_wait() {
    let mut pipeline = pipeline(Kept::Points(4));
    let mut staging = Staging::default();
    for number in 0..1000_u32 {
        pipeline.stage_point(&mut staging, f64::from(number), 0.0, None).unwrap();
        assert_eq!(staging.point_count(), (u64::from(number) + 1).min(4));
    }
    pipeline.stage_retraction(&mut staging, 998.0, 0.0).unwrap();
    assert!(pipeline.stage_retraction(&mut staging, 990.0, 0.0).is_err());
    pipeline.feed_staged(&mut staging, None, &mut |_, _| {});
    pipeline.commit(None);
    assert_eq!(pipeline.poll_frame().unwrap().points, 3);
}
