//! The lines of a table: one point per line, in columns.
//!
//! In: the content of one line after the other (UTF-8, not blank, without comment).
//! Out: the point and the event time on it, or what is wrong with it.
//! Invariants: the separator of the first good line of several fields holds for all that follow, so that no line is
//! ever read with a guess of its own. Every line is a point, or a header, or unusable. A header stands before all
//! points. It names x and y, or has no number in a chosen column and as many columns as the row after it, so that the
//! next line decides.
//! Must not know: line ends, comments.

use super::columns::{Columns, Places, PointColumns};
use super::error::{BadLine, BadLineReason, Fault, Field};
use super::excerpt::Excerpt;
use super::numbers;
use super::record::Parsed;
use super::separator::{Fields, Separator};

/// How the lines of a table become points.
pub trait TableColumns: PointColumns {
    /// The fields of a line that are read.
    fn fields<'a>(places: &Self::Places, line: &'a str, separator: Separator) -> impl Iterator<Item = &'a str>;

    /// The numbers of a line.
    ///
    /// # Errors
    /// Which field is missing or is no number.
    fn row<'a>(places: &Self::Places, line: &'a str, separator: Separator) -> Result<Row<'a, Self::Point>, Fault>;

    /// The column of a coordinate, both counted from 0.
    fn column(places: &Self::Places, coordinate: usize) -> usize;

    /// What a header has chosen, for people.
    fn choice(places: &Self::Places, separator: Separator, header: &str) -> Choice;
}

/// What is known of a table.
#[derive(Debug)]
pub(super) struct Table<C: TableColumns> {
    columns: C,
    /// Known from the start if the columns are chosen by number, else from the header.
    places: Option<C::Places>,
    separator: Option<Separator>,
    stage: Stage<C::Places>,
    /// Columns of the header, if there is one.
    width: Option<usize>,
    /// A line that was taken for a header, and is none.
    rejected: Option<BadLine>,
    /// What was chosen, for people, until somebody asks.
    choice: Option<Choice>,
    has_told_of_row: bool,
}

/// What was chosen without being asked for, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// In words.
    pub text: String,
    /// The names of the columns of x and y, if names were the reason.
    pub names: Vec<String>,
}

#[derive(Debug)]
enum Stage<S> {
    /// No point, and nothing that may be a header.
    First,
    /// The line before may be a header.
    Header(Candidate<S>),
    /// There was a header, or a point.
    Rows,
}

/// A line that may be a header.
#[derive(Debug)]
struct Candidate<S> {
    text: String,
    line: u64,
    /// What is wrong with it otherwise; nothing if it is a comment otherwise.
    fault: Option<Fault>,
    /// The columns that it names, and how it is cut for that.
    named: Option<(S, Separator)>,
}

/// The numbers of one line.
pub struct Row<'a, P> {
    pub(super) point: P,
    pub(super) time: Option<f64>,
    /// The fields up to the last that was chosen.
    pub(super) seen: usize,
    /// Those after it.
    pub(super) rest: Fields<'a>,
}

/// A column was chosen by a name that the header does not have.
pub(super) struct UnknownName(pub(super) String);

impl<C: TableColumns> Table<C> {
    pub(super) fn new(columns: C) -> Self {
        let places = columns.places();
        Self {
            columns,
            places,
            separator: None,
            stage: Stage::First,
            width: None,
            rejected: None,
            choice: None,
            has_told_of_row: false,
        }
    }

    /// Parses the next line. The point is put into `points`.
    pub(super) fn parse(&mut self, line: &str, number: u64, points: &mut Vec<C::Point>) -> Result<Parsed, UnknownName> {
        if self.places.is_none() {
            return self.read_header(line);
        }
        if let Stage::Header(_) = self.stage {
            self.decide(line);
        }
        let Some(places) = &self.places else { return Ok(Parsed::Nothing) };
        let read = read_row::<C>(places, &mut self.separator, self.width, line);
        Ok(match (read, &self.stage) {
            (Ok(row), _) => {
                self.stage = Stage::Rows;
                points.push(row.point);
                Parsed::Points { time: row.time }
            }
            (Err(fault), Stage::First) => self.first_fault(line, number, fault),
            (Err(fault), _) => Parsed::Bad(fault),
        })
    }

