//! One parsed line of a point stream.
//!
//! In: what a parser made of a line.
//! Out: the [`Record`] handed to the caller.
//! Must not know: formats, or how the line was read.

use std::fmt::Debug;

use super::error::{BadLine, Fault};

/// What a point is made of: two coordinates in the plane, as many as there are in other spaces.
pub trait Point: Sized + Clone + Debug {
    /// The point with so many coordinates, in the plane two, which are counted from 0.
    fn of(dimension: usize, coordinate: impl Fn(usize) -> f64) -> Self;
}

impl Point for [f64; 2] {
    #[inline]
    fn of(_: usize, coordinate: impl Fn(usize) -> f64) -> Self {
        [coordinate(0), coordinate(1)]
    }
}

/// What one line says. Points are lent until the next record is asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Record<'a, P = [f64; 2]> {
    /// Points to add. There may be none.
    Points {
        /// Their coordinates. From a table they may be infinite or not a number.
        points: &'a [P],
        /// When they were seen, if the line says so.
        time: Option<f64>,
    },
    /// Points to take back.
    Retract {
        /// Their coordinates.
        points: &'a [P],
    },
    /// The end of a frame, asked for in so many words.
    Commit {
        /// The time of the frame, if the line says so.
        time: Option<f64>,
    },
    /// An empty line.
    Blank,
    /// A header or a comment.
    Nothing,
    /// A line that could not be read.
    Bad(BadLine),
    /// Something else of the input that was not read: where, and why.
    Missed(String),
}

/// What a parser found on a line. Points are in the buffer it was given.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Parsed {
    Nothing,
    Points { time: Option<f64> },
    Retract,
    Commit { time: Option<f64> },
    Blank,
    Bad(Fault),
    Missed(String),
}

impl Parsed {
    /// The record of this, for the given line and the points found on it.
    pub(super) fn into_record<P>(self, line: u64, points: &[P]) -> Record<'_, P> {
        match self {
            Self::Nothing => Record::Nothing,
            Self::Points { time } => Record::Points { points, time },
            Self::Retract => Record::Retract { points },
            Self::Commit { time } => Record::Commit { time },
            Self::Blank => Record::Blank,
            Self::Bad(fault) => Record::Bad(fault.on_line(line)),
            Self::Missed(reason) => Record::Missed(reason),
        }
    }
}
