//! How things of a scene move and change with time.
//!
//! In: a frame's number. Out: offsets, and values that come round again. Invariants: all is a function of the frame
//! alone, for any number of frames. Must not know: what moves.

use super::turn::wave;

/// A smooth way around a place: a wave in each coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sway {
    /// How far it goes either way, in x and in y.
    pub reach: [f64; 2],
    /// Frames until it comes round, in x and in y.
    pub periods: [f64; 2],
    /// Where it begins, in turns.
    pub phases: [f64; 2],
}

impl Sway {
    /// Where it is.
    pub fn at(&self, frame: f64) -> [f64; 2] {
        [0, 1].map(|axis| match self.reach[axis] {
            0.0 => 0.0,
            reach => reach * wave(frame / self.periods[axis] + self.phases[axis]),
        })
    }
}

/// A value that goes straight from knot to knot, and round again.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Frames since the beginning, and the value there; the first at 0, the last one ends the round. Two at one time
    /// are a jump.
    knots: Vec<[f64; 2]>,
    /// How far into the round frame 0 is.
    shift: f64,
}

impl Cycle {
    /// Goes through values, each with the number of frames until the next; 0 for a jump. Begins at a share of the
    /// round.
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

    /// A switch that is on and off for so many frames.
    pub fn switch(on: f64, off: f64, begin: f64) -> Self {
        Self::new(&[[1.0, on], [1.0, 0.0], [0.0, off], [0.0, 0.0]], begin)
    }

    /// Its value.
    pub fn at(&self, frame: f64) -> f64 {
        let round = self.knots.last().map_or(0.0, |&[time, _]| time);
        let time = (frame + self.shift) % round;
        let leg = self.knots.windows(2).find(|leg| (leg[0][0]..leg[1][0]).contains(&time));
        leg.map_or(0.0, |leg| {
            let ([begin, from], [end, to]) = (leg[0], leg[1]);
            from + (to - from) * ((time - begin) / (end - begin))
        })
    }

    /// Whether a switch is on.
    pub fn is_on(&self, frame: f64) -> bool {
        self.at(frame) > 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_go_straight_and_round() {
        let cycle = Cycle::new(&[[0.0, 4.0], [2.0, 1.0], [2.0, 5.0]], 0.0);
        let values = [0.0, 1.0, 4.0, 4.5, 5.0, 7.5, 10.0, 12.0].map(|frame| cycle.at(frame));
        assert_eq!(values, [0.0, 0.5, 2.0, 2.0, 2.0, 1.0, 0.0, 1.0]);
        assert_eq!(Cycle::new(&[[0.0, 4.0], [2.0, 6.0]], 0.25).at(2.0), 2.0);
        let switch = Cycle::switch(3.0, 2.0, 0.0);
        let on: Vec<bool> = (0..7).map(|frame| switch.is_on(f64::from(frame))).collect();
        assert_eq!(on, [true, true, true, false, false, true, true]);
    }

    #[test]
    fn ways_come_round() {
        let sway = Sway { reach: [2.0, 0.0], periods: [8.0, 0.0], phases: [0.0, 0.0] };
        assert_eq!([0.0, 2.0, 6.0, 8.0].map(|frame| sway.at(frame)), [[0.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 0.0]]);
    }
}
