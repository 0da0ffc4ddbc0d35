//! PCD: point clouds of the Point Cloud Library, as text, binary or compressed.
//!
//! In: the columns that were chosen, and the bytes of a file in any pieces.
//! Out: x and y of the points, wherever these fields stand.
//! Invariants: memory is bounded by a line, a row or the header; of compressed data, by what has arrived, as they come
//! column by column. Bytes after the data are counted and reported.
//! Must not know: where the bytes come from.
//!
//! The crate `pcd-rs` allocates what a header claims, and panics where compressed data do not hold what it says.

use super::error::ForeignError;
use super::parts::found::{Found, Queue, listed, told_of_fields};
use super::parts::lzf::Lzf;
use super::parts::number::Number;
use super::parts::rows::{Cell, Cells, LONGEST_ROW, Rows, Stripe, Stripes};
use super::parts::tail::Tail;
use super::parts::text_lines::{TextLine, TextLines};
use crate::formats::input::columns::{FieldPlaces, PointColumns};
use crate::formats::input::excerpt::Excerpt;
use crate::formats::input::record::Point;

const FORMAT: &str = "a PCD file";

/// The most bytes of a line of the header, and the most lines.
const HEADER_LINE: usize = 1 << 16;
const HEADER_LINES: u64 = 1 << 10;

/// Reads points.
#[derive(Debug)]
pub(super) struct Pcd<C> {
    columns: C,
    lines: TextLines,
    /// The longest line of data.
    limit: usize,
    header: Header,
    data: Data,
    pub(super) choice: Option<String>,
    tail: Tail,
}

/// What the lines of the header say.
#[derive(Debug, Default)]
struct Header {
    names: Vec<String>,
    sizes: Vec<u64>,
    kinds: Vec<String>,
    counts: Vec<u64>,
    width: Option<u64>,
    height: Option<u64>,
    points: Option<u64>,
}

#[derive(Debug)]
enum Data {
    /// Still to come.
    None,
    Text {
        places: FieldPlaces,
        words: u64,
        total: u64,
        left: u64,
    },
    Binary(Rows),
    Compressed(Box<Compressed>),
}

/// Compressed data: their lengths, and then column after column.
#[derive(Debug)]
struct Compressed {
    lengths: Vec<u8>,
    /// Compressed bytes that are still to come, once it is known.
    left: Option<u64>,
    lzf: Lzf,
    stripes: Stripes,
}

/// One field of a point.
#[derive(Clone, Copy, Debug)]
struct Field {
    number: Option<Number>,
    /// In bytes, all its values together.
    size: u64,
    /// In bytes.
    offset: u64,
    /// In words of a line of text.
    word: u64,
}

impl<C: PointColumns> Pcd<C> {
    pub(super) fn new(columns: C, limit: usize) -> Self {
        let (lines, header) = (TextLines::new(HEADER_LINE), Header::default());
        Self { columns, lines, limit, header, data: Data::None, choice: None, tail: Tail::default() }
    }

    pub(super) fn push(&mut self, mut bytes: &[u8], found: &mut Queue<C::Point>) -> Result<(), ForeignError> {
        self.tail.add(bytes.len());
        while matches!(self.data, Data::None) {
            let line = match self.lines.take(&mut bytes) {
                None => return Ok(()),
                Some(TextLine::TooLong) => return Err(self.unreadable("it is too long")),
                Some(TextLine::Whole(line)) => String::from_utf8_lossy(line).into_owned(),
            };
            self.header_line(&line)?;
        }
        self.lines.skip_rest_of_end(&mut bytes);
        match &mut self.data {
            Data::None => {}
            Data::Text { .. } => self.text(&mut bytes, found),
            Data::Binary(rows) => rows.take(&mut bytes, found),
            Data::Compressed(compressed) => compressed.take(&mut bytes, found),
        }
        self.tail.leave(bytes.len());
        Ok(())
    }

    pub(super) fn finish(&mut self, found: &mut Queue<C::Point>) -> Result<Option<String>, ForeignError> {
        if matches!(self.data, Data::Text { .. }) && self.lines.finish().is_some() {
            let (line, number) = (self.lines.last(), self.lines.number());
            self.text_line(line.as_deref(), number, found);
        }
        let missing = match &mut self.data {
            Data::None => return Err(self.unreadable("the file ends before DATA: copy it again")),
            Data::Text { left, total, .. } => (*left > 0).then(|| {
                format!(
                    "the file is cut short: {left} of {total} points are missing, after line {}",
                    self.lines.number()
                )
            }),
            Data::Binary(rows) => rows.missing(),
            Data::Compressed(compressed) => compressed.missing(),
        };
        Ok(missing.or_else(|| self.tail.report("points")))
    }

