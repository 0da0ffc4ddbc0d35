//! How distances are written: named, or found by the lengths of the first rows.
//!
//! In: rows.
//! Out: a space, and in words what the rows were taken for.
//! Invariants: at most four rows are held until the form is known. Where rows may be two things, neither is taken.
//! Must not know: lines.
//!
//! Rows of equal lengths are a full matrix, but four or more of i, j and a distance are pairs. Rows of 1, 2, 3, ...
//! numbers are a lower triangle; rows of which each has one less than the row before, an upper one. An array of one
//! dimension is condensed.

use super::super::Space;
use super::full::Full;
use super::pairs::{Pairs, is_point};
use super::triangle::{Order, Rows, Triangle};
use super::{DistanceError, RowFault};

/// How distances are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DistanceForm {
    /// All rows and columns.
    Full,
    /// Below the diagonal, in rows or one number after the other: Ripser's lower-distance.
    Lower,
    /// Above the diagonal: Ripser's upper-distance.
    Upper,
    /// Above the diagonal, row by row in one list: what scipy's pdist returns.
    Condensed,
    /// Rows of i, j and distance, points counted from 0: Ripser's sparse.
    Sparse,
    /// Below the diagonal, as little-endian floats of four bytes: Ripser's binary.
    Binary,
}

/// Rows that become a space.
#[derive(Debug)]
pub(super) struct Builder {
    shape: Shape,
    most: usize,
}

#[derive(Debug)]
enum Shape {
    /// The rows so far.
    Open {
        rows: Vec<Vec<f64>>,
        is_array: bool,
    },
    Full(Full),
    Triangle(Triangle),
    Pairs(Pairs),
}

/// What the first rows say.
enum Guess {
    More,
    Form(DistanceForm),
    None,
}

impl Builder {
    /// Rows of this form, or of one that they show themselves; an array has rows that are known to be whole.
    pub(super) fn new(form: Option<DistanceForm>, is_array: bool, most: usize) -> Self {
        let shape = match form {
            Some(form) => Shape::of(form, Rows::Loose, most),
            None => Shape::Open { rows: Vec::new(), is_array },
        };
        Self { shape, most }
    }

    pub(super) fn row(&mut self, row: &[f64]) -> Result<(), RowFault> {
        let Shape::Open { rows, is_array } = &mut self.shape else { return self.shape.row(row) };
        rows.push(row.to_vec());
        let form = match guess(rows, *is_array) {
            Guess::More => return Ok(()),
            Guess::Form(form) => form,
            Guess::None => return Err(no_form(rows).of_line()),
        };
        let rows = std::mem::take(rows);
        self.shape = Shape::of(form, Rows::Strict, self.most);
        rows.iter().try_for_each(|row| self.shape.row(row))
    }

    /// The space, and what it was taken for.
    pub(super) fn finish(self) -> Result<(Space, String), DistanceError> {
        match self.shape {
            Shape::Open { rows, .. } => self::finish(&rows, self.most),
            Shape::Full(full) => full.finish(),
            Shape::Triangle(triangle) => triangle.finish(),
            Shape::Pairs(pairs) => pairs.finish(),
        }
    }
}

impl Shape {
    fn of(form: DistanceForm, rows: Rows, most: usize) -> Self {
        let triangle = |order, rows| Self::Triangle(Triangle::new(order, rows, most));
        match form {
            DistanceForm::Full => Self::Full(Full::new(most)),
            DistanceForm::Lower => triangle(Order::Lower, rows),
            DistanceForm::Upper => triangle(Order::Upper, rows),
            DistanceForm::Condensed => triangle(Order::Upper, Rows::Pieces),
            DistanceForm::Binary => triangle(Order::Lower, Rows::Pieces),
            DistanceForm::Sparse => Self::Pairs(Pairs::new(most)),
        }
    }

    fn row(&mut self, row: &[f64]) -> Result<(), RowFault> {
        match self {
            Self::Full(full) => full.row(row),
            Self::Triangle(triangle) => triangle.row(row),
            Self::Pairs(pairs) => pairs.row(row),
            Self::Open { .. } => Ok(()),
        }
    }
}

/// What the rows so far are, if they say it.
fn guess(rows: &[Vec<f64>], is_array: bool) -> Guess {
    let Some([first, second]) = rows.first_chunk() else { return Guess::More };
    match (first.len(), second.len()) {
        (1, 1) if is_array => Guess::Form(DistanceForm::Condensed),
        (1, 1) => Guess::None,
        (3, 3) => three_columns(rows),
        (width, next) if width == next => Guess::Form(DistanceForm::Full),
        (1, 2) => Guess::Form(DistanceForm::Lower),
        (width, next) if width == next + 1 => Guess::Form(DistanceForm::Upper),
        _ => Guess::None,
    }
}

/// Three rows of three numbers are a matrix, and more are pairs.
fn three_columns(rows: &[Vec<f64>]) -> Guess {
    let is_pair = |row: &Vec<f64>| matches!(row[..], [i, j, _] if is_point(i) && is_point(j));
    match rows.len() {
        0..=3 if rows.iter().all(|row| row.len() == 3) => Guess::More,
        4 if rows.iter().all(is_pair) => Guess::Form(DistanceForm::Sparse),
        _ => Guess::None,
    }
}

/// All rows have come.
fn finish(rows: &[Vec<f64>], most: usize) -> Result<(Space, String), DistanceError> {
    let form = match rows {
        [] => DistanceForm::Full,
        // One number is of two points, but 0 is of one.
        [only] if only[..] == [0.0] => DistanceForm::Full,
        [only] if only.len() == 1 => DistanceForm::Lower,
        [_, _, _] => DistanceForm::Full,
        _ => return Err(no_form(rows)),
    };
    let mut shape = Shape::of(form, Rows::Strict, most);
    rows.iter().try_for_each(|row| shape.row(row)).map_err(|fault| fault.error)?;
    Builder { shape, most }.finish()
}

fn no_form(rows: &[Vec<f64>]) -> DistanceError {
    let lengths: Vec<String> = rows.iter().map(|row| row.len().to_string()).collect();
    DistanceError::NoForm { lengths: lengths.join(", ") }
}
