//! Positions in the plane and their total order.
//!
//! In: pairs of doubles.
//! Out: [`Position`]s: finite, inside the limits of exact arithmetic, without negative zeros, ordered by x, then y.
//! Invariants: two positions are equal exactly when their bits are. Every tie in this crate is decided by this order.
//! Must not know: identifiers, triangulations.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};

use thiserror::Error;

/// The largest magnitude of a coordinate: 2^201. Beyond it the exact predicates could overflow.
pub const MAX_COORDINATE: f64 = f64::from_bits((1023 + 201) << 52);

/// The smallest magnitude of a coordinate other than zero: 2^-142. Below it the exact predicates could underflow.
pub const MIN_COORDINATE: f64 = f64::from_bits((1023 - 142) << 52);

/// A point of the plane that the exact predicates can handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    x: f64,
    y: f64,
}

/// Which coordinate of a point an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Axis::X => "x",
            Axis::Y => "y",
        })
    }
}

/// Why a pair of numbers is not a [`Position`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CoordinateError {
    /// NaN or an infinity.
    #[error("{axis} = {value} is not a finite number: leave the point out or mend its source")]
    NotFinite {
        /// The coordinate at fault.
        axis: Axis,
        /// Its value.
        value: f64,
    },
    /// Magnitude above [`MAX_COORDINATE`].
    #[error("{axis} = {value:e} is beyond 2^201 (3.2e60): use a larger unit")]
    TooLarge {
        /// The coordinate at fault.
        axis: Axis,
        /// Its value.
        value: f64,
    },
    /// Not zero, but of magnitude below [`MIN_COORDINATE`].
    #[error("{axis} = {value:e} is nearer to 0 than 2^-142 (1.8e-43): use a smaller unit, or 0")]
    TooSmall {
        /// The coordinate at fault.
        axis: Axis,
        /// Its value.
        value: f64,
    },
}

impl Position {
    /// The position (`x`, `y`); a negative zero becomes zero.
    ///
    /// # Errors
    /// [`CoordinateError`] when a coordinate is not finite or outside the limits of exact arithmetic.
    pub fn new(x: f64, y: f64) -> Result<Self, CoordinateError> {
        Ok(Self { x: coordinate(Axis::X, x)?, y: coordinate(Axis::Y, y)? })
    }

    /// A position that was computed from others and lies between them. A coordinate below [`MIN_COORDINATE`] becomes 0.
    pub(crate) fn between(x: f64, y: f64) -> Self {
        let [x, y] = [x, y].map(|v| if v.abs() < MIN_COORDINATE { 0.0 } else { v });
        Self { x, y }
    }

    /// The position of a vertex of a cloud in the plane, from its coordinates.
    pub(crate) fn of_vertex([x, y]: [f64; 2]) -> Self {
        Self { x, y }
    }

    /// The nearest node of the grid of step `resolution` (halves away from zero).
    ///
    /// # Errors
    /// As [`Position::new`], for the node.
    pub fn snapped(self, resolution: f64) -> Result<Self, CoordinateError> {
        let snap = |v: f64| (v / resolution).round() * resolution;
        Self::new(snap(self.x), snap(self.y))
    }

    /// First coordinate.
    #[inline]
    pub fn x(self) -> f64 {
        self.x
    }

    /// Second coordinate.
    #[inline]
    pub fn y(self) -> f64 {
        self.y
    }

    /// Both coordinates.
    #[inline]
    pub fn xy(self) -> [f64; 2] {
        [self.x, self.y]
    }
}

fn coordinate(axis: Axis, value: f64) -> Result<f64, CoordinateError> {
    let magnitude = value.abs();
    if !value.is_finite() {
        Err(CoordinateError::NotFinite { axis, value })
    } else if magnitude > MAX_COORDINATE {
        Err(CoordinateError::TooLarge { axis, value })
    } else if magnitude < MIN_COORDINATE && magnitude > 0.0 {
        Err(CoordinateError::TooSmall { axis, value })
    } else {
        // -0.0 + 0.0 is 0.0: equal positions then have equal bits.
        Ok(value + 0.0)
    }
}

impl Eq for Position {}

impl Hash for Position {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Equal positions have equal bits.
        self.xy().map(f64::to_bits).hash(state);
    }
}

impl PartialOrd for Position {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Position {
    #[inline]
    fn cmp(&self, other: &Self) -> Ordering {
        // No coordinate is NaN or -0.0, so plain comparisons are a total order. They are faster than `total_cmp`.
        let by = |a: f64, b: f64| (a > b).cmp(&(a < b));
        by(self.x, other.x).then_with(|| by(self.y, other.y))
    }
}

/// An item and its position.
pub type Located<S> = (Position, S);

/// A quarter of the squared distance of `a` and `b`: the squared scale at which a Gabriel edge enters the filtration.
#[inline]
pub fn half_length_squared(a: Position, b: Position) -> f64 {
    quarter_square(a.xy(), b.xy())
}

/// The same for points that need not be positions of a cloud.
#[inline]
pub fn quarter_square(p: [f64; 2], q: [f64; 2]) -> f64 {
    let (dx, dy) = (p[0] - q[0], p[1] - q[1]);
    (dx * dx + dy * dy) * 0.25
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_inclusive_and_zero_is_allowed() {
        for v in [0.0, -0.0, MIN_COORDINATE, -MIN_COORDINATE, MAX_COORDINATE, -MAX_COORDINATE] {
            assert!(Position::new(v, 1.0).is_ok(), "{v:e}");
        }
        assert_eq!(MAX_COORDINATE, 2f64.powi(201));
        assert_eq!(MIN_COORDINATE, 2f64.powi(-142));
    }

    #[test]
    fn refusals_name_the_coordinate() {
        let refusal = |x, y| Position::new(x, y).unwrap_err().to_string();
        assert!(refusal(1.0, f64::NAN).starts_with("y = NaN is not a finite number"));
        assert!(refusal(f64::NEG_INFINITY, 1.0).starts_with("x = -inf is not a finite number"));
        assert!(refusal(1e61, 1.0).starts_with("x = 1e61 is beyond"));
        assert!(refusal(1.0, 1e-43).starts_with("y = 1e-43 is nearer to 0"));
    }

    #[test]
    fn negative_zero_is_zero() {
        assert_eq!(Position::new(-0.0, 0.0).unwrap().x().to_bits(), 0);
    }

    #[test]
    fn order_is_by_x_then_y() {
        let at = |x, y| Position::new(x, y).unwrap();
        assert!(at(-1.0, 5.0) < at(0.0, -5.0));
        assert!(at(0.0, -5.0) < at(0.0, 5.0));
    }

    #[test]
    fn snapping_rounds_to_the_grid() {
        let p = Position::new(0.26, -0.74).unwrap().snapped(0.5).unwrap();
        assert_eq!(p.xy(), [0.5, -0.5]);
    }
}
