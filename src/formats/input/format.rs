//! Which of the two input formats a source is in.
//!
//! In: the path of the input, if it has one, and its first bytes.
//! Out: a [`Format`].
//! Invariant: of a live source no more is read than what decides.
//! Must not know: how either format is parsed.

use std::io::{self, Cursor, ErrorKind, Read};
use std::path::Path;

use super::lines::BYTE_ORDER_MARK;

/// The format of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A table: one point per line, in columns.
    Text,
    /// One JSON array or object per line.
    JsonLines,
}

impl Format {
    /// Guesses the format: by the extension `.jsonl`, `.ndjson` or `.json`, else by whether the
    /// first byte that is neither blank nor in a `#` comment opens a JSON array or object.
    pub fn sniff(path: Option<&Path>, first_bytes: &[u8]) -> Self {
        if path.is_some_and(has_json_extension) || begins_as_json(first_bytes) { Self::JsonLines } else { Self::Text }
    }
}

/// How many bytes the format is guessed from at the most.
const SNIFFED: usize = 4096;

/// Guesses the format of a source as [`Format::sniff`] does. Also gives all of its bytes.
///
/// # Errors
/// The source fails.
pub fn sniffed<R: Read>(path: Option<&Path>, mut source: R) -> io::Result<(Format, impl Read + use<R>)> {
    let mut first = Vec::new();
    if !path.is_some_and(has_json_extension) {
        let mut piece = [0; SNIFFED];
        while first.len() < SNIFFED && first_of_content(&first).is_none() {
            match source.read(&mut piece) {
                Ok(0) => break,
                Ok(length) => first.extend_from_slice(&piece[..length]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
    Ok((Format::sniff(path, &first), Cursor::new(first).chain(source)))
}

fn has_json_extension(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| ["jsonl", "ndjson", "json"].iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

fn begins_as_json(bytes: &[u8]) -> bool {
    first_of_content(bytes).is_some_and(|first| matches!(first, b'[' | b'{'))
}

/// The first byte that is neither blank nor in a comment.
fn first_of_content(bytes: &[u8]) -> Option<u8> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r'));
    lines.filter_map(|line| line.trim_ascii_start().first().copied()).find(|&first| first != b'#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_decides_first() {
        for name in ["a.jsonl", "a.ndjson", "b/a.json", "A.JSON"] {
            assert_eq!(Format::sniff(Some(Path::new(name)), b"1,2"), Format::JsonLines, "{name}");
        }
        for name in ["a.csv", "json", "a.json.txt", ""] {
            assert_eq!(Format::sniff(Some(Path::new(name)), b"1,2"), Format::Text, "{name}");
        }
    }

    #[test]
    fn of_a_live_source_no_more_is_read_than_decides() {
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
            let (found, mut all) = sniffed(None, &mut source).unwrap();
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
        let (format, _) = sniffed(Some(Path::new("a.json")), Pieces(Vec::new())).unwrap();
        assert_eq!(format, Format::JsonLines, "nothing has to be read");
    }

    #[test]
    fn the_first_byte_that_says_anything_decides_next() {
        for bytes in ["[1,2]", "{", " \t\r\n\n [", "# x\n  # [y\n{\"x\":1", "\u{feff}[1,2]"] {
            assert_eq!(Format::sniff(None, bytes.as_bytes()), Format::JsonLines, "{bytes:?}");
        }
        for bytes in ["", "\n", "# [1,2]", "1,2\n[1,2]", "x,y", "\u{feff}1,2", "# a\n1 2\n["] {
            assert_eq!(Format::sniff(None, bytes.as_bytes()), Format::Text, "{bytes:?}");
        }
        assert_eq!(Format::sniff(Some(Path::new("a.csv")), b"[1,2]"), Format::JsonLines);
    }
}
