//! GeoJSON: the positions of all geometries, whatever they are.
//!
//! In: the bytes of one document or of one after the other, in any pieces.
//! Out: longitudes and latitudes as points. Of a closed ring, the last position is the first one, and does not come
//! again.
//! Invariants: memory is bounded by one value and the depth of the nesting. A position that cannot be used loses only
//! itself.
//! Must not know: what properties mean.
//!
//! `json-event-parser` reads JSON piece by piece. The crate `geojson` needs a whole feature at a time, and one bad
//! position loses it.

use json_event_parser::{JsonEvent, LowLevelJsonParser, LowLevelJsonParserResult};

use super::parts::found::{Found, Queue, printable};
use super::parts::literals::{Literals, is_replaced};
use crate::formats::input::excerpt::Excerpt;
use crate::formats::input::record::Point;

/// The deepest nesting.
const DEEPEST: usize = 1 << 10;

/// Reads positions.
pub(super) struct GeoJson {
    parser: LowLevelJsonParser,
    literals: Literals,
    /// Bytes that were not parsed yet.
    pending: Vec<u8>,
    /// How many of them are ready to be.
    settled: usize,
    /// How many bytes were parsed.
    parsed: u64,
    /// The longest single value.
    limit: usize,
    walk: Walk,
    is_lost: bool,
}

impl std::fmt::Debug for GeoJson {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("GeoJson").field("walk", &self.walk).finish_non_exhaustive()
    }
}

impl GeoJson {
    pub(super) fn new(limit: usize) -> Self {
        Self {
            parser: parser(),
            literals: Literals::default(),
            pending: Vec::new(),
            settled: 0,
            parsed: 0,
            limit,
            walk: Walk::default(),
            is_lost: false,
        }
    }

    pub(super) fn push<P: Point>(&mut self, bytes: &[u8], found: &mut Queue<P>) {
        if self.is_lost {
            return;
        }
        self.pending.extend_from_slice(bytes);
        self.settled = self.literals.replace(&mut self.pending, self.settled);
        self.parse(false, found);
        if self.pending.len() > self.limit {
            self.lose(&format!("a value has more than {} bytes", self.limit), found);
        }
    }

    pub(super) fn finish<P: Point>(&mut self, found: &mut Queue<P>) {
        if !self.is_lost {
            self.settled = self.pending.len();
            self.parse(true, found);
        }
    }

    /// What the numbers are, as far as the document says.
    pub(super) fn choice(&self) -> String {
        match &self.walk.system {
            Some(name) => format!("GeoJSON: x and y are in the coordinate system {name}"),
            None => "GeoJSON: x is longitude, y is latitude, in degrees".to_owned(),
        }
    }

    /// Whether they are longitudes and latitudes.
    pub(super) fn is_degrees(&self) -> bool {
        self.walk.system.is_none()
    }

    fn parse<P: Point>(&mut self, is_ending: bool, found: &mut Queue<P>) {
        let mut at = 0;
        loop {
            if !self.walk.is_inside() {
                // Documents may follow each other, on lines or after a record separator.
                let blanks = self.pending[at..self.settled].iter().take_while(|byte| is_between(**byte)).count();
                at += blanks;
                if at == self.settled {
                    break;
                }
                self.parser = parser();
            }
            let LowLevelJsonParserResult { consumed_bytes, event } =
                self.parser.parse_next(&self.pending[at..self.settled], is_ending);
            let outcome = match event {
                None => {
                    at += consumed_bytes;
                    break;
                }
                Some(Ok(event)) => self.walk.take(&event, found),
                Some(Err(error)) => Err(error.message().to_owned()),
            };
            at += consumed_bytes;
            if let Err(reason) = outcome {
                self.parsed += at as u64;
                self.lose(&reason, found);
                return;
            }
        }
        self.parsed += at as u64;
        self.pending.drain(..at);
        self.settled -= at;
    }