    /// A comment may name the columns, if it stands before all points.
    pub(super) fn parse_comment(&mut self, comment: &str, number: u64) {
        let text = comment.trim_start_matches('#');
        self.tell_of_row(text, number);
        if !matches!(self.stage, Stage::First | Stage::Header(Candidate { fault: None, .. })) {
            return;
        }
        if let Some(named) = self.named_in(text) {
            let (text, named) = (text.to_owned(), Some(named));
            self.stage = Stage::Header(Candidate { text, line: number, fault: None, named });
        }
    }

    /// Whether a line that begins like a comment is a row: its mark is part of a value, and each chosen column has a
    /// number.
    pub(super) fn is_row(&self, line: &str) -> bool {
        let fits = |places, separator| C::row(places, line, separator).is_ok();
        // The header that stands before it may have chosen others.
        let named = if let Stage::Header(Candidate { named, .. }) = &self.stage { named.as_ref() } else { None };
        match (named, &self.places, self.separator) {
            (Some((places, separator)), ..) => fits(places, *separator),
            (None, Some(places), Some(separator)) => fits(places, separator),
            (None, Some(places), None) => Separator::candidates(line).any(|separator| fits(places, separator)),
            (None, None, _) => false,
        }
    }

    /// The first comment that would be a row without its mark is told, as somebody may have meant it for one.
    fn tell_of_row(&mut self, text: &str, number: u64) {
        let Some(places) = self.places.as_ref().filter(|_| !self.has_told_of_row) else { return };
        if Separator::candidates(text).any(|separator| C::row(places, text, separator).is_ok()) {
            self.has_told_of_row = true;
            let shown = Excerpt::of(format!("#{text}").as_bytes());
            let text = format!(
                "line {number}: {shown} is taken for a comment: if it is a row, choose columns that are numbers"
            );
            self.choice = Some(Choice { text, names: Vec::new() });
        }
    }

    /// The input has ended: what was taken for a header has no rows.
    pub(super) fn finish(&mut self) {
        if let Stage::Header(candidate) = std::mem::replace(&mut self.stage, Stage::Rows) {
            let is_named = candidate.named.is_some();
            self.rejected = candidate.fault.map(|fault| {
                let fault = if is_named { Fault::of_line(BadLineReason::NoRows) } else { fault };
                fault.on_line(candidate.line)
            });
        }
    }

    /// The column of a coordinate, both counted from 0, once it is known.
    pub(super) fn column(&self, coordinate: usize) -> Option<usize> {
        Some(C::column(self.places.as_ref()?, coordinate))
    }

    pub(super) fn has_rejected(&self) -> bool {
        self.rejected.is_some()
    }

    /// A line before the last one, which was taken for a header and is none.
    pub(super) fn take_rejected(&mut self) -> Option<BadLine> {
        self.rejected.take()
    }

    /// What was chosen by the header, or left out as a comment, once.
    pub(super) fn take_choice(&mut self) -> Option<Choice> {
        self.choice.take()
    }

    /// A line that is no row, before all rows: a header, if the next line says so.
    fn first_fault(&mut self, line: &str, number: u64, fault: Fault) -> Parsed {
        let named = self.named_in(line);
        let may_be_header = || self.places.as_ref().is_some_and(|places| is_header::<C>(places, line));
        if named.is_none() && !may_be_header() {
            return Parsed::Bad(fault);
        }
        self.stage = Stage::Header(Candidate { text: line.to_owned(), line: number, fault: Some(fault), named });
        Parsed::Nothing
    }

