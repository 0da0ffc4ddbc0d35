//! Where a tile is halved: at a position in a total order along one axis.
//!
//! In: positions. Out: the axis to halve them along, and the half that each is in. Invariant: any cloud of different positions can be halved. Must not know: the tree.

use crate::topology::cloud::Position;

/// Where a tile is halved.
#[derive(Clone, Copy, Debug)]
pub struct Split {
    /// Which coordinate decides first.
    pub axis: Axis,
    /// The first position of the second half.
    pub at: [f64; 2],
}

/// Along which coordinate a tile is halved.
#[derive(Clone, Copy, Debug)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
}

impl Split {
    /// Which half a position is in.
    #[inline]
    pub fn half(self, position: Position) -> usize {
        usize::from(self.axis.key(position) >= self.at)
    }
}

impl Axis {
    /// What positions are compared by: this coordinate, then the other one.
    #[inline]
    pub fn key(self, position: Position) -> [f64; 2] {
        let [x, y] = position.xy();
        match self {
            Axis::X => [x, y],
            Axis::Y => [y, x],
        }
    }

    /// The longer side of the box around some positions.
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
