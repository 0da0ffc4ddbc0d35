//! The radius that lone clutter points do not reach.
//!
//! In: the density of clutter, K, how many clutter points may pass.
//! Out: a rung of the ladder, and how many are expected to pass at a radius.
//! Invariant: clutter is taken for a Poisson process, so the number of others within a radius has a Poisson
//! distribution.
//! Must not know: points.

use std::f64::consts::PI;

use super::ladder::square;
use super::occupancy::Clutter;

/// Below this radius, in sides of cells, no clutter point has a neighbour.
const LOWEST: i32 = -200;

/// Within this radius, in sides of cells, any clutter point has neighbours.
const HIGHEST: i32 = 200;

/// With a mean of this, a clutter point has as many neighbours as may be asked for.
const LARGE: f64 = 1e6;

impl Clutter {
    /// How many clutter points are expected to have `neighbours` others within the radius of a rung; of no rung, within
    /// any.
    pub fn passing(&self, neighbours: u32, rung: Option<i32>) -> f64 {
        match rung {
            Some(rung) => self.passing_within(neighbours, square((rung - 4 * self.exponent).clamp(LOWEST, HIGHEST))),
            None => self.count(),
        }
    }

    /// The same within a radius, given by its square.
    pub fn passing_square(&self, neighbours: u32, square_of_radius: f64) -> f64 {
        let side = super::ladder::power_of_two(-self.exponent);
        self.passing_within(neighbours, square_of_radius * side * side)
    }

    /// The same within a radius in sides of cells, given by its square.
    fn passing_within(&self, neighbours: u32, square: f64) -> f64 {
        self.count() * at_least(neighbours, (self.per_cell * PI * square).min(LARGE))
    }

    /// The highest rung at which at most `expected` clutter points pass; none if so many pass at any radius.
    pub fn rung(&self, neighbours: u32, expected: f64) -> Option<i32> {
        if self.count() <= expected {
            return None;
        }
        let passes = |&rung: &i32| self.passing_within(neighbours, square(rung)) <= expected;
        // In sides of cells: four rungs are a factor of two.
        (LOWEST..=HIGHEST).take_while(passes).last().map(|rung| rung + 4 * self.exponent)
    }
}

/// The probability that a Poisson variable of a mean is at least `least`.
fn at_least(least: u32, mean: f64) -> f64 {
    let terms = |from: u32, first: f64| {
        std::iter::successors(Some((from, first)), move |&(n, term)| Some((n + 1, term * mean / f64::from(n + 1))))
            .map(|(_, term)| term)
    };
    let zero = (-mean).exp();
    if mean > f64::from(least) {
        return 1.0 - terms(0, zero).take(least as usize).sum::<f64>();
    }
    // A sum of small terms is accurate where one less a sum near one is not.
    let first = terms(0, zero).nth(least as usize).unwrap_or(0.0);
    terms(least, first).take_while(|term| *term > first * f64::EPSILON).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        for (least, mean, wanted) in [
            (1, 1.0, 1.0 - (-1f64).exp()),
            (3, 0.5, 0.014_387_677_966_970_7),
            (3, 2.0, 0.323_323_583_816_936_5),
            (3, 10.0, 0.997_230_604_284_488_4),
            (10, 3.0, 0.001_102_488_130_115_48),
            (64, 1e6, 1.0),
        ] {
            let tail = at_least(least, mean);
            assert!((tail - wanted).abs() < 1e-12 * wanted.max(1e-3), "{least} {mean}: {tail}");
        }
        let tiny = at_least(3, 1e-9);
        assert!((tiny / 1.666_666_665e-28 - 1.0).abs() < 1e-9, "{tiny:e}");
    }

    #[test]
    fn the_rung_is_the_last_at_which_few_pass() {
        for exponent in [-150, 0, 3] {
            let clutter = Clutter { exponent, per_cell: 0.05, cells: 2000.0 };
            for (neighbours, expected) in [(1, 1.0), (3, 1.0), (3, 0.01), (64, 5.0)] {
                let rung = clutter.rung(neighbours, expected).unwrap();
                assert!(clutter.passing(neighbours, Some(rung)) <= expected);
                assert!(clutter.passing(neighbours, Some(rung + 1)) > expected);
                let same = clutter.passing_square(neighbours, square(rung));
                assert!((same / clutter.passing(neighbours, Some(rung)) - 1.0).abs() < 1e-9);
            }
            assert_eq!(clutter.rung(3, 100.0), None, "there are no more than these");
            assert_eq!(clutter.passing(3, None), 100.0);
        }
    }
}
