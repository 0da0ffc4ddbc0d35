//! What a machine finds in the bytes of a foreign file.
//!
//! In: points, entries and faults, in the order of the file.
//! Out: a queue of them.
//! Must not know: formats.

use std::collections::VecDeque;

use crate::formats::input::record::Parsed;

/// One thing in a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Found {
    /// A point, and when it was seen.
    Point([f64; 2], Option<f64>),
    /// An element of JSON, with its points.
    Entry(Parsed, Vec<[f64; 2]>),
    /// A point or an element that cannot be used. It has a number like those that can.
    Bad(String),
    /// A point in the element before that cannot be used.
    Part(String),
    /// Something else that is wrong.
    Missed(String),
}

/// In the order of the file.
pub type Queue = VecDeque<Found>;

/// A piece of text from a file or about it, safe to show and short enough.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).take(300).collect()
}

/// Names in words.
pub fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    printable(&names.take(16).collect::<Vec<_>>().join(", "))
}

/// Bytes or points, in words.
pub fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
