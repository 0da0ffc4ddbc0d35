//! NPY: arrays of numpy.
//!
//! In: the columns that were chosen, and the bytes of a file in any pieces.
//! Out: points: the rows of an array of two dimensions, or the records of a structured one.
//! Invariants: nothing is allocated for what the header claims; bytes after the array are counted and reported.
//! Must not know: where the bytes come from.
//!
//! The header is a Python literal of a dictionary. It becomes JSON by a change of brackets and quotes, and `serde_json`
//! reads it. The crates for NPY (`npyz`, `ndarray-npy`) read Python literals by a parser that needs a C compiler, and
//! leave the order of columns to the caller.

use std::ops::Range;

use serde::Deserialize;
use serde_json::Value;

use super::error::ForeignError;
use super::parts::found::{Queue, counted, listed, printable, told_of_fields};
use super::parts::number::Number;
use super::parts::rows::{Cell, Cells, LONGEST_ROW, Rows, Stripe, Stripes};
use super::parts::tail::Tail;
use crate::formats::input::columns::{FieldPlaces, PointColumns};

const FORMAT: &str = "an NPY array";

/// The magic bytes, and the version.
const START: usize = 8;

/// The longest header, in bytes.
const LONGEST_HEADER: usize = 1 << 20;

/// The most columns of an array that is read column by column.
const MOST_STRIPES: usize = 1 << 16;

/// Reads an array.
#[derive(Debug)]
pub(super) struct Npy<C> {
    columns: C,
    stage: Stage,
    pub(super) choice: Option<String>,
    tail: Tail,
}

#[derive(Debug)]
enum Stage {
    /// The bytes so far.
    Header(Vec<u8>),
    Rows(Rows),
    Stripes(Stripes),
}

/// The header, as JSON.
#[derive(Debug, Deserialize)]
struct Header {
    descr: Value,
    fortran_order: bool,
    shape: Vec<u64>,
}

impl<C: PointColumns> Npy<C> {
    pub(super) fn new(columns: C) -> Self {
        Self { columns, stage: Stage::Header(Vec::new()), choice: None, tail: Tail::default() }
    }

    pub(super) fn push(&mut self, mut bytes: &[u8], found: &mut Queue<C::Point>) -> Result<(), ForeignError> {
        self.tail.add(bytes.len());
        if let Stage::Header(header) = &mut self.stage {
            let Some(text) = take_header(header, &mut bytes)? else { return Ok(()) };
            self.stage = self.begin(&text)?;
        }
        match &mut self.stage {
            Stage::Header(_) => {}
            Stage::Rows(rows) => rows.take(&mut bytes, found),
            Stage::Stripes(stripes) => stripes.take(&mut bytes, found),
        }
        self.tail.leave(bytes.len());
        Ok(())
    }

    pub(super) fn finish(&mut self) -> Result<Option<String>, ForeignError> {
        let missing = match &mut self.stage {
            Stage::Header(header) => return Err(unreadable(header.len(), "the file ends there: copy it again")),
            Stage::Rows(rows) => rows.missing(),
            Stage::Stripes(stripes) => stripes.missing(),
        };
        Ok(missing.or_else(|| self.tail.report("array")))
    }

    fn begin(&mut self, text: &str) -> Result<Stage, ForeignError> {
        let header: Header = serde_json::from_str(&as_json(text))
            .map_err(|error| unreadable(START, format!("{error}: save the array again with numpy.save")))?;
        match &header.descr {
            Value::String(descr) => self.begin_table(descr, &header),
            Value::Array(fields) => self.begin_records(fields, &header),
            _ => Err(content("its type is unknown: save it with numpy.save(FILE, a.astype(float))")),
        }
    }

