//! The life of one track, announced or not, in any space: its hysteresis.
//!
//! In: whether it was seen in a frame, how persistent its dot is, and whether that is selected.
//! Out: whether it begins, leaves the selection or comes back.
//! Invariant: a track counts as selected or not as was last reported, until a run of frames on the other side reverses
//! it.
//! Must not know: other tracks, holes, cycles, how a track is recognized.

use std::num::NonZeroU32;

use super::rule::Remember;
use super::track::{Changed, EventKind, FrameStamp, TrackId};

/// A dot that is not selected continues a track down to this share of the persistence that the track had when it was
/// last selected.
const LEAST_SHARE: f64 = 0.5;

/// What is told of a track in any space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Its id; 0 before it is announced.
    pub id: TrackId,
    /// The number of frames since its first detection, including that frame and this one.
    pub age: u64,
    /// Whether it is selected, as last reported.
    pub is_selected: bool,
}

/// A track as it is reported.
pub trait Report: Clone {
    /// What is told of it in any space.
    fn status(&self) -> Status;
    /// Sets that.
    fn set_status(&mut self, status: Status);
    /// Birth and death.
    fn label(&self) -> [f64; 2];
}

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct Life<T> {
    pub key: u64,
    pub is_announced: bool,
    pub track: T,
    /// The track as it was last reported.
    pub reported: T,
    pub first_seen: u64,
    pub last_seen: u64,
    /// A dot of less persistence does not continue the track, unless the dot is selected.
    pub least: f64,
    /// The time of the frame in which it was seen last.
    pub last_time: Option<f64>,
    /// The number of consecutive frames without a detection.
    pub missed: u32,
    /// Whether it is remembered: it was missing for so long that it would have ended, and is not selected again since.
    pub is_remembered: bool,
    /// The number of frames in which it was missing until it was seen last, since it is remembered.
    pub gone: u64,
    /// The number of consecutive frames in which the dot was on the other side of the selection than was reported.
    pub selection_streak: u32,
    /// The key of the track that it was a part of before.
    pub parent: Option<u64>,
}

impl<T: Report> Life<T> {
    /// A track that begins in a frame, with a dot of some persistence.
    pub fn new(key: u64, at: FrameStamp, track: T, persistence: f64, parent: Option<u64>) -> Self {
        Self {
            key,
            is_announced: false,
            reported: track.clone(),
            track,
            first_seen: at.number,
            last_seen: at.number,
            last_time: at.time,
            least: LEAST_SHARE * persistence,
            missed: 0,
            is_remembered: false,
            gone: 0,
            selection_streak: 0,
            parent,
        }
    }

    /// Whether it is announced and was detected in the newest frame.
    pub fn is_detected(&self) -> bool {
        self.is_announced && self.missed == 0
    }

    /// Whether it is time to announce it.
    pub fn is_due(&self, frame: u64, confirm: NonZeroU32) -> bool {
        !self.is_announced && frame - self.first_seen + 1 >= u64::from(confirm.get())
    }

    /// Whether it is dropped without an event, since it was never announced and is not seen or not selected.
    pub fn is_void(&self) -> bool {
        !self.is_announced && (self.missed > 0 || !self.track.status().is_selected)
    }

    /// It goes on in a frame, with a dot of some persistence.
    pub fn see(&mut self, at: FrameStamp, persistence: f64, is_selected: bool) {
        let mut status = self.track.status();
        status.age = at.number - self.first_seen + 1;
        if self.is_remembered {
            self.gone += at.number - self.last_seen - 1;
        }
        (self.last_seen, self.last_time, self.missed) = (at.number, at.time, 0);
        if is_selected {
            self.least = LEAST_SHARE * persistence;
        }
        if !self.is_announced {
            status.is_selected = is_selected;
        }
        self.selection_streak =
            if is_selected == status.is_selected { 0 } else { self.selection_streak.saturating_add(1) };
        self.track.set_status(status);
    }

    /// Whether it is remembered in a frame in which it is missing.
    pub fn is_recalled(&self, at: FrameStamp, remember: Remember) -> bool {
        match remember {
            Remember::Frames(most) => at.number - self.last_seen <= most,
            Remember::Time(most) => match (self.last_time, at.time) {
                (Some(last), Some(now)) => now - last <= most,
                _ => false,
            },
        }
    }

    /// It is missing in a frame.
    pub fn miss(&mut self) {
        self.missed = self.missed.saturating_add(1);
        if self.is_remembered {
            // It is back once it is seen in consecutive frames.
            self.selection_streak = 0;
        }
    }

    /// What has changed since it was last reported. Its centre has moved so far since then.
    pub fn changed(&self, moved: f64, delta: f64) -> Option<Changed> {
        let ([birth, death], [old_birth, old_death]) = (self.track.label(), self.reported.label());
        let is_more = |a: f64, b: f64| (a - b).abs() > delta;
        let changed =
            Changed { center: moved > delta, birth: is_more(birth, old_birth), death: is_more(death, old_death) };
        changed.any().then_some(changed)
    }

    /// Whether it has left the selection or come back, for long enough.
    pub fn selection_change(&self, confirm: NonZeroU32, miss: NonZeroU32) -> Option<EventKind> {
        match self.track.status().is_selected {
            true => (self.selection_streak >= miss.get()).then_some(EventKind::Unselected),
            false if self.selection_streak < confirm.get() => None,
            false => Some(EventKind::Reselected { gone: self.gone }),
        }
    }

    /// Records an event that is reported. Returns whether the track takes `id` because it begins.
    pub fn record(&mut self, kind: EventKind, id: TrackId) -> bool {
        let mut status = self.track.status();
        match kind {
            EventKind::Born | EventKind::Split { .. } => (self.is_announced, status.id) = (true, id),
            EventKind::Unselected => (status.is_selected, self.selection_streak) = (false, 0),
            EventKind::Reselected { .. } => {
                (status.is_selected, self.selection_streak) = (true, 0);
                (self.is_remembered, self.gone) = (false, 0);
            }
            EventKind::Updated(_) | EventKind::Merged { .. } | EventKind::Died => {}
        }
        self.track.set_status(status);
        self.reported = self.track.clone();
        matches!(kind, EventKind::Born | EventKind::Split { .. })
    }
}