    fn header_line(&mut self, line: &str) -> Result<(), ForeignError> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        let Some(key) = words.next() else { return self.check_length() };
        let numbers = || words.clone().map(|word| word.parse::<u64>().ok()).collect::<Option<Vec<u64>>>();
        let one = || numbers().and_then(|numbers| numbers.first().copied());
        let header = &mut self.header;
        let is_good = match key.to_ascii_uppercase().as_str() {
            "FIELDS" | "COLUMNS" => {
                header.names = words.clone().map(str::to_owned).collect();
                true
            }
            "TYPE" => {
                header.kinds = words.clone().map(str::to_owned).collect();
                true
            }
            "SIZE" => numbers().map(|sizes| header.sizes = sizes).is_some(),
            "COUNT" => numbers().map(|counts| header.counts = counts).is_some(),
            "WIDTH" => one().map(|width| header.width = Some(width)).is_some(),
            "HEIGHT" => one().map(|height| header.height = Some(height)).is_some(),
            "POINTS" => one().map(|points| header.points = Some(points)).is_some(),
            "DATA" => return self.begin(words.next().unwrap_or_default()),
            // VERSION and VIEWPOINT say nothing about the data.
            _ => true,
        };
        if !is_good {
            let line = Excerpt::of(line.as_bytes());
            return Err(self.unreadable(format!("{line} must have numbers: write the file again with another program")));
        }
        self.check_length()
    }

    fn check_length(&self) -> Result<(), ForeignError> {
        if self.lines.number() > HEADER_LINES {
            return Err(self.unreadable("there is no DATA before it: write the file again with another program"));
        }
        Ok(())
    }

    fn begin(&mut self, coding: &str) -> Result<(), ForeignError> {
        let (fields, total) = self.header.fields().map_err(|reason| self.unreadable(reason))?;
        let places = self.places(&fields)?;
        let cell = |place: usize| {
            let Field { number, offset, .. } = *fields.get(place)?;
            Some(Cell { offset: usize::try_from(offset).ok()?, number: number?, is_big_endian: false })
        };
        let row: Option<u64> = fields.iter().try_fold(0_u64, |sum, field| sum.checked_add(field.size));
        let row = row.filter(|&row| row <= LONGEST_ROW);
        let impossible = || self.unreadable("a point is too long: write the file again with only x and y");
        self.data = match coding.to_ascii_lowercase().as_str() {
            "ascii" => {
                let word = |place: usize| usize::try_from(fields[place].word).ok();
                let places = || {
                    let coordinates = places.coordinates.iter().map(|&place| word(place)).collect::<Option<_>>()?;
                    Some(FieldPlaces {
                        coordinates,
                        time: places.time.map_or(Some(None), |time| word(time).map(Some))?,
                    })
                };
                let words = fields.last().map_or(0, |last| last.word + self.header.count(fields.len() - 1));
                Data::Text { places: places().ok_or_else(impossible)?, words, total, left: total }
            }
            "binary" => {
                let row = row.and_then(|row| usize::try_from(row).ok());
                let (cells, row) = Cells::of(&places, cell).zip(row).ok_or_else(impossible)?;
                Data::Binary(Rows::new(cells, row, total))
            }
            "binary_compressed" => {
                let stripes =
                    Stripes::new(fields.iter().map(stripe).collect(), &places, total).filter(|_| row.is_some());
                let (lengths, lzf) = (Vec::new(), Lzf::new());
                let stripes = stripes.ok_or_else(impossible)?;
                Data::Compressed(Box::new(Compressed { lengths, left: None, lzf, stripes }))
            }
            other => {
                let other = Excerpt::of(other.as_bytes());
                return Err(self.unreadable(format!("its data are {other}: write them as ascii or binary")));
            }
        };
        self.lines.set_limit(self.limit);
        Ok(())
    }

    fn places(&mut self, fields: &[Field]) -> Result<FieldPlaces, ForeignError> {
        let names = || self.header.names.iter().map(String::as_str);
        let is_number = |place: usize| fields.get(place).is_some_and(|field| field.number.is_some());
        let is_good = |places: &FieldPlaces| places.all().all(is_number);
        let Some(places) = self.columns.among(names()).filter(is_good) else {
            let names = listed(names());
            let reason = format!("its fields are {names}, without x and y: choose with --columns");
            return Err(ForeignError::Content { format: FORMAT, reason });
        };
        let told = told_of_fields::<C>(&places, "field", |place| &self.header.names[place]);
        self.choice = Some(format!("a PCD file: {told}"));
        Ok(places)
    }

    fn text(&mut self, bytes: &mut &[u8], found: &mut Queue<C::Point>) {
        while !bytes.is_empty() {
            if self.lines.take(bytes).is_none() {
                return;
            }
            let (line, number) = (self.lines.last(), self.lines.number());
            self.text_line(line.as_deref(), number, found);
        }
    }

    /// A line of text, or one that was too long.
    fn text_line(&mut self, line: Option<&str>, number: u64, found: &mut Queue<C::Point>) {
        let Data::Text { places, words, left, .. } = &mut self.data else { return };
        if line.is_some_and(|line| line.trim_ascii().is_empty()) {
            return;
        }
        if *left == 0 {
            found.push_back(Found::Missed(format!("line {number}: it stands after the points, and was not read")));
            return;
        }
        *left -= 1;
        let point = match line {
            Some(line) => text_point(line, places, *words),
            None => Err(format!("longer than {} bytes: split it", self.limit)),
        };
        found.push_back(point.unwrap_or_else(|reason| Found::Bad(format!("line {number}: {reason}"))));
    }

    fn unreadable(&self, reason: impl Into<String>) -> ForeignError {
        let place = format!("line {}", self.lines.number());
        ForeignError::Header { format: FORMAT, place, reason: reason.into() }
    }
}

