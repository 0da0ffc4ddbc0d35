//! Bodies: fields in order, as bincode 2 writes them (SPEC.md, section 4). The only file that knows bincode.
//!
//! In: a wire type, or bytes. Out: bytes, or a wire type. Invariants: what is decoded takes memory in proportion to its bytes, whatever lengths they announce; a body ends
//! where its last field ends. Must not know: which types there are.
//!
//! bincode writes; [`Fields`] reads. Through serde bincode allocates what a length announces before it looks whether so much is there. Types come through serde and not
//! by bincode's own derive, so that the same definitions also give the JSON beside the golden vectors.

use std::sync::Arc;

use bincode::config::standard;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::fields::Fields;

/// Why a body is not what its type says.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum BodyError {
    /// A type of message that is not in this version.
    #[error("messages of type {kind:#06x} are not known in this version")]
    UnknownType {
        /// The type.
        kind: u16,
    },
    /// It ends too soon, or holds what cannot be.
    #[error("the body of a message of type {kind:#06x} cannot be read: {reason}")]
    Malformed {
        /// Type of the message.
        kind: u16,
        /// What is wrong.
        reason: String,
    },
    /// It goes on after its last field.
    #[error("the body of a message of type {kind:#06x} has {extra} bytes too many")]
    TrailingBytes {
        /// Type of the message.
        kind: u16,
        /// So many.
        extra: usize,
    },
    /// It does not fit into a frame.
    #[error("the body of a message of type {kind:#06x} has {length} bytes, more than a frame can hold")]
    TooLong {
        /// Type of the message.
        kind: u16,
        /// In bytes.
        length: usize,
    },
}

/// A body with its CRC, made once and sent to many: only the header before it differs.
#[derive(Clone, Debug)]
pub struct Shared {
    /// Type of the message.
    pub kind: u16,
    /// Length of the body alone.
    pub length: u32,
    /// The body and its CRC-32C.
    pub bytes: Arc<[u8]>,
}

/// A body and its CRC-32C.
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
