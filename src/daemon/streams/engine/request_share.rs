//! The share of an engine's time that requests of consumers have while points wait.
//!
//! In: how long requests and points took. Out: whether requests have used up their share.
//!
//! Invariants: while points wait, requests take no more time than points do, but for the last request, which is served
//! to its end.
//!
//! Must not know: what a request is.

use std::time::Duration;

/// What requests may have in advance.
const MOST: i128 = Duration::from_millis(2).as_nanos() as i128;

/// Counts the time of requests against that of points.
#[derive(Clone, Copy, Debug)]
pub struct RequestShare {
    /// Nanoseconds that requests may take; less than 0 if they took more than they had.
    left: i128,
}

impl Default for RequestShare {
    fn default() -> Self {
        Self { left: MOST }
    }
}

impl RequestShare {
    /// Points took so long.
    pub fn earn(&mut self, took: Duration) {
        self.left = (self.left + took.as_nanos() as i128).min(MOST);
    }

    /// Requests took so long.
    pub fn spend(&mut self, took: Duration) {
        self.left -= took.as_nanos() as i128;
    }

    /// Whether points come first.
    pub fn is_spent(&self) -> bool {
        self.left <= 0
    }

    /// No points wait.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_take_no_more_time_than_points() {
        let mut share = RequestShare::default();
        let (mut points, mut requests) = (0, 0);
        for _ in 0..10_000 {
            if share.is_spent() {
                share.earn(Duration::from_micros(50));
                points += 50;
            } else {
                share.spend(Duration::from_millis(7));
                requests += 7_000;
            }
        }
        assert!(points > 400_000 && requests <= points + 17_000, "{points} us of points, {requests} us of requests");
    }

    #[test]
    fn idle_time_is_not_saved_up() {
        let mut share = RequestShare::default();
        share.earn(Duration::from_secs(100));
        share.spend(Duration::from_millis(10));
        assert!(share.is_spent());
        share.reset();
        assert!(!share.is_spent());
    }
}
