//! Connections: peers on sockets, each with a reader and a writer thread.
//!
//! In: bytes of peers. Out: items and requests for streams; bytes to peers.
//!
//! ```text
//! socket ──▶ reader ──(items)──▶ queue of a stream
//! socket ◀── writer ◀──(replies)── outbox
//!                   ◀──(frames)─── cursors in streams
//! ```
//!
//! Invariants: the reader thread waits for nobody but the stream that it feeds and its own outbox, the writer thread
//! for nobody but the socket. No thread of another connection or stream waits for either.
//! Must not know: what streams compute.

mod administration;
pub mod connection;
pub mod control_pace;
pub mod listener;
pub mod members;
pub mod outbox;
pub mod producer;
pub mod reader;
pub mod registry;
mod session;
pub mod socket;
mod space_points;
pub mod subscription;
mod writer;
