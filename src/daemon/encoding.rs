//! Messages, encoded once for any number of receivers.
//!
//! In: a message of the protocol, the account that its bytes are charged to. Out: its bytes, shared.
//!
//! Invariants: the bytes are charged as long as anybody holds them, once. A message that cannot be encoded is logged.
//!
//! Must not know: who receives it.

use std::ops::Deref;
use std::sync::Arc;

use hopes_protocol as wire;

use super::memory::{Account, Charge};

/// An encoded message.
#[derive(Clone, Debug)]
pub struct Encoded {
    message: wire::Shared,
    /// Held for its drop.
    _charge: Arc<Charge>,
}

impl Deref for Encoded {
    type Target = wire::Shared;

    fn deref(&self) -> &wire::Shared {
        &self.message
    }
}

impl Encoded {
    /// Bytes that are encoded already.
    pub fn new(message: wire::Shared, account: &Arc<Account>) -> Self {
        let charge = Arc::new(account.charge(message.bytes.len() + size_of::<Self>()));
        Self { message, _charge: charge }
    }

    /// The bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.message.bytes.len() + size_of::<Self>()
    }
}

/// Encodes a message. Only one of more than 4 GiB has no encoding: a snapshot of hundreds of millions of points.
pub fn encoded(message: impl Into<wire::Message>, account: &Arc<Account>) -> Option<Encoded> {
    let message = wire::encode_shared(&message.into()).inspect_err(|error| tracing::error!("{error}")).ok()?;
    Some(Encoded::new(message, account))
}
