//! Messages about tracks (SPEC.md, section 9); since version 2.
//!
//! Invariants: a released message is never changed, and cases of a choice are never put in another order; lists of tracks are sorted by id. Must not know: bytes.

use serde::{Deserialize, Serialize};

/// What a consumer wants to know of a stream's tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum TracksWanted {
    /// Nothing.
    #[default]
    No,
    /// What happens to them.
    Events,
    /// That, and all that are alive in every frame.
    Alive,
    /// That, and the cycles of those that are alive, when they change.
    Cycles,
}

/// Sees tracks, or other ones than before, from here on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WantTracks {
    /// What of them.
    pub tracks: TracksWanted,
}

/// A persistent cycle that is followed, as it was last seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Never given twice within the stream's epoch.
    pub id: u64,
    /// Frames since it was first seen, both ends among them.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
    /// Where its hole is filled.
    pub center: (f64, f64),
    /// From there to the nearest points.
    pub radius: f64,
    /// Of its hole at birth, islands left out, when that was looked at last.
    pub area: f64,
    /// Of the centre, a frame.
    pub velocity: (f64, f64),
    /// Whether it is selected.
    pub selected: bool,
}

/// What of a track has changed by more than was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackChanges {
    /// The hole's centre.
    pub center: bool,
    /// The birth.
    pub birth: bool,
    /// The death.
    pub death: bool,
}

/// What has happened to a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Happening {
    /// It begins.
    Born,
    /// It begins inside what the hole of this one was, which goes on.
    Split(u64),
    /// It has moved or changed since it was last told of.
    Updated(TrackChanges),
    /// It goes on, out of the selection.
    Unselected,
    /// It is selected again.
    Reselected,
    /// It ends inside the hole of this one, which goes on.
    Merged(u64),
    /// It ends.
    Died,
}

/// Something that has happened to a track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackEvent {
    /// In which frame.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// What.
    pub happening: Happening,
    /// To whom.
    pub track: Track,
}

/// The cycle of a track.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackCycle {
    /// The track's.
    pub id: u64,
    /// Closed walks along vertices, by their ids, around the hole at its birth: the outer one counter-clockwise, then those around islands in it, clockwise. None, while the
    /// track is not there.
    pub walks: Vec<Vec<u64>>,
}

/// What has happened to tracks up to a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracks {
    /// The stream's number.
    pub stream: u32,
    /// The frame that was told of before; 0: what was told before means nothing, and all that are alive stand here.
    pub from: u64,
    /// The frame that this leads to.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// By frame, then by track.
    pub events: Vec<TrackEvent>,
    /// All that are alive, if that was wanted or if this starts from 0.
    pub alive: Option<Vec<Track>>,
    /// Cycles that have changed, if they were wanted.
    pub cycles: Vec<TrackCycle>,
}
