//! Distances between points: whole matrices, triangles of them, and lists of pairs.
//!
//! In: a source, its form if that is known, and the most points.
//! Out: a [`Space`] of distances, from 0 to infinity, or what is wrong and where.
//! Invariants: nothing is left out: one bad number ends the reading. Memory grows with the numbers that have come. A
//! matrix is symmetric to the last bit. Rows, columns and lines are counted from 1, points of pairs from 0.
//! Must not know: what is computed of them.
//!
//! Layers: `error`; `full`, `triangle` and `pairs` (one form each); `form` (which it is); `binary`.

mod binary;
mod error;
mod form;
mod full;
mod pairs;
mod triangle;

use std::io::Read;
use std::path::Path;

pub use error::DistanceError;
pub use form::DistanceForm;

use self::form::Builder;
use super::super::error::Field;
use super::super::foreign::Readable;
use super::super::format::{Format, opened};
use super::super::reader::{Limits, Reader};
use super::super::record::Record;
use super::columns::{Most, SpaceColumns};
use super::{MOST_OF_A_MATRIX, Notice, Space, SpaceError};

/// Reads distances of at most so many points, in the given form or in the one that the rows show.
///
/// # Errors
/// [`SpaceError`].
pub fn read_distances(
    path: Option<&Path>,
    source: impl Read,
    form: Option<DistanceForm>,
    most: usize,
    notice: &mut dyn FnMut(Notice),
) -> Result<Space, SpaceError> {
    let most = most.min(MOST_OF_A_MATRIX);
    if form == Some(DistanceForm::Binary) || form.is_none() && binary::is_named(path) {
        return binary::read(path, source, most);
    }
    let (format, source) = opened(path, None, source)?;
    let columns = SpaceColumns::all(Most::Distances(most));
    let mut reader = Reader::new(source, format, columns, Limits::default());
    let is_array = format == Format::Foreign(Readable::Npy);
    let mut builder = Builder::new(form, is_array, most);
    let place = loop {
        let place = format!("{} {}", reader.unit(), reader.next_line());
        let rows = match reader.next_record()? {
            None => break place,
            Some(Record::Points { points, .. }) => points.iter().try_for_each(|row| builder.row(row)),
            Some(Record::Retract { .. }) => Err(DistanceError::NoDistances.of_line()),
            Some(Record::Bad(bad)) => return Err(SpaceError::Line { reason: bad.to_string() }),
            Some(Record::Missed(reason)) => return Err(SpaceError::Line { reason }),
            Some(Record::Commit { .. } | Record::Blank | Record::Nothing) => Ok(()),
        };
        rows.map_err(|fault| fault.at(place, |column| reader.field(column)))?;
    };
    let (space, taken) =
        builder.finish().map_err(|error| SpaceError::Distances { place: format!("before {place}"), error })?;
    notice(Notice::Taken(taken));
    Ok(space)
}

/// What is wrong with a row, and in which column if it is not the row as a whole, counted from 0.
#[derive(Debug, PartialEq)]
struct RowFault {
    column: Option<usize>,
    error: DistanceError,
}

impl RowFault {
    fn at(self, line: String, field: impl Fn(usize) -> Field) -> SpaceError {
        let place = self.column.map_or_else(|| line.clone(), |column| format!("{line}, {}", field(column)));
        SpaceError::Distances { place, error: self.error }
    }
}

impl DistanceError {
    fn of_line(self) -> RowFault {
        RowFault { column: None, error: self }
    }

    fn in_column(self, column: usize) -> RowFault {
        RowFault { column: Some(column), error: self }
    }
}

/// A distance, without negative zero.
fn distance(value: f64) -> Result<f64, DistanceError> {
    if value >= 0.0 { Ok(value + 0.0) } else { Err(DistanceError::NoDistance { value: value.to_string() }) }
}

/// How many distances there are between so many points.
const fn pairs_of(points: usize) -> usize {
    points * points.saturating_sub(1) / 2
}
