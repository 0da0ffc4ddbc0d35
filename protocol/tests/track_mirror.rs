//! The contract of the track mirror: it holds the same tracks from events alone as from lists, and it detects missing
//! messages.
//!
//! In: random histories of tracks, and messages that this test makes of them by SPEC.md alone. Out: whether the mirror
//! equals the history, and whether messages that do not fit give the right error.
//!
//! Invariants: a history keeps the rules of SPEC.md, section 9.
//!
//! Must not know: how the mirror works.

use std::collections::BTreeMap;

use hopes_protocol::{
    Happening, Track, TrackChanges, TrackCycle, TrackEvent, TrackMirror, TrackMirrorError, Tracks, TracksWanted,
};
use proptest::prelude::*;
use proptest::sample::Index;

type Walks = Vec<Vec<u64>>;

/// One frame of a history.
#[derive(Clone, Debug, Default)]
struct Step {
    events: Vec<TrackEvent>,
    /// The living tracks in this frame.
    alive: BTreeMap<u64, Track>,
    /// The living tracks as their last events reported them.
    reported: BTreeMap<u64, Track>,
    cycles: BTreeMap<u64, Walks>,
}

/// An empty frame 0, and all frames from 1 on.
type History = Vec<Step>;

/// Random numbers that choose an event: its kind, its track and its other track.
type RandomEvent = (u8, Index, Index);

fn track(id: u64) -> Track {
    let center = (id as f64, -0.5);
    let velocity = (0.0, 0.0);
    Track { id, age: 1, birth: 0.5, death: 2.0, center, radius: 1.5, area: 7.0, velocity, selected: true }
}

fn time(frame: u64) -> Option<f64> {
    (!frame.is_multiple_of(3)).then_some(frame as f64 / 2.0)
}

/// The next frame of a history.
fn next(before: &Step, frame: u64, next_id: &mut u64, events_of_frame: &[RandomEvent]) -> Step {
    let mut step = Step { events: Vec::new(), ..before.clone() };
    // Changes below the reporting threshold, and the age, give no event.
    for track in step.alive.values_mut() {
        track.age += 1;
        track.area += 0.25;
    }
    for (what, subject, other) in events_of_frame {
        let mut living: Vec<u64> = before.alive.keys().copied().collect();
        // A track has at most one event in a frame, and none if another track's event refers to it.
        let is_taken = |id: &u64| step.events.iter().any(|event| involves(event, *id));
        living.retain(|id| !is_taken(id));
        let pick = |index: &Index| (!living.is_empty()).then(|| living[index.index(living.len())]);
        let other = pick(other).filter(|other| Some(*other) != pick(subject));
        let happening = match (what % 8, pick(subject), other) {
            (0 | 1, _, _) => Happening::Born,
            (2, _, Some(from)) => Happening::Split(from),
            (3, Some(_), _) => Happening::Died,
            (4, Some(_), Some(into)) => Happening::Merged(into),
            (5, Some(id), _) if step.alive[&id].selected => Happening::Unselected,
            (5, Some(_), _) => Happening::Reselected,
            (6 | 7, Some(_), _) => Happening::Updated(TrackChanges { center: true, birth: *what > 99, death: false }),
            _ => continue,
        };
        let id = match happening {
            Happening::Born | Happening::Split(_) => std::mem::replace(next_id, *next_id + 1),
            _ => pick(subject).expect("there is one"),
        };
        apply_event(&mut step, frame, id, happening);
    }
    step.events.sort_by_key(|event| event.track.id);
    step
}

fn involves(event: &TrackEvent, id: u64) -> bool {
    let other = matches!(event.happening, Happening::Split(other) | Happening::Merged(other) if other == id);
    event.track.id == id || other
}

fn apply_event(step: &mut Step, frame: u64, id: u64, happening: Happening) {
    let mut now = step.alive.get(&id).copied().unwrap_or_else(|| track(id));
    match happening {
        Happening::Unselected => now.selected = false,
        Happening::Reselected => now.selected = true,
        Happening::Updated(_) => now.center.0 += 1.0,
        _ => {}
    }
    step.events.push(TrackEvent { frame, time: time(frame), happening, track: now });
    if matches!(happening, Happening::Died | Happening::Merged(_)) {
        step.alive.remove(&id);
        step.reported.remove(&id);
        step.cycles.remove(&id);
        return;
    }
    step.alive.insert(id, now);
    step.reported.insert(id, now);
    // Cycles change with some events only, in a pattern that has no meaning.
    if !matches!(happening, Happening::Unselected | Happening::Reselected) {
        step.cycles.insert(id, vec![vec![id, frame, 7], vec![frame]]);
    }
}

