//! The numbers and times in the fields of a table, and the times of JSON lines.
//!
//! In: one field, trimmed, and what separates it from the next.
//! Out: its value, or what is wrong with it and how to write it.
//! Invariants: a comma is decimal only where it cannot separate columns. A time is a number, or a date and a time of
//! day in ISO 8601, which is seconds since 1970 in UTC; without an offset it is in UTC.
//! Must not know: which field of which line it is.

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::Offset;

use super::error::BadLineReason;
use super::excerpt::Excerpt;
use super::separator::Separator;

/// The value of a coordinate.
#[inline]
pub(super) fn number(field: &str, separator: Separator) -> Result<f64, BadLineReason> {
    field.parse().or_else(|_| unusual(field, separator))
}

/// The value of an event time.
pub(super) fn time(field: &str, separator: Separator) -> Result<f64, BadLineReason> {
    number(field, separator).or_else(|reason| iso_time(field).ok_or_else(|| no_time(field, reason)))
}

/// Seconds since 1970 of a date and a time of day, as ISO 8601 and RFC 3339 write them.
pub(super) fn iso_time(text: &str) -> Option<f64> {
    let text = text.trim();
    // A week's or a year's number alone is not meant.
    if !text.get(..5)?.ends_with('-') && !text.starts_with(['+', '-']) {
        return None;
    }
    let time = text.parse::<Timestamp>().ok().or_else(|| {
        let local: DateTime = text.parse().ok()?;
        Offset::UTC.to_timestamp(local).ok()
    })?;
    Some(time.as_second() as f64 + f64::from(time.subsec_nanosecond()) / 1e9)
}

/// Whether a field that is no name may be a number that somebody has meant.
pub(super) fn looks_numeric(field: &str) -> bool {
    field.parse::<f64>().is_ok()
        || decimal(field).is_some()
        || without_thousands(field).is_some()
        || minus(field).is_some()
}

/// A number with a decimal comma, or what is wrong.
#[cold]
fn unusual(field: &str, separator: Separator) -> Result<f64, BadLineReason> {
    match decimal(field) {
        Some(decimal) if separator != Separator::Comma => decimal.parse().map_err(|_| not_a_number(field)),
        _ => Err(reason(field)),
    }
}

fn reason(field: &str) -> BadLineReason {
    let found = Excerpt::of(field.as_bytes());
    if field.is_empty() {
        BadLineReason::EmptyColumn
    } else if let Some(decimal) = decimal(field) {
        let meant = [decimal, field.replace(',', "")].map(|meant| Excerpt::of(meant.as_bytes()));
        BadLineReason::Comma { found, meant: Box::new(meant) }
    } else if let Some(whole) = without_thousands(field) {
        BadLineReason::Thousands { found, meant: Box::new(Excerpt::of(whole.as_bytes())) }
    } else if let Some(meant) = minus(field) {
        BadLineReason::Minus { found, meant: Box::new(Excerpt::of(meant.as_bytes())) }
    } else if field.contains('\0') {
        BadLineReason::Nul { found }
    } else {
        not_a_number(field)
    }
}

fn not_a_number(field: &str) -> BadLineReason {
    BadLineReason::NotANumber { found: Excerpt::of(field.as_bytes()) }
}

fn no_time(field: &str, reason: BadLineReason) -> BadLineReason {
    match reason {
        BadLineReason::NotANumber { .. } => BadLineReason::NotATime { found: Excerpt::of(field.as_bytes()) },
        other => other,
    }
}

/// The number with a decimal point that is meant by one comma between digits.
fn decimal(field: &str) -> Option<String> {
    let (whole, fraction) = field.split_once(',')?;
    let is_between_digits =
        whole.ends_with(|c: char| c.is_ascii_digit()) && fraction.starts_with(|c: char| c.is_ascii_digit());
    // `1,5` is `1.5`; `1,` and `,5` are rather pieces of a line cut at the wrong place.
    let decimal = format!("{whole}.{fraction}");
    (is_between_digits && decimal.parse::<f64>().is_ok()).then_some(decimal)
}

