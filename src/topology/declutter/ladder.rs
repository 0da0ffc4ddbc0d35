//! Radii in steps: the ladder on which R rests, and how many points have which distance on it.
//!
//! In: squared distances.
//! Out: rungs, counts of them.
//! Invariants: rung n is the radius 2^(n/4). Only squares are compared; they are computed without rounding but for one
//! constant, the same everywhere.
//! Must not know: points.

use std::f64::consts::SQRT_2;

/// The lowest rung: below the distance of any two positions.
const LOWEST: i32 = -800;

/// The highest rung: above the distance of any two positions.
const HIGHEST: i32 = 830;

/// The square of the radius of a rung.
pub fn square(rung: i32) -> f64 {
    let power = power_of_two(rung.div_euclid(2));
    if rung.rem_euclid(2) == 1 { SQRT_2 * power } else { power }
}

/// A power of two in the range of normal numbers.
pub fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent.clamp(-1022, 1023)) as u64) << 52)
}

/// The exponent of the largest power of two up to a positive normal number.
pub fn exponent(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7FF) as i32 - 1023
}

/// The lowest rung whose radius is at least the root of `value`; none if that is infinite.
pub fn rung_of_square(value: f64) -> Option<i32> {
    let below = 2 * exponent(value);
    let rungs = [below, below + 1, below + 2];
    rungs.into_iter().find(|&rung| value <= square(rung)).filter(|_| value.is_finite())
}

/// How many squared distances are on which rung.
#[derive(Clone, Debug)]
pub struct Rungs {
    counts: Vec<u32>,
    /// Those that are infinite, or not known.
    infinite: usize,
    total: usize,
}

impl Default for Rungs {
    fn default() -> Self {
        Self { counts: vec![0; (HIGHEST - LOWEST + 1) as usize], infinite: 0, total: 0 }
    }
}

impl Rungs {
    /// Counts one more.
    pub fn add(&mut self, value: f64) {
        self.total += 1;
        match place(value) {
            Some(place) => self.counts[place] += 1,
            None => self.infinite += 1,
        }
    }

    /// Takes one back that was added.
    pub fn remove(&mut self, value: f64) {
        self.total -= 1;
        match place(value) {
            Some(place) => self.counts[place] -= 1,
            None => self.infinite -= 1,
        }
    }

    /// The lowest rung that at least half of them reach; none if that is infinite.
    pub fn median(&self) -> Option<i32> {
        let mut left = self.total.div_ceil(2);
        if left > self.total - self.infinite {
            return None;
        }
        let place = self.counts.iter().position(|&count| {
            left = left.saturating_sub(count as usize);
            left == 0
        });
        place.map(|place| LOWEST + place as i32)
    }
}

fn place(value: f64) -> Option<usize> {
    rung_of_square(value).map(|rung| (rung.clamp(LOWEST, HIGHEST) - LOWEST) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_are_fourth_roots_of_two_apart() {
        assert_eq!((square(0), square(2), square(-4), square(1)), (1.0, 2.0, 0.25, SQRT_2));
        for rung in [LOWEST, -801, -3, -2, -1, 0, 1, 2, 7, 600, HIGHEST] {
            let value = square(rung);
            assert!((value.log2() * 2.0 - f64::from(rung)).abs() < 1e-9);
            assert_eq!(rung_of_square(value), Some(rung));
            assert_eq!(rung_of_square(value.next_up()), Some(rung + 1));
        }
        assert_eq!(rung_of_square(f64::INFINITY), None);
    }

    #[test]
    fn the_median_is_that_of_what_is_there() {
        let mut rungs = Rungs::default();
        assert_eq!(rungs.median(), Some(LOWEST), "of nothing");
        [1.0, 4.0, f64::INFINITY, f64::INFINITY].into_iter().for_each(|value| rungs.add(value));
        assert_eq!(rungs.median(), Some(4));
        rungs.remove(1.0);
        assert_eq!(rungs.median(), None);
        rungs.add(16.0);
        assert_eq!(rungs.median(), Some(8));
    }
}