fn histories() -> impl Strategy<Value = History> {
    let events_of_frame = prop::collection::vec((any::<u8>(), any::<Index>(), any::<Index>()), 0..5);
    prop::collection::vec(events_of_frame, 1..24).prop_map(|frames| {
        let (mut history, mut next_id) = (vec![Step::default()], 1);
        for (frame, events_of_frame) in (1..).zip(&frames) {
            let step = next(&history[frame as usize - 1], frame, &mut next_id, events_of_frame);
            history.push(step);
        }
        history
    })
}

/// The message to a consumer whose last message was of frame `from`.
fn message(history: &History, from: u64, frame: u64, wanted: TracksWanted) -> Tracks {
    let (before, now) = (&history[from as usize], &history[frame as usize]);
    let since = |frame: &u64| history[*frame as usize].events.clone();
    let alive = from == 0 || matches!(wanted, TracksWanted::Alive | TracksWanted::Cycles);
    let is_new = |id: &u64, walks: &Walks| from == 0 || before.cycles.get(id) != Some(walks);
    let changed = now.cycles.iter().filter(|(id, walks)| is_new(id, walks));
    let cycles = changed.map(|(&id, walks)| TrackCycle { id, walks: walks.clone() });
    Tracks {
        stream: 3,
        from,
        frame,
        time: time(frame),
        events: if from == 0 { vec![] } else { (from + 1..=frame).flat_map(|frame| since(&frame)).collect() },
        alive: alive.then(|| now.alive.values().copied().collect()),
        cycles: if wanted == TracksWanted::Cycles { cycles.collect() } else { vec![] },
    }
}

/// The pairs of frames between which messages are sent. Strides say how many frames lie between; the last frame is
/// always sent.
fn visits(history: &History, strides: &[u64]) -> Vec<(u64, u64)> {
    let last = history.len() as u64 - 1;
    let mut visits: Vec<(u64, u64)> = Vec::new();
    let mut at = 0;
    for stride in strides.iter().cycle() {
        let next = (at + stride).min(last);
        visits.push((at, next));
        at = next;
        if at == last {
            break;
        }
    }
    visits
}

fn strides() -> impl Strategy<Value = Vec<u64>> {
    prop::collection::vec(1_u64..5, 1..8)
}

/// A mirror after a message that starts from 0.
fn mirror_of(history: &History, frame: u64) -> TrackMirror {
    let mut mirror = TrackMirror::new();
    mirror.apply(&message(history, 0, frame, TracksWanted::Cycles)).expect("a start can always be taken");
    mirror
}

/// Checks that a message gives this error, and that the mirror then accepts only a message that starts from 0.
fn check_refused(history: &History, from: u64, wrong: &Tracks, error: TrackMirrorError) -> Result<(), TestCaseError> {
    let mut mirror = mirror_of(history, from);
    let right = message(history, from, wrong.frame, TracksWanted::Cycles);
    prop_assert_eq!(mirror.apply(wrong), Err(error));
    prop_assert!(mirror.needs_start());
    for next in [&right, &Tracks { from: mirror.frame(), frame: wrong.frame + 1, ..right.clone() }] {
        prop_assert_eq!(mirror.apply(next), Err(TrackMirrorError::Lost));
    }
    let start = message(history, 0, wrong.frame, TracksWanted::Cycles);
    prop_assert_eq!(mirror.apply(&start), Ok(()));
    prop_assert_eq!(mirror, mirror_of(history, wrong.frame));
    Ok(())
}

