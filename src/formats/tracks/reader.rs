//! Lines of `serve --track`, one after the other.
//!
//! In: bytes.
//! Out: what each line says, with its number.
//! Invariants: blank lines are skipped; a line that is too long is reported and skipped.
//! Must not know: other lines, what becomes of the frames.

use std::io::{self, Read};

use super::frame::{self, Fault, LineContent};
use crate::formats::input::{Line, Lines};

/// A line of `serve` lists all points of a frame that is new: some millions of them.
const LONGEST_LINE: usize = 256 << 20;

/// A line that was read.
pub struct TrackLine {
    /// From 1.
    pub number: u64,
    /// What it says, or why it cannot be used.
    pub content: Result<LineContent, Fault>,
}

/// Reads lines.
pub struct TrackLines<R> {
    lines: Lines<R>,
}

impl<R: Read> TrackLines<R> {
    /// Nothing is read yet.
    pub fn new(source: R) -> Self {
        Self { lines: Lines::new(source, LONGEST_LINE) }
    }

    /// The next line that is not blank; none at the end.
    ///
    /// # Errors
    /// Those of the source.
    pub fn next(&mut self) -> io::Result<Option<TrackLine>> {
        let content = loop {
            match self.lines.next()? {
                None => return Ok(None),
                Some(Line::Whole(line)) if line.trim_ascii().is_empty() => {}
                Some(Line::Whole(line)) => break frame::read(line),
                Some(Line::TooLong) => break Err(Fault::TooLong { limit: LONGEST_LINE }),
            }
        };
        Ok(Some(TrackLine { number: self.lines.number(), content }))
    }
}
