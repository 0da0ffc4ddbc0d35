//! Why a space cannot be read.
//!
//! In: what was found, and where.
//! Out: messages of one line that say what to do.
//! Must not know: how it was found.

use std::io;

use thiserror::Error;

use super::super::error::ReadError;
use super::distances::DistanceError;

/// A space that cannot be read, or not any further.
#[derive(Debug, Error)]
pub enum SpaceError {
    /// The source fails, or is of a kind that is not read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The source of binary numbers fails.
    #[error("after byte {byte}: reading failed: {source}")]
    Io {
        /// How many bytes were read.
        byte: u64,
        /// What the source said.
        source: io::Error,
    },
    /// A point of too many coordinates.
    #[error(
        "{place}: a point has {found} coordinates, and may have {most}: take fewer columns by --columns, or reduce \
         them, as by PCA"
    )]
    Dimension {
        /// Of the point.
        place: String,
        /// Its coordinates.
        found: usize,
        /// The most of them.
        most: usize,
    },
    /// A series of samples has one column.
    #[error("{place}: {found} numbers, and a series has one: choose its column, as by --columns 1")]
    Series {
        /// Of the sample.
        place: String,
        /// How many there are.
        found: usize,
    },
    /// More points than are held.
    #[error("{place}: more than {most} points: take some of them by --landmarks M, or a smaller sample")]
    Points {
        /// Of the first point beyond.
        place: String,
        /// The most of them.
        most: usize,
    },
    /// More coordinates than are held.
    #[error("{place}: more than {most} coordinates in all: take fewer columns by --columns, or a smaller sample")]
    Coordinates {
        /// Of the first point beyond.
        place: String,
        /// The most of them.
        most: usize,
    },
    /// A line of distances cannot be read. None can be left out.
    #[error("{reason}; no distance may be missing")]
    Line {
        /// Where, and why.
        reason: String,
    },
    /// What was read is no distances.
    #[error("{place}: {error}")]
    Distances {
        /// The line, and perhaps the field.
        place: String,
        /// What is wrong.
        error: DistanceError,
    },
}
