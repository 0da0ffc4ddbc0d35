//! Asking a daemon for its numbers and its peers, and telling it to end a stream or a connection.
//!
//! In: an address, and requests.
//! Out: the daemon's answers, or why there is none.
//! Invariants: one request at a time. A daemon that is too old for a request is sent nothing.
//! Must not know: how answers are shown.

use hopes_protocol::{
    Disconnect, Disconnected, GetMemory, ListPeers, ListSpaces, Memory, Message, Peers, Spaces, Status, StatusWanted,
    StopStream, StreamStopped,
};
use thiserror::Error;

use super::connection::{Client, SOFTWARE, Timeouts};
use super::error::ClientError;
use crate::daemon::Address;

/// The channel of every request. It is free again once the answer has come.
const CHANNEL: u32 = 1;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum AdminError {
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
    /// The answer is that of another request.
    #[error("the daemon at {address} answers with a message of type {kind:#06x}; update the older of the two")]
    Wrong {
        /// Where it listens.
        address: Address,
        /// The type of the message.
        kind: u16,
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

/// A connection on which a daemon is asked.
#[derive(Debug)]
pub struct Admin {
    address: Address,
    client: Client,
}

impl Admin {
    /// Connects and greets.
    ///
    /// # Errors
    /// [`AdminError::Client`].
    pub fn connect(address: &Address) -> Result<Self, AdminError> {
        let client = Client::connect(address, SOFTWARE, Timeouts::default())?;
        Ok(Self { address: address.clone(), client })
    }

    /// How the daemon is, and its streams.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn status(&mut self) -> Result<Status, AdminError> {
        self.ask(StatusWanted {}, |answer| if let Message::Status(status) = answer { Some(status) } else { None })
    }

    /// Who is connected.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn peers(&mut self) -> Result<Peers, AdminError> {
        self.ask(ListPeers {}, |answer| if let Message::Peers(peers) = answer { Some(peers) } else { None })
    }

    /// What the daemon's memory is used for.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn memory(&mut self) -> Result<Memory, AdminError> {
        self.ask(GetMemory {}, |answer| if let Message::Memory(memory) = answer { Some(memory) } else { None })
    }

    /// The metric and dimension of each stream of points in R^d.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn spaces(&mut self) -> Result<Spaces, AdminError> {
        self.ask(ListSpaces {}, |answer| if let Message::Spaces(spaces) = answer { Some(spaces) } else { None })
    }

    /// Ends a stream, for all its peers.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn stop_stream(&mut self, name: &str) -> Result<StreamStopped, AdminError> {
        let request = StopStream { name: name.to_owned() };
        self.ask(request, |answer| if let Message::StreamStopped(last) = answer { Some(last) } else { None })
    }

    /// Ends the connection of a peer.
    ///
    /// # Errors
    /// [`AdminError`].
    pub fn disconnect(&mut self, peer: u64) -> Result<Disconnected, AdminError> {
        let request = Disconnect { peer };
        self.ask(request, |answer| if let Message::Disconnected(peer) = answer { Some(peer) } else { None })
    }

    /// Ends the connection in good order.
    pub fn end(self) {
        self.client.receiving.goodbye("that is all");
    }

    /// Asks, and waits for the answer. `take` gives none for another message.
    fn ask<T>(
        &mut self,
        request: impl Into<Message>,
        take: impl FnOnce(Message) -> Option<T>,
    ) -> Result<T, AdminError> {
        self.client.sending.send(CHANNEL, request)?;
        let answer = self.answer()?;
        let kind = answer.kind();
        take(answer).ok_or_else(|| AdminError::Wrong { address: self.address.clone(), kind })
    }

    /// The next message on the channel of requests that is no error.
    fn answer(&mut self) -> Result<Message, AdminError> {
        loop {
            let next = self.client.receiving.receive()?;
            let address = || self.address.clone();
            match next {
                Some((_, Message::Error(report))) => {
                    return Err(AdminError::Refused { address: address(), reason: report.text });
                }
                Some((_, Message::Goodbye(goodbye))) => {
                    return Err(AdminError::Goodbye { address: address(), reason: goodbye.reason });
                }
                Some((CHANNEL, answer)) => return Ok(answer),
                Some(_) => {}
                None => return Err(AdminError::Closed { address: address() }),
            }
        }
    }
}
