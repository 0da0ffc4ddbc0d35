//! Samples of the messages about tracks (SPEC.md, section 9), all of version 2, and one message of version 1 in a frame
//! of version 2.
//!
//! In: nothing. Out: samples.
//!
//! Invariants: `tracks_start`, `tracks` and `tracks_merged` are one sequence as a client would receive it, and so are
//! `tracks_start_events` and `tracks_events`. Otherwise as in the parent module.

use hopes_protocol::{Happening, Ping, Track, TrackChanges, TrackCycle, TrackEvent, Tracks, TracksWanted, WantTracks};

use super::{BORDERS, SPECIAL, Sample, sample};

pub fn samples() -> Vec<Sample> {
    [wanted(), sequence(), events_alone(), nothing(), borders(), older()].concat()
}

fn wanted() -> Vec<Sample> {
    let want = |tracks| WantTracks { tracks };
    vec![
        sample("want_tracks", 11, want(TracksWanted::Cycles)),
        sample("want_tracks_alive", 12, want(TracksWanted::Alive)),
        sample("want_tracks_events", 13, want(TracksWanted::Events)),
        sample("want_tracks_no", 14, want(TracksWanted::No)),
    ]
}

/// A large hole that stays. There is a small one beside it.
fn large(age: u64) -> Track {
    let (center, velocity) = ((1.0, -2.5), (0.25, -0.125));
    Track { id: 1, age, birth: 0.75, death: 8.5, center, radius: 8.25, area: 226.5, velocity, selected: true }
}

fn small(age: u64, selected: bool) -> Track {
    let (center, velocity) = ((20.5, 3.0), (0.0, -0.0));
    Track { id: 2, age, birth: 0.5, death: 2.0, center, radius: 1.75, area: 12.25, velocity, selected }
}

/// The hole that splits off.
fn part(age: u64) -> Track {
    Track { id: 3, death: 3.5, center: (4.5, -2.0), radius: 3.25, area: 33.5, ..large(age) }
}

fn event(frame: u64, time: Option<f64>, happening: Happening, track: Track) -> TrackEvent {
    TrackEvent { frame, time, happening, track }
}

fn updated(center: bool, birth: bool, death: bool) -> Happening {
    Happening::Updated(TrackChanges { center, birth, death })
}

/// Lists of living tracks and cycles. The first message lists everything.
fn sequence() -> Vec<Sample> {
    let cycle = |id, walks: &[&[u64]]| TrackCycle { id, walks: walks.iter().map(|walk| walk.to_vec()).collect() };
    let start = Tracks {
        stream: 4,
        from: 0,
        frame: 11,
        time: Some(12.5),
        events: vec![],
        alive: Some(vec![large(9), small(4, true)]),
        cycles: vec![cycle(1, &[&[0, 1, 2, 250, 251], &[7, 9, 8]]), cycle(2, &[&[65_535, 65_536, u64::MAX]])],
    };
    let now = Some(13.5);
    let onwards = Tracks {
        from: 11,
        frame: 12,
        time: now,
        events: vec![
            event(12, now, updated(true, false, true), Track { death: 8.0, ..large(10) }),
            event(12, now, updated(false, true, false), small(5, true)),
            event(12, now, Happening::Unselected, small(5, false)),
            event(12, now, Happening::Split(1), part(2)),
        ],
        alive: Some(vec![Track { death: 8.0, ..large(10) }, small(5, false), part(2)]),
        cycles: vec![cycle(1, &[&[0, 1, 251]]), cycle(3, &[&[1, 2, 250]])],
        ..start.clone()
    };
    let late = Track { id: 251, age: 2, selected: false, ..part(2) };
    let merged = Tracks {
        from: 12,
        frame: 20,
        time: None,
        events: vec![
            event(13, Some(14.5), updated(false, true, false), small(6, false)),
            event(14, Some(15.5), Happening::Reselected, small(7, true)),
            event(15, None, updated(false, false, false), large(13)),
            event(15, None, Happening::Merged(1), part(4)),
            event(17, Some(17.0), Happening::Born, Track { selected: true, ..late }),
            event(18, None, Happening::Unselected, Track { age: 3, ..late }),
            event(20, None, Happening::Died, small(9, true)),
        ],
        alive: Some(vec![large(18), Track { age: 5, ..late }]),
        cycles: vec![cycle(1, &[&[0, 2, 251], &[8, 7, 9]])],
        ..start.clone()
    };
    vec![sample("tracks", 11, onwards), sample("tracks_start", 11, start), sample("tracks_merged", 11, merged)]
}

