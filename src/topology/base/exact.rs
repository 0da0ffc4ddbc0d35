//! A number as text that stays short.
//!
//! In: any number.
//! Out: text.
//! Invariants: it is read as the same number. It has at most 26 characters, however small or large the number.
//! Must not know: where it is shown.

use std::fmt;

/// A number in the fewest digits that say it exactly, with an exponent where there would be many zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact(pub f64);

impl fmt::Display for Exact {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0;
        if !value.is_finite() || value == 0.0 || (1e-7..1e17).contains(&value.abs()) {
            write!(f, "{value}")
        } else {
            write!(f, "{value:e}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_the_same_and_stay_short() {
        for (value, shown) in [
            (0.0, "0"),
            (-1.5, "-1.5"),
            (4.0, "4"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e-7, "0.0000001"),
            (9e-8, "9e-8"),
            (1e-320, "1e-320"),
            (-5e-324, "-5e-324"),
            (1e16, "10000000000000000"),
            (2f64.powi(201), "3.213876088517981e60"),
        ] {
            assert_eq!(Exact(value).to_string(), shown);
            assert_eq!(shown.parse::<f64>(), Ok(value));
        }
        assert_eq!([f64::NAN, f64::NEG_INFINITY].map(|value| Exact(value).to_string()), ["NaN", "-inf"]);
        assert!(
            [-f64::MIN_POSITIVE, -f64::MAX, -1.234_567_890_123_456_7e-7]
                .iter()
                .all(|&v| Exact(v).to_string().len() <= 26)
        );
    }
}
