//! Numbers that JSON has no word for and that programs write into it all the same.
//!
//! In: a line that is no JSON.
//! Out: the same with quotes around `NaN`, `Infinity` and numbers beyond the largest double, if there are any, so that
//! they are values like others.
//! Invariants: nothing within a string is touched. The cost is linear in the line.
//! Must not know: what the line says.

use super::json_values::{INFINITY, MINUS_INFINITY, NAN};

/// A line with such literals in quotes; none if it has none.
pub(super) fn with_quoted_literals(line: &str) -> Option<String> {
    let mut quoted = String::new();
    let mut copied = 0;
    for (start, end) in Words::of(line) {
        let Some(literal) = literal(&line[start..end]) else { continue };
        quoted.push_str(&line[copied..start]);
        quoted.extend(["\"", literal, "\""]);
        copied = end;
    }
    quoted.push_str(&line[copied..]);
    (copied > 0).then_some(quoted)
}

/// The name of the number that a word stands for, if JSON has no word for it.
fn literal(word: &str) -> Option<&'static str> {
    match word {
        "NaN" | "nan" | "-NaN" | "-nan" => Some(NAN),
        _ => match word.parse::<f64>() {
            Ok(number) if number == f64::INFINITY => Some(INFINITY),
            Ok(number) if number == f64::NEG_INFINITY => Some(MINUS_INFINITY),
            _ => None,
        },
    }
}

/// The runs of bytes outside strings that are no marks and no blanks.
struct Words<'a> {
    line: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    fn of(line: &'a str) -> Self {
        Self { line: line.as_bytes(), at: 0 }
    }

    /// Goes behind the string that begins here.
    fn skip_string(&mut self) {
        self.at += 1;
        while let Some(&byte) = self.line.get(self.at) {
            self.at += if byte == b'\\' { 2 } else { 1 };
            if byte == b'"' {
                return;
            }
        }
    }
}

impl Iterator for Words<'_> {
    type Item = (usize, usize);

    fn next(&mut self) -> Option<(usize, usize)> {
        let is_of_word = |byte: &&u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
        loop {
            let byte = self.line.get(self.at)?;
            if *byte == b'"' {
                self.skip_string();
            } else if is_of_word(&byte) {
                let start = self.at;
                self.at += self.line[start..].iter().take_while(is_of_word).count();
                return Some((start, self.at));
            } else {
                self.at += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::with_quoted_literals;

    #[test]
    fn literals_are_quoted_outside_of_strings() {
        let cases = [
            ("[NaN,1]", "[\"NaN\",1]"),
            ("[-Infinity, Infinity]", "[\"-Infinity\", \"Infinity\"]"),
            ("[1e999,-1e999,1e3]", "[\"Infinity\",\"-Infinity\",1e3]"),
            (r#"{"NaN":"a\"NaN","x":nan}"#, r#"{"NaN":"a\"NaN","x":"NaN"}"#),
            ("{\"é\":NaN", "{\"é\":\"NaN\""),
        ];
        for (line, quoted) in cases {
            assert_eq!(with_quoted_literals(line).as_deref(), Some(quoted), "{line}");
        }
        for line in ["[1,2]", "[NaNa,1]", "\"NaN", "\"\\", "é", "", "[nul,1]"] {
            assert_eq!(with_quoted_literals(line), None, "{line}");
        }
    }
}
