//! Input errors: counted, logged, and under `strict` the end.
//!
//! In: the name of the input, if it has one; what could not be used, as it comes up.
//! Out: warnings in the log, a count.
//!
//! Invariants: every error is counted. The first hundred are logged one by one, then only their number, so that a flood
//! of garbage does not become a flood of logs.
//!
//! Must not know: how input is read.

use std::fmt::Display;

use thiserror::Error;

/// Errors that are logged one by one.
const LOGGED: u64 = 100;

/// Under `strict`, something could not be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0} (--strict stops here)")]
pub struct StrictStop(String);

/// Counts what could not be used.
#[derive(Debug, Default)]
pub struct InputErrors {
    strict: bool,
    /// The file that the input is from.
    origin: Option<String>,
    count: u64,
}

impl InputErrors {
    /// None so far. If `strict`, the first one is returned as an error.
    pub fn new(strict: bool) -> Self {
        Self { strict, origin: None, count: 0 }
    }

    /// The same, of the input of that name, which every error is told with. Stdin has none.
    pub fn of(self, origin: Option<String>) -> Self {
        Self { origin, ..self }
    }

    /// Counts an error, and logs it if it is among the first.
    ///
    /// # Errors
    /// [`StrictStop`], if strict.
    pub fn add(&mut self, what: &dyn Display) -> Result<(), StrictStop> {
        self.count += 1;
        if self.count > LOGGED && !self.strict {
            return Ok(());
        }
        let what = match &self.origin {
            Some(origin) => format!("{origin}: {what}"),
            None => what.to_string(),
        };
        if self.strict {
            return Err(StrictStop(what));
        }
        tracing::warn!("{what}");
        if self.count == LOGGED {
            tracing::warn!("{LOGGED} input errors so far: from here on they are only counted");
        }
        Ok(())
    }

    /// The number of errors.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Logs the number, if any error was not logged one by one.
    pub fn sum_up(&self) {
        if self.count > LOGGED {
            tracing::warn!("{} lines or points in all could not be used", self.count);
        }
    }
}
