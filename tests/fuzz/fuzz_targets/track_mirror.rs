//! A mirror of tracks: any messages lead to living tracks or to an error, and it makes no difference whether living
//! tracks are known by events, by lists, or by a new start.
//!
//! The input: steps, by `arbitrary`.
#![no_main]

use arbitrary::Arbitrary;
use hopes_protocol::{Happening, Track, TrackChanges, TrackCycle, TrackEvent, TrackMirror, TrackMirrorError, Tracks};
use libfuzzer_sys::fuzz_target;

/// Ids are few, so that steps meet the same tracks.
type Id = u8;

#[derive(Arbitrary, Debug)]
struct Step {
    /// The frame that it starts from, if it is not the mirror's.
    from: Option<u8>,
    by: u8,
    /// Frame, kind, track, selected.
    events: Vec<(u8, Kind, Id, bool)>,
    alive: Option<Vec<(Id, bool)>>,
    cycles: Vec<(Id, Vec<Vec<Id>>)>,
    is_sorted: bool,
}

#[derive(Arbitrary, Debug)]
enum Kind {
    Born,
    Split(Id),
    Updated,
    Unselected,
    Reselected,
    Merged(Id),
    Died,
}

fuzz_target!(|steps: Vec<Step>| {
    let mut mirror = TrackMirror::new();
    for step in &steps {
        let message = message(step, mirror.frame());
        take(&mut mirror, &message);
    }
});

fn take(mirror: &mut TrackMirror, message: &Tracks) {
    let before = mirror.clone();
    let applied = mirror.apply(message);
    assert_eq!(applied.is_err(), mirror.needs_start(), "{applied:?}");
    match applied {
        Ok(()) => check(&before, mirror, message),
        Err(TrackMirrorError::Lost) => assert!(before.needs_start() && message.from != 0),
        Err(error) => assert!(error.to_string().len() < 200, "{error}"),
    }
}

fn check(before: &TrackMirror, mirror: &TrackMirror, message: &Tracks) {
    assert_eq!((mirror.frame(), mirror.time()), (message.frame, message.time));
    assert!(mirror.cycles().keys().all(|id| mirror.alive().contains_key(id)), "only living tracks have cycles");
    let arrived = message.events.len() + message.alive.as_ref().map_or(0, Vec::len);
    let held = if message.from == 0 { 0 } else { before.alive().len() };
    assert!(mirror.alive().len() <= held + arrived, "nothing is alive that did not begin");
    let alive: Vec<Track> = mirror.alive().values().copied().collect();

    let listed = Tracks { alive: Some(alive.clone()), ..message.clone() };
    let mut other = before.clone();
    assert_eq!((other.apply(&listed), &other), (Ok(()), mirror), "the list of the living changes nothing");

    let cycles = mirror.cycles().iter().map(|(&id, walks)| TrackCycle { id, walks: walks.clone() }).collect();
    let start = Tracks { from: 0, events: Vec::new(), alive: Some(alive), cycles, ..message.clone() };
    assert_eq!((other.apply(&start), &other), (Ok(()), mirror), "a new start says the same");
}

fn message(step: &Step, held: u64) -> Tracks {
    let from = step.from.map_or(held, u64::from);
    let mut events: Vec<TrackEvent> = step
        .events
        .iter()
        .map(|(frame, kind, id, selected)| event(from + u64::from(*frame), kind, *id, *selected))
        .collect();
    let mut alive: Option<Vec<Track>> =
        step.alive.as_ref().map(|alive| alive.iter().map(|&(id, selected)| track(id, selected)).collect());
    let walks = |walks: &[Vec<Id>]| walks.iter().map(|walk| walk.iter().map(|&id| id.into()).collect()).collect();
    let mut cycles: Vec<TrackCycle> =
        step.cycles.iter().map(|(id, list)| TrackCycle { id: (*id).into(), walks: walks(list) }).collect();
    if step.is_sorted {
        events.sort_by_key(|event| (event.frame, event.track.id));
        cycles.sort_by_key(|cycle| cycle.id);
        cycles.dedup_by_key(|cycle| cycle.id);
        if let Some(alive) = &mut alive {
            alive.sort_by_key(|track| track.id);
            alive.dedup_by_key(|track| track.id);
        }
    }
    Tracks { stream: 1, from, frame: from + u64::from(step.by), time: Some(step.by.into()), events, alive, cycles }
}

fn event(frame: u64, kind: &Kind, id: Id, selected: bool) -> TrackEvent {
    let happening = match *kind {
        Kind::Born => Happening::Born,
        Kind::Split(other) => Happening::Split(other.into()),
        Kind::Updated => Happening::Updated(TrackChanges { center: selected, birth: true, death: false }),
        Kind::Unselected => Happening::Unselected,
        Kind::Reselected => Happening::Reselected,
        Kind::Merged(other) => Happening::Merged(other.into()),
        Kind::Died => Happening::Died,
    };
    TrackEvent { frame, time: None, happening, track: track(id, selected) }
}

fn track(id: Id, selected: bool) -> Track {
    Track {
        id: id.into(),
        age: 1,
        birth: 1.0,
        death: 2.0,
        center: (0.0, f64::from(id)),
        radius: 2.0,
        area: 4.0,
        velocity: (0.0, 0.0),
        selected,
    }
}
