//! The reasons why a cloud refuses a point.
//!
//! In: nothing.
//! Out: [`Refusal`], whose text is written for the producer of the point.
//! Invariant: a refused point changes nothing.

use thiserror::Error;

use super::position::CoordinateError;
use crate::topology::base::Exact;

/// Why a point was refused. The cloud is as it was.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum Refusal {
    /// The position is outside the limits of exact arithmetic.
    #[error(transparent)]
    Coordinate(#[from] CoordinateError),
    /// A time window needs an event time.
    #[error("the point has no event time, which a time window needs: give one (t), at least to the first point")]
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
    /// No point is there to retract.
    #[error("there is no point at ({}, {}) to retract", Exact(*.x), Exact(*.y))]
    NotThere {
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// The cloud holds 2^32 - 2 vertices.
    #[error("the cloud is full ({0} distinct positions): use a window or a resolution")]
    Full(usize),
}
