//! Tracks of a stream as messages: those of the plane, or those of a space.
//!
//! In: tracks and events of the core. Out: the same of the wire, and the messages that have them.
//!
//! Invariants: numbers go over bit by bit; what is infinite on one side is none on the other.
//!
//! Must not know: bytes, which tracks there are.

use std::fmt::Debug;

use hopes::topology::{EventKind, SpaceTrack, SpaceTrackEvent, Track, TrackEvent};
use hopes_protocol as wire;

/// What a message says of tracks besides them.
#[derive(Clone, Copy, Debug)]
pub struct TrackSpan {
    /// The stream.
    pub stream: u32,
    /// The frame of the message before; 0 for none.
    pub from: u64,
    /// The frame that it leads to.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
}

/// The kind of a stream's tracks, by the message that has them.
pub trait TrackKind: Debug {
    /// A track.
    type Track: wire::TrackState;
    /// What has happened to one.
    type Event: Clone + Debug;

    /// The message.
    fn message(
        span: TrackSpan,
        events: Vec<Self::Event>,
        alive: Option<Vec<Self::Track>>,
        cycles: Vec<wire::TrackCycle>,
    ) -> wire::Message;
}

impl TrackKind for wire::Tracks {
    type Track = wire::Track;
    type Event = wire::TrackEvent;

    fn message(
        TrackSpan { stream, from, frame, time }: TrackSpan,
        events: Vec<wire::TrackEvent>,
        alive: Option<Vec<wire::Track>>,
        cycles: Vec<wire::TrackCycle>,
    ) -> wire::Message {
        Self { stream, from, frame, time, events, alive, cycles }.into()
    }
}

impl TrackKind for wire::SpaceTracks {
    type Track = wire::SpaceTrack;
    type Event = wire::SpaceTrackEvent;

    fn message(
        TrackSpan { stream, from, frame, time }: TrackSpan,
        events: Vec<wire::SpaceTrackEvent>,
        alive: Option<Vec<wire::SpaceTrack>>,
        cycles: Vec<wire::TrackCycle>,
    ) -> wire::Message {
        Self { stream, from, frame, time, events, alive, cycles }.into()
    }
}

/// A track of the plane as it was last seen.
pub fn track(track: &Track) -> wire::Track {
    let &Track { id, age, birth, death, hole, area, velocity, is_selected } = track;
    let (center, velocity) = (hole.center.into(), velocity.into());
    wire::Track { id: id.0, age, birth, death, center, radius: hole.radius, area, velocity, selected: is_selected }
}

/// What has happened to a track of the plane.
pub fn track_event(event: &TrackEvent) -> wire::TrackEvent {
    let (happening, time) = (happening(event.kind), event.time.filter(|time| time.is_finite()));
    wire::TrackEvent { frame: event.frame, time, happening, track: track(&event.track) }
}

/// A track of a space as it was last seen.
pub fn space_track(track: &SpaceTrack) -> wire::SpaceTrack {
    let &SpaceTrack { id, age, birth, death, ref center, radius, ref velocity, is_selected } = track;
    let death = Some(death).filter(|death| death.is_finite());
    let (center, velocity) = (center.clone(), velocity.clone());
    wire::SpaceTrack { id: id.0, age, birth, death, center, radius, velocity, selected: is_selected }
}

/// What has happened to a track of a space.
pub fn space_track_event(event: &SpaceTrackEvent) -> wire::SpaceTrackEvent {
    let (happening, time) = (happening(event.kind), event.time.filter(|time| time.is_finite()));
    wire::SpaceTrackEvent { frame: event.frame, time, happening, track: space_track(&event.track) }
}

fn happening(kind: EventKind) -> wire::Happening {
    match kind {
        EventKind::Born => wire::Happening::Born,
        EventKind::Split { from } => wire::Happening::Split(from.0),
        EventKind::Updated(changed) => {
            let hopes::topology::Changed { center, birth, death } = changed;
            wire::Happening::Updated(wire::TrackChanges { center, birth, death })
        }
        EventKind::Unselected => wire::Happening::Unselected,
        EventKind::Reselected { .. } => wire::Happening::Reselected,
        EventKind::Merged { into } => wire::Happening::Merged(into.0),
        EventKind::Died => wire::Happening::Died,
    }
}
