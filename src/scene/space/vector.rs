//! Positions in R^3, and rotations.
//!
//! In: turns around axes, numbers of frames.
//! Out: rotated and moved positions.
//! Invariants: the same bits on every machine: angles go through `turn`.
//! Must not know: what is rotated.

use crate::scene::random::Random;
use crate::scene::turn::direction;

/// A position in R^3.
pub type Vector = [f64; 3];

/// A position, moved by a multiple of a vector.
pub fn moved(position: Vector, by: Vector, lengths: f64) -> Vector {
    std::array::from_fn(|axis| position[axis] + by[axis] * lengths)
}

/// A rotation around the origin, as the images of the three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attitude([Vector; 3]);

impl Attitude {
    /// A rotation around the z axis by `yaw` turns, after one around the x axis by `roll` turns.
    pub fn new(roll: f64, yaw: f64) -> Self {
        let ([rx, ry], [yx, yy]) = (direction(roll), direction(yaw));
        Self([[yx, yy, 0.0], [-yy * rx, yx * rx, ry], [yy * ry, -yx * ry, rx]])
    }

    /// A position, rotated.
    pub fn of(&self, [x, y, z]: Vector) -> Vector {
        moved(moved(moved([0.0; 3], self.0[0], x), self.0[1], y), self.0[2], z)
    }
}

/// A rotation that goes on evenly.
#[derive(Clone, Copy, Debug)]
pub struct Tumble {
    /// Turns in each frame around x, then around z.
    rates: [f64; 2],
    phases: [f64; 2],
}

impl Tumble {
    /// About one turn in 600 to 900 frames around each of two axes, from a random attitude.
    pub fn draw(random: &mut Random) -> Self {
        let rates = [(); 2].map(|()| if random.unit() < 0.5 { 1.0 } else { -1.0 } / random.between(600.0, 900.0));
        Self { rates, phases: [random.unit(), random.unit()] }
    }

    /// The attitude in a frame.
    pub fn at(&self, frame: f64) -> Attitude {
        let [roll, yaw] = [0, 1].map(|axis| self.rates[axis] * frame + self.phases[axis]);
        Attitude::new(roll, yaw)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_keep_distances_and_handedness() {
        let attitude = Tumble::draw(&mut Random::new(3)).at(17.0);
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| attitude.of(axis));
        let dot = |a: Vector, b: Vector| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for (product, expected) in [(dot(x, x), 1.0), (dot(y, y), 1.0), (dot(x, y), 0.0), (dot(y, z), 0.0)] {
            assert!((product - expected).abs() < 1e-14, "{product}");
        }
        let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
        assert!(cross.iter().zip(z).all(|(a, b)| (a - b).abs() < 1e-14), "{cross:?} {z:?}");
        assert_eq!(Attitude::new(0.0, 0.25).of([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(Attitude::new(0.25, 0.0).of([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
    }
}
