//! Pairs of points with their distance: all others are infinite.
//!
//! In: rows of three numbers, i, j and their distance.
//! Out: each pair once, in order.
//! Invariants: a pair that comes again has the same distance. Memory grows with the number of different pairs.
//! Must not know: lines.

use super::super::Space;
use super::{DistanceError, RowFault, distance};

/// After so many pairs, those that are there twice are dropped for the first time.
const FEW: usize = 1 << 16;

/// Pairs that are being read.
#[derive(Debug)]
pub(super) struct Pairs {
    pairs: Vec<Pair>,
    count: usize,
    rows: u64,
    most: usize,
    /// How many pairs there may be until some are dropped again.
    next_settling: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    low: u32,
    high: u32,
    distance: f64,
    row: u64,
}

impl Pairs {
    /// Of at most so many points.
    pub(super) fn new(most: usize) -> Self {
        Self { pairs: Vec::new(), count: 0, rows: 0, most, next_settling: FEW }
    }

    pub(super) fn row(&mut self, row: &[f64]) -> Result<(), RowFault> {
        self.rows += 1;
        let &[i, j, value] = row else {
            let (number, form) = (usize::try_from(self.rows).unwrap_or(usize::MAX), "a list of pairs");
            return Err(DistanceError::Width { row: number, found: row.len(), expected: 3, form }.of_line());
        };
        let i = self.point(i).map_err(|error| error.in_column(0))?;
        let j = self.point(j).map_err(|error| error.in_column(1))?;
        let distance = distance(value).map_err(|error| error.in_column(2))?;
        if i == j {
            let apart = || DistanceError::Apart { point: i, value: value.to_string() }.in_column(2);
            return if distance == 0.0 { Ok(()) } else { Err(apart()) };
        }
        self.pairs.push(Pair { low: i.min(j), high: i.max(j), distance, row: self.rows });
        if self.pairs.len() >= self.next_settling {
            self.settle().map_err(DistanceError::of_line)?;
            self.next_settling = FEW.max(2 * self.pairs.len());
        }
        Ok(())
    }

    fn point(&mut self, value: f64) -> Result<u32, DistanceError> {
        if !is_point(value) {
            return Err(DistanceError::NoPoint { value: value.to_string() });
        }
        if value >= self.most as f64 {
            return Err(DistanceError::TooMany { most: self.most });
        }
        self.count = self.count.max(value as usize + 1);
        Ok(value as u32)
    }

    /// Keeps each pair once.
    fn settle(&mut self) -> Result<(), DistanceError> {
        self.pairs.sort_unstable_by_key(|pair| (pair.low, pair.high, pair.row));
        let is_same = |before: &Pair, pair: &Pair| (before.low, before.high) == (pair.low, pair.high);
        for two in self.pairs.windows(2) {
            let (before, Pair { low, high, distance, row }) = (two[0], two[1]);
            if is_same(&before, &two[1]) && before.distance != distance {
                let (value, other) = (distance.to_string(), before.distance.to_string());
                return Err(DistanceError::Contradiction { low, high, row, value, before: before.row, other });
            }
        }
        self.pairs.dedup_by(|pair, before| is_same(before, pair));
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<(Space, String), DistanceError> {
        self.settle()?;
        let joined = self.pairs.into_iter().filter(|pair| pair.distance.is_finite());
        let edges: Vec<_> = joined.map(|Pair { low, high, distance, .. }| (low, high, distance)).collect();
        let taken = format!("{} pairs i j distance, of {} points", edges.len(), self.count);
        Ok((Space::Sparse { count: self.count, edges }, taken))
    }
}

/// Whether a number counts a point.
pub(super) fn is_point(value: f64) -> bool {
    (0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0
}