/// The last two frames of a history, if a track is alive in the first of them.
fn last_two(history: &History) -> Option<(u64, u64)> {
    let last = history.len() as u64 - 1;
    (last >= 2 && !history[last as usize].alive.is_empty()).then_some((last - 1, last))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    /// The number of frames in a message does not matter.
    #[test]
    fn events_alone_lead_to_the_list_of_living_tracks(history in histories(), strides in strides()) {
        let (mut by_events, mut by_lists) = (TrackMirror::new(), TrackMirror::new());
        let mut first = 0;
        for (from, frame) in visits(&history, &strides) {
            prop_assert_eq!(by_lists.apply(&message(&history, from, frame, TracksWanted::Alive)), Ok(()));
            prop_assert_eq!(by_lists.alive(), &history[frame as usize].alive);
            prop_assert!(by_lists.cycles().is_empty());
            let news = message(&history, by_events.frame(), frame, TracksWanted::Events);
            // A consumer that wants events alone gets no message for frames without events.
            if by_events.frame() == 0 || !news.events.is_empty() {
                prop_assert_eq!(by_events.apply(&news), Ok(()));
                prop_assert_eq!((by_events.frame(), by_events.time()), (frame, time(frame)));
                first = if first == 0 { frame } else { first };
            }
            let known = |mirror: &TrackMirror| -> Vec<(u64, bool)> {
                mirror.alive().values().map(|track| (track.id, track.selected)).collect()
            };
            prop_assert_eq!(known(&by_events), known(&by_lists));
            for (id, track) in by_events.alive() {
                // A track without an event since the start is held in its state at the start.
                let is_reported = (first + 1..=frame).any(|frame| {
                    history[frame as usize].events.iter().any(|event| event.track.id == *id)
                });
                let expected = if is_reported { &history[frame as usize].reported } else { &history[first as usize].alive };
                prop_assert_eq!(Some(track), expected.get(id));
            }
        }
    }

    #[test]
    fn cycles_are_those_of_living_tracks(history in histories(), strides in strides()) {
        let mut mirror = TrackMirror::new();
        prop_assert!(mirror.needs_start());
        for (from, frame) in visits(&history, &strides) {
            prop_assert_eq!(mirror.apply(&message(&history, from, frame, TracksWanted::Cycles)), Ok(()));
            prop_assert_eq!(mirror.cycles(), &history[frame as usize].cycles);
            prop_assert_eq!(&mirror, &mirror_of(&history, frame));
            prop_assert!(!mirror.needs_start());
        }
    }

    #[test]
    fn a_message_from_another_frame_is_a_gap(history in histories(), from in 1_u64..40, to in 1_u64..40) {
        let Some((held, _)) = last_two(&history) else { return Ok(()) };
        prop_assume!(from != held || to <= from);
        let empty = Tracks { stream: 3, from, frame: to, time: None, events: vec![], alive: None, cycles: vec![] };
        let mut mirror = mirror_of(&history, held);
        prop_assert_eq!(mirror.apply(&empty), Err(TrackMirrorError::Gap { holds: held, from, to }));
        // The content is unchanged: no part of the message was applied.
        prop_assert_eq!((mirror.alive(), mirror.frame()), (&history[held as usize].alive, held));
        prop_assert!(mirror.needs_start());
    }

    /// If any event is left out that begins or ends a track or changes its selection, then the list of living tracks
    /// shows it.
    #[test]
    fn a_missing_event_is_detected(history in histories(), strides in strides(), which in any::<Index>()) {
        let Some(&(from, frame)) = visits(&history, &strides).last().filter(|(from, _)| *from > 0) else { return Ok(()) };
        let right = message(&history, from, frame, TracksWanted::Alive);
        prop_assume!(!right.events.is_empty());
        let mut wrong = right.clone();
        let gone = wrong.events.remove(which.index(right.events.len()));
        let mut mirror = mirror_of(&history, from);
        let applied = mirror.apply(&wrong);
        let id = gone.track.id;
        let matters = !matches!(gone.happening, Happening::Updated(_));
        // Two events may cancel each other: a track begins and ends, or is unselected and reselected.
        let was = history[from as usize].alive.get(&id).map(|track| track.selected);
        let is = history[frame as usize].alive.get(&id).map(|track| track.selected);
        if matters && was != is && right.events.iter().filter(|event| involves(event, id)).count() == 1 {
            prop_assert_eq!(applied, Err(TrackMirrorError::Contradiction { frame, track: id }));
        }
        prop_assert_eq!(applied.is_err(), mirror.needs_start());
    }

    #[test]
    fn events_must_be_of_living_tracks(history in histories(), subject in any::<Index>()) {
        let Some((from, frame)) = last_two(&history) else { return Ok(()) };
        let empty = Tracks {
            stream: 3, from, frame, time: None, events: vec![], alive: None, cycles: vec![],
        };
        let message_of = |happening, id| Tracks {
            events: vec![TrackEvent { frame, time: None, happening, track: track(id) }],
            ..empty.clone()
        };
        let unknown = 1_000;
        let not_alive = |track| TrackMirrorError::NotAlive { frame, track };
        let changes = TrackChanges { center: true, birth: false, death: false };
        for happening in [Happening::Updated(changes), Happening::Unselected, Happening::Reselected, Happening::Died] {
            check_refused(&history, from, &message_of(happening, unknown), not_alive(unknown))?;
        }
        check_refused(&history, from, &message_of(Happening::Merged(1), unknown), not_alive(unknown))?;
        check_refused(&history, from, &message_of(Happening::Split(unknown), 1_001), not_alive(unknown))?;
        check_refused(&history, from, &message_of(Happening::Split(unknown), unknown), not_alive(unknown))?;
        let orphan = Tracks { cycles: vec![TrackCycle { id: unknown, walks: vec![] }], ..empty.clone() };
        check_refused(&history, from, &orphan, not_alive(unknown))?;
        let living: Vec<u64> = history[from as usize].alive.keys().copied().collect();
        if !living.is_empty() {
            let id = living[subject.index(living.len())];
            let alive = TrackMirrorError::Alive { frame, track: id };
            check_refused(&history, from, &message_of(Happening::Born, id), alive)?;
            check_refused(&history, from, &message_of(Happening::Split(id), id), alive)?;
            check_refused(&history, from, &message_of(Happening::Merged(id), id), not_alive(id))?;
            check_refused(&history, from, &message_of(Happening::Merged(unknown), id), not_alive(unknown))?;
        }
    }

    #[test]
    fn lists_that_contradict_events_are_refused(history in histories(), subject in any::<Index>()) {
        let Some((from, frame)) = last_two(&history) else { return Ok(()) };
        let right = message(&history, from, frame, TracksWanted::Cycles);
        let listed = right.alive.clone().expect("it was wanted");
        let place = subject.index(listed.len());
        let contradiction = |track| TrackMirrorError::Contradiction { frame, track };
        let with = |alive: Vec<Track>| Tracks { alive: Some(alive), ..right.clone() };
        let mut fewer = listed.clone();
        let gone = fewer.remove(place).id;
        check_refused(&history, from, &with(fewer), contradiction(gone))?;
        let more = [listed.clone(), vec![track(1_000)]].concat();
        check_refused(&history, from, &with(more), contradiction(1_000))?;
        let mut swayed = listed.clone();
        swayed[place].selected ^= true;
        check_refused(&history, from, &with(swayed), contradiction(listed[place].id))?;
        let mut twice = listed.clone();
        twice.insert(place, listed[place]);
        let order = TrackMirrorError::Order { frame, track: listed[place].id };
        check_refused(&history, from, &with(twice), order)?;
    }
}

