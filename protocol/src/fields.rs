//! Reads the fields of a body as SPEC.md, section 4, defines them.
//!
//! In: bytes. Out: any type that serde can build from fields in order.
//!
//! Invariants: a length above the number of bytes left is an error, so memory is in proportion to the bytes given.
//! Reading never goes back.
//!
//! Must not know: which types there are, frames.
//!
//! Why not bincode, which writes bodies: through serde it reserves what a length announces (1 MiB for lists; for texts
//! anything below a limit that is a constant, not the body's length).

use std::fmt::Display;

use serde::de::{self, DeserializeSeed, Deserializer, IntoDeserializer, SeqAccess, Visitor, value::U32Deserializer};
use serde::forward_to_deserialize_any;

/// Why fields cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Unreadable(String);

impl de::Error for Unreadable {
    fn custom<T: Display>(reason: T) -> Self {
        Self(reason.to_string())
    }
}

/// The bytes that are not read yet.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl Fields<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], Unreadable> {
        let left = self.0.len();
        let missing = || Unreadable(format!("it ends where {count} bytes are due and {left} are left"));
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(missing)?;
        self.0 = rest;
        Ok(taken)
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Unreadable> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    /// Reads a number of at most `largest` bytes.
    fn number(&mut self, largest: usize) -> Result<u64, Unreadable> {
        let [mark] = self.bytes()?;
        match mark {
            0..=250 => Ok(mark.into()),
            251 => Ok(u16::from_le_bytes(self.bytes()?).into()),
            252 if largest >= 4 => Ok(u32::from_le_bytes(self.bytes()?).into()),
            253 if largest >= 8 => Ok(u64::from_le_bytes(self.bytes()?)),
            _ => Err(Unreadable(format!("a number of {largest} bytes has the mark {mark}"))),
        }
    }

    /// Reads the length of a text or a list. Each of its elements takes at least one byte.
    fn length(&mut self) -> Result<usize, Unreadable> {
        let (length, left) = (self.number(8)?, self.0.len());
        let fitting = usize::try_from(length).ok().filter(|length| *length <= left);
        fitting.ok_or_else(|| Unreadable(format!("a length of {length} where {left} bytes are left")))
    }

    fn flag(&mut self) -> Result<bool, Unreadable> {
        match self.bytes()? {
            [0] => Ok(false),
            [1] => Ok(true),
            [byte] => Err(Unreadable(format!("{byte} where 0 or 1 is due"))),
        }
    }

    fn text(&mut self) -> Result<&str, Unreadable> {
        let length = self.length()?;
        std::str::from_utf8(self.take(length)?).map_err(|error| Unreadable(format!("a text is no UTF-8: {error}")))
    }
}

impl<'de> Deserializer<'de> for &mut Fields<'_> {
    type Error = Unreadable;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Unreadable> {
        Err(Unreadable("bodies do not say what type a field has, and have no fields of this one".into()))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_bool(self.flag()?)
    }

    fn deserialize_u8<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        let [byte] = self.bytes()?;
        visitor.visit_u8(byte)
    }

    fn deserialize_u16<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_u64(self.number(2)?)
    }

    fn deserialize_u32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_u64(self.number(4)?)
    }

    fn deserialize_u64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_u64(self.number(8)?)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_f64(f64::from_le_bytes(self.bytes()?))
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        if self.flag()? { visitor.visit_some(self) } else { visitor.visit_none() }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        let left = self.length()?;
        visitor.visit_seq(Elements { fields: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, left: usize, visitor: V) -> Result<V::Value, Unreadable> {
        visitor.visit_seq(Elements { fields: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_enum(self)
    }

    fn is_human_readable(&self) -> bool {
        false
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 i128 u128 f32 char bytes byte_buf unit unit_struct newtype_struct tuple_struct map identifier ignored_any
    }
}

/// The elements of a list, or the fields of a struct.
struct Elements<'a, 'b> {
    fields: &'a mut Fields<'b>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Elements<'_, '_> {
    type Error = Unreadable;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Unreadable> {
        if self.left == 0 {
            return Ok(None);
        }
        self.left -= 1;
        seed.deserialize(&mut *self.fields).map(Some)
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.left)
    }
}

impl<'de> de::EnumAccess<'de> for &mut Fields<'_> {
    type Error = Unreadable;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Unreadable> {
        // A case is a number of at most 4 bytes.
        let case: U32Deserializer<Unreadable> = (self.number(4)? as u32).into_deserializer();
        Ok((seed.deserialize(case)?, self))
    }
}

impl<'de> de::VariantAccess<'de> for &mut Fields<'_> {
    type Error = Unreadable;

    fn unit_variant(self) -> Result<(), Unreadable> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Unreadable> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, fields: usize, visitor: V) -> Result<V::Value, Unreadable> {
        self.deserialize_tuple(fields, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        self.deserialize_tuple(fields.len(), visitor)
    }
}
