//! Points of R^d as the cloud stores them.
//!
//! In: slices of doubles.
//! Out: [`Coordinates`]: finite, of bounded magnitude and number, without negative zeros.
//! Invariants: two of them are equal exactly when their bits are. Clones share their memory.
//! Must not know: distances, which dimension a stream has.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

use super::point_error::PointError;
use super::refusal::Refusal;
use super::site::{Site, finish};
use crate::topology::base::{MAX_DIMENSION, MAX_MAGNITUDE};

/// A point of R^d.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinates(Arc<[f64]>);

impl Coordinates {
    /// The point with these coordinates; a negative zero becomes zero.
    ///
    /// # Errors
    /// [`PointError::Dimension`] without coordinates or with more than 4,096; [`PointError::Coordinate`] if
    /// one is not finite or exceeds 1e150.
    pub fn new(coordinates: &[f64]) -> Result<Self, PointError> {
        if !(1..=MAX_DIMENSION).contains(&coordinates.len()) {
            return Err(PointError::Dimension(coordinates.len()));
        }
        let is_wrong = |value: &f64| value.is_nan() || value.abs() > MAX_MAGNITUDE;
        if let Some(at) = coordinates.iter().position(is_wrong) {
            return Err(PointError::Coordinate { number: at + 1, value: coordinates[at] });
        }
        // -0.0 + 0.0 is 0.0: equal points then have equal bits.
        Ok(Self(coordinates.iter().map(|value| value + 0.0).collect()))
    }

    /// The coordinates.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }
}

impl Eq for Coordinates {}

impl Hash for Coordinates {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.digest());
    }
}

impl Site for Coordinates {
    fn coordinates(&self) -> impl AsRef<[f64]> {
        self.as_slice()
    }

    fn digest(&self) -> u64 {
        let mix =
            |sum: u64, value: &f64| finish((sum.rotate_left(32) ^ value.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15));
        self.0.iter().fold(0, mix)
    }

    fn on_grid(self, step: f64) -> Result<Self, Refusal> {
        Ok(Self::new(&self.0.iter().map(|value| (value / step).round() * step).collect::<Vec<_>>())?)
    }

    fn not_there(&self) -> Refusal {
        Refusal::Absent(self.as_slice().into())
    }

    /// With the two counts of those who share it.
    fn heap_size(&self) -> usize {
        size_of_val(self.as_slice()) + 2 * size_of::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_name_the_coordinate_and_the_dimension() {
        let refusal = |coordinates: &[f64]| Coordinates::new(coordinates).unwrap_err().to_string();
        assert!(refusal(&[1.0, 2.0, f64::NAN]).starts_with("coordinate 3 is NaN"));
        assert!(refusal(&[1.0, -2e150]).starts_with("coordinate 2 is -2e150: it must be finite and at most 1e150"));
        assert!(refusal(&[]).starts_with("the point has 0 coordinates"));
        assert!(refusal(&[0.0; MAX_DIMENSION + 1]).starts_with("the point has 4097 coordinates"));
        assert!(Coordinates::new(&[1e150; MAX_DIMENSION]).is_ok());
    }

    #[test]
    fn absent_points_are_named_shortly() {
        let absent = |coordinates: &[f64]| Coordinates::new(coordinates).unwrap().not_there().to_string();
        assert_eq!(absent(&[0.5]), "there is no point at (0.5) to retract");
        assert_eq!(absent(&[1.0, -2.0, 0.0]), "there is no point at (1, -2, 0) to retract");
        assert_eq!(absent(&[1.0, 2.0, 3.0, 4.0, 5.0]), "there is no point at (1, 2, 3 and 2 more) to retract");
    }

    #[test]
    fn equal_points_have_equal_digests() {
        let of = |coordinates: &[f64]| Coordinates::new(coordinates).unwrap();
        assert_eq!((of(&[-0.0, 1.0]), of(&[-0.0, 1.0]).digest()), (of(&[0.0, 1.0]), of(&[0.0, 1.0]).digest()));
        assert_ne!(of(&[1.0, 0.0]).digest(), of(&[0.0, 1.0]).digest());
        assert_ne!(of(&[1.0]), of(&[1.0, 0.0]));
    }

    #[test]
    fn grids_are_of_any_dimension() {
        let on_grid = Coordinates::new(&[0.26, -0.74, 7.1]).unwrap().on_grid(0.5).unwrap();
        assert_eq!(on_grid.as_slice(), [0.5, -0.5, 7.0]);
        assert!(Coordinates::new(&[1e150]).unwrap().on_grid(1e-300).is_err());
    }
}
