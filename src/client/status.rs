//! Asking a daemon for its numbers.
//!
//! In: an address.
//! Out: the daemon's answer, or why there is none.
//! Must not know: how the numbers are shown.

use hopes_protocol::{Message, Status, StatusWanted};
use thiserror::Error;

use super::connection::{Client, SOFTWARE, Timeouts};
use super::error::ClientError;
use crate::daemon::Address;

/// The channel of the question.
const CHANNEL: u32 = 1;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum StatusError {
    /// The connection.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// The daemon reports an error.
    #[error("the daemon at {address}: {reason}")]
    Refused {
        /// Where it listens.
        address: Address,
        /// For people.
        reason: String,
    },
    /// The daemon ends.
    #[error("the daemon at {address} says goodbye instead: {reason}")]
    Goodbye {
        /// Where it listens.
        address: Address,
        /// For people.
        reason: String,
    },
    /// The connection was closed without an answer.
    #[error("the daemon at {address} closed the connection instead of answering: see its log")]
    Closed {
        /// Where it listens.
        address: Address,
    },
}

/// Asks, and waits for the answer.
///
/// # Errors
/// [`StatusError`].
pub fn ask(address: &Address) -> Result<Status, StatusError> {
    let mut client = Client::connect(address, SOFTWARE, Timeouts::default())?;
    client.sending.send(CHANNEL, StatusWanted {})?;
    let address = || address.clone();
    loop {
        match client.receiving.receive()? {
            Some((CHANNEL, Message::Status(status))) => {
                client.receiving.goodbye("that is all");
                return Ok(status);
            }
            Some((_, Message::Error(report))) => {
                return Err(StatusError::Refused { address: address(), reason: report.text });
            }
            Some((_, Message::Goodbye(goodbye))) => {
                return Err(StatusError::Goodbye { address: address(), reason: goodbye.reason });
            }
            Some(_) => {}
            None => return Err(StatusError::Closed { address: address() }),
        }
    }
}
