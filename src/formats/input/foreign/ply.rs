//! PLY: vertices of polygons and of point clouds, as text or binary in either byte order.
//!
//! In: the columns that were chosen, and the bytes of a file in any pieces.
//! Out: x and y of the vertices, wherever these properties stand.
//! Invariants: memory is bounded by a line or a header, whatever counts the header claims; all elements are walked
//! through, so that what is missing and what stands after the data is found.
//! Must not know: where the bytes come from.
//!
//! The crate `ply-rs-bw` reads all vertices into maps of names at once, and its text has no `nan`, `.5` or `5.`.

use super::error::ForeignError;
use super::parts::found::{Found, Queue, listed, told_of_fields};
use super::parts::number::{LONGEST, Number};
use super::parts::tail::Tail;
use super::parts::text_lines::{TextLine, TextLines};
use crate::formats::input::columns::{FieldPlaces, PointColumns};
use crate::formats::input::excerpt::Excerpt;
use crate::formats::input::record::Point;

const FORMAT: &str = "a PLY file";

/// The most lines of a header.
const HEADER_LINES: u64 = 1 << 16;

/// The most bytes of a line of the header.
const HEADER_LINE: usize = 1 << 16;

/// Reads vertices.
#[derive(Debug)]
pub(super) struct Ply<C> {
    columns: C,
    lines: TextLines,
    /// The longest line of data.
    limit: usize,
    coding: Option<Coding>,
    elements: Vec<Element>,
    stage: Stage,
    pub(super) choice: Option<String>,
    tail: Tail,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Coding {
    Ascii,
    Binary { is_big_endian: bool },
}

#[derive(Debug, PartialEq, Eq)]
enum Stage {
    Header,
    Data,
    /// A list of vertices is impossible, so nothing after it can be found.
    Lost,
}

#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
    /// How many coordinates the vertices have.
    dimension: Option<usize>,
    /// Of each property, which coordinate it is, or the time after them.
    slots: Vec<Vec<usize>>,
    row: Row,
}

#[derive(Debug)]
struct Property {
    name: String,
    number: Number,
    /// The type of the length of a list.
    list: Option<Number>,
}

/// Where in a row the binary data are.
#[derive(Debug, Default)]
struct Row {
    property: usize,
    /// Bytes of a list that are still to come.
    skip: u64,
    bytes: [u8; LONGEST],
    have: usize,
    /// The coordinates so far, then the time.
    values: Vec<f64>,
}

impl<C: PointColumns> Ply<C> {
    pub(super) fn new(columns: C, limit: usize) -> Self {
        let lines = TextLines::new(HEADER_LINE);
        let (stage, tail) = (Stage::Header, Tail::default());
        Self { columns, lines, limit, coding: None, elements: Vec::new(), stage, choice: None, tail }
    }

    pub(super) fn push(&mut self, mut bytes: &[u8], found: &mut Queue<C::Point>) -> Result<(), ForeignError> {
        self.tail.add(bytes.len());
        while self.stage == Stage::Header {
            let line = match self.lines.take(&mut bytes) {
                None => return Ok(()),
                Some(TextLine::TooLong) => return Err(self.unreadable("it is too long")),
                Some(TextLine::Whole(line)) => String::from_utf8_lossy(line).into_owned(),
            };
            self.header_line(&line)?;
        }
        self.lines.skip_rest_of_end(&mut bytes);
        match self.coding {
            _ if self.stage == Stage::Lost => {}
            Some(Coding::Binary { is_big_endian }) => self.binary(&mut bytes, is_big_endian, found),
            _ => self.text(&mut bytes, found),
        }
        self.tail.leave(bytes.len());
        Ok(())
    }

    pub(super) fn finish(&mut self, found: &mut Queue<C::Point>) -> Result<Option<String>, ForeignError> {
        if self.stage == Stage::Header {
            return Err(self.unreadable("the file ends before end_header: copy it again"));
        }
        if self.coding == Some(Coding::Ascii) && self.lines.finish().is_some() {
            let (line, number) = (self.lines.last(), self.lines.number());
            self.text_line(line.as_deref(), number, found);
        }
        if self.stage == Stage::Lost {
            return Ok(None);
        }
        let missing = self.elements.iter().find(|element| element.count > 0 && !element.properties.is_empty());
        let missing = missing.map(|Element { name, count, .. }| {
            let name = Excerpt::of(name.as_bytes());
            format!("the file is cut short, at byte {}: {count} elements {name} are missing", self.tail.all())
        });
        Ok(missing.or_else(|| self.tail.report("elements")))
    }

