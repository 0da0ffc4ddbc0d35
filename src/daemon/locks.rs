//! Locking, where a panic of another thread does no harm.
//!
//! In: a mutex. Out: its guard.
//!
//! Invariants: only for data that is whole between any two statements, so that a poisoned lock guards whole data.
//!
//! Must not know: what is guarded.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a mutex, poisoned or not.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
