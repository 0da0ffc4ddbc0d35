//! Why a subcommand did not succeed.
//!
//! In: errors of all rooms.
//! Out: one of three kinds, each with an exit code of its own.
//! Must not know: exit codes.

use std::borrow::Cow;

use crate::client::delivery::DeliveryError;
use crate::daemon::{DaemonError, StrictStop};

/// Why a subcommand did not succeed.
#[derive(Debug)]
pub enum Failure {
    /// Arguments that do not go together.
    Usage(Cow<'static, str>),
    /// `--strict` met something that cannot be used.
    Refused(String),
    /// Something else failed.
    Failed(anyhow::Error),
}

impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        let error = error.into();
        match strict_stop(&error) {
            Some(stop) => Self::Refused(stop.to_string()),
            None => Self::Failed(error),
        }
    }
}

impl Failure {
    /// Arguments that do not go together, and why.
    pub fn usage(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Usage(reason.into())
    }

    /// As said of a file, or of another thing of that name.
    pub fn of(self, name: &str) -> Self {
        match self {
            Self::Failed(error) => Self::Failed(error.context(name.to_owned())),
            other => other,
        }
    }
}

/// The first input that `--strict` does not let pass, if that is what it is about.
fn strict_stop(error: &anyhow::Error) -> Option<&StrictStop> {
    if let Some(DeliveryError::Strict(stop)) = error.downcast_ref() {
        return Some(stop);
    }
    if let Some(DaemonError::Refused(stop)) = error.downcast_ref() {
        return Some(stop);
    }
    error.downcast_ref()
}