    fn lose<P: Point>(&mut self, reason: &str, found: &mut Queue<P>) {
        self.is_lost = true;
        self.pending = Vec::new();
        let reason = printable(reason);
        found.push_back(Found::Missed(format!("byte {}: {reason}: nothing after it was read", self.parsed)));
    }
}

fn parser() -> LowLevelJsonParser {
    LowLevelJsonParser::new().with_max_stack_size(DEEPEST)
}

fn is_between(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == b'\x1e'
}

/// Where in the document the parser is.
#[derive(Debug, Default)]
struct Walk {
    levels: Vec<Level>,
    /// How deep in a value that says nothing of positions.
    skipped: usize,
    key: Key,
    /// The coordinate system that the document names, if it is not of degrees.
    system: Option<Excerpt>,
}

/// An object or array that positions are in.
#[derive(Debug)]
enum Level {
    /// A collection, a feature or a geometry.
    Object,
    /// Features or geometries.
    Members,
    Coordinates(Coordinates),
}

/// The last key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Key {
    /// The document itself.
    #[default]
    Document,
    Members,
    Geometry,
    Coordinates,
    System,
    Other,
}

/// An array of coordinates or of such arrays.
#[derive(Debug, Default)]
struct Coordinates {
    point: [f64; 2],
    /// How many elements are no arrays.
    length: usize,
    /// What is wrong with one of them.
    fault: Option<String>,
    has_arrays: bool,
    /// Of a ring, its first position, and the last one that was not handed on yet.
    first: Option<[f64; 2]>,
    held: Option<[f64; 2]>,
}

impl Walk {
    fn is_inside(&self) -> bool {
        self.skipped > 0 || !self.levels.is_empty()
    }

    fn take<P: Point>(&mut self, event: &JsonEvent<'_>, found: &mut Queue<P>) -> Result<(), String> {
        match event {
            JsonEvent::StartObject => self.open_object(),
            JsonEvent::StartArray => self.open_array(),
            JsonEvent::EndObject | JsonEvent::EndArray => self.close(found),
            JsonEvent::ObjectKey(name) if self.skipped == 0 => {
                self.key = match &**name {
                    "features" | "geometries" => Key::Members,
                    "geometry" => Key::Geometry,
                    "coordinates" => Key::Coordinates,
                    "crs" => Key::System,
                    _ => Key::Other,
                };
            }
            JsonEvent::ObjectKey(_) => {}
            JsonEvent::String(text) if self.skipped > 0 => self.note_system(text),
            JsonEvent::String(text) if is_replaced(text) => self.scalar(Err("NaN or Infinity".to_owned()), found)?,
            JsonEvent::String(text) => self.scalar(Err(Excerpt::of(text.as_bytes()).to_string()), found)?,
            JsonEvent::Number(text) => self.scalar(text.parse().map_err(|_| text.to_string()), found)?,
            JsonEvent::Boolean(value) => self.scalar(Err(value.to_string()), found)?,
            JsonEvent::Null => self.scalar(Err("null".to_owned()), found)?,
            JsonEvent::Eof => {}
        }
        Ok(())
    }

    fn open_object(&mut self) {
        let is_known = match self.levels.last_mut() {
            None => true,
            Some(Level::Object) => self.key == Key::Geometry,
            Some(Level::Members) => true,
            Some(Level::Coordinates(coordinates)) => {
                coordinates.note(Err("an object".to_owned()));
                false
            }
        };
        if self.skipped > 0 || !is_known {
            self.skipped += 1;
        } else {
            self.levels.push(Level::Object);
            self.key = Key::Other;
        }
    }

    fn open_array(&mut self) {
        let level = match (self.levels.last_mut(), self.key) {
            _ if self.skipped > 0 => None,
            // A list of features without a collection around it.
            (None, _) | (Some(Level::Object), Key::Members) => Some(Level::Members),
            (Some(Level::Object), Key::Coordinates) => Some(Level::Coordinates(Coordinates::default())),
            (Some(Level::Coordinates(outer)), _) => {
                outer.has_arrays = true;
                Some(Level::Coordinates(Coordinates::default()))
            }
            _ => None,
        };
        match level {
            Some(level) => self.levels.push(level),
            None => self.skipped += 1,
        }
    }

