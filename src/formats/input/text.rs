//! The lines of a table: one point per line, in columns.
//!
//! In: the content of one line after the other (UTF-8, not blank, without comment).
//! Out: the point and the event time on it, or what is wrong with it.
//! Invariants: the separator of the first good line holds for all that follow, so that no line is ever read with a
//! guess of its own; only the first line may be a header.
//! Must not know: line ends, line numbers, comments.

use super::columns::{Columns, Places};
use super::error::{BadLineReason, Fault, Field};
use super::excerpt::Excerpt;
use super::record::Parsed;
use super::separator::Separator;

/// What is known of a table.
#[derive(Debug)]
pub(super) struct Table {
    columns: Columns,
    /// Known from the start if the columns are chosen by number, else from the header.
    places: Option<Places>,
    separator: Option<Separator>,
    at_first_line: bool,
}

/// The numbers of one line.
struct Row {
    point: [f64; 2],
    time: Option<f64>,
}

/// A column was chosen by a name that the header does not have.
pub(super) struct UnknownName(pub(super) String);

impl Table {
    pub(super) fn new(columns: Columns) -> Self {
        let places = columns.places();
        Self { columns, places, separator: None, at_first_line: true }
    }

    /// Parses the next line. The point is put into `points`.
    pub(super) fn parse(&mut self, line: &str, points: &mut Vec<[f64; 2]>) -> Result<Parsed, UnknownName> {
        let first = std::mem::take(&mut self.at_first_line);
        let Some(places) = self.places else {
            return self.read_header(line);
        };
        Ok(match self.row(places, line) {
            Ok(row) => {
                points.push(row.point);
                Parsed::Points { time: row.time }
            }
            Err(_) if first && is_header(places, line) => Parsed::Nothing,
            Err(fault) => Parsed::Bad(fault),
        })
    }

    /// Looks for the chosen columns in the header. The separator is the one that shows them all.
    fn read_header(&mut self, line: &str) -> Result<Parsed, UnknownName> {
        let find = |separator| self.columns.find(|name| place_of(name, line, separator));
        let separator = Separator::fitting(line, |separator| find(separator).is_ok());
        let places = find(separator).map_err(|name| UnknownName(name.to_owned()))?;
        self.places = Some(places);
        self.separator = Some(separator);
        Ok(Parsed::Nothing)
    }

    fn row(&mut self, places: Places, line: &str) -> Result<Row, Fault> {
        match self.separator {
            Some(separator) => row(places, line, separator),
            None => self.first_row(places, line),
        }
    }

    /// Reads a line before the separator is known, which it is from then on if the line is good.
    fn first_row(&mut self, places: Places, line: &str) -> Result<Row, Fault> {
        let fits = |separator| row(places, line, separator).is_ok();
        let separator = Separator::fitting(line, fits);
        let row = row(places, line, separator)?;
        self.separator = Some(separator);
        Ok(row)
    }
}

fn place_of(name: &str, header: &str, separator: Separator) -> Option<usize> {
    separator.split(header).position(|field| field == name)
}

/// The fields of a line that were chosen.
#[derive(Default)]
struct Chosen<'a> {
    x: Option<&'a str>,
    y: Option<&'a str>,
    time: Option<&'a str>,
    /// How many fields were looked at: all there are, if a chosen one is missing.
    seen: usize,
}

impl<'a> Chosen<'a> {
    #[inline]
    fn of(places: Places, line: &'a str, separator: Separator) -> Self {
        let last = places.x.max(places.y).max(places.time.unwrap_or(0));
        let mut chosen = Self::default();
        for (place, field) in separator.split(line).enumerate() {
            chosen.seen = place + 1;
            if place == places.x {
                chosen.x = Some(field);
            }
            if place == places.y {
                chosen.y = Some(field);
            }
            if Some(place) == places.time {
                chosen.time = Some(field);
            }
            if place == last {
                break;
            }
        }
        chosen
    }

    fn all(&self) -> impl Iterator<Item = &'a str> {
        [self.x, self.y, self.time].into_iter().flatten()
    }
}

fn row(places: Places, line: &str, separator: Separator) -> Result<Row, Fault> {
    let chosen = Chosen::of(places, line, separator);
    let number = |field: Option<&str>, place: usize| match field.map(str::parse) {
        Some(Ok(number)) => Ok(number),
        _ => Err(fault(field, place, chosen.seen, separator)),
    };
    Ok(Row {
        point: [number(chosen.x, places.x)?, number(chosen.y, places.y)?],
        time: places.time.map(|place| number(chosen.time, place)).transpose()?,
    })
}

/// What is wrong with a chosen field.
#[cold]
fn fault(field: Option<&str>, place: usize, columns: usize, separator: Separator) -> Fault {
    let reason = match field {
        None => BadLineReason::MissingColumn { columns, separator },
        Some("") => BadLineReason::EmptyColumn,
        Some(field) => {
            let found = Excerpt::of(field.as_bytes());
            if has_decimal_comma(field) {
                BadLineReason::DecimalComma { found }
            } else {
                BadLineReason::NotANumber { found }
            }
        }
    };
    Fault::at(Field::Column(place + 1), reason)
}

/// Whether a line that is not a row may be a header: cut as is likeliest it has something in a
/// chosen column, and however it is cut none of the chosen columns is a number.
fn is_header(places: Places, line: &str) -> bool {
    let mut cuts = Separator::candidates(line).map(|separator| Chosen::of(places, line, separator)).peekable();
    let named = |chosen: &Chosen<'_>| chosen.all().any(|field| !field.is_empty());
    cuts.peek().is_some_and(named) && !cuts.any(|chosen| chosen.all().any(looks_numeric))
}

fn looks_numeric(field: &str) -> bool {
    field.parse::<f64>().is_ok() || has_decimal_comma(field)
}

fn has_decimal_comma(field: &str) -> bool {
    field.split_once(',').is_some_and(|(whole, fraction)| {
        // `1,2` is `1.2`; `1,` and `,2` are rather pieces of a line cut at the wrong place.
        [whole, fraction].iter().all(|part| !part.is_empty()) && field.replacen(',', ".", 1).parse::<f64>().is_ok()
    })
}
