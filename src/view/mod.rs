//! The live page of a daemon: a place for browsers, and for whatever else reads HTTP.
//!
//! ```text
//!            ┌─▶ routes ─▶ assets, metrics, snapshot ─▶ answer, and that is all
//! listener ──┤
//!            └─▶ websocket ─▶ a peer of the daemon, who may only read
//! ```
//!
//! In: connections. Out: the page and its files, `/healthz`, `/metrics`, `/api/streams`, `/api/streams/NAME/snapshot`;
//! at `/ws` the protocol itself, byte by byte. Invariants: nobody changes anything here; what another site's page asks
//! for in a visitor's name is refused or stays unreadable for it; whatever is sent, or not read, costs one thread and
//! a bounded buffer. Must not know: engines, geometry.

mod assets;
mod framing;
mod http;
mod listener;
mod metrics;
mod routes;
mod snapshot;
mod websocket;

pub use listener::{Page, Place};
