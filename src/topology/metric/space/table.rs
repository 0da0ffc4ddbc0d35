//! The lengths of another space, computed once.
//!
//! In: a space whose lengths are costly.
//! Out: a [`Table`] with the same lengths, bit for bit.
//! Must not know: what makes them costly.

use super::Distances;
use super::matrix::Matrix;

/// All lengths of a space of points.
pub struct Table<'s> {
    lengths: Matrix,
    space: &'s dyn Distances,
}

impl<'s> Table<'s> {
    /// Computes all lengths.
    pub fn new(space: &'s dyn Distances) -> Self {
        Self { lengths: Matrix::of(space), space }
    }
}

impl Distances for Table<'_> {
    fn count(&self) -> usize {
        self.lengths.count()
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.lengths.length(a, b)
    }

    fn lengths(&self, a: u32, first: u32, out: &mut [f64]) {
        self.lengths.lengths(a, first, out);
    }

    fn radius(&self, length: f64) -> f64 {
        self.space.radius(length)
    }
}
