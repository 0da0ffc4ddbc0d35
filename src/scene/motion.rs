//! Periodic motions and values of a scene.
//!
//! In: a frame's number. Out: offsets, and periodic values.
//!
//! Invariants: everything is a function of the frame's number alone, for any number of frames.
//!
//! Must not know: what moves.

use super::turn::wave;

/// A smooth periodic motion around a position: a sine wave in each coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation<const D: usize = 2> {
    /// The amplitude in each coordinate.
    pub reach: [f64; D],
    /// The period in each coordinate, in frames.
    pub periods: [f64; D],
    /// The phase in each coordinate, in turns.
    pub phases: [f64; D],
}

impl<const D: usize> Default for Oscillation<D> {
    /// No motion.
    fn default() -> Self {
        Self { reach: [0.0; D], periods: [0.0; D], phases: [0.0; D] }
    }
}

impl<const D: usize> Oscillation<D> {
    /// The offset in a frame.
    pub fn at(&self, frame: f64) -> [f64; D] {
        std::array::from_fn(|axis| match self.reach[axis] {
            0.0 => 0.0,
            reach => reach * wave(frame / self.periods[axis] + self.phases[axis]),
        })
    }
}

/// A periodic value, linear between its knots.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Frames since the beginning of the period, and the value there. The first knot is at 0, the last one ends the
    /// period. Two knots at the same time are a jump.
    knots: Vec<[f64; 2]>,
    /// The position of frame 0 in the period.
    shift: f64,
}

impl Cycle {
    /// A value that goes through a list of values. Each comes with the number of frames until the next one; 0 is a
    /// jump. It begins at `begin`, a share of the period.
    pub fn new(legs: &[[f64; 2]], begin: f64) -> Self {
        let mut time = 0.0;
        let mut knots: Vec<[f64; 2]> = Vec::with_capacity(legs.len() + 1);
        for &[value, frames] in legs {
            knots.push([time, value]);
            time += frames;
        }
        knots.extend(legs.first().map(|&[value, _]| [time, value]));
        Self { knots, shift: (begin * time).floor() }
    }

    /// A value that is 1 for `on` frames and 0 for `off` frames, and so on.
    pub fn switch(on: f64, off: f64, begin: f64) -> Self {
        Self::new(&[[1.0, on], [1.0, 0.0], [0.0, off], [0.0, 0.0]], begin)
    }

    /// The value in a frame.
    pub fn at(&self, frame: f64) -> f64 {
        let round = self.knots.last().map_or(0.0, |&[time, _]| time);
        let time = (frame + self.shift) % round;
        let leg = self.knots.windows(2).find(|leg| (leg[0][0]..leg[1][0]).contains(&time));
        leg.map_or(0.0, |leg| {
            let ([begin, from], [end, to]) = (leg[0], leg[1]);
            from + (to - from) * ((time - begin) / (end - begin))
        })
    }

    /// Whether the value of a switch is 1.
    pub fn is_on(&self, frame: f64) -> bool {
        self.at(frame) > 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_are_linear_between_knots_and_periodic() {
        let cycle = Cycle::new(&[[0.0, 4.0], [2.0, 1.0], [2.0, 5.0]], 0.0);
        let values = [0.0, 1.0, 4.0, 4.5, 5.0, 7.5, 10.0, 12.0].map(|frame| cycle.at(frame));
        assert_eq!(values, [0.0, 0.5, 2.0, 2.0, 2.0, 1.0, 0.0, 1.0]);
        assert_eq!(Cycle::new(&[[0.0, 4.0], [2.0, 6.0]], 0.25).at(2.0), 2.0);
        let switch = Cycle::switch(3.0, 2.0, 0.0);
        let on: Vec<bool> = (0..7).map(|frame| switch.is_on(f64::from(frame))).collect();
        assert_eq!(on, [true, true, true, false, false, true, true]);
    }

    #[test]
    fn oscillations_are_periodic() {
        let oscillation = Oscillation { reach: [2.0, 0.0], periods: [8.0, 0.0], phases: [0.0, 0.0] };
        assert_eq!(
            [0.0, 2.0, 6.0, 8.0].map(|frame| oscillation.at(frame)),
            [[0.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 0.0]]
        );
    }
}
