//! A client of a daemon: connecting, sending points, following streams, asking for numbers, ending what is too much.
//!
//! In: an address; points to send, or the streams to follow.
//! Out: outcomes; proved frames.
//! Invariants: nothing waits for ever; a frame that is handed on is proved by its checksum.
//! Must not know: arguments, how frames are shown.

pub mod admin;
mod chain;
pub mod connection;
pub mod delivery;
mod error;
pub mod follow;
mod link;
pub mod mirrors;
pub mod pace;
mod running;
pub mod verify;

pub use chain::Chain;
pub use connection::{Client, SOFTWARE, Timeouts};
pub use error::ClientError;