    fn header_line(&mut self, line: &str) -> Result<(), ForeignError> {
        let mut words = line.split_ascii_whitespace();
        let number = self.lines.number();
        let known = match (words.next(), words.next(), words.next(), words.next(), words.next()) {
            (Some("ply"), None, ..) if number == 1 => true,
            (Some("format"), Some(coding), Some(_), None, _) => {
                self.coding = match coding {
                    "ascii" => Some(Coding::Ascii),
                    "binary_little_endian" => Some(Coding::Binary { is_big_endian: false }),
                    "binary_big_endian" => Some(Coding::Binary { is_big_endian: true }),
                    _ => None,
                };
                self.coding.is_some()
            }
            (Some("comment" | "obj_info"), ..) | (None, ..) => true,
            (Some("element"), Some(name), Some(count), None, _) => self.element(name, count),
            (Some("property"), Some("list"), Some(list), Some(kind), Some(name)) => self.list(list, kind, name),
            (Some("property"), Some(kind), Some(name), None, _) => self.property(kind, None, name),
            (Some("end_header"), None, ..) => return self.begin(),
            _ => false,
        };
        if !known || number > HEADER_LINES {
            let line = Excerpt::of(line.as_bytes());
            return Err(
                self.unreadable(format!("{line} has no place there: write the file again with another program"))
            );
        }
        Ok(())
    }

    fn element(&mut self, name: &str, count: &str) -> bool {
        let Ok(count) = count.parse() else { return false };
        let (name, properties, slots) = (name.to_owned(), Vec::new(), Vec::new());
        self.elements.push(Element { name, count, properties, dimension: None, slots, row: Row::default() });
        true
    }

    fn list(&mut self, list: &str, kind: &str, name: &str) -> bool {
        number(list).is_some_and(|list| self.property(kind, Some(list), name))
    }

    fn property(&mut self, kind: &str, list: Option<Number>, name: &str) -> bool {
        let (Some(element), Some(number)) = (self.elements.last_mut(), number(kind)) else { return false };
        element.properties.push(Property { name: name.to_owned(), number, list });
        true
    }

    fn begin(&mut self) -> Result<(), ForeignError> {
        if self.coding.is_none() {
            return Err(self.unreadable("there is no format before it"));
        }
        let Some(vertex) = self.elements.iter_mut().find(|element| element.name == "vertex") else {
            return Err(ForeignError::Content { format: FORMAT, reason: "it has no element vertex".to_owned() });
        };
        let names = || vertex.properties.iter().map(|property| property.name.as_str());
        let is_number = |place: usize| vertex.properties.get(place).is_some_and(|property| property.list.is_none());
        let is_good = |places: &FieldPlaces| places.all().all(is_number);
        let Some(places) = self.columns.among(names()).filter(is_good) else {
            let names = listed(names());
            let reason = format!("its vertices have {names}, without x and y: choose with --columns");
            return Err(ForeignError::Content { format: FORMAT, reason });
        };
        let told = told_of_fields::<C>(&places, "property", |place| &vertex.properties[place].name);
        self.choice = Some(format!("a PLY file: {told}"));
        vertex.make_points(&places);
        self.stage = Stage::Data;
        self.lines.set_limit(self.limit);
        Ok(())
    }

    fn binary(&mut self, bytes: &mut &[u8], is_big_endian: bool, found: &mut Queue<C::Point>) {
        let elements = self.elements.iter_mut().filter(|element| !element.properties.is_empty());
        for element in elements {
            while element.count > 0 {
                if bytes.is_empty() {
                    return;
                }
                if element.step(bytes, is_big_endian, found).is_err() {
                    let place = self.tail.all() - bytes.len() as u64;
                    let reason =
                        format!("a list has a negative length, before byte {place}: nothing after it was read");
                    found.push_back(Found::Missed(reason));
                    self.stage = Stage::Lost;
                    return;
                }
            }
        }
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
        if line.is_some_and(|line| line.trim_ascii().is_empty()) {
            return;
        }
        let Some(element) = self.elements.iter_mut().find(|element| element.count > 0) else {
            let reason = format!("line {number}: it stands after the elements, and was not read");
            found.push_back(Found::Missed(reason));
            return;
        };
        element.count -= 1;
        let Some(line) = line else {
            found.push_back(Found::Bad(format!("line {number}: longer than {} bytes: split it", self.limit)));
            return;
        };
        match (element.text_row(line), element.dimension) {
            (Ok(()), _) => found.extend(element.found()),
            (Err(reason), Some(_)) => found.push_back(Found::Bad(format!("line {number}: {reason}"))),
            (Err(reason), None) => found.push_back(Found::Missed(format!("line {number}: {reason}"))),
        }
    }

