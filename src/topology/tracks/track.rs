//! Tracks and what happens to them, as a consumer is told.
//!
//! In: nothing. Out: the types that a tracker gives. Must not know: how tracks are found, formats.

use crate::topology::skeleton::Hole;

/// Names a track for good: they count from 1, in order of announcement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrackId(pub u64);

/// A persistent cycle that is followed, as it was last seen. Scales are radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    /// Its name.
    pub id: TrackId,
    /// Frames since it was first seen, that one and this one among them.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
    /// Where its hole is filled.
    pub hole: Hole,
    /// Of its hole at birth, islands left out. Looked at when the track begins, and from then on in turn with those of all others, as many a frame as have 256 vertices
    /// around them together.
    pub area: f64,
    /// Of the hole's centre, a frame.
    pub velocity: [f64; 2],
    /// Whether it is selected, as far as that was told.
    pub is_selected: bool,
}

impl Track {
    /// Death minus birth.
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

/// What of a track has changed by more than was asked for.
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
    /// Whether anything has.
    pub(super) fn any(self) -> bool {
        self.center || self.birth || self.death
    }
}

/// What has happened to a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// It begins.
    Born,
    /// It begins inside what another one's hole was.
    Split {
        /// The other one, which goes on.
        from: TrackId,
    },
    /// It has moved or changed since it was last told of.
    Updated(Changed),
    /// It goes on, out of the selection.
    Unselected,
    /// It is selected again.
    Reselected,
    /// It ends inside another one's hole.
    Merged {
        /// The other one, which goes on.
        into: TrackId,
    },
    /// It ends.
    Died,
}

/// Something that has happened to a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackEvent {
    /// In which frame.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// What.
    pub kind: EventKind,
    /// To whom.
    pub track: Track,
}

/// What has happened to tracks up to a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackStep {
    /// Number of the frame.
    pub number: u64,
    /// Its time.
    pub time: Option<f64>,
    /// In order of ids; of one track, in order of [`EventKind`].
    pub events: Vec<TrackEvent>,
    /// All tracks that have been announced and have not ended, by id.
    pub alive: Vec<Track>,
    /// Dots that the rule selects, and that were too many to be looked at: the least persistent ones.
    pub left_out: usize,
}