// ---- by hand

fn start() -> Tracks {
    let cycles = vec![TrackCycle { id: 2, walks: vec![vec![4, 5, 6]] }];
    Tracks {
        stream: 3,
        from: 0,
        frame: 10,
        time: Some(1.0),
        events: vec![],
        alive: Some(vec![track(2), track(5)]),
        cycles,
    }
}

fn event(frame: u64, happening: Happening, id: u64) -> TrackEvent {
    TrackEvent { frame, time: None, happening, track: track(id) }
}

fn onwards(frame: u64, events: Vec<TrackEvent>) -> Tracks {
    Tracks { from: 10, frame, time: None, events, alive: None, cycles: vec![], ..start() }
}

fn started() -> TrackMirror {
    let mut mirror = TrackMirror::new();
    assert_eq!(mirror.apply(&start()), Ok(()));
    mirror
}

#[test]
fn a_new_mirror_is_empty_and_needs_a_start() {
    let mut mirror = TrackMirror::new();
    assert_eq!((mirror.frame(), mirror.time(), mirror.needs_start()), (0, None, true));
    assert!(mirror.alive().is_empty() && mirror.cycles().is_empty());
    assert_eq!(mirror.apply(&onwards(11, vec![])), Err(TrackMirrorError::Gap { holds: 0, from: 10, to: 11 }));
}

