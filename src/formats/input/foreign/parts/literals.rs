//! The literals `NaN` and `Infinity`, which are no JSON, as strings of the same length, which are.
//!
//! In: JSON text, in any pieces.
//! Out: the same, with each such literal (also with a sign) replaced by a string of dashes.
//! Invariants: no byte changes its place; nothing within strings changes.
//! Must not know: what the text says.

/// The literals that are replaced.
const LITERALS: [&[u8]; 3] = [b"NaN", b"Infinity", b"-Infinity"];

/// What stands in a string that was such a literal.
pub fn is_replaced(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte == b'-')
}

/// Where in the text the bytes are.
#[derive(Debug, Default)]
pub struct Literals {
    is_in_string: bool,
    is_escaped: bool,
}

impl Literals {
    /// Replaces in `text`, of which the bytes before `from` are done. How many are done now: what may become a literal
    /// waits for more.
    pub fn replace(&mut self, text: &mut [u8], from: usize) -> usize {
        let mut at = from;
        while at < text.len() {
            let byte = text[at];
            if self.is_in_string {
                self.is_in_string = byte != b'"' || self.is_escaped;
                self.is_escaped = byte == b'\\' && !self.is_escaped;
            } else if byte == b'"' {
                self.is_in_string = true;
            } else if matches!(byte, b'N' | b'I' | b'-') {
                let rest = &text[at..];
                if let Some(length) = LITERALS.iter().find(|&&known| rest.starts_with(known)).map(|known| known.len()) {
                    text[at..at + length].fill(b'-');
                    (text[at], text[at + length - 1]) = (b'"', b'"');
                    at += length;
                    continue;
                }
                if LITERALS.iter().any(|known| known.starts_with(rest)) {
                    return at;
                }
            }
            at += 1;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_become_strings_of_their_length_however_the_text_is_cut() {
        let text = br#"[NaN,-Infinity,Infinity,-1,"NaN \" -Infinity",-Inf,N]"#;
        let expected = r#"["-","-------","------",-1,"NaN \" -Infinity",-Inf,N]"#;
        for size in 1..=text.len() {
            let (mut done, mut all, mut literals) = (0, Vec::new(), Literals::default());
            for piece in text.chunks(size) {
                all.extend_from_slice(piece);
                done = literals.replace(&mut all, done);
            }
            assert_eq!(String::from_utf8(all).unwrap(), expected, "{size}");
            assert_eq!(done, text.len());
        }
        assert!(is_replaced("-") && !is_replaced("") && !is_replaced("-1"));
    }
}
