//! JSON documents that are not one line each: arrays of points, in one line or many, and objects over several lines.
//!
//! In: bytes, in any pieces.
//! Out: the elements of every array, and every object, read as a line of JSON would be.
//! Invariants: memory is bounded by the longest element allowed. A bad element loses only itself. No byte is skipped
//! without a word.
//! Must not know: the forms that an element may have.

use super::parts::found::{Found, Queue, counted};
use crate::formats::input::error::{BadLineReason, Fault};
use crate::formats::input::excerpt::Excerpt;
use crate::formats::input::jsonl::{self, Faults, JsonPoint};
use crate::formats::input::record::Parsed;

/// Finds elements.
#[derive(Debug)]
pub(super) struct Elements {
    place: Place,
    /// The text of the present element.
    text: Vec<u8>,
    is_too_long: bool,
    /// How many bytes an element may have.
    limit: usize,
    wants_times: bool,
    /// Bytes so far.
    bytes: u64,
    /// Bytes outside of all documents that are none.
    strange: u64,
}

/// Where the next byte is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Outside,
    /// After the bracket of an array.
    Begin,
    /// Before an element, after a comma.
    Before,
    /// After an element.
    After,
    Within(Within),
}

/// In an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Within {
    /// How many brackets are open.
    depth: usize,
    is_in_string: bool,
    is_escaped: bool,
    /// In an array, or a document of its own.
    is_listed: bool,
}

impl Elements {
    pub(super) fn new(wants_times: bool, limit: usize) -> Self {
        let (place, text) = (Place::Outside, Vec::new());
        Self { place, text, is_too_long: false, limit, wants_times, bytes: 0, strange: 0 }
    }

    pub(super) fn push<P: JsonPoint>(&mut self, bytes: &[u8], found: &mut Queue<P>) {
        for &byte in bytes {
            self.byte(byte, found);
            self.bytes += 1;
        }
    }

    /// What is missing at the end.
    pub(super) fn finish<P: JsonPoint>(&mut self, found: &mut Queue<P>) -> Option<String> {
        self.report_strange(found);
        match self.place {
            Place::Outside => None,
            Place::Within(_) => Some(format!("the text ends within an element, at byte {}", self.bytes)),
            _ => Some(format!("the text ends at byte {} before the array does", self.bytes)),
        }
    }

    fn byte<P: JsonPoint>(&mut self, byte: u8, found: &mut Queue<P>) {
        if let Place::Within(within) = self.place {
            return self.within(within, byte, found);
        }
        match (self.place, byte) {
            // A record separator may stand before each document.
            (Place::Outside, b'\x1e') => {}
            (_, b' ' | b'\t' | b'\n' | b'\r') => {}
            (Place::Outside, b'[') => {
                self.report_strange(found);
                self.place = Place::Begin;
            }
            (Place::Outside, b'{') => {
                self.report_strange(found);
                self.start(byte, false, found);
            }
            (Place::Outside, _) => self.strange += 1,
            (_, b']') => self.place = Place::Outside,
            (Place::After, b',') => self.place = Place::Before,
            (_, b',') => self.missed("an element is missing before the comma", found),
            // An array of numbers is a point, as it is on a line.
            (Place::Begin, b'0'..=b'9' | b'-' | b'+') => {
                self.start(b'[', false, found);
                self.place = self.opened(1, false);
                self.keep(byte);
            }
            (Place::After, _) => {
                self.missed("a comma is missing between two elements", found);
                self.start(byte, true, found);
            }
            _ => self.start(byte, true, found),
        }
    }

    fn opened(&self, depth: usize, is_listed: bool) -> Place {
        Place::Within(Within { depth, is_in_string: false, is_escaped: false, is_listed })
    }

    fn start<P: JsonPoint>(&mut self, byte: u8, is_listed: bool, found: &mut Queue<P>) {
        self.text.clear();
        self.is_too_long = false;
        let within = Within { depth: 0, is_in_string: false, is_escaped: false, is_listed };
        self.within(within, byte, found);
    }

    fn within<P: JsonPoint>(&mut self, mut within: Within, byte: u8, found: &mut Queue<P>) {
        if within.is_in_string {
            within.is_in_string = byte != b'"' || within.is_escaped;
            within.is_escaped = byte == b'\\' && !within.is_escaped;
        } else {
            match byte {
                b'"' => within.is_in_string = true,
                b'[' | b'{' => within.depth += 1,
                b']' | b'}' if within.depth > 0 => within.depth -= 1,
                _ => {}
            }
            if within.depth == 0 && within.is_listed && matches!(byte, b',' | b']') && !self.has_brackets() {
                // A bare value ends before what separates it.
                self.end(within, found);
                return self.byte(byte, found);
            }
        }
        self.place = Place::Within(within);
        self.keep(byte);
        if within.depth == 0 && !within.is_in_string && self.has_brackets() {
            self.end(within, found);
        }
    }

    /// Whether the element is an array or an object.
    fn has_brackets(&self) -> bool {
        matches!(self.text.first(), Some(b'[' | b'{'))
    }

    fn keep(&mut self, byte: u8) {
        // Of an element that is too long, the first byte still says when it ends.
        self.is_too_long |= self.text.len() >= self.limit.max(1);
        if !self.is_too_long {
            // Places in the element are counted as on one line.
            self.text.push(if matches!(byte, b'\n' | b'\r') { b' ' } else { byte });
        }
    }

    fn end<P: JsonPoint>(&mut self, within: Within, found: &mut Queue<P>) {
        self.place = if within.is_listed { Place::After } else { Place::Outside };
        self.element(found);
    }

    fn element<P: JsonPoint>(&self, found: &mut Queue<P>) {
        if self.is_too_long {
            found.push_back(Found::Bad(format!("longer than {} bytes: split it", self.limit)));
            return;
        }
        let text = self.text.trim_ascii();
        let Ok(text) = std::str::from_utf8(text) else {
            let text = Excerpt::of(text);
            found.push_back(Found::Bad(format!("{text} is not UTF-8 text: convert the input to UTF-8")));
            return;
        };
        let (mut points, mut faults) = (Vec::new(), Faults::default());
        match jsonl::parse(text, self.wants_times, &mut points, &mut faults) {
            Ok(Parsed::Bad(fault)) | Err(fault) => found.push_back(Found::Bad(said(&fault))),
            Ok(parsed) => {
                found.push_back(Found::Entry(parsed, points));
                found.extend(std::iter::from_fn(|| faults.next()).map(|fault| Found::Part(said(&fault))));
            }
        }
    }

    fn missed<P: JsonPoint>(&self, reason: &str, found: &mut Queue<P>) {
        found.push_back(Found::Missed(format!("byte {}: {reason}", self.bytes + 1)));
    }

    fn report_strange<P: JsonPoint>(&mut self, found: &mut Queue<P>) {
        let strange = std::mem::take(&mut self.strange);
        if strange > 0 {
            let bytes = counted(strange, "byte");
            let reason =
                format!("{bytes} before byte {} are no array and no object: they were not read", self.bytes + 1);
            found.push_back(Found::Missed(reason));
        }
    }
}

fn said(fault: &Fault) -> String {
    let reason = match &fault.reason {
        // What a line must have is not what an element is.
        BadLineReason::NotAnEntry { found } => format!("{found} is no point: write [x,y] or {{\"x\":0,\"y\":0}}"),
        other => other.to_string(),
    };
    match fault.field {
        Some(field) => format!("{field}: {reason}"),
        None => reason,
    }
}
