//! The reader: lines of either format, one record at a time.
//!
//! In: a source, its format, the columns of a table and the limits.
//! Out: [`Record`]s, with the number of the line and of the bytes so far.
//! Invariants: what every format shares is decided here and nowhere else: the byte order mark, blank lines,
//! comments, the encoding. The buffer of points is reused from line to line.
//! Must not know: the forms a line may have, or what becomes of a record.

use std::io::Read;

use super::columns::Columns;
use super::decoding::Damage;
use super::error::{BadLine, BadLineReason, Fault, Field, ReadError};
use super::excerpt::Excerpt;
use super::foreign::Foreign;
use super::format::Format;
use super::jsonl::{self, Faults};
use super::lines::{BYTE_ORDER_MARK, Line, Lines};
use super::record::{Parsed, Record};
use super::separator::without_comment;
use super::text::{Choice, Table, TableColumns, UnknownName};

/// What a reader does not exceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// How many bytes a line may have, its `\n` not counted. A longer one is skipped and reported
    /// as a bad line.
    pub line_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { line_bytes: 16 * 1024 * 1024 }
    }
}

/// Reads a point stream line by line.
#[derive(Debug)]
pub struct Reader<R, C: TableColumns = Columns> {
    lines: Lines<R>,
    content: Content<C>,
    /// The points of the present line.
    points: Vec<C::Point>,
    /// The present line, while one before it is reported that only this one has shown to be bad.
    held: Option<Parsed>,
}

/// What the lines hold.
#[derive(Debug)]
enum Content<C: TableColumns> {
    Table(Box<Table<C>>),
    Json { wants_times: bool, faults: Faults },
    Foreign(Box<Foreign<C>>),
}

impl<R: Read, C: TableColumns> Reader<R, C> {
    /// Reads `source` as `format`. Only a table has `columns`; of them JSON lines take
    /// whether event times are wanted.
    pub fn new(source: R, format: Format, columns: C, limits: Limits) -> Self {
        let content = match format {
            Format::Text => Content::Table(Box::new(Table::new(columns))),
            Format::JsonLines => Content::Json { wants_times: columns.wants_times(), faults: Faults::default() },
            Format::Foreign(format) => Content::Foreign(Box::new(Foreign::new(format, columns, limits.line_bytes))),
        };
        Self { lines: Lines::new(source, limits.line_bytes), content, points: Vec::new(), held: None }
    }

    /// The record of the next line; none at the end of the source.
    ///
    /// Returns as soon as a line is complete: the source is read only when no complete line is
    /// left, and then once. The last line needs no line end.
    ///
    /// # Errors
    ///
    /// The source fails, or a chosen column is not in the header of the table. After a failure of
    /// the source nothing is lost, and the reader may be asked again.
    pub fn next_record(&mut self) -> Result<Option<Record<'_, C::Point>>, ReadError> {
        // Nearly all lines are points, and pay nothing for those that are not.
        if self.content.has_fault() {
            let number = self.lines.number();
            return Ok(self.content.take_fault().map(|fault| Record::Bad(fault.on_line(number))));
        }
        let parsed = if self.held.is_some() { self.held.take() } else { self.parse_line()? };
        if parsed.is_none() {
            self.content.finish();
        }
        if self.content.has_rejected() {
            self.held = parsed;
            return Ok(self.content.take_rejected().map(Record::Bad));
        }
        Ok(parsed.map(|parsed| parsed.into_record(self.lines.number(), &self.points)))
    }

    /// Whether what comes next is said of single points of the line, or of the element, of the last record.
    pub fn has_fault(&self) -> bool {
        match &self.content {
            Content::Foreign(foreign) => foreign.has_fault(),
            content => content.has_fault(),
        }
    }

    /// Whether the next record is at hand, so that asking for it would not wait for the source.
    pub fn is_ready(&mut self) -> bool {
        match &self.content {
            Content::Foreign(foreign) => foreign.is_ready(),
            content => self.held.is_some() || content.has_fault() || self.lines.has_line(),
        }
    }

    /// The number of the line of the last record, counted from 1; 0 before the first. After the end
    /// it is the number of lines. Of a foreign file, points or elements are counted instead: see `unit`.
    #[cfg(test)]
    pub fn line(&self) -> u64 {
        match &self.content {
            Content::Foreign(foreign) => foreign.number(),
            Content::Table(_) | Content::Json { .. } => self.lines.number(),
        }
    }

    /// Where a coordinate of the last record stands, counted from 0: in a table, in which column.
    pub fn field(&self, coordinate: usize) -> Field {
        let column = if let Content::Table(table) = &self.content { table.column(coordinate) } else { None };
        column.map_or(Field::Coordinate(coordinate + 1), |column| Field::Column(column + 1))
    }

    /// What [`Reader::line`] counts.
    pub fn unit(&self) -> &'static str {
        match &self.content {
            Content::Foreign(foreign) => foreign.unit(),
            Content::Table(_) | Content::Json { .. } => "line",
        }
    }

    /// The number of the line, or of what `unit` says, that the next record is of, if that is points.
    pub fn next_line(&self) -> u64 {
        match &self.content {
            Content::Foreign(foreign) => foreign.number() + 1,
            Content::Table(_) | Content::Json { .. } => self.lines.number() + u64::from(self.held.is_none()),
        }
    }

    /// How many bytes of the source have been used, up to the end of that line.
    pub fn bytes_read(&self) -> u64 {
        self.lines.consumed()
    }

    /// What the header has chosen, or that a comment may be a row, for people; once, after it is known.
    pub fn take_choice(&mut self) -> Option<Choice> {
        match &mut self.content {
            Content::Table(table) => table.take_choice(),
            Content::Foreign(foreign) => foreign.take_choice(),
            Content::Json { .. } => None,
        }
    }

    fn parse_line(&mut self) -> Result<Option<Parsed>, ReadError> {
        self.points.clear();
        if let Content::Foreign(foreign) = &mut self.content {
            return Ok(foreign.next(&mut self.lines, &mut self.points)?);
        }
        let number = self.lines.number() + 1;
        let line = match self.lines.next() {
            Ok(Some(Line::Whole(line))) => line,
            Ok(Some(Line::TooLong)) => return Ok(Some(self.too_long())),
            Ok(None) => return Ok(None),
            Err(source) => {
                return match Damage::of(&source) {
                    Some(damage) => Ok(Some(Parsed::Missed(self.cut_short(damage)))),
                    None => Err(ReadError::Io { line: number, source }),
                };
            }
        };
        let line = if number == 1 { without_mark(line) } else { line };
        self.content
            .parse(line, number, &mut self.points)
            .map(Some)
            .map_err(|UnknownName(name)| unknown_column(number, name, line))
    }

    /// What is missing after the last whole line.
    fn cut_short(&mut self, damage: &Damage) -> String {
        let line = self.lines.number();
        match self.lines.drop_unfinished() {
            0 => format!("after line {line}: {damage}"),
            bytes => format!("after line {line}, of the next line only {bytes} byte(s) came: {damage}"),
        }
    }

    fn too_long(&self) -> Parsed {
        Parsed::Bad(Fault::of_line(BadLineReason::TooLong { limit: self.lines.limit() }))
    }
}

