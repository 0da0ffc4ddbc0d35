//! Tracks and their events, as they are reported.
//!
//! In: nothing.
//! Out: the types that a tracker gives.
//! Must not know: how tracks are found, formats.

use crate::topology::skeleton::Hole;

/// The number and time of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameStamp {
    /// The number.
    pub number: u64,
    /// The time.
    pub time: Option<f64>,
}

/// The id of a track: counts from 1 in order of announcement, never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u64);

/// A tracked persistent cycle, as it was last detected. Scales are radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Its id.
    pub id: TrackId,
    /// The number of frames since its first detection, including that frame and this one.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
    /// The last point of its hole to be filled.
    pub hole: Hole,
    /// The area of its hole at birth, without islands. Found when the track begins, and then in turn with those of all
    /// other tracks: each frame, as many regions as have 256 vertices together.
    pub area: f64,
    /// The movement of the hole's centre in a frame.
    pub velocity: [f64; 2],
    /// Whether it is selected, as last reported.
    pub is_selected: bool,
}

impl Track {
    /// Death minus birth.
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

/// What of a track has changed by more than the tracker's `delta`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// The hole's centre.
    pub center: bool,
    /// The birth.
    pub birth: bool,
    /// The death, which is the hole's radius.
    pub death: bool,
}

impl Changed {
    /// Whether anything has changed.
    pub(super) fn any(self) -> bool {
        self.center || self.birth || self.death
    }
}

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// The track begins.
    Born,
    /// The track begins inside the hole of another track.
    Split {
        /// The other track, which goes on.
        from: TrackId,
    },
    /// The track has moved or changed since it was last reported.
    Updated(Changed),
    /// The track goes on, but is not selected any more.
    Unselected,
    /// The track is selected again.
    Reselected {
        /// The number of frames in which it was missing and remembered; 0 if it was not.
        gone: u64,
    },
    /// The track ends inside the hole of another track.
    Merged {
        /// The other track, which goes on.
        into: TrackId,
    },
    /// The track ends.
    Died,
}

/// An event of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackEvent<T = Track> {
    /// The number of the frame.
    pub frame: u64,
    /// The time of the frame.
    pub time: Option<f64>,
    /// The kind.
    pub kind: EventKind,
    /// The track after the event.
    pub track: T,
}

/// The events of all tracks up to a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackStep<T = Track> {
    /// The number of the frame.
    pub number: u64,
    /// The time of the frame.
    pub time: Option<f64>,
    /// In order of track ids; for one track, in order of [`EventKind`].
    pub events: Vec<TrackEvent<T>>,
    /// All tracks that were announced and have not ended, by id.
    pub alive: Vec<T>,
    /// The number of dots that the rule selects beyond the largest number of detections: the least persistent ones.
    pub left_out: usize,
}

impl<T> Default for TrackStep<T> {
    fn default() -> Self {
        Self { number: 0, time: None, events: Vec::new(), alive: Vec::new(), left_out: 0 }
    }
}
