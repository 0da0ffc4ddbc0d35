//! Time during which this program runs.
//!
//! In: looks at it, at least every half second while something is waited for.
//! Out: how much time has passed that was waited.
//! Invariants: of the time between two looks no more than a step counts. A program that was stopped (SIGSTOP, a closed
//! lid) has not waited meanwhile, and has not heard what was said to it; nor has one that was blocked elsewhere.
//! Must not know: what is waited for.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What counts at most of the time between two looks.
const STEP: Duration = Duration::from_millis(500);

/// A clock that stands still while this program does.
#[derive(Debug)]
pub struct Running {
    begun: Instant,
    state: Mutex<State>,
}

#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// The time of the last look, by the clock on the wall.
    looked: Duration,
    /// What has not counted.
    missed: Duration,
    last: Option<Standstill>,
}

/// A time during which this program did not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standstill {
    /// When it ended, by the running clock.
    pub ended: Duration,
    /// For so long.
    pub length: Duration,
}

impl Running {
    /// Begins now.
    pub fn new() -> Self {
        Self { begun: Instant::now(), state: Mutex::default() }
    }

    /// How long it has run since it began.
    pub fn elapsed(&self) -> Duration {
        // The lock comes first: looks in another order than their times would miss time twice.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.look(self.begun.elapsed())
    }

    /// The last time during which it did not run.
    pub fn standstill(&self) -> Option<Standstill> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).last
    }
}

impl State {
    fn look(&mut self, now: Duration) -> Duration {
        let missed = now.saturating_sub(self.looked).saturating_sub(STEP);
        self.looked = now;
        self.missed += missed;
        let running = now - self.missed;
        if !missed.is_zero() {
            self.last = Some(Standstill { ended: running, length: missed });
        }
        running
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_does_not_count() {
        let ms = Duration::from_millis;
        let mut state = State::default();
        assert_eq!(state.look(ms(50)), ms(50));
        assert_eq!((state.look(ms(550)), state.last), (ms(550), None));
        assert_eq!(state.look(ms(60_600)), ms(1050));
        assert_eq!(state.last, Some(Standstill { ended: ms(1050), length: ms(59_550) }));
        assert_eq!(state.look(ms(60_650)), ms(1100));
        assert_eq!(state.last.map(|last| last.ended), Some(ms(1050)));
    }
}
