//! Colours for persistence.
//!
//! In: the largest persistence of a diagram, then others.
//! Out: buckets and their colours, from light (on the diagonal) to dark (the most persistent).
//! Invariants: perceptually uniform (stops of matplotlib's "plasma", its palest and darkest ends left out, which
//! are too near to the ground and to the ink); the number of buckets is fixed, so a picture of a million dots needs
//! no more paths than that.
//! Must not know: dots, shapes.

use std::fmt::{self, Display};

/// How many colours there are.
pub const BUCKETS: usize = 48;

/// Evenly spaced colours between which the ramp is linear.
pub const STOPS: [Rgb; 8] = [
    Rgb([0xfc, 0xa6, 0x36]),
    Rgb([0xf2, 0x84, 0x4b]),
    Rgb([0xe1, 0x64, 0x62]),
    Rgb([0xcc, 0x47, 0x78]),
    Rgb([0xb1, 0x2a, 0x90]),
    Rgb([0x8f, 0x0d, 0xa4]),
    Rgb([0x6a, 0x00, 0xa8]),
    Rgb([0x41, 0x04, 0x9d]),
];

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rgb([u8; 3]);

impl Display for Rgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// A share of the largest persistence, rounded to one of [`BUCKETS`] steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bucket(usize);

impl Bucket {
    /// All of them, the least persistent first.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..BUCKETS).map(Self)
    }

    /// Its place among all.
    pub fn index(self) -> usize {
        self.0
    }

    /// From 0 (on the diagonal) to 1 (the most persistent).
    pub fn share(self) -> f64 {
        self.0 as f64 / (BUCKETS - 1) as f64
    }

    /// Its colour.
    pub fn color(self) -> Rgb {
        let place = self.share() * (STOPS.len() - 1) as f64;
        let left = (place as usize).min(STOPS.len() - 2);
        let share = place - left as f64;
        let mix = |channel: usize| {
            let [from, to] = [STOPS[left], STOPS[left + 1]].map(|stop| f64::from(stop.0[channel]));
            (from + share * (to - from)).round() as u8
        };
        Rgb([mix(0), mix(1), mix(2)])
    }
}

/// Maps persistence to colours.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    top: f64,
}

impl Ramp {
    /// The ramp whose dark end is `top`.
    pub fn new(top: f64) -> Self {
        Self { top }
    }

    /// The persistence at the dark end.
    pub fn top(&self) -> f64 {
        self.top
    }

    /// The bucket of a persistence.
    pub fn bucket(&self, persistence: f64) -> Bucket {
        let share = if persistence < self.top { persistence / self.top } else { 1.0 };
        Bucket((share * (BUCKETS - 1) as f64).round() as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_the_first_and_last_stop() {
        let ramp = Ramp::new(2.0);
        assert_eq!(ramp.bucket(0.0).color(), STOPS[0]);
        assert_eq!(ramp.bucket(2.0).color(), STOPS[7]);
        assert_eq!(ramp.bucket(f64::INFINITY).color(), STOPS[7]);
        assert_eq!(STOPS[0].to_string(), "#fca636");
    }

    #[test]
    fn more_persistent_is_darker() {
        let brightness = |bucket: Bucket| {
            let [r, g, b] = bucket.color().0.map(f64::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let all: Vec<f64> = Bucket::all().map(brightness).collect();
        assert!(all.is_sorted_by(|a, b| a > b), "{all:?}");
    }

    #[test]
    fn a_ramp_without_height_has_one_colour() {
        assert_eq!(Ramp::new(0.0).bucket(0.0).color(), STOPS[7]);
    }
}
