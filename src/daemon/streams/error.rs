//! Why the engine of a stream stops before its stream ends.
//!
//! In: errors of the input and of the core. Out: one of a few kinds.
//!
//! Invariants: each says what was wrong.
//!
//! Must not know: what the daemon does about it.

use hopes::topology::Contradiction;
use thiserror::Error;

use crate::daemon::input_errors::StrictStop;

/// Why an engine stops.
#[derive(Debug, Error)]
pub enum EngineError {
    /// Under `strict`, the first thing that cannot be used.
    #[error(transparent)]
    Refused(#[from] StrictStop),
    /// Under `check`, the first difference.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// The source failed.
    #[error("cannot read the input: {0}")]
    Source(String),
    /// The input has ended, and nothing of it could be used.
    #[error("nothing of the input could be used, of {rejected} lines or points: see hopes help serve")]
    NothingUsable {
        /// How much was refused.
        rejected: u64,
    },
    /// It had to end while the reader of its output took nothing.
    #[error("the reader of stdout took nothing for too long: frame {frame} and later ones are not written")]
    OutputNotRead {
        /// The first frame that was not written.
        frame: u64,
    },
    /// It panicked, which is a bug.
    #[error("the engine thread stopped by itself: please report this")]
    Panicked,
}
