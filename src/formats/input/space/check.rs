//! Whether a point can be used: all its coordinates are numbers of a size that can be squared, and it has as many as
//! the points before it.
//!
//! In: the coordinates of a point.
//! Out: the same without negative zeros, or what is wrong with which coordinate.
//! Invariants: the first point that can be used fixes the dimension.
//! Must not know: where the point was read.

use super::super::error::BadLineReason;

/// Beyond it a sum of squares would not be finite.
const LARGEST: f64 = 1e150;

/// The largest latitude, in degrees.
const POLE: f64 = 90.0;

/// What is known of the points so far.
#[derive(Clone, Debug)]
pub(super) struct Check {
    dimension: Option<usize>,
    is_degrees: bool,
}

/// Why a point cannot be used, and which coordinate is to blame, counted from 0.
pub(super) type Reason = (Option<usize>, BadLineReason);

impl Check {
    /// Of points that are longitude and latitude, or any.
    pub(super) fn new(is_degrees: bool) -> Self {
        Self { dimension: None, is_degrees }
    }

    /// How many coordinates points have, once it is known.
    pub(super) fn dimension(&self) -> Option<usize> {
        self.dimension
    }

    /// Takes the next point.
    pub(super) fn take(&mut self, point: &mut [f64]) -> Result<(), Reason> {
        for (place, value) in point.iter_mut().enumerate() {
            *value = coordinate(*value).map_err(|reason| (Some(place), reason))?;
        }
        if let &[_, latitude] = &*point
            && self.is_degrees
            && latitude.abs() > POLE
        {
            return Err((Some(1), BadLineReason::Latitude { found: latitude.to_string() }));
        }
        let expected = *self.dimension.get_or_insert(point.len());
        if point.len() != expected {
            return Err((None, BadLineReason::Dimension { found: point.len(), expected }));
        }
        Ok(())
    }
}

fn coordinate(value: f64) -> Result<f64, BadLineReason> {
    if !value.is_finite() {
        return Err(BadLineReason::NotFinite { found: value.to_string() });
    }
    if value.abs() > LARGEST {
        return Err(BadLineReason::TooLarge { found: format!("{value:e}") });
    }
    // Of a negative zero and of zero the sum is zero.
    Ok(value + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(check: &mut Check, point: &mut [f64]) -> Option<(Option<usize>, String)> {
        check.take(point).err().map(|(place, reason)| (place, reason.to_string()))
    }

    #[test]
    fn coordinates_are_numbers_of_which_squares_are_finite() {
        let mut check = Check::new(false);
        let mut point = [-0.0, 1e150, -1e150, 5e-324];
        assert_eq!(said(&mut check, &mut point), None);
        assert!(point[0].is_sign_positive());
        let large = "1.1e150 is beyond 1e150: use a larger unit";
        assert_eq!(said(&mut check, &mut [0.0, 1.1e150, 0.0, 0.0]), Some((Some(1), large.to_owned())));
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let reason = format!("{value} is not a finite number: leave the point out or mend its source");
            assert_eq!(said(&mut check, &mut [0.0, 0.0, value]), Some((Some(2), reason)));
        }
    }

    #[test]
    fn the_first_good_point_fixes_the_dimension() {
        let mut check = Check::new(false);
        assert!(said(&mut check, &mut [f64::NAN, 1.0]).is_some());
        assert_eq!((said(&mut check, &mut [1.0; 3]), check.dimension()), (None, Some(3)));
        let reason = "2 coordinate(s), and the points before have 3: give all points as many";
        assert_eq!(said(&mut check, &mut [1.0; 2]), Some((None, reason.to_owned())));
    }

    #[test]
    fn latitudes_end_at_the_poles() {
        let mut check = Check::new(true);
        assert_eq!(said(&mut check, &mut [500.0, -90.0]), None);
        let (place, reason) = said(&mut check, &mut [0.0, 90.5]).unwrap();
        assert_eq!(
            (place, reason.starts_with("90.5 is no latitude, which is from -90 to 90 degrees")),
            (Some(1), true)
        );
    }
}
