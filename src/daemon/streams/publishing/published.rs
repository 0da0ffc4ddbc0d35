//! What a stream publishes beside its views: the newest dots and the log of its tracks.
//!
//! In: dots of the newest frame, frames of tracks. Out: the same, shared.
//!
//! Invariants: dots are published whole, for one frame; a reader that holds them does not block the engine.
//!
//! Must not know: who reads it.

use std::sync::Arc;

use hopes::topology::Ranking;

use super::any_tracks::AnyTrackLog;
use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::memory::{Account, Charge};
use crate::daemon::streams::convert::{Dots, Shape};

/// The most persistent dots of a frame.
#[derive(Debug)]
pub struct PublishedDots {
    /// The frame.
    pub frame: u64,
    /// The number of all dots.
    pub total: u64,
    /// As many as any consumer wants, the most persistent first.
    pub dots: Dots,
    /// Held for its drop.
    _charge: Charge,
}

impl PublishedDots {
    /// The dots of a ranking, of a stream of this shape.
    pub fn new(shape: Shape, ranking: &Ranking, account: &Arc<Account>) -> Self {
        let dots = Dots::new(shape, ranking);
        let charge = account.charge(dots.bytes());
        Self { frame: ranking.number, total: ranking.total as u64, dots, _charge: charge }
    }

    /// Whether a consumer that wants so many gets the same of both.
    pub fn has_same_top(&self, other: &Self, most: usize) -> bool {
        self.total == other.total && self.dots.are_same(&other.dots, most)
    }

    /// Whether there are as many as a consumer may get that wants so many.
    pub fn has_top(&self, most: usize) -> bool {
        self.dots.len() as u64 == self.total || self.dots.len() >= most
    }
}

/// What a stream publishes beside its views.
#[derive(Debug)]
pub struct Published {
    dots: Lock<Option<Arc<PublishedDots>>>,
    tracks: Lock<AnyTrackLog>,
}

impl Published {
    /// Nothing yet, of a stream of this shape.
    pub fn new(shape: Shape) -> Self {
        let tracks = AnyTrackLog::new(shape != Shape::Plane);
        Self { dots: Lock::new(Level::Published, None), tracks: Lock::new(Level::Published, tracks) }
    }

    /// The log of its tracks.
    pub fn tracks(&self) -> Guard<'_, AnyTrackLog> {
        self.tracks.lock()
    }

    /// The newest dots, if any consumer wants them.
    pub fn dots(&self) -> Option<Arc<PublishedDots>> {
        self.dots.lock().clone()
    }

    /// Publishes other dots.
    pub fn set_dots(&self, dots: Option<PublishedDots>) {
        *self.dots.lock() = dots.map(Arc::new);
    }
}
