//! Which format a source is in, and what its bytes are behind compression and encoding.
//!
//! In: the path of the input, if it has one, the format if it was chosen, and the source.
//! Out: a [`Format`], and the bytes to be read as that; or why they are not read here.
//! Invariant: of a live source no more is read than what decides.
//! Must not know: how a format is parsed.

use std::io::{Cursor, ErrorKind, Read};
use std::path::Path;

use super::decoding::{Damage, Gzip, Utf16};
use super::error::ReadError;
use super::foreign::Readable;
use super::foreign::error::ForeignError;
use super::foreign::signature::{DECISIVE, Kind, recognise};

/// The format of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A table: one point per line, in columns.
    Text,
    /// One JSON array or object per line.
    JsonLines,
    /// A file of another program.
    Foreign(Readable),
}

/// How many bytes are asked for at once while the format is not known.
const PIECE: usize = 4096;

/// How many layers of compression and encoding are taken off.
const MOST_LAYERS: usize = 4;

/// The format of a source, by its first bytes, and by the end of its path where these do not decide, and what is to be
/// read as that. Compression and encoding are taken off, also if the format was chosen.
///
/// # Errors
/// The source fails, or is of a kind that is not read here.
pub fn opened<'a>(
    path: Option<&Path>,
    chosen: Option<Format>,
    source: impl Read + 'a,
) -> Result<(Format, Box<dyn Read + 'a>), ReadError> {
    let mut source: Box<dyn Read + 'a> = Box::new(source);
    let mut name = path.map(Path::to_path_buf);
    for _ in 0..=MOST_LAYERS {
        let (kind, all) = begin(name.as_deref(), chosen.is_some(), source)?;
        let format = match kind {
            Kind::Gzip => {
                source = Box::new(Gzip::new(all));
                // `points.csv.gz` holds `points.csv`.
                name = name.map(|name| name.with_extension(""));
                continue;
            }
            Kind::Utf16 { is_big_endian } => {
                source = Box::new(Utf16::new(all, is_big_endian));
                continue;
            }
            Kind::Text => Format::Text,
            Kind::JsonLines => Format::JsonLines,
            Kind::Readable(format) => Format::Foreign(format),
            Kind::Refused(refusal) => return Err(ForeignError::Refused(refusal).into()),
        };
        // What was chosen is text, or lines of JSON. A binary format that is read all the same is no mistake.
        let format = if matches!(kind, Kind::Text) { chosen.unwrap_or(format) } else { format };
        return Ok((format, all));
    }
    Err(ForeignError::Layers { most: MOST_LAYERS }.into())
}

/// What a source is, and all of its bytes.
fn begin<'a>(
    path: Option<&Path>,
    is_chosen: bool,
    mut source: Box<dyn Read + 'a>,
) -> Result<(Kind, Box<dyn Read + 'a>), ReadError> {
    let mut first = Vec::new();
    let mut piece = [0; PIECE];
    let mut is_all = false;
    let kind = loop {
        if let Some(kind) = recognise(path, &first, is_all, is_chosen) {
            break kind;
        }
        // What is known to be all is always recognised.
        let room = PIECE.min(DECISIVE.saturating_sub(first.len()).max(1));
        match source.read(&mut piece[..room]) {
            Ok(0) => is_all = true,
            Ok(length) => first.extend_from_slice(&piece[..length.min(room)]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if Damage::of(&error).is_none() => return Err(ReadError::Io { line: 1, source: error }),
            // Its reader meets the damage after what came before.
            Err(error) => {
                let kind = recognise(path, &first, true, is_chosen).unwrap_or(Kind::Text);
                let failed = Failing(Some(error)).chain(source);
                return Ok((kind, Box::new(Cursor::new(first).chain(failed))));
            }
        }
    };
    Ok((kind, Box::new(Cursor::new(first).chain(source))))
}

/// Fails once.
struct Failing(Option<std::io::Error>);

impl Read for Failing {
    fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
        self.0.take().map_or(Ok(0), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn format_of(path: Option<&str>, bytes: &[u8]) -> Format {
        opened(path.map(Path::new), None, bytes).unwrap().0
    }

    #[test]
    fn the_extension_decides_where_the_bytes_do_not() {
        for name in ["a.jsonl", "a.ndjson", "b/a.json", "A.JSON"] {
            assert_eq!(format_of(Some(name), b"1,2"), Format::JsonLines, "{name}");
        }
        for name in ["a.csv", "json", "a.json.txt", ""] {
            assert_eq!(format_of(Some(name), b"1,2"), Format::Text, "{name}");
        }
        assert_eq!(format_of(Some("a.csv"), b"[1,2]"), Format::JsonLines);
        assert_eq!(format_of(Some("a.csv"), b"[[1,2]]"), Format::Foreign(Readable::Elements));
    }

    #[test]
    fn of_a_live_source_no_more_is_read_than_decides() {
        use std::io;

        struct Pieces(Vec<&'static str>);
        impl Read for Pieces {
            fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
                assert!(!self.0.is_empty(), "one read too many");
                let piece = self.0.remove(0);
                room[..piece.len()].copy_from_slice(piece.as_bytes());
                Ok(piece.len())
            }
        }
        for (pieces, format) in [
            (vec!["[1,2]\n", ""], Format::JsonLines),
            (vec!["# a comment", " goes on\n", "\r\n", "1 2\n", ""], Format::Text),
            (vec!["\n", "\n", ""], Format::Text),
        ] {
            let (whole, content) = (pieces.concat(), pieces.len() - usize::from(pieces[0] != "\n"));
            let mut source = Pieces(pieces.clone());
            let (found, mut all) = opened(None, None, &mut source).unwrap();
            assert_eq!(found, format);
            let mut read = String::new();
            let mut buffer = [0; 100];
            for _ in 0..content.max(1) {
                if read.len() < whole.len() {
                    let length = all.read(&mut buffer).unwrap();
                    read.push_str(std::str::from_utf8(&buffer[..length]).unwrap());
                }
            }
            assert_eq!(read, whole);
        }
    }

    #[test]
    fn the_first_byte_that_says_anything_decides_next() {
        for bytes in ["[1,2]", "{", " \t\r\n\n [", "# x\n  # [y\n{\"x\":1", "\u{feff}[1,2]"] {
            assert_eq!(format_of(None, bytes.as_bytes()), Format::JsonLines, "{bytes:?}");
        }
        for bytes in ["", "\n", "# [1,2]", "1,2\n[1,2]", "x,y", "\u{feff}1,2", "# a\n1 2\n["] {
            assert_eq!(format_of(None, bytes.as_bytes()), Format::Text, "{bytes:?}");
        }
    }

    #[test]
    fn layers_are_taken_off_up_to_a_number() {
        use std::io::Write;

        let mut bytes = b"\xff\xfe1\0,\x002\0\n\0".to_vec();
        let mut formats = Vec::new();
        for _ in 0..=MOST_LAYERS {
            formats.push(opened(None, None, &bytes[..]).map(|(format, _)| format).ok());
            let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            encoder.write_all(&bytes).unwrap();
            bytes = encoder.finish().unwrap();
        }
        let layered = [Some(Format::Text); MOST_LAYERS];
        assert_eq!((&formats[..MOST_LAYERS], formats[MOST_LAYERS]), (&layered[..], None));
    }
}