    fn begin_table(&mut self, descr: &str, header: &Header) -> Result<Stage, ForeignError> {
        let shape = shape(&header.shape);
        let places = self.columns.in_array(&header.shape);
        let places = places.map_err(|reason| content(format!("its shape is {shape}, and {reason}")))?;
        let (rows, columns) = (header.shape.first().copied().unwrap_or(0), header.shape.get(1).copied().unwrap_or(1));
        let cell = cell(descr, 0).ok_or_else(|| unsupported(descr))?;
        let size = cell.number.size();
        let last = places.all().max().unwrap_or(0);
        if last as u64 >= columns {
            return Err(content(format!("its shape is {shape}, and there is no column {}: choose others", last + 1)));
        }
        let rest = if columns > places.coordinates.len() as u64 { "; the others are not read" } else { "" };
        let told = C::told(places.coordinates.iter().map(|place| format!("column {}", place + 1)));
        self.choice = Some(format!("an NPY array of shape {shape}: {told}{rest}"));
        if header.fortran_order {
            return stripes(cell, &places, columns, rows);
        }
        let row = row_length(columns.checked_mul(size as u64))?;
        let at = |place: usize| Cell { offset: place * size, ..cell };
        let cells = Cells::of(&places, |place| Some(at(place)));
        Ok(Stage::Rows(Rows::new(cells.unwrap_or_default(), row, rows)))
    }

    /// The records of a structured array are points whatever its shape.
    fn begin_records(&mut self, fields: &[Value], header: &Header) -> Result<Stage, ForeignError> {
        let mut named = Vec::new();
        let mut offset = 0;
        for field in fields {
            let (name, size, cell) = field_of(field, offset).ok_or_else(|| unsupported(&field.to_string()))?;
            offset = row_length(offset.checked_add(size).map(|offset| offset as u64))?;
            named.push((name, cell));
        }
        let names = || named.iter().map(|(name, _)| *name);
        let none = || content(format!("its fields are {}, without x and y: choose with --columns", listed(names())));
        let places = self.columns.among(names()).ok_or_else(none)?;
        let cells = Cells::of(&places, |place| named.get(place)?.1).ok_or_else(none)?;
        self.choice = Some(format!("an NPY array: {}", told_of_fields::<C>(&places, "field", |place| named[place].0)));
        let total = header.shape.iter().try_fold(1_u64, |product, &length| product.checked_mul(length));
        let total = total.ok_or_else(|| content(format!("its shape {} is impossible", shape(&header.shape))))?;
        Ok(Stage::Rows(Rows::new(cells, offset, total)))
    }
}

/// Takes bytes of the header. Its text, once it is whole.
fn take_header(header: &mut Vec<u8>, bytes: &mut &[u8]) -> Result<Option<String>, ForeignError> {
    loop {
        let extent = extent(header);
        let needed = extent.as_ref().map_or(header.len() + 1, |extent| extent.end);
        if needed > LONGEST_HEADER {
            return Err(unreadable(START, "it is too long: save the array again with numpy.save"));
        }
        if let Some(extent) = extent.filter(|_| header.len() == needed) {
            return Ok(Some(String::from_utf8_lossy(&header[extent]).into_owned()));
        }
        let (own, rest) = bytes.split_at((needed - header.len()).min(bytes.len()));
        header.extend_from_slice(own);
        *bytes = rest;
        if header.len() < needed {
            return Ok(None);
        }
    }
}

/// Where the text of the header is, once its length is known.
fn extent(header: &[u8]) -> Option<Range<usize>> {
    let width = if *header.get(6)? == 1 { 2 } else { 4 };
    let begin = START + width;
    let mut raw = [0; 4];
    raw[..width].copy_from_slice(header.get(START..begin)?);
    Some(begin..begin + u32::from_le_bytes(raw) as usize)
}

/// A Python literal of dictionaries, lists, tuples, strings, numbers and truth values as JSON.
fn as_json(python: &str) -> String {
    let mut json = String::with_capacity(python.len());
    let mut rest = python.chars().peekable();
    while let Some(next) = rest.next() {
        match next {
            '\'' | '"' => {
                let mut text = String::new();
                while let Some(inner) = rest.next().filter(|&inner| inner != next) {
                    text.extend(if inner == '\\' { rest.next() } else { Some(inner) });
                }
                json.push_str(&Value::String(text).to_string());
            }
            '(' => json.push('['),
            ')' | ']' | '}' => {
                // Python allows a comma after the last element.
                json.truncate(json.trim_end().trim_end_matches(',').len());
                json.push(if next == '}' { '}' } else { ']' });
            }
            'A'..='Z' | 'a'..='z' => {
                let mut word = String::from(next);
                while let Some(letter) = rest.next_if(char::is_ascii_alphanumeric) {
                    word.push(letter);
                }
                json.push_str(match word.as_str() {
                    "True" => "true",
                    "False" => "false",
                    // Python 2 marks long integers with it.
                    "L" => "",
                    other => other,
                });
            }
            other => json.push(other),
        }
    }
    json
}

