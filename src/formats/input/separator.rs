//! What separates the columns of a table, and how a line is cut at it.
//!
//! In: the content of one line, and a [`Separator`].
//! Out: its fields, trimmed and without quotes.
//!
//! Invariant: cutting a line takes time in proportion to its length.
//!
//! Must not know: which columns are wanted, or that they are numbers.

use std::fmt;

/// What stands between two columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// One tab.
    Tab,
    /// One semicolon.
    Semicolon,
    /// One comma.
    Comma,
    /// Any run of spaces and tabs.
    Blanks,
}

impl Separator {
    /// The separators that may be meant on a line, the likeliest first. A comma comes late since it
    /// may be in a decimal number, and blanks come last since they may stand beside any other.
    pub(super) fn candidates(line: &str) -> impl Iterator<Item = Self> {
        [Self::Tab, Self::Semicolon, Self::Comma, Self::Blanks]
            .into_iter()
            .filter(|separator| separator.byte().is_none_or(|byte| line.as_bytes().contains(&byte)))
    }

    /// The likeliest separator of a line that fits; if none does, the likeliest.
    pub(super) fn fitting(line: &str, fits: impl Fn(Self) -> bool) -> Self {
        let likeliest = Self::candidates(line).next().unwrap_or(Self::Blanks);
        Self::candidates(line).find(|&separator| fits(separator)).unwrap_or(likeliest)
    }

    /// Cuts a line into fields. There is always at least one, except between blanks.
    pub(super) fn split(self, line: &str) -> Fields<'_> {
        Fields { rest: Some(line), separator: self }
    }

    fn byte(self) -> Option<u8> {
        match self {
            Self::Tab => Some(b'\t'),
            Self::Semicolon => Some(b';'),
            Self::Comma => Some(b','),
            Self::Blanks => None,
        }
    }

    /// Without the blanks before a field. A tab that separates is not one of them: it closes an
    /// empty field.
    #[inline]
    fn trim_start(self, rest: &str) -> &str {
        match self {
            Self::Tab => rest.trim_start_matches(' '),
            _ => rest.trim_start_matches([' ', '\t']),
        }
    }

    fn matches(self, byte: u8) -> bool {
        match self.byte() {
            Some(own) => byte == own,
            None => is_blank(byte),
        }
    }
}

impl fmt::Display for Separator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tab => "tabs",
            Self::Semicolon => "semicolons",
            Self::Comma => "commas",
            Self::Blanks => "blanks",
        })
    }
}

/// The fields of one line.
#[derive(Debug, Clone)]
pub struct Fields<'a> {
    rest: Option<&'a str>,
    separator: Separator,
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    #[inline]
    fn next(&mut self) -> Option<&'a str> {
        let rest = self.separator.trim_start(self.rest?);
        if self.separator == Separator::Blanks && rest.is_empty() {
            self.rest = None;
            return None;
        }
        let end = self.end_of_field(rest);
        self.rest = rest.get(end + 1..);
        Some(unquote(trim_end(&rest[..end])))
    }
}

impl Fields<'_> {
    /// Where the first field ends. A field in quotes may contain separators.
    #[inline]
    fn end_of_field(&self, rest: &str) -> usize {
        let from = if rest.starts_with('"') { end_of_quotes(rest).unwrap_or(0) } else { 0 };
        let found = rest.as_bytes()[from..].iter().position(|&byte| self.separator.matches(byte));
        found.map_or(rest.len(), |offset| from + offset)
    }
}

/// Where the quotes end that `rest` begins with; none if nothing closes them. Two quotes in a row
/// stand for one that does not close.
fn end_of_quotes(rest: &str) -> Option<usize> {
    let mut at = 1;
    loop {
        at += memchr::memchr(b'"', rest.as_bytes().get(at..)?)? + 1;
        if rest.as_bytes().get(at) != Some(&b'"') {
            return Some(at);
        }
        at += 1;
    }
}

fn unquote(field: &str) -> &str {
    let inside = field.strip_prefix('"').and_then(|field| field.strip_suffix('"'));
    inside.map_or(field, |inside| inside.trim_matches([' ', '\t']))
}

/// The line without a comment: up to the first `#` that is not in quotes.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    let mut quoted = false;
    let mut from = 0;
    for at in memchr::memchr_iter(b'#', line) {
        quoted ^= memchr::memchr_iter(b'"', &line[from..at]).count() % 2 == 1;
        from = at;
        if !quoted {
            return &line[..at];
        }
    }
    line
}

/// `\r` is not a blank: alone it is no line end, and must not pass for a separator either.
fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

fn trim_end(text: &str) -> &str {
    text.trim_end_matches([' ', '\t'])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(separator: Separator, line: &str) -> Vec<&str> {
        separator.split(line).collect()
    }

    #[test]
    fn fields_are_cut_and_trimmed() {
        assert_eq!(split(Separator::Comma, "1,2"), ["1", "2"]);
        assert_eq!(split(Separator::Comma, " 1 ,\t2 , "), ["1", "2", ""]);
        assert_eq!(split(Separator::Comma, ",,"), ["", "", ""]);
        assert_eq!(split(Separator::Comma, ""), [""]);
        assert_eq!(split(Separator::Semicolon, "1,5;2,5"), ["1,5", "2,5"]);
        assert_eq!(split(Separator::Tab, "New York\t1\t2"), ["New York", "1", "2"]);
        assert_eq!(split(Separator::Tab, "\t1\t\t 2 \t"), ["", "1", "", "2", ""]);
        assert_eq!(split(Separator::Blanks, "  1 \t 2  "), ["1", "2"]);
        assert_eq!(split(Separator::Blanks, ""), [""; 0]);
        assert_eq!(split(Separator::Blanks, "1\r2 3"), ["1\r2", "3"]);
    }

    #[test]
    fn quotes_are_stripped_and_protect_separators() {
        assert_eq!(split(Separator::Comma, r#""1.5"," 2 ""#), ["1.5", "2"]);
        assert_eq!(split(Separator::Comma, r#""Bonn, am Rhein",7,51"#), ["Bonn, am Rhein", "7", "51"]);
        assert_eq!(split(Separator::Comma, r#""a""b,c",1"#), [r#"a""b,c"#, "1"]);
        assert_eq!(split(Separator::Blanks, r#""x of it" y"#), ["x of it", "y"]);
    }

    #[test]
    fn stray_quotes_are_ordinary_characters() {
        assert_eq!(split(Separator::Comma, r#""1,2"#), ["\"1", "2"]);
        assert_eq!(split(Separator::Comma, r#"5",2"#), ["5\"", "2"]);
        assert_eq!(split(Separator::Comma, r#""a"b,2"#), [r#""a"b"#, "2"]);
        assert_eq!(split(Separator::Comma, r#"",2"#), ["\"", "2"]);
        assert_eq!(split(Separator::Comma, r#""",2"#), ["", "2"]);
    }

    #[test]
    fn comments_are_cut_off() {
        let cases = [
            ("1,2 # a # b", "1,2 "),
            ("# 1,2", ""),
            ("1,2", "1,2"),
            (r##""#id",x#c"##, r##""#id",x"##),
            (r##""a"#"b""##, r#""a""#),
        ];
        for (line, content) in cases {
            assert_eq!(without_comment(line.as_bytes()), content.as_bytes(), "{line}");
        }
    }
}