/// What marks groups of digits.
const MARKS: [char; 7] = [',', '.', '\'', ' ', '\u{a0}', '\u{202f}', '\u{2009}'];

/// The number without marks if it is written in groups of three digits, as `1,234.5`, `1.234,5` and `1'234`.
fn without_thousands(field: &str) -> Option<String> {
    let mark = field.chars().find(|c| MARKS.contains(c))?;
    let mut groups = field.split(mark).skip(1).peekable();
    while let Some(group) = groups.next() {
        let digits = group.bytes().take_while(u8::is_ascii_digit).count();
        if digits != 3 || groups.peek().is_some() && group.len() != 3 {
            return None;
        }
    }
    // A second kind of mark is decimal.
    let plain = field.replace(mark, "").replace(',', ".");
    plain.parse::<f64>().is_ok().then_some(plain)
}

/// The number with a hyphen in the place of the typographic minus.
fn minus(field: &str) -> Option<String> {
    let meant = field.replace(['\u{2212}', '\u{2013}', '\u{2012}', '\u{fe63}', '\u{ff0d}'], "-");
    (meant != field && meant.parse::<f64>().is_ok()).then_some(meant)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(field: &str, separator: Separator) -> String {
        number(field, separator).unwrap_err().to_string()
    }

    #[test]
    fn a_decimal_comma_is_read_where_it_cannot_separate() {
        for separator in [Separator::Semicolon, Separator::Blanks, Separator::Tab] {
            assert_eq!(number("1,5", separator), Ok(1.5));
            assert_eq!(number("-0,25e2", separator), Ok(-25.0));
            assert!(number("1,e5", separator).is_err());
            assert!(number("1,2,3", separator).is_err());
        }
        assert_eq!(
            message("60,000", Separator::Comma),
            "\"60,000\" has a comma: write \"60.000\" if it is decimal, \"60000\" if it marks thousands"
        );
    }

    #[test]
    fn marks_of_thousands_are_named() {
        for (field, meant) in
            [("1,234.5", "1234.5"), ("1.234,5", "1234.5"), ("1'234", "1234"), ("1,234,567", "1234567")]
        {
            let message = message(field, Separator::Semicolon);
            assert_eq!(message, format!("\"{field}\" has marks of thousands: write \"{meant}\""));
        }
        for field in ["192.168.1.1", "1.23.456", "12:30", "1.2345,6", "1,2345.6"] {
            assert!(message(field, Separator::Semicolon).contains("is not a number"), "{field}");
        }
        assert_eq!(message("a.b", Separator::Comma), "\"a.b\" is not a number: write one such as 1.5 or -2e-3");
    }

    #[test]
    fn a_typographic_minus_is_named() {
        let message = message("\u{2212}5", Separator::Comma);
        assert_eq!(message, "\"\u{2212}5\" has a minus sign that is no hyphen: write \"-5\"");
        assert!(looks_numeric("\u{2212}5"));
    }

    #[test]
    fn times_are_numbers_or_iso_8601() {
        let time = |text| super::time(text, Separator::Comma);
        assert_eq!(time("1.5"), Ok(1.5));
        assert_eq!(time("1970-01-01T00:00:01Z"), Ok(1.0));
        assert_eq!(time("1970-01-01 00:01:00.25"), Ok(60.25));
        assert_eq!(time("1970-01-01T02:00:00+02:00"), Ok(0.0));
        assert_eq!(time("2026-11-29"), Ok(1_795_910_400.0));
        assert_eq!(time("1969-12-31T23:59:59.5Z"), Ok(-0.5));
        for bad in ["", "noon", "2026-13-01", "12:30"] {
            assert!(time(bad).is_err(), "{bad}");
        }
        assert_eq!(
            time("noon").unwrap_err().to_string(),
            "\"noon\" is not a time: write seconds such as 1.5, or a date and time such as 2026-11-29T12:30:00Z"
        );
    }
}
