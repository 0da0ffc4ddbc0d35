//! The reasons why a cloud refuses a point.
//!
//! In: nothing.
//! Out: [`Refusal`], whose text is written for the producer of the point.
//! Invariant: a refused point changes nothing.

use std::fmt;

use thiserror::Error;

use super::point_error::PointError;
use super::position::CoordinateError;
use crate::topology::base::Exact;

/// Event times with which a source confirms a jump of its clock alone.
pub const CONFIRMING: u64 = 16;

/// Why a point was refused. The cloud is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// The position is outside the limits of exact arithmetic.
    #[error(transparent)]
    Coordinate(#[from] CoordinateError),
    /// It is no point of the stream's space.
    #[error(transparent)]
    Point(#[from] PointError),
    /// A time window needs an event time.
    #[error(
        "the point has no event time, nor has the commit of its frame, and none is known yet: \
        a time window needs one (t) for points or commits"
    )]
    NoTime,
    /// The event time is not finite.
    #[error("event time {0} is not a finite number")]
    TimeNotFinite(f64),
    /// The event time is before the begin of the time window.
    #[error(
        "event time {time} is before {oldest}, where the time window begins by now: send points sooner or widen it"
    )]
    TooLate {
        /// Its event time.
        time: f64,
        /// The oldest time that the window still holds.
        oldest: f64,
    },
    /// The event time is ahead of the time window by more than its length.
    #[error(
        "event time {time} is too far ahead of {newest}, the newest that is believed: \
        check the clock; it is believed once another producer, or {CONFIRMING} points over a commit, confirm it"
    )]
    Unconfirmed {
        /// Its event time.
        time: f64,
        /// The newest time that is believed.
        newest: f64,
    },
    /// The event time goes with what was believed before the time window started anew.
    #[error(
        "event time {time} goes with {before}, but the time window has started anew at {newest}: \
        check the clocks of all producers"
    )]
    Outdated {
        /// Its event time.
        time: f64,
        /// What was believed before.
        before: f64,
        /// The newest time that is believed.
        newest: f64,
    },
    /// No point is there to retract.
    #[error("there is no point at ({}, {}) to retract", Exact(*.x), Exact(*.y))]
    NotThere {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// No point of R^d is there to retract.
    #[error("there is no point at {0} to retract")]
    Absent(FirstCoordinates),
    /// As many distinct positions as the stream may have.
    #[error(
        "the stream has {0} distinct points, as many as it may: use a window or a resolution that keeps fewer, \
        or raise max-vertices"
    )]
    TooMany(usize),
    /// The cloud holds 2^32 - 2 vertices.
    #[error("the cloud is full ({0} distinct positions): use a window or a resolution")]
    Full(usize),
}

/// The first coordinates of a point, enough to recognise it by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstCoordinates {
    first: [f64; 3],
    dimension: usize,
}

impl From<&[f64]> for FirstCoordinates {
    fn from(coordinates: &[f64]) -> Self {
        let mut first = [0.0; 3];
        first.iter_mut().zip(coordinates).for_each(|(first, value)| *first = *value);
        Self { first, dimension: coordinates.len() }
    }
}

impl fmt::Display for FirstCoordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = self.dimension.min(self.first.len());
        for (place, &value) in self.first[..shown].iter().enumerate() {
            write!(f, "{}{}", if place == 0 { "(" } else { ", " }, Exact(value))?;
        }
        match self.dimension - shown {
            0 => f.write_str(")"),
            more => write!(f, " and {more} more)"),
        }
    }
}