impl Header {
    /// All fields, and how many points there are.
    fn fields(&self) -> Result<(Vec<Field>, u64), String> {
        let area = self.width.zip(self.height.or(Some(1))).and_then(|(width, height)| width.checked_mul(height));
        let total = self.points.or(area).ok_or("it does not say how many POINTS there are")?;
        let is_short = |length: usize| length != self.names.len();
        if is_short(self.sizes.len()) || is_short(self.kinds.len()) {
            return Err("FIELDS, SIZE and TYPE must have as many entries as each other".to_owned());
        }
        let (mut offset, mut word) = (0_u64, 0_u64);
        let mut fields = Vec::new();
        for (index, (&size, kind)) in self.sizes.iter().zip(&self.kinds).enumerate() {
            let count = self.count(index);
            let number = kind.chars().next().and_then(|kind| Number::of(kind, size));
            let size = size.checked_mul(count).ok_or("a COUNT is too large")?;
            fields.push(Field { number, size, offset, word });
            offset = offset.checked_add(size).ok_or("a SIZE is too large")?;
            word = word.checked_add(count).ok_or("a COUNT is too large")?;
        }
        Ok((fields, total))
    }

    /// How many values a field has.
    fn count(&self, field: usize) -> u64 {
        self.counts.get(field).copied().unwrap_or(1).max(1)
    }
}

fn stripe(field: &Field) -> Stripe {
    Stripe { size: field.size, number: field.number, is_big_endian: false }
}

fn text_point<P: Point>(line: &str, places: &FieldPlaces, expected: u64) -> Result<Found<P>, String> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    if words.len() as u64 != expected {
        return Err(format!(
            "{} values, and the header has {expected}: complete the header, or mend the line",
            words.len()
        ));
    }
    let number = |place: usize| {
        let word = words[place];
        let found = Excerpt::of(word.as_bytes());
        word.parse::<f64>().map_err(|_| format!("value {}: {found} is not a number: write one such as 1.5", place + 1))
    };
    let coordinates = places.coordinates.iter().map(|&place| number(place)).collect::<Result<Vec<_>, _>>()?;
    Ok(Found::Point(P::of(coordinates.len(), |axis| coordinates[axis]), places.time.map(number).transpose()?))
}

impl Compressed {
    /// The lengths of the compressed data and of the data.
    const LENGTHS: usize = 8;

    fn take<P: Point>(&mut self, bytes: &mut &[u8], found: &mut Queue<P>) {
        let missing = Self::LENGTHS - self.lengths.len();
        let (own, rest) = bytes.split_at(missing.min(bytes.len()));
        self.lengths.extend_from_slice(own);
        *bytes = rest;
        if self.lengths.len() < Self::LENGTHS {
            return;
        }
        let left = self.left.get_or_insert_with(|| Number::U32.read(false, &self.lengths) as u64);
        let (own, rest) = bytes.split_at(usize::try_from(*left).unwrap_or(usize::MAX).min(bytes.len()));
        *left -= own.len() as u64;
        *bytes = rest;
        let was_damaged = self.lzf.is_damaged();
        self.stripes.take(&mut self.lzf.decompress(own), found);
        if self.lzf.is_damaged() && !was_damaged {
            let reason = "the compressed data are damaged: only the points before the damage were read";
            found.push_back(Found::Missed(reason.to_owned()));
        }
    }

    fn missing(&mut self) -> Option<String> {
        let is_short = self.left != Some(0) || !self.lzf.is_whole();
        let cut = is_short.then(|| "the file is cut short, within the compressed data".to_owned());
        self.stripes.missing().or(cut)
    }
}
