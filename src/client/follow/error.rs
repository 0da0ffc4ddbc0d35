//! Why streams cannot be followed on.
//!
//! Must not know: how streams are followed, how messages are written.

use std::io;

use thiserror::Error;

use crate::client::ClientError;
use crate::client::mirrors::MirrorsError;
use crate::client::verify::Differs;
use crate::daemon::Address;

/// Why following ended before it should.
#[derive(Debug, Error)]
pub enum FollowError {
    /// The connection.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// No connection for too long.
    #[error("no connection for {seconds} s: {reason}")]
    Unreachable {
        /// For so long.
        seconds: u64,
        /// Why the last attempt failed.
        reason: ClientError,
    },
    /// Signals cannot be received.
    #[error("cannot listen to signals")]
    Signals(#[source] io::Error),
    /// The daemon reports an error.
    #[error("the daemon at {address}: {reason}")]
    Refused {
        /// Where it listens.
        address: Address,
        /// For people.
        reason: String,
    },
    /// A message that cannot be true.
    #[error("the daemon at {address} is wrong")]
    Wrong {
        /// Where it listens.
        address: Address,
        /// What is wrong.
        source: MirrorsError,
    },
    /// Gap after gap.
    #[error("{tries} subscriptions did not help: the daemon is wrong")]
    Gaps {
        /// So many subscriptions, one after the other.
        tries: u32,
        /// What is missing.
        source: MirrorsError,
    },
    /// A gap, where none is allowed.
    #[error("--check stops here")]
    Gap(#[source] MirrorsError),
    /// A frame that differs from what its vertices give.
    #[error("stream {stream}")]
    Differs {
        /// The name of the stream.
        stream: String,
        /// How.
        source: Differs,
    },
    /// The sink failed; a closed pipe is one of these.
    #[error("cannot write frames")]
    Write(#[source] io::Error),
}
