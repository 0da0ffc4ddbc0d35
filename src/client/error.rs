//! Why a connection to a daemon does not begin or does not go on.
//!
//! Invariants: every message names the address, and the remedy where there is one. An error of the socket is told
//! as text and is never a source: a connection that breaks is not the closed pipe behind stdout that is no error.
//! Must not know: what the messages of the connection are about.

use std::io;

use hopes_protocol::{BodyError, FrameError, NoCommonVersion};
use thiserror::Error;

use crate::daemon::Address;

/// What a client cannot go on from.
#[derive(Debug, Error)]
pub enum ClientError {
    /// It is too old for the message.
    #[error("the daemon at {address} speaks protocol version {spoken}, and this needs version {needed}: update it")]
    Older {
        /// Where it listens.
        address: Address,
        /// The version agreed on.
        spoken: u16,
        /// The first that has it.
        needed: u16,
    },
    /// No daemon answers there.
    #[error("cannot connect to {address}: {reason}; start a daemon there with: hopes serve --listen {address}")]
    Connect {
        /// Where.
        address: Address,
        /// What the system says.
        reason: String,
    },
    /// The daemon is too old or too new.
    #[error("cannot talk to the daemon at {address}")]
    Versions {
        /// Where.
        address: Address,
        /// What either side speaks.
        source: NoCommonVersion,
    },
    /// Something else listens there.
    #[error("what listens at {address} is no hopes daemon: {reason}; check the address")]
    NotHopes {
        /// Where.
        address: Address,
        /// What is wrong with what it says.
        reason: FrameError,
    },
    /// It did not answer the greeting in time.
    #[error(
        "what listens at {address} has not greeted within {seconds} s: \
         check the address, or try again when the daemon is less busy"
    )]
    Mute {
        /// Where.
        address: Address,
        /// For so long.
        seconds: f64,
    },
    /// The daemon does not want this connection.
    #[error("the daemon at {address} refuses the connection: {reason}")]
    Rejected {
        /// Where.
        address: Address,
        /// For people.
        reason: String,
    },
    /// It closed the connection where more was due.
    #[error("the daemon at {address} closed the connection {when}: see its log, and try again")]
    Closed {
        /// Where.
        address: Address,
        /// In the middle of what.
        when: &'static str,
    },
    /// It has sent nothing for too long.
    #[error("the daemon at {address} has been silent for {seconds} s: see whether it is still there, and try again")]
    Silent {
        /// Where.
        address: Address,
        /// For so long.
        seconds: f64,
    },
    /// It closed the connection because this program did not answer.
    #[error(
        "the daemon at {address} has ended the connection, since this program was stopped or blocked for {stopped:.1} \
         s and the daemon waits no longer than {timeout} s: try again, or start the daemon with a longer --timeout"
    )]
    StoodStill {
        /// Where it listens.
        address: Address,
        /// For so many seconds.
        stopped: f64,
        /// The daemon's timeout, in seconds.
        timeout: f64,
    },
    /// The system ended it.
    #[error("the connection to {address} is lost: {reason}; see whether the daemon is still there, and try again")]
    Lost {
        /// Where.
        address: Address,
        /// What the system says.
        reason: String,
    },
    /// What came is no frame.
    #[error("the daemon at {address} sent what cannot be read; try again, and report it if it happens again")]
    Frame {
        /// Where.
        address: Address,
        /// What is wrong with it.
        source: FrameError,
    },
    /// What came is no message.
    #[error("the daemon at {address} sent what cannot be understood; update the older of the two")]
    Body {
        /// Where.
        address: Address,
        /// What is wrong with it.
        source: BodyError,
    },
    /// What is to be sent does not fit into a frame.
    #[error("a message to {address} is too long; send fewer points together")]
    TooLong {
        /// Where to.
        address: Address,
        /// How long it is.
        source: BodyError,
    },
}

impl ClientError {
    /// The connection broke.
    pub(super) fn lost(address: &Address, reason: &io::Error) -> Self {
        Self::Lost { address: address.clone(), reason: reason.to_string() }
    }
}
