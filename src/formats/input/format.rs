//! Which of the two input formats a source is in.
//!
//! In: the path of the input, if it has one, and its first bytes.
//! Out: a [`Format`].
//! Must not know: how either format is parsed.

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

fn has_json_extension(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| ["jsonl", "ndjson", "json"].iter().any(|known| extension.eq_ignore_ascii_case(known)))
}

fn begins_as_json(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    bytes
        .split(|&byte| byte == b'\n')
        .filter_map(|line| line.trim_ascii_start().first())
        .find(|&&first| first != b'#')
        .is_some_and(|first| matches!(first, b'[' | b'{'))
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
