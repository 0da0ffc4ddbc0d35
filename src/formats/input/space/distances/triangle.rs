//! The distances on one side of the diagonal, in rows or one after the other.
//!
//! In: rows, of any lengths or of those of a triangle.
//! Out: the distances below the diagonal.
//! Invariants: rows that are one longer than the row before, or one shorter, and all have zeros where the diagonal
//! would be, have the diagonal.
//! Must not know: lines.

use super::super::Space;
use super::{DistanceError, RowFault, distance, pairs_of};

/// In which order the distances come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// d(1,0), d(2,0), d(2,1), ...
    Lower,
    /// d(0,1), d(0,2), ..., d(1,2), ...
    Upper,
}

/// What rows are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rows {
    /// Those of a triangle.
    Strict,
    /// Those of a triangle if their lengths say so, else pieces of one list.
    Loose,
    /// Pieces of one list.
    Pieces,
}

/// A triangle that is being read.
#[derive(Debug)]
pub(super) struct Triangle {
    order: Order,
    is_strict: bool,
    numbers: Vec<f64>,
    rows: usize,
    first: usize,
    last: usize,
    /// Whether all rows so far have the lengths of a triangle.
    has_lengths: bool,
    /// Whether all rows so far have zeros where the diagonal would be.
    has_zeros: bool,
    most: usize,
}

impl Triangle {
    /// A triangle of at most so many points.
    pub(super) fn new(order: Order, kind: Rows, most: usize) -> Self {
        let (is_strict, has_lengths) = (kind == Rows::Strict, kind != Rows::Pieces);
        let (numbers, rows, first, last) = (Vec::new(), 0, 0, 0);
        Self { order, is_strict, numbers, rows, first, last, has_lengths, has_zeros: true, most }
    }

    pub(super) fn row(&mut self, row: &[f64]) -> Result<(), RowFault> {
        if self.rows == 0 {
            self.first = row.len();
        }
        let expected = match self.order {
            Order::Lower => self.rows + 1,
            Order::Upper => self.first.saturating_sub(self.rows),
        };
        self.has_lengths &= row.len() == expected;
        if self.is_strict && !self.has_lengths {
            let form = if self.order == Order::Lower { "a lower triangle" } else { "an upper triangle" };
            return Err(DistanceError::Width { row: self.rows + 1, found: row.len(), expected, form }.of_line());
        }
        for (column, &value) in row.iter().enumerate() {
            self.number(value).map_err(|error| error.in_column(column))?;
        }
        let diagonal = if self.order == Order::Lower { row.last() } else { row.first() };
        self.has_zeros &= diagonal == Some(&0.0);
        self.rows += 1;
        self.last = row.len();
        Ok(())
    }

    fn number(&mut self, value: f64) -> Result<(), DistanceError> {
        // With the diagonal, there is one number more for each point.
        if self.numbers.len() == pairs_of(self.most) + self.most {
            return Err(DistanceError::TooMany { most: self.most });
        }
        self.numbers.push(distance(value)?);
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<(Space, String), DistanceError> {
        let is_whole = self.order == Order::Lower || self.last == 1;
        if self.is_strict && !is_whole {
            return Err(DistanceError::Unfinished { found: self.last });
        }
        // One zero in one row may be the distance of two points that coincide.
        let has_diagonal = self.has_lengths && self.has_zeros && is_whole && self.rows > 1;
        if has_diagonal {
            self.drop_diagonal();
        }
        let count = points_of(self.numbers.len())?;
        if count > self.most {
            return Err(DistanceError::TooMany { most: self.most });
        }
        let distances = if self.order == Order::Upper { transposed(&self.numbers, count) } else { self.numbers };
        let side = if self.order == Order::Lower { "a lower" } else { "an upper" };
        let diagonal = if has_diagonal { "with" } else { "without" };
        let taken = format!("{side} triangle {diagonal} its diagonal, of {count} points");
        Ok((Space::Lower { count, distances }, taken))
    }

    fn drop_diagonal(&mut self) {
        let (mut row, mut place) = (0, 0);
        let (rows, order) = (self.rows, self.order);
        self.numbers.retain(|_| {
            let length = if order == Order::Lower { row + 1 } else { rows - row };
            let is_diagonal = place == if order == Order::Lower { length - 1 } else { 0 };
            place += 1;
            if place == length {
                (row, place) = (row + 1, 0);
            }
            !is_diagonal
        });
    }
}

/// How many points have so many distances.
fn points_of(distances: usize) -> Result<usize, DistanceError> {
    if distances == 0 {
        return Ok(0);
    }
    // (n - 1)^2 <= n (n - 1) < n^2
    let points = (2 * distances).isqrt() + 1;
    if pairs_of(points) == distances { Ok(points) } else { Err(DistanceError::NoTriangle { numbers: distances }) }
}

/// The same distances in the order of a lower triangle.
fn transposed(upper: &[f64], count: usize) -> Vec<f64> {
    let place = |low: usize, high: usize| low * (2 * count - low - 1) / 2 + high - low - 1;
    (1..count).flat_map(|high| (0..high).map(move |low| upper[place(low, high)])).collect()
}
