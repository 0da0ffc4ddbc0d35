//! Ripser's binary distances: a lower triangle of little-endian floats of four bytes, and nothing else.
//!
//! In: bytes, perhaps compressed.
//! Out: a space.
//! Invariants: memory grows with the bytes that have come, up to the most points.
//! Must not know: other forms.

use std::ffi::OsStr;
use std::io::{ErrorKind, Read};
use std::path::Path;

use super::super::super::decoding::{Damage, Gzip};
use super::super::super::error::Field;
use super::super::{Space, SpaceError};
use super::triangle::{Order, Rows, Triangle};
use super::{DistanceError, RowFault};

/// How many bytes are read at once.
const PIECE: usize = 1 << 16;

const SIZE: usize = size_of::<f32>();

/// Whether the end of a name says that the file is of this form.
pub(super) fn is_named(path: Option<&Path>) -> bool {
    let Some(path) = path else { return false };
    let plain = if is_compressed(path) { path.with_extension("") } else { path.to_path_buf() };
    plain.extension() == Some(OsStr::new("bin"))
}

fn is_compressed(path: &Path) -> bool {
    path.extension() == Some(OsStr::new("gz"))
}

/// Reads all of the source.
pub(super) fn read(path: Option<&Path>, source: impl Read, most: usize) -> Result<Space, SpaceError> {
    let mut source: Box<dyn Read + '_> = match path.is_some_and(is_compressed) {
        true => Box::new(Gzip::new(source)),
        false => Box::new(source),
    };
    let mut triangle = Triangle::new(Order::Lower, Rows::Pieces, most);
    let (mut pending, mut piece, mut byte) = (Vec::with_capacity(PIECE), [0; PIECE], 0);
    loop {
        let length = match source.read(&mut piece) {
            Ok(0) => break,
            Ok(length) => length,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => return Err(failed(byte, error)),
        };
        pending.extend_from_slice(&piece[..length.min(PIECE)]);
        let whole = pending.len() - pending.len() % SIZE;
        let numbers: Vec<f64> = pending[..whole].chunks_exact(SIZE).map(number).collect();
        triangle.row(&numbers).map_err(|fault| in_file(byte, fault))?;
        pending.drain(..whole);
        byte += whole as u64;
    }
    let end = |error| SpaceError::Distances { place: format!("byte {byte}"), error };
    if !pending.is_empty() {
        return Err(end(DistanceError::CutShort));
    }
    triangle.finish().map(|(space, _)| space).map_err(end)
}

fn number(bytes: &[u8]) -> f64 {
    let mut raw = [0; SIZE];
    raw.copy_from_slice(bytes);
    f64::from(f32::from_le_bytes(raw))
}

fn failed(byte: u64, source: std::io::Error) -> SpaceError {
    match Damage::of(&source) {
        Some(damage) => SpaceError::Line { reason: damage.to_string() },
        None => SpaceError::Io { byte, source },
    }
}

/// A fault in a number, by its first byte, counted from 1.
fn in_file(byte: u64, fault: RowFault) -> SpaceError {
    let place = byte as usize + fault.column.unwrap_or(0) * SIZE + 1;
    SpaceError::Distances { place: Field::Byte(place).to_string(), error: fault.error }
}
