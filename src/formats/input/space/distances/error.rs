//! What can be wrong with distances.
//!
//! In: values, rows and columns.
//! Out: messages that say what to do.
//! Must not know: where they were read.

use thiserror::Error;

/// Numbers that are no distances of a finite metric space.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum DistanceError {
    /// Negative, or no number.
    #[error("{value} is no distance: write a number from 0 up, or inf for points that are never joined")]
    NoDistance {
        /// The value.
        value: String,
    },
    /// A point is not where it is.
    #[error("{value}, and a point is at distance 0 from itself: correct the diagonal (row {row}, column {row})")]
    Diagonal {
        /// Counted from 1.
        row: usize,
        /// The value there.
        value: String,
    },
    /// Two points have two distances.
    #[error(
        "row {row} column {column} = {value}, and row {column} column {row} = {other}: make the matrix symmetric to the \
         last bit, as by numpy.maximum(a, a.T)"
    )]
    Asymmetric {
        /// Counted from 1.
        row: usize,
        /// Counted from 1.
        column: usize,
        /// The value there.
        value: String,
        /// The value at the other place.
        other: String,
    },
    /// A row of a wrong length.
    #[error(
        "row {row} has {found} number(s), and in {form} it has {expected}: complete it, or name another form by --distances"
    )]
    Width {
        /// Counted from 1.
        row: usize,
        /// How many numbers it has.
        found: usize,
        /// How many it must have.
        expected: usize,
        /// What is being read.
        form: &'static str,
    },
    /// A matrix that is not square.
    #[error(
        "a matrix of {columns} columns has as many rows, and this has {rows}: if these are points, name their metric"
    )]
    NotSquare {
        /// How many there are, or more.
        rows: usize,
        /// How many there are.
        columns: usize,
    },
    /// Rows that are cut short.
    #[error("the rows of an upper triangle end with 1 number, and the last has {found}: complete it")]
    Unfinished {
        /// The numbers of the last row.
        found: usize,
    },
    /// Not n(n-1)/2.
    #[error("{numbers} numbers are no triangle: n points have n (n - 1) / 2 distances")]
    NoTriangle {
        /// How many there are.
        numbers: usize,
    },
    /// More points than are read.
    #[error("more than {most} points: take a smaller sample")]
    TooMany {
        /// The most of them.
        most: usize,
    },
    /// The rows do not say what they are.
    #[error(
        "rows of {lengths} numbers do not say what they are: name it by --distances full, lower, upper, condensed or \
         sparse; if these are points, name their metric"
    )]
    NoForm {
        /// Of the first rows.
        lengths: String,
    },
    /// A point that cannot be.
    #[error("{value} is no point: count points from 0, in whole numbers")]
    NoPoint {
        /// The value.
        value: String,
    },
    /// A pair of points has two distances.
    #[error("points {low} and {high} are at distance {value} in row {row}, and at {other} in row {before}: keep one")]
    Contradiction {
        /// The points, counted from 0.
        low: u32,
        /// The larger.
        high: u32,
        /// In the later row.
        row: u64,
        /// The distance there.
        value: String,
        /// In the earlier row.
        before: u64,
        /// The distance there.
        other: String,
    },
    /// A pair of one point.
    #[error("point {point} is at distance {value} from itself, which is 0: leave the row out")]
    Apart {
        /// Counted from 0.
        point: u32,
        /// The value.
        value: String,
    },
    /// Something else than numbers.
    #[error("points to take back are no distances: leave the line out")]
    NoDistances,
    /// A binary file is cut short.
    #[error("the file ends within a number, which has {} bytes: copy it again", size_of::<f32>())]
    CutShort,
}
