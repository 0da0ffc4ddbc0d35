//! Similarities of the plane: the motions of a camera.
//!
//! In: points.
//! Out: where they are after a motion, or were before it; a [`Motion`] after another one.
//! Invariant: a motion has an inverse.
//! Must not know: holes, tracks.

/// A similarity of the plane: `point` goes to `turn * point + shift`, as complex numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// A turn and a change of scale.
    pub turn: [f64; 2],
    /// A shift.
    pub shift: [f64; 2],
}

impl Motion {
    /// No motion.
    pub const IDENTITY: Self = Self { turn: [1.0, 0.0], shift: [0.0; 2] };

    /// Where a point is after it.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([c, s], [dx, dy]) = (self.turn, self.shift);
        [c * x - s * y + dx, s * x + c * y + dy]
    }

    /// Where a point was before it.
    pub fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([c, s], [dx, dy]) = (self.turn, self.shift);
        let ([x, y], size) = ([x - dx, y - dy], c * c + s * s);
        [(c * x + s * y) / size, (c * y - s * x) / size]
    }

    /// This motion after another one.
    pub fn after(&self, other: &Self) -> Self {
        let ([c, s], [x, y]) = (self.turn, other.turn);
        Self { turn: [c * x - s * y, s * x + c * y], shift: self.apply(other.shift) }
    }

    /// What becomes of a difference of two points.
    pub fn turned(&self, difference: [f64; 2]) -> [f64; 2] {
        Self { shift: [0.0; 2], ..*self }.apply(difference)
    }
}
