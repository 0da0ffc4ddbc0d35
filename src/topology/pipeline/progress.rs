//! The frames of a stream: which was committed, computed and given last.
//!
//! In: commits, skeletons.
//! Out: numbers, whole frames.
//! Invariants: numbers rise from 1. A frame is given as a whole once.
//! Must not know: points, how skeletons are found.

use std::sync::Arc;

use crate::topology::declutter::Decluttered;
use crate::topology::frames::Frame;
use crate::topology::skeleton::Skeleton;

/// Counts the frames of a stream.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// The number of the newest frame; 0 before the first commit.
    pub committed: u64,
    /// The time given at its commit.
    pub time: Option<f64>,
    /// The number of points in the window then, including duplicates.
    pub points: u64,
    /// How outliers were left out of the frame that was computed last.
    pub decluttered: Option<Decluttered>,
    /// The number of the frame that was computed last.
    pub reached: u64,
    /// How many were computed so far.
    pub computed: u64,
    /// The last frame that was given as a whole.
    given: Option<Arc<Frame>>,
}

impl Progress {
    /// Closes a frame of so many points. Returns its number.
    pub fn commit(&mut self, time: Option<f64>, points: u64) -> u64 {
        (self.time, self.points) = (time, points);
        self.committed += 1;
        self.committed
    }

    /// Whether the newest frame is computed.
    pub fn is_reached(&self) -> bool {
        self.reached == self.committed
    }

    /// Begins the computation of the newest frame. Returns the number of the frame computed before.
    pub fn begin(&mut self) -> u64 {
        self.computed += 1;
        std::mem::replace(&mut self.reached, self.committed)
    }

    /// The newest frame as a whole.
    pub fn frame_of(&self, skeleton: Skeleton) -> Frame {
        let &Self { committed: number, time, points, decluttered, .. } = self;
        Frame { number, time, points, decluttered, skeleton }
    }

    /// Whether the newest frame was given as a whole.
    pub fn is_given(&self) -> bool {
        self.given.as_ref().map_or(0, |frame| frame.number) >= self.committed
    }

    /// Gives a frame as a whole.
    pub fn give(&mut self, frame: Arc<Frame>) -> Arc<Frame> {
        self.given = Some(Arc::clone(&frame));
        frame
    }

    /// The last frame that was given as a whole.
    pub fn given(&self) -> Option<&Arc<Frame>> {
        self.given.as_ref()
    }
}
