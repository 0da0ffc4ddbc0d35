//! Streams: an engine each, what it takes in and what it publishes.
//!
//! In: items of producers, requests of consumers. Out: replies, and frames that any number of cursors read.
//!
//! Must not know: sockets, connections.
//!
//! ```text
//! item ──▶ queue ──▶ engine ──▶ view log, track log, dots ──▶ cursor ──▶ message
//!                      ▲                                        │
//!                      └──────────────── request ───────────────┘
//! ```
//!
//! Replies go through a [`reply::ReplySink`], announcements of streams through a [`directory::StreamWatcher`]; both are
//! implemented by the side of the connection. Requests wait in a line of their own ([`requests`]), which bounds them.

pub mod consumer;
pub mod convert;
pub mod directory;
pub mod engine;
pub mod error;
pub mod frame_times;
pub mod input;
pub mod output;
pub mod pipeline;
pub mod publishing;
pub mod queue;
pub mod reply;
pub mod requests;
pub mod roster;
pub mod stream;
pub mod stream_state;
