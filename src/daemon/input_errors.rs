//! What is said of input that cannot be used.
//!
//! In: input errors, as they come up. Out: warnings in the log, a count. Invariants: every error is counted; the first ones are
//! logged one by one, then only their number, so that a flood of garbage does not become a flood of logs. Must not know: where input
//! comes from.

use std::fmt::Display;

use thiserror::Error;

/// How many input errors are logged one by one.
const LOGGED: u64 = 100;

/// `strict` met a error.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0} (--strict stops here)")]
pub struct StrictStop(String);

/// Counts what could not be used.
#[derive(Debug, Default)]
pub struct InputErrors {
    strict: bool,
    count: u64,
}

impl InputErrors {
    /// None so far; the first will stop a strict one.
    pub fn new(strict: bool) -> Self {
        Self { strict, count: 0 }
    }

    /// Notes one.
    ///
    /// # Errors
    /// [`StrictStop`], if strict.
    pub fn add(&mut self, what: &dyn Display) -> Result<(), StrictStop> {
        self.count += 1;
        if self.strict {
            return Err(StrictStop(what.to_string()));
        }
        if self.count <= LOGGED {
            tracing::warn!("{what}");
        }
        if self.count == LOGGED {
            tracing::warn!("{LOGGED} input errors so far: from here on they are only counted");
        }
        Ok(())
    }

    /// How many there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Logs the number, if any were not logged one by one.
    pub fn sum_up(&self) {
        if self.count > LOGGED {
            tracing::warn!("{} lines or points in all could not be used", self.count);
        }
    }
}