    /// Decides by the line after it whether a line is the header.
    fn decide(&mut self, next: &str) {
        let Stage::Header(candidate) = std::mem::replace(&mut self.stage, Stage::First) else { return };
        let Some(places) = &self.places else { return };
        let fits = |separator| C::row(places, next, separator).is_ok();
        let separator = match candidate.named {
            Some((_, separator)) => separator,
            None => self.separator.unwrap_or_else(|| Separator::fitting(next, fits)),
        };
        let is_as_wide = || are_as_wide(separator, &candidate.text, next);
        let is_header = match (&candidate.named, &candidate.fault) {
            // What names x and y is a header, and rows of another width are not what it says.
            (Some(_), Some(_)) => true,
            (Some(_), None) => is_as_wide(),
            (None, _) => fits(separator) && is_as_wide(),
        };
        if !is_header {
            self.rejected = candidate.fault.map(|fault| fault.on_line(candidate.line));
            return;
        }
        if let Some((places, separator)) = candidate.named {
            self.choice = Some(C::choice(&places, separator, &candidate.text));
            (self.places, self.separator) = (Some(places), Some(separator));
        }
        (self.stage, self.width) = (Stage::Rows, Some(separator.split(&candidate.text).count()));
    }

    /// The columns that a header names, if nobody has chosen others.
    fn named_in(&self, header: &str) -> Option<(C::Places, Separator)> {
        let cuts = Separator::candidates(header);
        cuts.filter_map(|cut| Some((self.columns.named_in(cut.split(header))?, cut))).next()
    }

    /// Looks for the chosen columns in the header. The separator is the one that shows them all.
    fn read_header(&mut self, line: &str) -> Result<Parsed, UnknownName> {
        let find = |separator| self.columns.find(|name| place_of(name, line, separator));
        let separator = Separator::fitting(line, |separator| find(separator).is_ok());
        let places = find(separator).map_err(|name| UnknownName(name.to_owned()))?;
        (self.places, self.separator) = (Some(places), Some(separator));
        (self.stage, self.width) = (Stage::Rows, Some(separator.split(line).count()));
        Ok(Parsed::Nothing)
    }
}

/// Reads a line, and checks it against the header.
#[inline]
fn read_row<'a, C: TableColumns>(
    places: &C::Places,
    separator: &mut Option<Separator>,
    header: Option<usize>,
    line: &'a str,
) -> Result<Row<'a, C::Point>, Fault> {
    let row = match *separator {
        Some(separator) => C::row(places, line, separator),
        None => first_row::<C>(places, separator, line),
    }?;
    match header {
        Some(width) => check_width(row, width),
        None => Ok(row),
    }
}

/// Reads a line before the separator is known, which it is from then on if the line is good and has several fields.
#[cold]
fn first_row<'a, C: TableColumns>(
    places: &C::Places,
    separator: &mut Option<Separator>,
    line: &'a str,
) -> Result<Row<'a, C::Point>, Fault> {
    let fitting = Separator::fitting(line, |separator| C::row(places, line, separator).is_ok());
    let row = C::row(places, line, fitting)?;
    // A line of one field says nothing of what would stand between two.
    if fitting.split(line).nth(1).is_some() {
        *separator = Some(fitting);
    }
    Ok(row)
}

/// A row with more columns than its header is not what the header says. Empty ones at its end say nothing.
fn check_width<P>(row: Row<'_, P>, header: usize) -> Result<Row<'_, P>, Fault> {
    let beyond = row.rest.clone().skip(header.saturating_sub(row.seen));
    if row.seen <= header && beyond.clone().all(str::is_empty) {
        return Ok(row);
    }
    let columns = row.seen + row.rest.count();
    Err(Fault::of_line(BadLineReason::TooManyColumns { columns, header }))
}

/// Whether two lines have as many columns. Empty ones at the end count if both lines have them.
fn are_as_wide(separator: Separator, header: &str, next: &str) -> bool {
    let count = |line| separator.split(line).count();
    let last = |line| separator.split(line).zip(1..).filter(|(field, _)| !field.is_empty()).map(|(_, at)| at).last();
    count(header) == count(next) || last(header) == last(next)
}

fn place_of(name: &str, header: &str, separator: Separator) -> Option<usize> {
    separator.split(header).position(|field| field == name)
}

/// The fields of a line that were chosen.
struct Chosen<'a> {
    x: Option<&'a str>,
    y: Option<&'a str>,
    time: Option<&'a str>,
    /// How many fields were looked at: all there are, if a chosen one is missing.
    seen: usize,
    /// The other fields.
    rest: Fields<'a>,
}

