//! Bodies: fields in order, as bincode 2 writes them (SPEC.md, section 4). Only this file knows bincode.
//!
//! In: a wire type, or bytes. Out: bytes, or a wire type.
//!
//! Invariants: decoding takes memory in proportion to the bytes given, whatever lengths they announce. A body ends
//! where its last field ends.
//!
//! Must not know: which types there are.
//!
//! bincode writes and [`Fields`] reads: through serde, bincode allocates an announced length before it checks that so
//! many bytes are there. The types use serde instead of bincode's own derive, so that the same definitions also give
//! the JSON of the golden vectors.

use std::sync::Arc;

use bincode::config::standard;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::fields::Fields;

/// Why a body does not match its type.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BodyError {
    /// The version has no messages of this type.
    #[error("messages of type {kind:#06x} are not known in this version")]
    UnknownType {
        /// The type of the message.
        kind: u16,
    },
    /// The body ends too soon, or a field has an invalid value.
    #[error("the body of a message of type {kind:#06x} cannot be read: {reason}")]
    Malformed {
        /// The type of the message.
        kind: u16,
        /// What is wrong.
        reason: String,
    },
    /// There are bytes after the last field.
    #[error("the body of a message of type {kind:#06x} has {extra} bytes too many")]
    TrailingBytes {
        /// The type of the message.
        kind: u16,
        /// The number of bytes after the last field.
        extra: usize,
    },
    /// The body does not fit into a frame.
    #[error("the body of a message of type {kind:#06x} has {length} bytes, more than a frame can hold")]
    TooLong {
        /// The type of the message.
        kind: u16,
        /// The length of the body in bytes.
        length: usize,
    },
}

/// An encoded body with its CRC. It is encoded once and sent to many receivers: only the header differs.
#[derive(Clone, Debug)]
pub struct Shared {
    /// The type of the message.
    pub kind: u16,
    /// The length of the body without the CRC.
    pub length: u32,
    /// The body and its CRC-32C.
    pub bytes: Arc<[u8]>,
}

/// Encodes a body and appends its CRC-32C.
pub(crate) fn seal<T: Serialize>(kind: u16, body: &T) -> Result<Shared, BodyError> {
    let mut bytes = encode(kind, body)?;
    let length = u32::try_from(bytes.len()).map_err(|_| BodyError::TooLong { kind, length: bytes.len() })?;
    bytes.extend(crc32c::crc32c(&bytes).to_le_bytes());
    Ok(Shared { kind, length, bytes: bytes.into() })
}

pub(crate) fn encode<T: Serialize>(kind: u16, body: &T) -> Result<Vec<u8>, BodyError> {
    bincode::serde::encode_to_vec(body, standard())
        .map_err(|error| BodyError::Malformed { kind, reason: error.to_string() })
}

pub(crate) fn decode<T: DeserializeOwned>(kind: u16, body: &[u8]) -> Result<T, BodyError> {
    let mut fields = Fields(body);
    let message =
        T::deserialize(&mut fields).map_err(|error| BodyError::Malformed { kind, reason: error.to_string() })?;
    match fields.0.len() {
        0 => Ok(message),
        extra => Err(BodyError::TrailingBytes { kind, extra }),
    }
}
