//! An error with its causes, on one line of a log.
//!
//! In: an error.
//! Out: its text and those of its sources, separated by colons.
//! Must not know: which errors there are.

use std::error::Error;
use std::fmt;

/// Shows an error with its causes.
pub struct Chain<'a>(pub &'a dyn Error);

impl fmt::Display for Chain<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)?;
        let mut cause = self.0.source();
        while let Some(error) = cause {
            write!(f, ": {error}")?;
            cause = error.source();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("cannot write")]
    struct CannotWrite(#[source] io::Error);

    #[test]
    fn causes_follow_the_error() {
        let error = CannotWrite(io::Error::other("disk full"));
        assert_eq!(Chain(&error).to_string(), "cannot write: disk full");
        assert_eq!(Chain(&io::Error::other("disk full")).to_string(), "disk full");
    }
}
