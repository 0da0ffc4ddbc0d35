//! Tracks of a stream of either kind: of the plane, or in a space.
//!
//! In: frames of tracks. Out: the same, shared; messages.
//!
//! Invariants: a stream's log and its frames are of the stream's kind.
//!
//! Must not know: how tracks are found, who reads them.

use std::sync::Arc;

use hopes_protocol as wire;

use super::track_log::{NextTracks, TrackFrame, TrackLog, TrackPosition};

/// What has happened to tracks up to a frame.
#[derive(Clone, Debug)]
pub enum AnyTrackFrame {
    /// In the plane.
    Plane(Arc<TrackFrame<wire::Tracks>>),
    /// In a space.
    Space(Arc<TrackFrame<wire::SpaceTracks>>),
}

/// The last frames of a stream's tracks.
#[derive(Debug)]
pub enum AnyTrackLog {
    /// In the plane.
    Plane(TrackLog<wire::Tracks>),
    /// In a space.
    Space(TrackLog<wire::SpaceTracks>),
}

/// Calls the same of either kind.
macro_rules! either {
    ($type:ident, $any:expr, $name:ident => $call:expr) => {
        match $any {
            $type::Plane($name) => $call,
            $type::Space($name) => $call,
        }
    };
}

impl AnyTrackFrame {
    /// The frame.
    pub fn frame(&self) -> u64 {
        either!(Self, self, frame => frame.frame)
    }

    /// What has happened since the frame before, with all that are alive if these are wanted.
    pub fn changes(&self, stream: u32, with_alive: bool) -> wire::Message {
        either!(Self, self, frame => frame.changes(stream, with_alive))
    }

    /// The message that follows the frame `from` in a recording.
    pub fn message(&self, stream: u32, from: u64, with_alive: bool) -> wire::Message {
        either!(Self, self, frame => frame.message(stream, from, with_alive))
    }
}

impl AnyTrackLog {
    /// The log of a stream of the plane, or in a space.
    pub fn new(is_of_space: bool) -> Self {
        if is_of_space { Self::Space(TrackLog::default()) } else { Self::Plane(TrackLog::default()) }
    }

    /// Drops the oldest frames while all take more than `limit` bytes.
    pub fn shrink(&mut self, limit: usize) {
        either!(Self, self, log => log.shrink(limit));
    }

    /// The newest frame.
    pub fn newest(&self) -> Option<AnyTrackFrame> {
        match self {
            Self::Plane(log) => log.newest().cloned().map(AnyTrackFrame::Plane),
            Self::Space(log) => log.newest().cloned().map(AnyTrackFrame::Space),
        }
    }

    /// Appends the newest frame, or replaces it if it is there; drops the oldest while all take more than `limit`
    /// bytes. One of the other kind is none of this stream.
    pub fn push(&mut self, frame: &AnyTrackFrame, limit: usize) {
        match (self, frame) {
            (Self::Plane(log), AnyTrackFrame::Plane(frame)) => log.push(Arc::clone(frame), limit),
            (Self::Space(log), AnyTrackFrame::Space(frame)) => log.push(Arc::clone(frame), limit),
            _ => debug_assert!(false, "tracks are of their stream's kind"),
        }
    }

    /// What follows a position, up to the frame `at` that the consumer has of its view.
    pub fn next(&self, stream: u32, position: TrackPosition, at: u64, wanted: wire::TracksWanted) -> NextTracks {
        either!(Self, self, log => log.next(stream, position, at, wanted))
    }
}