impl<'a> Chosen<'a> {
    #[inline]
    fn of(places: Places, line: &'a str, separator: Separator) -> Self {
        let last = places.x.max(places.y).max(places.time.unwrap_or(0));
        let mut rest = separator.split(line);
        let (mut x, mut y, mut time, mut seen) = (None, None, None, 0);
        for field in rest.by_ref() {
            let place = seen;
            seen += 1;
            if place == places.x {
                x = Some(field);
            }
            if place == places.y {
                y = Some(field);
            }
            if Some(place) == places.time {
                time = Some(field);
            }
            if place == last {
                break;
            }
        }
        Self { x, y, time, seen, rest }
    }

    fn all(self) -> impl Iterator<Item = &'a str> {
        [self.x, self.y, self.time].into_iter().flatten()
    }
}

impl TableColumns for Columns {
    fn fields<'a>(places: &Places, line: &'a str, separator: Separator) -> impl Iterator<Item = &'a str> {
        Chosen::of(*places, line, separator).all()
    }

    #[inline]
    fn row<'a>(places: &Places, line: &'a str, separator: Separator) -> Result<Row<'a, [f64; 2]>, Fault> {
        let chosen = Chosen::of(*places, line, separator);
        let missing = || BadLineReason::MissingColumn { columns: chosen.seen, separator };
        let coordinate = |field, place| value_at(place, field, separator, numbers::number, missing);
        let point = [coordinate(chosen.x, places.x)?, coordinate(chosen.y, places.y)?];
        let time = |place| value_at(place, chosen.time, separator, numbers::time, missing);
        let time = places.time.map(time).transpose()?;
        Ok(Row { point, time, seen: chosen.seen, rest: chosen.rest })
    }

    fn column(places: &Places, coordinate: usize) -> usize {
        if coordinate == 0 { places.x } else { places.y }
    }

    fn choice(places: &Places, separator: Separator, header: &str) -> Choice {
        let name = |place| separator.split(header).nth(place).unwrap_or_default();
        let shown = |place| Excerpt::of(name(place).as_bytes());
        let time = places.time.map(|place| format!(", t is column {} {}", place + 1, shown(place))).unwrap_or_default();
        let told =
            Self::told([places.x, places.y].map(|place| format!("column {} {}", place + 1, shown(place))).into_iter());
        let text = format!("the header names columns: {told}{time}");
        Choice { text, names: [places.x, places.y].map(|place| name(place).to_owned()).to_vec() }
    }
}

/// The value of a field, or what is wrong with it and at which place.
#[inline]
pub(super) fn value_at(
    place: usize,
    field: Option<&str>,
    separator: Separator,
    value: impl Fn(&str, Separator) -> Result<f64, BadLineReason>,
    missing: impl Fn() -> BadLineReason,
) -> Result<f64, Fault> {
    let field = field.ok_or_else(&missing);
    field.and_then(|field| value(field, separator)).map_err(|reason| Fault::at(Field::Column(place + 1), reason))
}

/// Whether a line that is not a row may be a header: cut as is likeliest it has something in a
/// chosen column, and however it is cut none of the chosen columns is a number. No name opens a bracket.
fn is_header<C: TableColumns>(places: &C::Places, line: &str) -> bool {
    let fields = |separator| C::fields(places, line, separator);
    let mut cuts = Separator::candidates(line).peekable();
    let named = |&separator: &Separator| {
        fields(separator).any(|field| !field.is_empty())
            && !fields(separator).any(|field| field.starts_with(['{', '[']))
    };
    cuts.peek().is_some_and(named) && !cuts.any(|separator| fields(separator).any(numbers::looks_numeric))
}
