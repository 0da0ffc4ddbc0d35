//! A horizontal axis that need not begin at 0.
//!
//! In: the first and the last value, a length in pixels.
//! Out: places of values, and round ticks with their labels.
//! Invariants: the ends are the ends of the axis; a range without length is in its middle. A tick's label is exact
//! to the step. There are never many ticks.
//! Must not know: what is drawn there.

use super::numbers::round_step;

/// Pixels between ticks, about.
const TICK_SPACE: f64 = 110.0;
/// Labels are written with an exponent for magnitudes beyond these.
const PLAIN: std::ops::RangeInclusive<i32> = -5..=12;

/// Maps values to pixels from the left end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    span: f64,
    length: f64,
    /// Whether only whole values are meant.
    is_whole: bool,
}

impl Axis {
    /// An axis for values that are no farther apart than numbers go.
    pub fn new([low, high]: [f64; 2], length: f64, is_whole: bool) -> Self {
        Self { low, span: high - low, length, is_whole }
    }

    /// Where a value is.
    pub fn place(self, value: f64) -> f64 {
        if self.span.is_normal() { (value - self.low) / self.span * self.length } else { self.length / 2.0 }
    }

    /// Round values with their labels.
    pub fn ticks(self) -> Vec<(f64, String)> {
        if !self.span.is_normal() {
            return vec![(self.low, self.label(self.low, 0))];
        }
        let (mut digit, mut power) = round_step(self.span * (TICK_SPACE / self.length).min(1.0));
        if self.is_whole && power < 0 {
            (digit, power) = (1, 0);
        }
        let step = f64::from(digit) * 10f64.powi(power);
        let first = (self.low / step).ceil();
        let most = (2.0 * self.length / TICK_SPACE) as usize + 2;
        // Where values are great and the span is small, some steps round to the same value.
        let mut ticks: Vec<f64> = (0..most).map(|index| (first + index as f64) * step).collect();
        ticks.dedup();
        ticks.retain(|&value| value.is_finite() && value <= self.low + self.span * (1.0 + 1e-9));
        ticks.into_iter().map(|value| (value, self.label(value, power))).collect()
    }

    fn label(self, value: f64, power: i32) -> String {
        let top = self.low.abs().max((self.low + self.span).abs());
        let magnitude = if top > 0.0 { top.log10().floor() as i32 } else { 0 };
        if PLAIN.contains(&magnitude) && power > -10 {
            let decimals = (-power).max(0) as usize;
            return format!("{value:.decimals$}");
        }
        let digits = (magnitude - power).clamp(0, 16) as usize;
        format!("{value:.digits$e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: [f64; 2], is_whole: bool) -> Vec<String> {
        Axis::new(range, 550.0, is_whole).ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_wherever_the_axis_begins() {
        assert_eq!(labels([1.0, 600.0], true), ["200", "400", "600"]);
        assert_eq!(labels([-0.3, 0.3], false), ["-0.2", "0.0", "0.2"]);
        assert_eq!(labels([1.7e9 + 0.2, 1.7e9 + 1.0], false)[..2], ["1700000000.2", "1700000000.4"]);
        assert_eq!(labels([0.0, 4e60], false), ["0e0", "1e60", "2e60", "3e60", "4e60"]);
    }

    #[test]
    fn frames_have_whole_numbers() {
        assert_eq!(labels([3.0, 5.0], true), ["3", "4", "5"]);
        assert_eq!(labels([7.0, 7.0], true), ["7"]);
    }

    #[test]
    fn extreme_ranges_have_few_ticks_inside() {
        for range in
            [[0.0, f64::MAX], [-8e307, 8e307], [0.0, 5e-324], [1e17, 1e17 + 32.0], [1e300, 1.1e300], [-1e-300, 0.0]]
        {
            let axis = Axis::new(range, 900.0, false);
            let ticks = axis.ticks();
            assert!(ticks.len() <= 20, "{range:?}: {ticks:?}");
            for (value, label) in ticks {
                assert!((-1.0..=901.0).contains(&axis.place(value)), "{range:?}: {value}");
                assert!(label.len() <= 26, "{label}");
            }
        }
    }
}
