//! The rule by which points are taken for clutter, as options.
//!
//! In: numbers of a caller.
//! Out: a [`Declutter`] that makes sense.
//! Invariants: the number of neighbours is from 1 to [`MAX_NEIGHBOURS`]; the radius and the expected number are
//! positive.
//! Must not know: points.

use thiserror::Error;

use crate::topology::base::Exact;

/// The largest K: the search for neighbours takes time in proportion to it.
pub const MAX_NEIGHBOURS: u32 = 64;

/// The usual K.
const NEIGHBOURS: u32 = 3;

/// How many clutter points are let pass on average, if nothing else is said.
const EXPECTED: f64 = 1.0;

/// With at most so many, the certificate is given.
const FEW: f64 = 0.1;

/// Which points are left out as outliers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declutter {
    neighbours: u32,
    radius: Option<f64>,
    expected: f64,
}

/// Why no [`Declutter`] is made.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DeclutterError {
    /// The number of neighbours.
    #[error("{0} neighbours cannot be asked for: K is from 1 to {MAX_NEIGHBOURS}")]
    Neighbours(u32),
    /// The radius.
    #[error("a radius of {} leaves no neighbour: R must be above 0 and finite", Exact(*.0))]
    Radius(f64),
    /// The expected number of clutter points that pass.
    #[error("{} clutter points cannot be expected: the number must be above 0 and finite", Exact(*.0))]
    Expected(f64),
}

impl Default for Declutter {
    fn default() -> Self {
        Self { neighbours: NEIGHBOURS, radius: None, expected: EXPECTED }
    }
}

impl Declutter {
    /// The rule for K neighbours.
    ///
    /// # Errors [`DeclutterError::Neighbours`]
    pub fn new(neighbours: u32) -> Result<Self, DeclutterError> {
        if !(1..=MAX_NEIGHBOURS).contains(&neighbours) {
            return Err(DeclutterError::Neighbours(neighbours));
        }
        Ok(Self { neighbours, ..Self::default() })
    }

    /// With the radius R, instead of one that is found from the cloud.
    ///
    /// # Errors [`DeclutterError::Radius`]
    pub fn with_radius(self, radius: f64) -> Result<Self, DeclutterError> {
        let is_radius = radius > 0.0 && radius.is_finite();
        if is_radius { Ok(Self { radius: Some(radius), ..self }) } else { Err(DeclutterError::Radius(radius)) }
    }

    /// With so many lone clutter points that may pass on average, by which R is found.
    ///
    /// # Errors [`DeclutterError::Expected`]
    pub fn with_expected(self, expected: f64) -> Result<Self, DeclutterError> {
        let is_number = expected > 0.0 && expected.is_finite();
        if is_number { Ok(Self { expected, ..self }) } else { Err(DeclutterError::Expected(expected)) }
    }

    /// K: how many neighbours a point needs.
    pub fn neighbours(&self) -> u32 {
        self.neighbours
    }

    /// R, if it is not found from the cloud.
    pub fn radius(&self) -> Option<f64> {
        self.radius
    }

    /// How many lone clutter points may pass on average.
    pub fn expected(&self) -> f64 {
        self.expected
    }

    /// Whether what passes is certified, when so many lone clutter points are expected to pass.
    pub(super) fn is_certified(&self, expected: f64) -> bool {
        self.radius.is_some() || (self.expected <= FEW && expected <= FEW)
    }

    /// More than K and their neighbours: so many close points tell a wall from a clump.
    pub(super) fn witnesses(&self) -> usize {
        2 * self.neighbours as usize + 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_makes_no_sense_is_refused() {
        assert_eq!(Declutter::new(3), Ok(Declutter::default()));
        for neighbours in [0, MAX_NEIGHBOURS + 1] {
            assert_eq!(Declutter::new(neighbours), Err(DeclutterError::Neighbours(neighbours)));
        }
        for bad in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(Declutter::default().with_radius(bad).is_err());
            assert!(Declutter::default().with_expected(bad).is_err());
        }
        let message = Declutter::default().with_radius(-2.0).unwrap_err().to_string();
        assert_eq!(message, "a radius of -2 leaves no neighbour: R must be above 0 and finite");
    }

    #[test]
    fn a_given_radius_or_few_expected_points_are_certified() {
        let rule = Declutter::default();
        assert!(!rule.is_certified(0.0));
        assert!(rule.with_radius(2.0).unwrap().is_certified(7.0));
        let strict = rule.with_expected(0.1).unwrap();
        assert!(strict.is_certified(0.05) && !strict.is_certified(0.2));
    }
}
