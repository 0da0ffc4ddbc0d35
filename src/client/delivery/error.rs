//! Why points cannot be delivered.
//!
//! Must not know: how points are sent, what they were read from.

use std::io;

use thiserror::Error;

use crate::client::ClientError;
use crate::daemon::{Address, StrictStop};

/// Why a delivery ended before all was answered.
#[derive(Debug, Error)]
pub enum DeliveryError {
    /// The connection.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// Under `strict`.
    #[error(transparent)]
    Strict(#[from] StrictStop),
    /// Signals cannot be received.
    #[error("cannot listen to signals")]
    Signals(#[source] io::Error),
    /// The system gave no thread for answers.
    #[error("cannot start a thread")]
    Thread(#[source] io::Error),
    /// The system gave no thread for the reader.
    #[error("cannot start the reader's thread")]
    Reader(#[source] io::Error),
    /// The input cannot be read on.
    #[error("cannot read the input: {0}")]
    Input(String),
    /// The stream cannot be opened.
    #[error("the daemon at {address} does not open stream {stream}: {reason}")]
    NotOpened {
        /// Where the daemon listens.
        address: Address,
        /// The name of the stream.
        stream: String,
        /// For people.
        reason: String,
    },
    /// The daemon left before the stream was open.
    #[error("the daemon at {address} says goodbye: {reason}")]
    GoodbyeAtOnce {
        /// Where the daemon listens.
        address: Address,
        /// For people.
        reason: String,
    },
    /// The daemon left before all was answered.
    #[error("the daemon says goodbye: {reason}; {unanswered} messages are not answered")]
    Goodbye {
        /// For people.
        reason: String,
        /// Messages without an answer.
        unanswered: usize,
    },
    /// A signal came, and the answers did not.
    #[error(
        "the daemon has not answered within {seconds} s after the signal: {points} points may not be in the stream"
    )]
    Unanswered {
        /// For so long.
        seconds: u64,
        /// So many that were sent.
        points: u64,
    },
    /// The input has ended, and nothing of it could be used.
    #[error("nothing of the input could be used, {rejected} times: see hopes help feed")]
    NothingUsable {
        /// How often something could not be used.
        rejected: u64,
    },
    /// Another producer ended the stream.
    #[error("another producer has ended the stream, after frame {frame}")]
    Ended {
        /// Its last.
        frame: u64,
    },
    /// The daemon reports an error.
    #[error("the daemon refuses: {0}")]
    Refused(String),
    /// An answer to nothing.
    #[error("the daemon answers message {sequence}, which does not wait for an answer")]
    NotAsked {
        /// The number of the message.
        sequence: u64,
    },
    /// An answer of a kind that the message does not have.
    #[error("the daemon answers with {answer} to something else")]
    OtherAnswer {
        /// The type of the answer.
        answer: &'static str,
    },
    /// No answer at all.
    #[error("the daemon answers with a message of type {kind:#06x}")]
    NoAnswer {
        /// The type of the message.
        kind: u16,
    },
}
