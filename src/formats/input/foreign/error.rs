//! Why a foreign file cannot be read at all.
//!
//! In: what a file says it is.
//! Out: messages of one line that say what it is and what to do.
//! Must not know: how a file is recognised.

use std::io;

use super::refusal::Refusal;

/// A file of another program that cannot be read, or not any further.
#[derive(Debug, thiserror::Error)]
pub enum ForeignError {
    /// It is not read here; another program converts it.
    #[error("this is {}: {}", .0.what(), .0.remedy())]
    Refused(Refusal),
    /// It does not say what it must.
    #[error("this is {format} whose header cannot be read, at {place}: {reason}")]
    Header {
        /// What it is.
        format: &'static str,
        /// A line or a byte.
        place: String,
        /// What is wrong, and what to do.
        reason: String,
    },
    /// It does not hold points.
    #[error("this is {format}: {reason}")]
    Content {
        /// What it is.
        format: &'static str,
        /// What it holds instead, and what to do.
        reason: String,
    },
    /// It has too many layers of compression.
    #[error("compressed more than {most} times: decompress it")]
    Layers {
        /// How many are allowed.
        most: usize,
    },
    /// The source failed. What had arrived whole has been handed on before.
    #[error("after {unit} {number}: reading failed: {source}")]
    Io {
        /// What is counted.
        unit: &'static str,
        /// The last one.
        number: u64,
        /// What the source said.
        source: io::Error,
    },
}
