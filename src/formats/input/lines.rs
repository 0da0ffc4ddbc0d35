//! From bytes to lines.
//!
//! In: any [`Read`].
//! Out: one line at a time, without its line end (`\n`, `\r\n` or `\r`), as a slice of the one buffer here.
//! Invariants: a line is handed out as soon as its `\n` or `\r` has arrived, with no further read; a byte is searched
//! for line ends once and moved a bounded number of times, however the source cuts its reads; the buffer never exceeds
//! the longest line allowed and one [`CHUNK`].
//! Must not know: what a line says.

use std::io::{self, Read};
use std::ops::Range;

use memchr::memchr2;

/// What may stand before the first line of a UTF-8 text.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// How many bytes are asked for at first.
const CHUNK: usize = 64 * 1024;

/// One line.
#[derive(Debug, PartialEq, Eq)]
pub enum Line<'a> {
    /// All of it, without the line end.
    Whole(&'a [u8]),
    /// It was longer than allowed and has been skipped.
    TooLong,
}

/// The lines of a source.
///
/// `buffer[start..filled]` has been read and not handed out; in `buffer[start..searched]` there is
/// no line end.
#[derive(Debug)]
pub struct Lines<R> {
    source: R,
    buffer: Vec<u8>,
    start: usize,
    searched: usize,
    filled: usize,
    /// How many bytes a line may have.
    limit: usize,
    /// Whether the beginning of the present line has been dropped as too long.
    skipping: bool,
    ended: bool,
    /// The line before has ended with `\r`, so that a `\n` that comes next belongs to its end.
    after_return: bool,
    number: u64,
    consumed: u64,
}

impl<R: Read> Lines<R> {
    /// Lines of at most so many bytes.
    pub fn new(source: R, limit: usize) -> Self {
        Self {
            source,
            buffer: vec![0; CHUNK],
            start: 0,
            searched: 0,
            filled: 0,
            limit,
            skipping: false,
            ended: false,
            after_return: false,
            number: 0,
            consumed: 0,
        }
    }

