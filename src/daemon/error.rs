//! Why the daemon stops before it was asked to.
//!
//! In: errors of its parts. Out: one kind for each, with the exit code's meaning.
//!
//! Must not know: exit codes.

use hopes::topology::Contradiction;
use thiserror::Error;

use super::connections::listener::ListenError;
use super::input_errors::StrictStop;
use super::streams::directory::OpenError;
use super::streams::error::EngineError;

/// Why the daemon stops.
#[derive(Debug, Error)]
pub enum DaemonError {
    /// Under `strict`.
    #[error(transparent)]
    Refused(#[from] StrictStop),
    /// Under `check`.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// The thread pool could not be started.
    #[error("cannot start the threads that reduce tiles: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// An address cannot be listened at.
    #[error(transparent)]
    Listen(#[from] ListenError),
    /// A stream of the settings cannot be opened.
    #[error("{0}")]
    Stream(String),
    /// The source failed.
    #[error("cannot read the input: {0}")]
    Source(String),
    /// Nothing of the input could be used.
    #[error("nothing of the input could be used, of {rejected} lines or points: see hopes help serve")]
    NothingUsable {
        /// How much was refused.
        rejected: u64,
    },
    /// The sink failed; a closed pipe is one of these.
    #[error("cannot write frames")]
    Sink(#[source] std::io::Error),
    /// The sink has not taken all frames before the daemon had to end.
    #[error("the reader of stdout took nothing for too long: {0}")]
    SinkStuck(String),
    /// The system gave no thread.
    #[error("cannot start")]
    Start(#[source] std::io::Error),
    /// A thread panicked, which is a bug.
    #[error("the {0} thread stopped by itself: please report this")]
    Thread(&'static str),
}

impl From<OpenError> for DaemonError {
    fn from(error: OpenError) -> Self {
        Self::Stream(error.text)
    }
}

impl From<EngineError> for DaemonError {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::Refused(stop) => Self::Refused(stop),
            EngineError::Contradiction(contradiction) => Self::Contradiction(contradiction),
            EngineError::Source(reason) => Self::Source(reason),
            EngineError::NothingUsable { rejected } => Self::NothingUsable { rejected },
            EngineError::OutputNotRead { frame } => {
                Self::SinkStuck(format!("frame {frame} and later ones are not written"))
            }
            EngineError::Panicked => Self::Thread("engine"),
        }
    }
}
