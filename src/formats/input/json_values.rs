//! The values that a JSON line is made of, as serde reads them.
//!
//! In: a deserializer.
//! Out: a [`Scalar`], an [`Element`] with a [`Row`] of them, or the [`Name`] of a member.
//! Invariants: of a value that cannot be used only the kind is kept, or the beginning of a string; an error of a
//! type here never quotes a string, which may be long.
//! Must not know: which values a line needs.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};

use super::error::{BadLineReason, Member};
use super::excerpt::Excerpt;
use super::numbers::iso_time;

/// Numbers that JSON has no word for, as programs write them anyway.
pub(super) const NAN: &str = "NaN";
pub(super) const INFINITY: &str = "Infinity";
pub(super) const MINUS_INFINITY: &str = "-Infinity";

/// A JSON value where a number or a truth value is expected; any other is only named.
#[derive(Debug, Default)]
pub enum Scalar {
    #[default]
    Null,
    Bool(bool),
    Number(f64),
    Text(Excerpt),
    /// A date and a time of day, in seconds since 1970.
    Time(f64, Box<Excerpt>),
    Array,
    Object,
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null => f.write_str("null"),
            Self::Bool(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Text(text) => text.fmt(f),
            Self::Time(_, text) => text.fmt(f),
            Self::Array => f.write_str("an array"),
            Self::Object => f.write_str("an object"),
        }
    }
}

impl<'de> Deserialize<'de> for Scalar {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        source.deserialize_any(ScalarVisitor)
    }
}

struct ScalarVisitor;

impl<'de> Visitor<'de> for ScalarVisitor {
    type Value = Scalar;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Scalar, E> {
        Ok(Scalar::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Scalar, E> {
        Ok(Scalar::Bool(value))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Scalar, E> {
        Ok(Scalar::Number(value as f64))
    }

    fn visit_str<E>(self, text: &str) -> Result<Scalar, E> {
        let excerpt = || Excerpt::of(text.as_bytes());
        Ok(match text {
            NAN => Scalar::Number(f64::NAN),
            INFINITY => Scalar::Number(f64::INFINITY),
            MINUS_INFINITY => Scalar::Number(f64::NEG_INFINITY),
            _ => iso_time(text).map_or_else(|| Scalar::Text(excerpt()), |time| Scalar::Time(time, Box::new(excerpt()))),
        })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Scalar, A::Error> {
        while elements.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Scalar::Array)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Scalar, A::Error> {
        while members.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Scalar::Object)
    }
}

/// An array that should hold coordinates: its first elements, and how many there are.
#[derive(Debug)]
pub struct Row {
    pub(super) elements: [Scalar; 3],
    pub(super) length: usize,
}

/// A JSON value where a point should be, whatever it is: one that is no array does not end a list of points.
#[derive(Debug)]
pub(super) enum Element<W> {
    Row(W),
    Other(Scalar),
}

/// What is kept of an array of coordinates.
pub trait ReadRow: Sized {
    /// Reads all of its elements.
    ///
    /// # Errors
    /// The text is no JSON.
    fn read<'de, A: SeqAccess<'de>>(source: A) -> Result<Self, A::Error>;
}

impl<W> Element<W> {
    /// The row of coordinates, or what is wrong with an element that is none.
    pub(super) fn row(self) -> Result<W, BadLineReason> {
        match self {
            Self::Row(row) => Ok(row),
            Self::Other(found) => Err(BadLineReason::NotAPoint { found: found.to_string() }),
        }
    }
}

impl<'de, W: ReadRow> Deserialize<'de> for Element<W> {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        source.deserialize_any(ElementVisitor(PhantomData))
    }
}

struct ElementVisitor<W>(PhantomData<W>);

impl<'de, W: ReadRow> Visitor<'de> for ElementVisitor<W> {
    type Value = Element<W>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a point [x,y]")
    }

    fn visit_unit<E: Error>(self) -> Result<Element<W>, E> {
        ScalarVisitor.visit_unit().map(Element::Other)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Element<W>, E> {
        ScalarVisitor.visit_bool(value).map(Element::Other)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Element<W>, E> {
        ScalarVisitor.visit_f64(value).map(Element::Other)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Element<W>, E> {
        ScalarVisitor.visit_i64(value).map(Element::Other)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Element<W>, E> {
        ScalarVisitor.visit_u64(value).map(Element::Other)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Element<W>, E> {
        ScalarVisitor.visit_str(text).map(Element::Other)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, source: A) -> Result<Element<W>, A::Error> {
        W::read(source).map(Element::Row)
    }

    fn visit_map<A: MapAccess<'de>>(self, members: A) -> Result<Element<W>, A::Error> {
        ScalarVisitor.visit_map(members).map(Element::Other)
    }
}

impl ReadRow for Row {
    #[inline]
    fn read<'de, A: SeqAccess<'de>>(mut source: A) -> Result<Self, A::Error> {
        let mut elements = <[Scalar; 3]>::default();
        let mut length = 0;
        while length < elements.len() {
            let Some(element) = source.next_element()? else {
                return Ok(Self { elements, length });
            };
            elements[length] = element;
            length += 1;
        }
        while source.next_element::<IgnoredAny>()?.is_some() {
            length += 1;
        }
        Ok(Self { elements, length })
    }
}

/// A string where `expected` should be. The string itself, which may be long, is not quoted.
pub(super) fn a_string<'de, E: Error>(expected: &impl Visitor<'de>) -> E {
    E::invalid_type(Unexpected::Other("string"), expected)
}

/// The name of a member, if a form of line has it.
pub(super) struct Name(pub(super) Option<Member>);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        source.deserialize_identifier(NameVisitor)
    }
}

struct NameVisitor;

impl Visitor<'_> for NameVisitor {
    type Value = Name;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name")
    }

    fn visit_str<E>(self, name: &str) -> Result<Name, E> {
        Ok(Name(Member::named(name)))
    }
}
