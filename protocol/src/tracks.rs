//! Messages about tracks (SPEC.md, section 9). Since version 2.
//!
//! Invariants: a released message never changes, and the cases of an enum keep their order. Lists of tracks are sorted
//! by id.
//!
//! Must not know: bytes.

use serde::{Deserialize, Serialize};

/// What a consumer wants of a stream's tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum TracksWanted {
    /// Nothing.
    #[default]
    No,
    /// Their events.
    Events,
    /// Their events, and the list of living tracks in every frame.
    Alive,
    /// All of that, and the cycles of living tracks when they change.
    Cycles,
}

/// Starts to follow tracks, or changes what is sent of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WantTracks {
    /// What to send.
    pub tracks: TracksWanted,
}

/// A persistent cycle that is followed over time, in its last seen state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Unique within the stream's epoch.
    pub id: u64,
    /// The number of frames from the first to the last in which it was seen.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
    /// Where its hole is filled.
    pub center: (f64, f64),
    /// The distance from there to the nearest points.
    pub radius: f64,
    /// The area of its hole at birth, without islands, when it was last computed.
    pub area: f64,
    /// The movement of the centre in one frame.
    pub velocity: (f64, f64),
    /// Whether it is selected.
    pub selected: bool,
}

/// Which values of a track have changed by more than the reporting threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackChanges {
    /// The hole's centre.
    pub center: bool,
    /// The birth.
    pub birth: bool,
    /// The death.
    pub death: bool,
}

/// The kinds of events of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Happening {
    /// The track begins.
    Born,
    /// The track begins inside the former hole of this other track, which goes on.
    Split(u64),
    /// The track has moved or changed since its last report.
    Updated(TrackChanges),
    /// The track goes on, but is no longer selected.
    Unselected,
    /// The track is selected again.
    Reselected,
    /// The track ends inside the hole of this other track, which goes on.
    Merged(u64),
    /// The track ends.
    Died,
}

/// An event of a track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackEvent {
    /// The frame of the event.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// The kind of event.
    pub happening: Happening,
    /// The track after the event.
    pub track: Track,
}

/// The cycle of a track.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackCycle {
    /// The track's id.
    pub id: u64,
    /// Closed walks along vertices, by their ids, around the hole at its birth. The outer one runs counter-clockwise;
    /// then follow those around islands in the hole, clockwise. Empty while the hole is not seen.
    pub walks: Vec<Vec<u64>>,
}

/// The events of tracks up to a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracks {
    /// The stream's number.
    pub stream: u32,
    /// The frame of the previous message. 0: the consumer drops what it has, and `alive` lists all living tracks.
    pub from: u64,
    /// The frame that the message leads to.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// Sorted by frame, then by track.
    pub events: Vec<TrackEvent>,
    /// All living tracks, if the consumer asked for them or if the message starts from 0.
    pub alive: Option<Vec<Track>>,
    /// Cycles that have changed, if the consumer asked for them.
    pub cycles: Vec<TrackCycle>,
}