#[test]
fn a_start_is_only_a_list_of_living_tracks() {
    for (wrong, error) in [
        (Tracks { alive: None, ..start() }, TrackMirrorError::NoStart { frame: 10 }),
        (Tracks { events: vec![event(10, Happening::Died, 2)], ..start() }, TrackMirrorError::NoStart { frame: 10 }),
        (Tracks { frame: 0, ..start() }, TrackMirrorError::Gap { holds: 0, from: 0, to: 0 }),
    ] {
        let mut mirror = started();
        assert_eq!(mirror.apply(&wrong), Err(error));
        assert!(mirror.needs_start() && mirror.alive().is_empty(), "a message from 0 replaces the content");
    }
}

/// A stream that was created again counts frames from 1 again.
#[test]
fn a_start_may_be_of_an_earlier_frame() {
    let mut mirror = started();
    let again = Tracks { frame: 1, alive: Some(vec![track(1)]), cycles: vec![], ..start() };
    assert_eq!(mirror.apply(&again), Ok(()));
    assert_eq!((mirror.frame(), mirror.alive().len(), mirror.cycles().len()), (1, 1, 0));
}

#[test]
fn a_track_may_begin_and_end_within_one_message() {
    let mut mirror = started();
    let events = vec![
        event(11, Happening::Split(5), 6),
        event(12, Happening::Merged(5), 2),
        event(12, Happening::Unselected, 6),
        event(13, Happening::Died, 6),
    ];
    assert_eq!(mirror.apply(&onwards(13, events)), Ok(()));
    assert_eq!(mirror.alive().keys().collect::<Vec<_>>(), [&5]);
    assert!(mirror.cycles().is_empty(), "a cycle goes with its track");
}

#[test]
fn events_are_sorted_by_frame_then_by_track() {
    let updated = |frame, id| event(frame, Happening::Reselected, id);
    for (events, track) in [
        (vec![updated(12, 2), updated(11, 5)], 5),
        (vec![updated(11, 5), updated(11, 2)], 2),
        (vec![updated(10, 5)], 5),
        (vec![updated(11, 2), updated(14, 5)], 5),
    ] {
        let mut mirror = started();
        assert_eq!(mirror.apply(&onwards(13, events)), Err(TrackMirrorError::Order { frame: 13, track }));
        assert_eq!(mirror.alive().len(), 2, "nothing of it was applied");
    }
    let mut mirror = started();
    let several = vec![updated(11, 5), event(11, Happening::Unselected, 5), updated(12, 2), updated(12, 5)];
    assert_eq!(mirror.apply(&onwards(13, several)), Ok(()), "several of one track in one frame");
    for ids in [[5, 2], [2, 2]] {
        let cycles = ids.map(|id| TrackCycle { id, walks: vec![] }).to_vec();
        let wrong = Tracks { cycles, ..start() };
        assert_eq!(started().apply(&wrong), Err(TrackMirrorError::Order { frame: 10, track: 2 }));
    }
}

#[test]
fn errors_state_the_cause_and_the_remedy() {
    let texts = [
        (
            TrackMirrorError::Gap { holds: 3, from: 5, to: 6 },
            "tracks of frame 6 start from frame 5, but the mirror holds frame 3",
        ),
        (TrackMirrorError::NoStart { frame: 6 }, "tracks of frame 6 start anew, but"),
        (TrackMirrorError::Order { frame: 6, track: 2 }, "tracks of frame 6 name track 2 out of order"),
        (TrackMirrorError::NotAlive { frame: 6, track: 2 }, "tracks of frame 6 name track 2, which is not alive"),
        (TrackMirrorError::Alive { frame: 6, track: 2 }, "in frame 6 track 2 begins, which is alive already"),
        (TrackMirrorError::Contradiction { frame: 6, track: 2 }, "the living tracks of frame 6 are not those"),
        (TrackMirrorError::Lost, "the mirror of tracks has lost its place"),
    ];
    for (error, text) in texts {
        let said = error.to_string();
        assert!(said.starts_with(text) && said.ends_with("ask for tracks again"), "{said}");
    }
}
