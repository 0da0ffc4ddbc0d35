//! Input in pieces, as a pipe or a socket delivers it.
//!
//! In: bytes, and the lengths of the pieces. Out: an iterator of pieces, or a source that gives a piece at each read.
//!
//! Invariants: the pieces together are the bytes. A read is interrupted now and then, and never twice in a row.
//!
//! Must not know: what the bytes mean.

use std::cell::Cell;
use std::io::{self, ErrorKind, Read};
use std::rc::Rc;

/// How many lengths a target takes from its input.
const LENGTHS: usize = 4;

/// Bytes in pieces.
#[derive(Clone, Debug)]
pub struct Pieces<'a> {
    rest: &'a [u8],
    /// Used over and over. A piece has one byte more.
    lengths: [u8; LENGTHS],
    at: usize,
    was_interrupted: bool,
    reads: Rc<Cell<usize>>,
}

impl<'a> Pieces<'a> {
    /// Pieces whose lengths stand at the beginning of the data, and all bytes after the lengths.
    pub fn of(data: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let (&lengths, rest) = data.split_first_chunk()?;
        Some((Self::new(rest, lengths), rest))
    }

    fn new(rest: &'a [u8], lengths: [u8; LENGTHS]) -> Self {
        Self { rest, lengths, at: 0, was_interrupted: false, reads: Rc::default() }
    }

    /// Other bytes in pieces of the same lengths.
    pub fn over<'b>(&self, bytes: &'b [u8]) -> Pieces<'b> {
        Pieces::new(bytes, self.lengths)
    }

    /// The number of reads so far, also after the source was given away.
    pub fn reads(&self) -> Rc<Cell<usize>> {
        Rc::clone(&self.reads)
    }

    fn take(&mut self, most: usize) -> &'a [u8] {
        let length = usize::from(self.lengths[self.at % LENGTHS]) + 1;
        self.at += 1;
        let (piece, rest) = self.rest.split_at(length.min(most).min(self.rest.len()));
        self.rest = rest;
        piece
    }
}

impl<'a> Iterator for Pieces<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        Some(self.take(usize::MAX)).filter(|piece| !piece.is_empty())
    }
}

impl Read for Pieces<'_> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        self.reads.set(self.reads.get() + 1);
        self.was_interrupted = !self.was_interrupted && self.lengths[self.at % LENGTHS] % 8 == 7;
        if self.was_interrupted {
            return Err(ErrorKind::Interrupted.into());
        }
        let piece = self.take(room.len());
        room[..piece.len()].copy_from_slice(piece);
        Ok(piece.len())
    }
}
