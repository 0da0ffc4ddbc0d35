//! A matrix of distances.
//!
//! In: its strict lower triangle, or all of it.
//! Out: a [`Matrix`].
//! Invariants: one value a pair, stored once, row by row of the upper triangle, so that the distances of a vertex to
//! all larger ones stand together.
//! Must not know: what the distances are of.

use super::Distances;
use super::error::{SpaceError, distance};

/// Distances of all pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    count: usize,
    /// d(0,1), d(0,2), ..., d(1,2), ...
    upper: Vec<f64>,
}

/// So many columns are turned into rows at once, so that what is written stays in the cache.
const BLOCK: usize = 64;

impl Matrix {
    /// From d(1,0), d(2,0), d(2,1), d(3,0), ... Infinite distances join nothing.
    ///
    /// # Errors
    /// [`SpaceError`] if a distance is negative or NaN, or if there are too few or too many.
    pub fn from_lower(count: usize, lower: &[f64]) -> Result<Self, SpaceError> {
        let mut matrix = Self::zero(count);
        if lower.len() != matrix.upper.len() {
            return Err(SpaceError::Count { values: lower.len(), count, expected: matrix.upper.len() });
        }
        for first in (0..count).step_by(BLOCK) {
            for b in first + 1..count {
                for a in first..b.min(first + BLOCK) {
                    let at = matrix.row(a) + b - a - 1;
                    matrix.upper[at] = distance(b, a, lower[b * (b - 1) / 2 + a])?;
                }
            }
        }
        Ok(matrix)
    }

    /// From all rows of a square matrix.
    ///
    /// # Errors
    /// Those of [`from_lower`](Self::from_lower), and if the diagonal is not zero or the two halves differ in any bit.
    pub fn from_square(count: usize, square: &[f64]) -> Result<Self, SpaceError> {
        if square.len() != count * count {
            return Err(SpaceError::Count { values: square.len(), count, expected: count * count });
        }
        let mut matrix = Self { count, upper: Vec::with_capacity(count * count.saturating_sub(1) / 2) };
        for a in 0..count {
            let value = square[a * count + a];
            if value != 0.0 {
                return Err(SpaceError::Diagonal { point: a, value });
            }
            for b in a + 1..count {
                let there = distance(a, b, square[a * count + b])?;
                let back = distance(b, a, square[b * count + a])?;
                if there != back {
                    return Err(SpaceError::Asymmetric { a, b, there, back });
                }
                matrix.upper.push(there);
            }
        }
        Ok(matrix)
    }

    /// The lengths of another space.
    pub(super) fn of(space: &dyn Distances) -> Self {
        let mut matrix = Self::zero(space.count());
        let mut rest = matrix.upper.as_mut_slice();
        for a in 0..matrix.count {
            let (row, rows) = rest.split_at_mut(matrix.count - a - 1);
            space.lengths(a as u32, a as u32 + 1, row);
            rest = rows;
        }
        matrix
    }

    /// These vertices alone; they must be in increasing order.
    pub fn subset(&self, chosen: &[u32]) -> Self {
        let mut matrix = Self::zero(chosen.len());
        let pairs = chosen.iter().enumerate().flat_map(|(at, &a)| chosen[at + 1..].iter().map(move |&b| (a, b)));
        for (value, (a, b)) in matrix.upper.iter_mut().zip(pairs) {
            *value = self.length(a, b);
        }
        matrix
    }

    fn zero(count: usize) -> Self {
        Self { count, upper: vec![0.0; count * count.saturating_sub(1) / 2] }
    }

    /// Where the row of a vertex begins: its distances to larger vertices.
    #[inline]
    fn row(&self, a: usize) -> usize {
        a * (2 * self.count - a - 1) / 2
    }
}

impl Distances for Matrix {
    fn count(&self) -> usize {
        self.count
    }

    #[inline]
    fn length(&self, a: u32, b: u32) -> f64 {
        let (small, large) = (a.min(b) as usize, a.max(b) as usize);
        if small == large { 0.0 } else { self.upper[self.row(small) + large - small - 1] }
    }

    fn lengths(&self, a: u32, first: u32, out: &mut [f64]) {
        let (from, first) = (a as usize, first as usize);
        let smaller = (from + 1).saturating_sub(first).min(out.len());
        let (before, after) = out.split_at_mut(smaller);
        for (out, b) in before.iter_mut().zip(first as u32..) {
            *out = self.length(a, b);
        }
        if !after.is_empty() {
            let start = self.row(from) + first + smaller - from - 1;
            after.copy_from_slice(&self.upper[start..start + after.len()]);
        }
    }

    fn radius(&self, length: f64) -> f64 {
        0.5 * length
    }
}