impl<C: TableColumns> Content<C> {
    /// The source has ended.
    fn finish(&mut self) {
        if let Self::Table(table) = self {
            table.finish();
        }
    }

    fn has_rejected(&self) -> bool {
        matches!(self, Self::Table(table) if table.has_rejected())
    }

    /// A line that was taken for a header, and is none.
    fn take_rejected(&mut self) -> Option<BadLine> {
        let Self::Table(table) = self else { return None };
        table.take_rejected()
    }

    /// What is wrong with a single point of the last line.
    fn take_fault(&mut self) -> Option<Fault> {
        let Self::Json { faults, .. } = self else { return None };
        faults.next()
    }

    fn has_fault(&self) -> bool {
        matches!(self, Self::Json { faults, .. } if !faults.is_empty())
    }

    /// Only the end of the line is trimmed, so that places in it remain what they are.
    fn parse(&mut self, line: &[u8], number: u64, points: &mut Vec<C::Point>) -> Result<Parsed, UnknownName> {
        let line = line.trim_ascii_end();
        match (line.trim_ascii_start().first(), self) {
            (None, _) => Ok(Parsed::Blank),
            (Some(b'#'), Self::Table(table)) => Ok(match row_with_a_mark(line).filter(|line| table.is_row(line)) {
                Some(line) => table.parse(line, number, points)?,
                None => {
                    // A comment that is no text names nothing.
                    let _ = text(line).map(|line| table.parse_comment(line, number));
                    Parsed::Nothing
                }
            }),
            (Some(_), Self::Table(table)) => match text(without_comment(line)) {
                Ok(line) => table.parse(line, number, points),
                Err(fault) => Ok(Parsed::Bad(fault)),
            },
            (Some(b'#'), Self::Json { .. }) => Ok(Parsed::Nothing),
            (Some(_), Self::Json { wants_times, faults }) => {
                let parsed = text(line).and_then(|line| jsonl::parse(line, *wants_times, points, faults));
                Ok(parsed.unwrap_or_else(|fault| {
                    faults.clear();
                    Parsed::Bad(fault)
                }))
            }
            // It is not read by lines.
            (Some(_), Self::Foreign(_)) => Ok(Parsed::Nothing),
        }
    }
}

/// A line whose first value begins with the mark of a comment, as in `#17,1,2`, without the comment at its end.
fn row_with_a_mark(line: &[u8]) -> Option<&str> {
    let line = line.trim_ascii_start();
    let rest = line.get(1..).filter(|rest| rest.first().is_some_and(|byte| !byte.is_ascii_whitespace()))?;
    text(&line[..1 + without_comment(rest).len()]).ok()
}

fn without_mark(line: &[u8]) -> &[u8] {
    line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line)
}

fn text(line: &[u8]) -> Result<&str, Fault> {
    std::str::from_utf8(line).map_err(|error| Fault::at(Field::Byte(error.valid_up_to() + 1), BadLineReason::NotUtf8))
}

fn unknown_column(line: u64, name: String, header: &[u8]) -> ReadError {
    let header = Excerpt::of(header.trim_ascii());
    ReadError::UnknownColumn { line, name, header }
}
