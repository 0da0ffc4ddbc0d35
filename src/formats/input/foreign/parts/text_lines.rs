//! Lines within a foreign file: its header, or all of it.
//!
//! In: bytes, in any pieces.
//! Out: one line after the other, without its end (`\n`, `\r\n` or `\r`).
//! Invariants: no byte after the end of a line is touched before the next is asked for, so that binary data may follow.
//! Memory is bounded by the longest line allowed.
//! Must not know: what a line says.

use memchr::memchr2;

/// Gathers the present line.
#[derive(Debug)]
pub struct TextLines {
    line: Vec<u8>,
    limit: usize,
    is_too_long: bool,
    /// The present line was handed out.
    is_given: bool,
    /// The line before ended with `\r`.
    after_return: bool,
    /// Whether `\r` is followed by `\n` in this file, once that is known.
    has_pairs: Option<bool>,
    number: u64,
}

/// A line of a file.
#[derive(Debug, PartialEq, Eq)]
pub enum TextLine<'a> {
    Whole(&'a [u8]),
    /// Longer than allowed.
    TooLong,
}

impl TextLines {
    pub fn new(limit: usize) -> Self {
        let line = Vec::new();
        Self { line, limit, is_too_long: false, is_given: false, after_return: false, has_pairs: None, number: 0 }
    }

    /// From the next line on.
    pub fn set_limit(&mut self, limit: usize) {
        self.limit = limit;
    }

    /// The number of the last line, counted from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Takes the bytes of the present line from the front of `bytes`. The line, if it is whole.
    pub fn take(&mut self, bytes: &mut &[u8]) -> Option<TextLine<'_>> {
        self.begin();
        self.skip_rest_of_end(bytes);
        let end = memchr2(b'\n', b'\r', bytes);
        let (own, rest) = bytes.split_at(end.unwrap_or(bytes.len()));
        self.keep(own);
        *bytes = rest;
        let (&last, rest) = rest.split_first()?;
        *bytes = rest;
        self.after_return = last == b'\r';
        self.skip_rest_of_end(bytes);
        Some(self.give())
    }

    /// The last line, which has no end.
    pub fn finish(&mut self) -> Option<TextLine<'_>> {
        self.begin();
        (!self.line.is_empty() || self.is_too_long).then(|| self.give())
    }

    /// The text of the last line again; none if it was too long.
    pub fn last(&self) -> Option<String> {
        (!self.is_too_long).then(|| String::from_utf8_lossy(&self.line).into_owned())
    }

    fn begin(&mut self) {
        if std::mem::take(&mut self.is_given) {
            self.line.clear();
            self.is_too_long = false;
        }
    }

    fn give(&mut self) -> TextLine<'_> {
        self.number += 1;
        self.is_given = true;
        if self.is_too_long { TextLine::TooLong } else { TextLine::Whole(&self.line) }
    }

    fn keep(&mut self, bytes: &[u8]) {
        if self.line.len() + bytes.len() > self.limit {
            self.is_too_long = true;
            self.line.clear();
        }
        if !self.is_too_long {
            self.line.extend_from_slice(bytes);
        }
    }

    /// Skips the second byte of `\r\n`, which may come later than the first one.
    pub fn skip_rest_of_end(&mut self, bytes: &mut &[u8]) {
        let Some((&first, rest)) = bytes.split_first().filter(|_| self.after_return) else { return };
        self.after_return = false;
        let is_pair = first == b'\n' && self.has_pairs != Some(false);
        self.has_pairs = Some(self.has_pairs.unwrap_or(is_pair));
        if is_pair {
            *bytes = rest;
        }
    }
}