    /// The next line; none at the end of the source. After an error it may be called again.
    ///
    /// # Errors
    /// The source fails.
    pub fn next(&mut self) -> io::Result<Option<Line<'_>>> {
        let whole = loop {
            if let Some(end) = self.line_end() {
                break self.take(end, end + 1);
            }
            self.drop_if_too_long();
            if self.ended {
                if !self.unfinished() {
                    return Ok(None);
                }
                break self.take(self.filled, self.filled);
            }
            self.fill()?;
        };
        Ok(Some(whole.map_or(Line::TooLong, |range| Line::Whole(&self.buffer[range]))))
    }

    /// Whether a whole line has arrived that was not handed out yet.
    pub(super) fn has_line(&mut self) -> bool {
        // The end that is found here is not searched for again.
        self.line_end().is_some()
    }

    /// What has been read and not handed out, or what comes next, instead of a line; empty at the end of the source.
    pub(super) fn take_bytes(&mut self) -> io::Result<&[u8]> {
        if self.start == self.filled && !self.ended {
            self.fill()?;
        }
        let bytes = self.start..self.filled;
        self.consumed += bytes.len() as u64;
        (self.start, self.searched) = (self.filled, self.filled);
        Ok(&self.buffer[bytes])
    }

    /// Drops a line that has no end, after the source has failed for good. How many bytes it had.
    pub(super) fn drop_unfinished(&mut self) -> usize {
        let dropped = self.filled - self.start;
        (self.start, self.searched, self.skipping, self.ended) = (self.filled, self.filled, false, true);
        dropped
    }

    /// How many bytes a line may have.
    pub fn limit(&self) -> usize {
        self.limit
    }

    /// The number of the line handed out last, counted from 1; 0 before the first.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// How many bytes the lines handed out so far have taken, line ends included. The second byte of `\r\n` counts with
    /// the next line, as it may come later.
    pub(super) fn consumed(&self) -> u64 {
        self.consumed
    }

    /// Where the present line ends, if that has arrived.
    fn line_end(&mut self) -> Option<usize> {
        self.skip_rest_of_end();
        let found = memchr2(b'\n', b'\r', &self.buffer[self.searched..self.filled]);
        let end = found.map(|offset| self.searched + offset);
        self.searched = end.unwrap_or(self.filled);
        end
    }

    /// Skips the second byte of `\r\n`, which may come later than the first one.
    fn skip_rest_of_end(&mut self) {
        if !self.after_return || self.start == self.filled {
            return;
        }
        self.after_return = false;
        if self.buffer[self.start] == b'\n' {
            self.start += 1;
            self.searched = self.searched.max(self.start);
            self.consumed += 1;
        }
    }

    /// Takes the present line, up to `end`, and goes to the next, at `next`. None if it was longer
    /// than allowed.
    fn take(&mut self, end: usize, next: usize) -> Option<Range<usize>> {
        let whole = self.start..end;
        self.after_return = self.buffer[..self.filled].get(end) == Some(&b'\r');
        let too_long = std::mem::take(&mut self.skipping) || whole.len() > self.limit;
        self.consumed += (next - self.start) as u64;
        self.number += 1;
        self.start = next;
        self.searched = next;
        (!too_long).then_some(whole)
    }

    /// Whether there is a last line that no line end closes.
    fn unfinished(&self) -> bool {
        self.skipping || self.start < self.filled
    }

    fn drop_if_too_long(&mut self) {
        let pending = self.filled - self.start;
        if self.skipping || pending > self.limit {
            self.skipping = true;
            self.consumed += pending as u64;
            self.start = self.filled;
        }
    }

    /// Reads once, and takes what comes: to wait for more would hold back a line of a live stream.
    fn fill(&mut self) -> io::Result<()> {
        self.make_room();
        let room = &mut self.buffer[self.filled..];
        let count = loop {
            match self.source.read(room) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                outcome => break outcome?,
            }
        };
        // A source that claims more than it was given room for must not lead to a panic.
        self.filled += count.min(room.len());
        self.ended = count == 0;
        Ok(())
    }

    /// Makes room behind the present line: by moving it to the front if there is anything before
    /// it, and only then by growing. Doubling keeps the number of moves of a byte bounded.
    fn make_room(&mut self) {
        if self.start == self.filled {
            self.move_to_front();
        } else if self.filled == self.buffer.len() {
            if self.start > 0 {
                self.move_to_front();
            } else {
                let most = self.limit.saturating_add(CHUNK);
                let length = (2 * self.filled).min(most);
                self.buffer.reserve_exact(length - self.filled);
                self.buffer.resize(length, 0);
            }
        }
    }

    fn move_to_front(&mut self) {
        self.buffer.copy_within(self.start..self.filled, 0);
        self.filled -= self.start;
        self.start = 0;
        self.searched = self.filled;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;

    /// A source that plays a script: pieces and failures, one for each read.
    struct Script(VecDeque<Result<&'static str, io::ErrorKind>>);

    fn script(steps: &[Result<&'static str, io::ErrorKind>]) -> Script {
        Script(steps.iter().copied().collect())
    }

    impl Read for Script {
        fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
            let piece = self.0.pop_front().expect("one read too many")?;
            room[..piece.len()].copy_from_slice(piece.as_bytes());
            Ok(piece.len())
        }
    }

    fn all(source: impl Read, limit: usize) -> Vec<Option<String>> {
        let mut lines = Lines::new(source, limit);
        let mut found = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            found.push(match line {
                Line::Whole(line) => Some(String::from_utf8_lossy(line).into_owned()),
                Line::TooLong => None,
            });
        }
        found
    }

    fn whole(text: &str) -> Option<String> {
        Some(text.to_owned())
    }

    #[test]
    fn line_ends_are_cut_off() {
        let cases: [(&str, &[&str]); 10] = [
            ("", &[]),
            ("\n", &[""]),
            ("a", &["a"]),
            ("a\nb\n", &["a", "b"]),
            ("a\r\nb\r\n\r\n", &["a", "b", ""]),
            ("a\rb\n", &["a", "b"]),
            ("a\rb\r\rc", &["a", "b", "", "c"]),
            ("a\r\n\rb", &["a", "", "b"]),
            ("a\n\nb", &["a", "", "b"]),
            ("a\r", &["a"]),
        ];
        for (text, lines) in cases {
            let lines: Vec<_> = lines.iter().map(|line| whole(line)).collect();
            assert_eq!(all(text.as_bytes(), 100), lines, "{text:?}");
        }
    }

    #[test]
    fn a_line_is_handed_out_before_the_next_read() {
        let mut lines = Lines::new(script(&[Ok("a\nb\nc"), Ok("d\n")]), 100);
        for expected in [&b"a"[..], b"b", b"cd"] {
            assert_eq!(lines.next().unwrap(), Some(Line::Whole(expected)));
        }
        assert_eq!((lines.number(), lines.consumed()), (3, 7));
    }

    #[test]
    fn both_bytes_of_a_line_end_may_come_apart() {
        let mut lines = Lines::new(script(&[Ok("a\r"), Ok("\nb\r"), Ok("\n"), Ok("")]), 100);
        for (expected, consumed) in [(&b"a"[..], 2), (b"b", 5)] {
            assert_eq!(lines.next().unwrap(), Some(Line::Whole(expected)));
            assert_eq!(lines.consumed(), consumed);
            assert!(!lines.has_line());
        }
        assert_eq!(lines.next().unwrap(), None);
        assert_eq!((lines.number(), lines.consumed()), (2, 6));
    }

    #[test]
    fn after_the_end_the_source_is_left_alone() {
        let mut lines = Lines::new(script(&[Ok("a"), Ok("")]), 100);
        assert_eq!(lines.next().unwrap(), Some(Line::Whole(b"a")));
        assert_eq!(lines.next().unwrap(), None);
        assert_eq!(lines.next().unwrap(), None);
    }

    #[test]
    fn interruptions_are_not_errors() {
        let steps = [Ok("a"), Err(io::ErrorKind::Interrupted), Ok("b\n"), Err(io::ErrorKind::Interrupted), Ok("")];
        assert_eq!(all(script(&steps), 100), [whole("ab")]);
    }

    #[test]
    fn an_error_loses_nothing() {
        let mut lines = Lines::new(script(&[Ok("a"), Err(io::ErrorKind::WouldBlock), Ok("b\n")]), 100);
        assert_eq!(lines.next().unwrap_err().kind(), io::ErrorKind::WouldBlock);
        assert_eq!(lines.next().unwrap(), Some(Line::Whole(b"ab")));
    }

    #[test]
    fn a_long_line_is_skipped_wherever_reads_cut_it() {
        let long = [None, whole("b")];
        assert_eq!(all(&b"aaaa\nb"[..], 3), long);
        assert_eq!(all(script(&[Ok("aa"), Ok("aa"), Ok("aa\nb"), Ok("")]), 3), long);
        assert_eq!(all(script(&[Ok("aaaa"), Ok("\nb"), Ok("")]), 3), long);
        assert_eq!(all(&b"aaa\naaaa"[..], 3), [whole("aaa"), None]);
        assert_eq!(all(&b"aaa\n\n"[..], 0), [None, whole("")]);
    }

    #[test]
    fn memory_is_bounded_by_the_limit() {
        for (limit, length) in [(1000, 10_000_000), (300_000, 300_000), (300_000, 300_001)] {
            let mut lines = Lines::new(io::repeat(b'x').take(length), limit);
            let whole = matches!(lines.next().unwrap(), Some(Line::Whole(_)));
            assert_eq!(whole, length <= limit as u64);
            assert_eq!(lines.consumed(), length);
            assert!(lines.buffer.capacity() <= limit + CHUNK, "{limit}: {}", lines.buffer.capacity());
        }
    }

    #[test]
    fn lines_longer_than_the_first_buffer_come_out_whole() {
        let line = "0123456789".repeat(CHUNK / 3);
        let text = format!("a\n{line}\n{line}\nb");
        let expected = [whole("a"), whole(&line), whole(&line), whole("b")];
        assert_eq!(all(text.as_bytes(), 1 << 20), expected);
    }
}
