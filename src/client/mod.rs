//! A client of a daemon: connecting, sending points, following streams.
//!
//! In: an address; points to send, or the streams to follow. Out: answers; proved frames.
//! Invariants: nothing waits for ever; a frame that is handed on was proved by its checksum.
//! Must not know: arguments, how frames are shown.

pub mod connection;
pub mod delivery;
mod error;
pub mod follow;
mod link;
pub mod mirrors;
pub mod pace;
pub mod verify;

pub use connection::{Client, Timeouts};
pub use error::ClientError;
