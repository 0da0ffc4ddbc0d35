//! Numbers for people: round ticks, short values, counts.
//!
//! In: values of any magnitude, from 1e-60 to 1e60.
//! Out: strings.
//! Invariants: ticks are multiples of 1, 2 or 5 times a power of ten; a tick's label is exact, if need be with a
//! power of ten taken out of all of them.
//! Must not know: where the numbers are shown.

/// Round values from 0 on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ticks {
    /// 1, 2 or 5.
    digit: i32,
    /// The step is the digit times this power of ten.
    power: i32,
    /// The power of ten taken out of the labels.
    exponent: i32,
    count: i32,
}

impl Ticks {
    /// Ticks up to `top`, which is positive: about so many.
    pub fn new(top: f64, wanted: f64) -> Self {
        let (digit, power) = round_step(top / wanted);
        let magnitude = top.log10().floor() as i32;
        let exponent = if (-3..=4).contains(&magnitude) { 0 } else { magnitude };
        let count = (top / (f64::from(digit) * 10f64.powi(power)) * (1.0 + 1e-9)).floor() as i32;
        Self { digit, power, exponent, count }
    }

    /// Every tick with its label.
    pub fn all(self) -> impl Iterator<Item = (f64, String)> {
        let shift = self.power - self.exponent;
        let decimals = (-shift).max(0) as usize;
        (0..=self.count).map(move |index| {
            let units = f64::from(index * self.digit);
            (units * 10f64.powi(self.power), format!("{:.decimals$}", units * 10f64.powi(shift)))
        })
    }

    /// What labels must be multiplied by, to follow the name of the axis.
    pub fn factor(self) -> String {
        if self.exponent == 0 { String::new() } else { format!(" (\u{d7} 1e{})", self.exponent) }
    }
}

/// The round number nearest below twice `value`: 1, 2 or 5, and the power of ten it is multiplied by.
pub fn round_step(value: f64) -> (i32, i32) {
    let power = value.log10().floor() as i32;
    match value / 10f64.powi(power) {
        share if share <= 1.0 => (1, power),
        share if share <= 2.0 => (2, power),
        share if share <= 5.0 => (5, power),
        _ => (1, power + 1),
    }
}

/// A value in four significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if value.is_infinite() {
        return "\u{221e}".to_owned();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        let written = format!("{value:.3e}");
        let (digits, exponent) = written.split_once('e').unwrap_or((&written, "0"));
        return format!("{}e{exponent}", without_zeros(digits));
    }
    let decimals = (3 - magnitude).max(0) as usize;
    without_zeros(&format!("{value:.decimals$}")).to_owned()
}

fn without_zeros(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// A count with its noun: "1 cycle", "12,345 points".
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(number))
}

/// A count in groups of three digits.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(top: f64) -> (Vec<String>, String) {
        let ticks = Ticks::new(top, 5.0);
        (ticks.all().map(|(_, label)| label).collect(), ticks.factor())
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(0.46), (["0.0", "0.1", "0.2", "0.3", "0.4"].map(str::to_owned).into(), String::new()));
        assert_eq!(labels(65.0), (["0", "20", "40", "60"].map(str::to_owned).into(), String::new()));
        assert_eq!(labels(1.0).0.last().map(String::as_str), Some("1.0"));
    }

    #[test]
    fn extreme_ticks_have_a_factor() {
        let (labels_small, factor) = labels(4.6e-10);
        assert_eq!((labels_small.join(" ").as_str(), factor.as_str()), ("0 1 2 3 4", " (\u{d7} 1e-10)"));
        let (labels_large, factor) = labels(2.0e60);
        assert_eq!((labels_large.join(" ").as_str(), factor.as_str()), ("0.0 0.5 1.0 1.5 2.0", " (\u{d7} 1e60)"));
        assert!(labels(1e-59).0.len() >= 4);
    }

    #[test]
    fn values_are_short() {
        let values = [0.0, 0.576_941_016, 2.0, 51.171_281, 29_131.6, 4.558_7e-10, 1e9, f64::INFINITY, -0.5];
        let written = values.map(short);
        assert_eq!(written, ["0", "0.5769", "2", "51.17", "29132", "4.559e-10", "1e9", "\u{221e}", "-0.5"]);
    }

    #[test]
    fn counts_are_grouped() {
        assert_eq!(count(1, "cycle"), "1 cycle");
        assert_eq!(count(0, "cycle"), "0 cycles");
        assert_eq!([12, 999, 1000, 1_234_567].map(grouped), ["12", "999", "1,000", "1,234,567"]);
    }
}