/// The cell of a type such as `<f8`.
fn cell(descr: &str, offset: usize) -> Option<Cell> {
    let (order, rest) = descr.split_at_checked(1)?;
    let (kind, size) = rest.split_at_checked(1)?;
    let number = Number::of(kind.chars().next()?, size.parse().ok()?)?;
    let is_big_endian = match order {
        "<" | "|" => false,
        ">" => true,
        "=" => cfg!(target_endian = "big"),
        _ => return None,
    };
    Some(Cell { offset, number, is_big_endian })
}

/// A field of a record: its name, how many bytes it has, and its cell if it is a number.
fn field_of(field: &Value, offset: usize) -> Option<(&str, usize, Option<Cell>)> {
    let parts = field.as_array()?;
    let name = parts.first()?;
    // A field may have a title beside its name.
    let name = name.as_str().or_else(|| name.get(1)?.as_str())?;
    let size = size_of_type(parts.get(1)?)?;
    let count = parts.get(2).map_or(Some(1), |shape| {
        let lengths = shape.as_array().map_or(std::slice::from_ref(shape), Vec::as_slice);
        lengths.iter().try_fold(1_usize, |product, length| product.checked_mul(usize::try_from(length.as_u64()?).ok()?))
    })?;
    let cell = parts.get(1)?.as_str().and_then(|descr| cell(descr, offset)).filter(|_| count == 1);
    Some((name, size.checked_mul(count)?, cell))
}

/// How many bytes a type has, if that is fixed.
fn size_of_type(descr: &Value) -> Option<usize> {
    match descr {
        Value::String(descr) => {
            let digits = descr.get(2..)?;
            let digits = digits.split('[').next()?;
            let size: usize = digits.parse().ok()?;
            match descr.as_bytes()[1] {
                b'O' => None,
                b'U' => size.checked_mul(4),
                _ => Some(size),
            }
        }
        Value::Array(fields) => fields.iter().try_fold(0_usize, |sum, field| sum.checked_add(field_of(field, 0)?.1)),
        _ => None,
    }
}

fn stripes(cell: Cell, places: &FieldPlaces, columns: u64, rows: u64) -> Result<Stage, ForeignError> {
    let large = || content("it is too large to be read column by column: save numpy.ascontiguousarray(a)");
    let columns = usize::try_from(columns).ok().filter(|&columns| columns <= MOST_STRIPES).ok_or_else(large)?;
    let stripe =
        Stripe { size: cell.number.size() as u64, number: Some(cell.number), is_big_endian: cell.is_big_endian };
    Stripes::new(vec![stripe; columns], places, rows).map(Stage::Stripes).ok_or_else(large)
}

fn row_length(length: Option<u64>) -> Result<usize, ForeignError> {
    let fits = length.filter(|&length| length <= LONGEST_ROW).and_then(|length| usize::try_from(length).ok());
    fits.ok_or_else(|| content(format!("a row has more than {}: save only x and y", counted(LONGEST_ROW, "byte"))))
}

fn shape(lengths: &[u64]) -> String {
    let lengths: Vec<String> = lengths.iter().take(8).map(u64::to_string).collect();
    format!("({})", lengths.join(", "))
}

fn unsupported(descr: &str) -> ForeignError {
    let descr: String = descr.chars().take(60).collect();
    content(format!("its type {descr} is no number of 1 to 8 bytes: save a.astype(float)"))
}

fn content(reason: impl Into<String>) -> ForeignError {
    ForeignError::Content { format: FORMAT, reason: printable(&reason.into()) }
}

fn unreadable(byte: usize, reason: impl Into<String>) -> ForeignError {
    ForeignError::Header { format: FORMAT, place: format!("byte {byte}"), reason: printable(&reason.into()) }
}
