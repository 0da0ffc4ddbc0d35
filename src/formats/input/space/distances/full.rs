//! A square matrix, row by row.
//!
//! In: rows.
//! Out: the distances below the diagonal.
//! Invariants: each distance is kept once, when its first half comes; the other half must be the same.
//! Must not know: lines.

use std::cmp::Ordering;

use super::super::Space;
use super::{DistanceError, RowFault, distance, pairs_of};

/// A matrix that is being read.
#[derive(Debug)]
pub(super) struct Full {
    /// Of each column, the distances above the diagonal so far, from the first row down.
    columns: Vec<Vec<f64>>,
    rows: usize,
    most: usize,
}

impl Full {
    /// A matrix of at most so many points.
    pub(super) fn new(most: usize) -> Self {
        Self { columns: Vec::new(), rows: 0, most }
    }

    pub(super) fn row(&mut self, row: &[f64]) -> Result<(), RowFault> {
        let own = self.rows;
        if own == 0 {
            if row.len() > self.most {
                return Err(DistanceError::TooMany { most: self.most }.of_line());
            }
            self.columns = vec![Vec::new(); row.len()];
        }
        let width = self.columns.len();
        if own == width {
            return Err(DistanceError::NotSquare { rows: own + 1, columns: width }.of_line());
        }
        if row.len() != width {
            let form = "a full matrix";
            return Err(DistanceError::Width { row: own + 1, found: row.len(), expected: width, form }.of_line());
        }
        for (column, &value) in row.iter().enumerate() {
            self.entry(column, value).map_err(|error| error.in_column(column))?;
        }
        self.rows += 1;
        Ok(())
    }

    fn entry(&mut self, column: usize, value: f64) -> Result<(), DistanceError> {
        let value = distance(value)?;
        let row = self.rows;
        match column.cmp(&row) {
            Ordering::Greater => self.columns[column].push(value),
            Ordering::Equal if value == 0.0 => {}
            Ordering::Equal => return Err(DistanceError::Diagonal { row: row + 1, value: value.to_string() }),
            Ordering::Less => {
                let other = self.columns[row][column];
                if other != value {
                    let (value, other) = (value.to_string(), other.to_string());
                    return Err(DistanceError::Asymmetric { row: row + 1, column: column + 1, value, other });
                }
            }
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<(Space, String), DistanceError> {
        let count = self.columns.len();
        if self.rows != count {
            return Err(DistanceError::NotSquare { rows: self.rows, columns: count });
        }
        let mut distances = Vec::with_capacity(pairs_of(count));
        for column in self.columns {
            distances.extend(column);
        }
        Ok((Space::Lower { count, distances }, format!("a full matrix of {count} points")))
    }
}
