//! Messages, encoded once for any number of receivers.
//!
//! In: a message of the protocol. Out: its bytes, shared.
//!
//! Invariants: a message that cannot be encoded is logged.
//!
//! Must not know: who receives it.

use hopes_protocol as wire;

/// Encodes a message. Only one of more than 4 GiB has no encoding: a snapshot of hundreds of millions of points.
pub fn encoded(message: impl Into<wire::Message>) -> Option<wire::Shared> {
    wire::encode_shared(&message.into()).inspect_err(|error| tracing::error!("{error}")).ok()
}
