//! The split of a tile: a position in a total order along one axis.
//!
//! In: positions.
//! Out: the axis along which they are halved, and the half that a position is in.
//! Invariant: any set of different positions can be halved.
//! Must not know: the tree.

use crate::topology::cloud::Position;

/// Where a tile is halved.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// The coordinate that is compared first.
    pub axis: Axis,
    /// The first position of the second half.
    pub at: [f64; 2],
}

/// The axis along which a tile is halved.
#[derive(Clone, Copy, Debug)]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
}

impl Split {
    /// The half that a position is in.
    #[inline]
    pub fn half(self, position: Position) -> usize {
        usize::from(self.axis.key(position) >= self.at)
    }
}

impl Axis {
    /// The key of a position: this coordinate, then the other one.
    #[inline]
    pub fn key(self, position: Position) -> [f64; 2] {
        let [x, y] = position.xy();
        match self {
            Axis::X => [x, y],
            Axis::Y => [y, x],
        }
    }

    /// The longer side of the bounding box of some positions.
    pub fn longest(positions: impl Iterator<Item = Position>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for position in positions {
            for (axis, v) in position.xy().into_iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(v), high[axis].max(v));
            }
        }
        if high[1] - low[1] > high[0] - low[0] { Axis::Y } else { Axis::X }
    }
}