/// Events alone. Each kind of event occurs once.
fn events_alone() -> Vec<Sample> {
    let start = Tracks {
        stream: 5,
        from: 0,
        frame: 250,
        time: None,
        events: vec![],
        alive: Some(vec![large(2)]),
        cycles: vec![],
    };
    let ones = [
        updated(false, true, false),
        updated(false, false, true),
        Happening::Unselected,
        Happening::Reselected,
        Happening::Died,
    ];
    let numbered = |(frame, happening)| {
        event(frame, None, happening, Track { selected: happening != Happening::Unselected, ..large(frame - 248) })
    };
    let events: Vec<TrackEvent> = (251..).zip(ones).map(numbered).collect();
    let together = Tracks { from: 250, frame: 255, events: events.clone(), alive: None, ..start.clone() };
    let alone = |name: &'static str, from: u64, event: TrackEvent| {
        sample(name, 0xFFFF, Tracks { from, frame: event.frame, events: vec![event], ..together.clone() })
    };
    let first = |happening| event(u64::MAX, Some(-0.0), happening, small(1, false));
    vec![
        sample("tracks_start_events", 21, start.clone()),
        sample("tracks_events", 21, together.clone()),
        alone("tracks_updated", 250, events[0]),
        alone("tracks_updated_death", 251, events[1]),
        alone("tracks_unselected", 252, events[2]),
        alone("tracks_reselected", 253, events[3]),
        alone("tracks_died", 254, events[4]),
        alone("tracks_born", 65_535, first(Happening::Born)),
        alone("tracks_split", 65_536, first(Happening::Split(251))),
        alone("tracks_merge", 0xFFFF_FFFF, first(Happening::Merged(0x1_0000_0000))),
    ]
}

/// Empty lists of every kind.
fn nothing() -> Vec<Sample> {
    let none = Tracks {
        stream: u32::MAX,
        from: 65_536,
        frame: 0x1_0000_0000,
        time: Some(5e-324),
        events: vec![],
        alive: None,
        cycles: vec![],
    };
    let start = Tracks { from: 0, alive: Some(vec![]), ..none.clone() };
    let point = |id, walks| TrackCycle { id, walks };
    let cycles = vec![point(250, vec![]), point(251, vec![vec![]])];
    vec![
        sample("tracks_none", 11, none.clone()),
        sample("tracks_start_nothing", 11, start),
        sample("tracks_walks_nothing", 11, Tracks { cycles: cycles.clone(), ..none.clone() }),
        sample("tracks_walk_nothing", 11, Tracks { cycles: cycles[1..].to_vec(), ..none }),
    ]
}

/// Numbers at the borders of the encoding, and special numbers.
fn borders() -> Vec<Sample> {
    let [a, b, c, d, e, f, g, h] = SPECIAL;
    let odd = |(id, age): (u64, u64)| Track {
        id,
        age,
        birth: a,
        death: b,
        center: (c, d),
        radius: e,
        area: f,
        velocity: (g, h),
        selected: id.is_multiple_of(2),
    };
    let alive = BORDERS.into_iter().zip(BORDERS.into_iter().rev()).map(odd).collect();
    let cycles = vec![TrackCycle { id: u64::MAX, walks: vec![BORDERS.to_vec(), (0..251).collect()] }];
    let tracks =
        Tracks { stream: 251, from: 0, frame: u64::MAX, time: Some(e), events: vec![], alive: Some(alive), cycles };
    vec![sample("tracks_borders", 0x0102_0304, tracks)]
}

/// A message of version 1 in a frame of version 2. Its body is the same.
fn older() -> Vec<Sample> {
    vec![Sample { version: 2, ..sample("ping", 0, Ping { token: 251 }) }]
}
