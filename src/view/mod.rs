//! The live page of a daemon, and its other HTTP resources.
//!
//! ```text
//!             ┌─▶ routes ─▶ assets, metrics, snapshot ─▶ one response, then the connection is closed
//! listener ───┼─▶ websocket (framing) ─▶ a read-only connection of the daemon
//!             └─▶ events ──────────────▶ a read-only connection of the daemon
//! ```
//!
//! In: connections.
//! Out: the page and its files, `/healthz`, `/metrics`, `/api/streams`, `/api/streams/NAME/snapshot`; at
//! `/api/streams/NAME/frames` frames as server-sent events; at `/ws` the protocol itself, byte by byte.
//! Invariants: no request changes anything. Requests that the page of another site causes are refused, or that page
//! cannot read the response. A client that sends anything, or does not read, costs one thread and a bounded buffer.
//! Must not know: engines, geometry.

mod assets;
mod documents;
mod events;
mod flat;
mod framing;
mod http;
mod listener;
mod metrics;
mod names;
mod permits;
mod query;
mod routes;
mod snapshot;
mod websocket;

pub use listener::{Page, PageAddress};
