//! Permits: how many threads may do a thing at a time.
//!
//! In: the number, the wish to begin. Out: a permit, once there is one.
//!
//! Invariants: no more permits are out than there are. A permit is given back when it is dropped.
//!
//! Must not know: what is permitted.

use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// So many permits.
#[derive(Debug)]
pub struct Permits {
    free: Mutex<usize>,
    given_back: Condvar,
}

/// A permit, until it is dropped.
#[derive(Debug)]
pub struct Permit<'a>(&'a Permits);

impl Permits {
    /// So many permits.
    pub fn new(count: usize) -> Self {
        Self { free: Mutex::new(count), given_back: Condvar::new() }
    }

    /// Waits for a permit. None if there is none in that time.
    pub fn wait(&self, timeout: Duration) -> Option<Permit<'_>> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.given_back.wait_timeout_while(free, timeout, |free| *free == 0);
        let (mut free, _) = waited.unwrap_or_else(PoisonError::into_inner);
        *free = free.checked_sub(1)?;
        Some(Permit(self))
    }
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        *self.0.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.given_back.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permit_is_waited_for() {
        let permits = Permits::new(1);
        let first = permits.wait(Duration::ZERO).unwrap();
        assert!(permits.wait(Duration::from_millis(1)).is_none());
        std::thread::scope(|scope| {
            let second = scope.spawn(|| permits.wait(Duration::from_secs(60)).is_some());
            drop(first);
            assert!(second.join().unwrap());
        });
        assert!(permits.wait(Duration::ZERO).is_some());
    }
}
