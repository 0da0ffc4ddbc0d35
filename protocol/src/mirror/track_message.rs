//! What a mirror of tracks reads of a message, whichever space the tracks are in.
//!
//! In: [`Tracks`] or [`SpaceTracks`]. Out: their frames, events and lists.
//!
//! Invariants: nothing is left out. Must not know: mirrors.

use std::fmt::Debug;

use crate::space::{SpaceTrack, SpaceTracks};
use crate::tracks::{Happening, Track, TrackCycle, Tracks};

/// The last reported state of a track.
pub trait TrackState: Clone + Debug + PartialEq {
    /// The track's id.
    fn id(&self) -> u64;

    /// Whether it is selected.
    fn is_selected(&self) -> bool;

    /// The number of coordinates of its centre and velocity. None: they differ, or one is not finite.
    fn dimension(&self) -> Option<usize>;
}

/// An event of a track.
#[derive(Clone, Copy, Debug)]
pub struct TrackStep<'a, T> {
    /// The frame of the event.
    pub frame: u64,
    /// The kind of event.
    pub happening: Happening,
    /// The track after the event.
    pub track: &'a T,
}

/// A message with the events of tracks.
pub trait TrackMessage {
    /// Its tracks.
    type Track: TrackState;

    /// The frame of the previous message, or 0.
    fn from(&self) -> u64;

    /// The frame that it leads to.
    fn frame(&self) -> u64;

    /// That frame's time.
    fn time(&self) -> Option<f64>;

    /// The events in their order.
    fn events(&self) -> impl Iterator<Item = TrackStep<'_, Self::Track>>;

    /// The list of living tracks, if it has one.
    fn alive(&self) -> Option<&[Self::Track]>;

    /// Cycles that have changed.
    fn cycles(&self) -> &[TrackCycle];
}

impl TrackState for Track {
    fn id(&self) -> u64 {
        self.id
    }

    fn is_selected(&self) -> bool {
        self.selected
    }

    fn dimension(&self) -> Option<usize> {
        Some(2)
    }
}

impl TrackState for SpaceTrack {
    fn id(&self) -> u64 {
        self.id
    }

    fn is_selected(&self) -> bool {
        self.selected
    }

    fn dimension(&self) -> Option<usize> {
        let are_finite = self.center.iter().chain(&self.velocity).all(|number| number.is_finite());
        (are_finite && self.center.len() == self.velocity.len()).then_some(self.center.len())
    }
}

macro_rules! track_message {
    ($message:ident of $track:ident) => {
        impl TrackMessage for $message {
            type Track = $track;

            fn from(&self) -> u64 {
                self.from
            }

            fn frame(&self) -> u64 {
                self.frame
            }

            fn time(&self) -> Option<f64> {
                self.time
            }

            fn events(&self) -> impl Iterator<Item = TrackStep<'_, $track>> {
                let events = self.events.iter();
                events.map(|event| TrackStep { frame: event.frame, happening: event.happening, track: &event.track })
            }

            fn alive(&self) -> Option<&[$track]> {
                self.alive.as_deref()
            }

            fn cycles(&self) -> &[TrackCycle] {
                &self.cycles
            }
        }
    };
}

track_message!(Tracks of Track);
track_message!(SpaceTracks of SpaceTrack);
