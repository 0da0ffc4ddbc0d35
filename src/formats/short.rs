//! A number for people, to four digits.
//!
//! In: any number.
//! Out: text.
//! Invariants: it is read as the number rounded to four digits.
//! Must not know: where it is shown.

use std::fmt;

/// A number to four digits.
pub struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = format!("{:.3e}", self.0);
        match rounded.parse::<f64>() {
            Ok(value) if value == 0.0 || (1e-4..1e7).contains(&value.abs()) => write!(f, "{value}"),
            _ => f.write_str(&rounded),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, shown) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123456, "0.1235"),
            (12345.6, "12350"),
            (1e-9, "1.000e-9"),
            (6.02e23, "6.020e23"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Short(value).to_string(), shown);
        }
    }
}