    fn close<P: Point>(&mut self, found: &mut Queue<P>) {
        if self.skipped > 0 {
            self.skipped -= 1;
        } else if let Some(Level::Coordinates(inner)) = self.levels.pop() {
            let is_in_ring = matches!(&self.levels[..], [.., Level::Coordinates(_), Level::Coordinates(_)]);
            let outer = self.levels.last_mut();
            let ring = match outer {
                Some(Level::Coordinates(outer)) if is_in_ring => Some(outer),
                _ => None,
            };
            inner.end(ring, found);
        }
        if self.skipped == 0 && matches!(self.levels.last(), Some(Level::Object)) {
            self.key = Key::Other;
        }
    }

    /// A number, or what stands in its place.
    fn scalar<P: Point>(&mut self, value: Result<f64, String>, found: &mut Queue<P>) -> Result<(), String> {
        if self.skipped > 0 {
            return Ok(());
        }
        match self.levels.last_mut() {
            Some(Level::Coordinates(coordinates)) => coordinates.note(value),
            Some(Level::Object) if matches!(self.key, Key::Geometry | Key::Coordinates | Key::Members) => {
                let found_value = value.map_or_else(|text| text, |number| number.to_string());
                found.push_back(Found::Bad(format!("{found_value} stands where a geometry should be: give it one")));
            }
            Some(Level::Object) => {}
            Some(Level::Members) => {
                let found_value = value.map_or_else(|text| text, |number| number.to_string());
                found.push_back(Found::Bad(format!("{found_value} is no feature and no geometry: leave it out")));
            }
            None => return Err("this is no GeoJSON object: write one".to_owned()),
        }
        Ok(())
    }

    /// A document of before 2016 may name a coordinate system.
    fn note_system(&mut self, text: &str) {
        let is_name = self.key == Key::System && (text.contains("EPSG") || text.contains("CRS"));
        let is_degrees = text.ends_with("CRS84") || text.ends_with(":4326");
        if is_name && !is_degrees {
            self.system = Some(Excerpt::of(text.as_bytes()));
        }
    }
}

impl Coordinates {
    fn note(&mut self, value: Result<f64, String>) {
        match value {
            Ok(number) if self.length < 2 => self.point[self.length] = number,
            Ok(_) => {}
            // What stands behind x and y is not read.
            Err(_) if self.length >= 2 => {}
            Err(text) => {
                let coordinate = ["x", "y"][self.length];
                let fault = format!("{coordinate}: {text} is not a number: write one such as 1.5");
                self.fault.get_or_insert(fault);
            }
        }
        self.length += 1;
    }

    /// The array has ended, in a ring or not.
    fn end<P: Point>(mut self, ring: Option<&mut Self>, found: &mut Queue<P>) {
        if let Some(fault) = self.fault.take() {
            found.push_back(Found::Bad(fault));
        } else if self.length > 0 && (self.length == 1 || self.has_arrays) {
            found.push_back(Found::Bad("a position is [longitude, latitude]: write both numbers".to_owned()));
        } else if self.length > 0 {
            match ring {
                Some(ring) => ring.position(self.point, found),
                None => found.push_back(Found::position(self.point)),
            }
        } else if let Some(last) = self.held.filter(|last| self.first != Some(*last)) {
            found.push_back(Found::position(last));
        }
    }

    /// The next position of a ring or a line. The last one may be the first again.
    fn position<P: Point>(&mut self, point: [f64; 2], found: &mut Queue<P>) {
        match self.first {
            None => {
                self.first = Some(point);
                found.push_back(Found::position(point));
            }
            Some(_) => found.extend(self.held.replace(point).map(Found::position)),
        }
    }
}
