//! Why something is no point of a stream's space, outside of the plane.
//!
//! In: nothing.
//! Out: [`PointError`], whose text is written for the producer of the point.
//! Must not know: clouds, distances.

use thiserror::Error;

use crate::topology::base::{MAX_DIMENSION, MAX_MAGNITUDE};

/// Why numbers are no point of a space.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PointError {
    /// No coordinates, or more than are supported.
    #[error("the point has {0} coordinates: it must have 1 to {MAX_DIMENSION}; reduce the dimension first")]
    Dimension(usize),
    /// The points of a stream are in one space.
    #[error(
        "the point has {found} coordinates, but those of this stream have {expected}: send points of one dimension"
    )]
    OtherDimension {
        /// Its number of coordinates.
        found: usize,
        /// That of the stream's points.
        expected: usize,
    },
    /// NaN, an infinity, or so large that squares overflow.
    #[error(
        "coordinate {number} is {value:e}: it must be finite and at most {MAX_MAGNITUDE:e}; \
        leave the point out or mend its source"
    )]
    Coordinate {
        /// Its number in the point, from 1.
        number: usize,
        /// Its value.
        value: f64,
    },
    /// A latitude beyond a pole.
    #[error("the latitude is {0}: it must be from -90 to 90; send longitude, then latitude, in degrees")]
    Latitude(f64),
    /// A vector without a direction.
    #[error("the point is zero, so it has no angle to other points: leave it out or choose another metric")]
    NoDirection,
}
