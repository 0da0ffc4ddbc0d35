//! Points that wait for their source's commit: frames are those of a stream that is fed at the commit only.

mod common;

use common::by_position::ByPosition;
use common::clouds::cases;
use common::model::Kept;
use hopes::topology::{Options, Pipeline, Refusal, Staging};
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
    prop_oneof![
        Just(Kept::All),
        (1..12_u64).prop_map(Kept::Points),
        (1..4_u64).prop_map(Kept::Frames),
        (1..6_i32).prop_map(|length| Kept::Time(length.into())),
    ]
}

fn pipeline(kept: Kept) -> Pipeline {
    Pipeline::new(Options { window: kept.window(), resolution: None })
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

fn assert_same_frames(ours: &mut Pipeline, theirs: &mut Pipeline) {
    assert_eq!(ours.commit(None), theirs.commit(None));
    let (ours, theirs) = (ours.poll_frame().unwrap(), theirs.poll_frame().unwrap());
    assert_eq!(ours.points, theirs.points);
    ByPosition::of(&ours.skeleton).assert_same(&ByPosition::of(&theirs.skeleton));
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
                    let refused = staged.feed_staged(&mut stagings[source]);
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
            let kept_back: u64 = stagings.iter().map(Staging::point_count).sum();
            if let Kept::Points(most) = kept {
                prop_assert!(kept_back <= most * SOURCES as u64);
            }
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
        for (_, act) in acts {
            match act {
                Act::Point([x, y], time) => {
                    let (ours, theirs) = (staged.stage_point(&mut staging, x, y, time), direct.feed_point(x, y, time));
                    match kept {
                        // Points leave a window of time while it is fed, and their vertices with them.
                        Kept::Time(_) => prop_assert_eq!(ours.map(drop), theirs.map(drop)),
                        _ => prop_assert_eq!(ours, theirs),
                    }
                }
                Act::Retract([x, y]) if !matches!(kept, Kept::Time(_)) => {
                    prop_assert_eq!(staged.stage_retraction(&mut staging, x, y), direct.feed_retraction(x, y));
                }
                Act::Retract(_) => {}
                Act::Commit | Act::Abandon => {
                    staged.feed_staged(&mut staging);
                    assert_same_frames(&mut staged, &mut direct);
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
    pipeline.feed_staged(&mut first);
    pipeline.commit(None);
    // The vertex is there, and goes with the next frame.
    assert_eq!(pipeline.stage_point(&mut second, 1.0, 2.0, None), Ok(before));
    pipeline.commit(None);
    assert_eq!(pipeline.poll_frame().unwrap().points, 0);
    pipeline.feed_staged(&mut second);
    pipeline.commit(None);
    let frame = pipeline.poll_frame().unwrap();
    assert_eq!(frame.skeleton.vertices().len(), 1);
    assert_ne!(frame.skeleton.vertices()[0].id, before, "an id is never used again");
}
