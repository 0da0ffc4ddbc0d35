//! Why something is no metric space.
//!
//! In: nothing.
//! Out: [`SpaceError`].
//! Invariants: every message names the place, by vertices or coordinates counted from 0, and what to do.
//! Must not know: files, lines.

use thiserror::Error;

use crate::topology::base::MAX_DIMENSION;

/// Why points or distances are refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SpaceError {
    /// No coordinates, or more than are supported.
    #[error("a point has {0} coordinates: it must have 1 to {MAX_DIMENSION}; reduce the dimension first")]
    Dimension(usize),
    /// Not a multiple of the dimension.
    #[error("{values} coordinates are not whole points of {dimension} coordinates each")]
    Ragged {
        /// The number of values.
        values: usize,
        /// The dimension.
        dimension: usize,
    },
    /// The dimension does not suit the metric.
    #[error(
        "a point has {0} coordinates: haversine takes two, longitude and latitude in degrees; choose these columns"
    )]
    NotOnTheSphere(usize),
    /// NaN, an infinity, or so large that squares overflow.
    #[error(
        "coordinate {coordinate} of point {point} is {value:e}: it must be finite and at most 1e150; mend its source"
    )]
    Coordinate {
        /// The point.
        point: usize,
        /// The coordinate.
        coordinate: usize,
        /// Its value.
        value: f64,
    },
    /// A latitude beyond a pole.
    #[error("the latitude of point {point} is {value}: it must be from -90 to 90; the columns are longitude, latitude")]
    Latitude {
        /// The point.
        point: usize,
        /// Its value.
        value: f64,
    },
    /// A vector without a direction.
    #[error("point {0} is zero: it has no angle to other points; leave it out or choose another metric")]
    NoDirection(usize),
    /// A number of distances that makes no triangle or square.
    #[error("{values} distances do not fit {count} points: {expected} are needed")]
    Count {
        /// The number of values.
        values: usize,
        /// The number of points.
        count: usize,
        /// The number of values that such a matrix has.
        expected: usize,
    },
    /// Negative or NaN.
    #[error("the distance of points {a} and {b} is {value}: it must be 0 or more, or inf for points never joined")]
    Distance {
        /// One point.
        a: usize,
        /// The other.
        b: usize,
        /// The value.
        value: f64,
    },
    /// Not zero on the diagonal.
    #[error("the distance of point {point} from itself is {value}: it must be 0")]
    Diagonal {
        /// The point.
        point: usize,
        /// The value.
        value: f64,
    },
    /// Two values for one pair.
    #[error(
        "points {a} and {b} are at distance {there}, but {b} and {a} at {back}: the two must be equal to the last bit"
    )]
    Asymmetric {
        /// One point.
        a: usize,
        /// The other.
        b: usize,
        /// One value.
        there: f64,
        /// The other.
        back: f64,
    },
    /// A vertex of a sparse graph beyond its count.
    #[error("point {point} is named, but there are {count}, counted from 0")]
    NoSuchPoint {
        /// The point.
        point: usize,
        /// The number of points.
        count: usize,
    },
}

/// Checks one distance.
pub(super) fn distance(a: usize, b: usize, value: f64) -> Result<f64, SpaceError> {
    // -0.0 + 0.0 is 0.0.
    if value >= 0.0 { Ok(value + 0.0) } else { Err(SpaceError::Distance { a, b, value }) }
}
