//! A pace of frames.
//!
//! In: frames a second.
//! Out: when the next frame is due.
//! Invariants: the distance between two frames is never less than asked for. A late frame is not made up for.
//! Must not know: what frames are.

use std::time::{Duration, Instant};

/// When the next frame is due.
pub struct Pace {
    period: Duration,
    due: Instant,
}

impl Pace {
    /// So many a second.
    pub fn new(rate: f64) -> Self {
        // A frame a year is as good as none.
        let longest = Duration::from_secs(365 * 24 * 3600);
        let period = Duration::try_from_secs_f64(1.0 / rate).unwrap_or(longest).min(longest);
        Self { period, due: Instant::now() }
    }

    /// The time of the next frame: a period after the one before, and where that is past, now.
    pub fn next(&mut self) -> Instant {
        let due = self.due.max(Instant::now());
        self.due = due + self.period;
        due
    }
}