    fn unreadable(&self, reason: impl Into<String>) -> ForeignError {
        let place = format!("line {}", self.lines.number());
        ForeignError::Header { format: FORMAT, place, reason: reason.into() }
    }
}

/// A list cannot be so long.
struct NegativeLength;

impl Element {
    /// Its properties at these places are points.
    fn make_points(&mut self, places: &FieldPlaces) {
        self.dimension = Some(places.coordinates.len());
        self.slots = vec![Vec::new(); self.properties.len()];
        for (slot, place) in places.all().enumerate() {
            self.slots[place].push(slot);
        }
        self.row.values = vec![f64::NAN; places.all().count()];
    }

    /// The point of a row that was read whole, if its element has points.
    fn found<P: Point>(&self) -> Option<Found<P>> {
        let (point, time) = self.row.values.split_at(self.dimension?);
        Some(Found::Point(P::of(point.len(), |axis| point[axis]), time.first().copied()))
    }

    /// Reads on in the present row.
    fn step<P: Point>(
        &mut self,
        bytes: &mut &[u8],
        is_big_endian: bool,
        found: &mut Queue<P>,
    ) -> Result<(), NegativeLength> {
        let row = &mut self.row;
        if row.skip > 0 {
            let length = usize::try_from(row.skip).unwrap_or(usize::MAX).min(bytes.len());
            *bytes = &bytes[length..];
            row.skip -= length as u64;
        } else if let Some(property) = self.properties.get(row.property) {
            let number = property.list.unwrap_or(property.number);
            let (own, rest) = bytes.split_at((number.size() - row.have).min(bytes.len()));
            row.bytes[row.have..row.have + own.len()].copy_from_slice(own);
            row.have += own.len();
            *bytes = rest;
            if row.have < number.size() {
                return Ok(());
            }
            row.have = 0;
            let value = number.read(is_big_endian, &row.bytes);
            if property.list.is_some() {
                // The length may be a float, and no number.
                if value.is_nan() || value < 0.0 {
                    return Err(NegativeLength);
                }
                row.skip = (value as u64).saturating_mul(property.number.size() as u64);
            } else {
                note(&mut row.values, &self.slots, row.property, value);
            }
            row.property += 1;
        }
        if row.skip == 0 && row.property == self.properties.len() {
            row.property = 0;
            self.count -= 1;
            found.extend(self.found());
        }
        Ok(())
    }

    fn text_row(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        for (place, Property { name, list, .. }) in self.properties.iter().enumerate() {
            let name = || Excerpt::of(name.as_bytes());
            let word = words.next().ok_or_else(|| format!("property {} is missing: complete the line", name()))?;
            let value: Result<f64, _> = word.parse();
            let value = value.map_err(|_| {
                format!("property {}: {} is not a number: write one such as 1.5", name(), Excerpt::of(word.as_bytes()))
            })?;
            match list {
                None => note(&mut self.row.values, &self.slots, place, value),
                Some(_) => {
                    let length = value as usize;
                    let skipped = words.by_ref().take(length).count();
                    if skipped < length {
                        return Err(format!("property {} has {skipped} of {length} values: complete the line", name()));
                    }
                }
            }
        }
        let more = words.count();
        if more > 0 {
            return Err(format!("{more} more values than the header says: complete the header, or mend the line"));
        }
        Ok(())
    }
}

/// Keeps a value if it belongs to the point.
fn note(values: &mut [f64], slots: &[Vec<usize>], property: usize, value: f64) {
    for &slot in slots.get(property).into_iter().flatten() {
        values[slot] = value;
    }
}

fn number(name: &str) -> Option<Number> {
    Some(match name {
        "char" | "int8" => Number::I8,
        "uchar" | "uint8" => Number::U8,
        "short" | "int16" => Number::I16,
        "ushort" | "uint16" => Number::U16,
        "int" | "int32" => Number::I32,
        "uint" | "uint32" => Number::U32,
        "float" | "float32" => Number::F32,
        "double" | "float64" => Number::F64,
        _ => return None,
    })
}
