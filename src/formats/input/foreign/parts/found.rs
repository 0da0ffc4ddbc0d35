//! What a machine finds in the bytes of a foreign file.
//!
//! In: points, entries and faults, in the order of the file.
//! Out: a queue of them.
//! Must not know: formats.

use std::collections::VecDeque;

use crate::formats::input::columns::{FieldPlaces, PointColumns};
use crate::formats::input::excerpt::Excerpt;
use crate::formats::input::record::{Parsed, Point};

/// One thing in a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Found<P> {
    /// A point, and when it was seen.
    Point(P, Option<f64>),
    /// An element of JSON, with its points.
    Entry(Parsed, Vec<P>),
    /// A point or an element that cannot be used. It has a number like those that can.
    Bad(String),
    /// A point in the element before that cannot be used.
    Part(String),
    /// Something else that is wrong.
    Missed(String),
}

impl<P: Point> Found<P> {
    /// A point of two coordinates, without a time.
    pub fn position(point: [f64; 2]) -> Self {
        Self::Point(P::of(point.len(), |axis| point[axis]), None)
    }
}

/// In the order of the file.
pub type Queue<P> = VecDeque<Found<P>>;

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

/// Which fields are the coordinates, in words. Only the first is called by what it is.
pub fn told_of_fields<'a, C: PointColumns>(
    places: &FieldPlaces,
    what: &str,
    name: impl Fn(usize) -> &'a str,
) -> String {
    let named = |(number, &place): (usize, &usize)| {
        let what = if number == 0 { format!("the {what} ") } else { String::new() };
        format!("{what}{}", Excerpt::of(name(place).as_bytes()))
    };
    C::told(places.coordinates.iter().enumerate().map(named))
}
