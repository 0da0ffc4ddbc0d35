//! A short, printable piece of input, for messages.
//!
//! In: bytes or text of any length and content.
//! Out: at most [`Excerpt::CHARACTERS`] printable characters, with control characters, quotes and stray bytes
//! escaped.
//!
//! Invariant: the cost is bounded whatever the length of the input.
//!
//! Must not know: where the piece comes from or what is wrong with it.

use std::fmt;

/// A piece of input made safe to show: escaped, and cut with `…` when it is long.
///
/// Displayed between double quotes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt(String);

impl Excerpt {
    /// How many characters are shown at most, the mark of a cut not counted.
    pub const CHARACTERS: usize = 40;

    /// The beginning of `bytes`.
    pub fn of(bytes: &[u8]) -> Self {
        // A character has at most four bytes, so the cut of the bytes cannot hide a character that
        // would have been shown; whether it breaks the last one does not matter.
        let near = &bytes[..bytes.len().min(4 * (Self::CHARACTERS + 1))];
        let mut shown = Shown::default();
        for chunk in near.utf8_chunks() {
            chunk.valid().chars().for_each(|c| shown.character(c));
            chunk.invalid().iter().for_each(|&b| shown.stray(b));
        }
        Self(shown.finish())
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\"", self.0)
    }
}

/// The text of an excerpt while it is being written.
#[derive(Default)]
struct Shown {
    text: String,
    characters: usize,
    full: bool,
}

impl Shown {
    fn character(&mut self, character: char) {
        // A quote of the other kind is harmless between double quotes.
        if character == '\'' {
            self.put("'", 1);
        } else {
            let escaped = character.escape_debug();
            self.put(&escaped.to_string(), escaped.count());
        }
    }

    fn stray(&mut self, byte: u8) {
        self.put(&format!("\\x{byte:02x}"), 4);
    }

    /// An escape is shown whole or not at all.
    fn put(&mut self, piece: &str, length: usize) {
        self.full |= self.characters + length > Excerpt::CHARACTERS;
        if !self.full {
            self.text.push_str(piece);
            self.characters += length;
        }
    }

    fn finish(mut self) -> String {
        if self.full {
            self.text.push('…');
        }
        self.text
    }
}

#[cfg(test)]
mod tests {
    use super::Excerpt;

    fn shown(bytes: &[u8]) -> String {
        Excerpt::of(bytes).to_string()
    }

    #[test]
    fn short_text_is_shown_as_it_is() {
        assert_eq!(shown(b"abc"), "\"abc\"");
        assert_eq!(shown("Länge's".as_bytes()), "\"Länge's\"");
        assert_eq!(shown(b""), "\"\"");
    }

    #[test]
    fn unprintable_characters_are_escaped() {
        assert_eq!(shown(b"a\r\tb\"\x1b"), r#""a\r\tb\"\u{1b}""#);
        assert_eq!(shown(b"\xff\x00"), r#""\xff\0""#);
    }

    #[test]
    fn long_content_is_cut() {
        assert_eq!(shown(&[b'z'; 40]), format!("\"{}\"", "z".repeat(40)));
        assert_eq!(shown(&[b'z'; 41]), format!("\"{}…\"", "z".repeat(40)));
        assert_eq!(shown(&[0xff; 99]), format!("\"{}…\"", "\\xff".repeat(10)));
        let wide = "😀".repeat(41);
        assert_eq!(shown(wide.as_bytes()), format!("\"{}…\"", "😀".repeat(40)));
    }
}
