//! The daemon: streams with an engine each, producers that feed them, consumers that follow them.
//!
//! In: points from stdin and from producers, settings. Out: frames to stdout and to consumers.
//!
//! ```text
//! stdin ──▶ reader ──┐                                        ┌──▶ output ──▶ writer ──▶ stdout
//!                    ├──▶ queue ──▶ engine ──▶ published frames┤
//! peer ───▶ reader ──┘                                        └──▶ cursor ──▶ writer ──▶ peer
//! ```
//!
//! Data flows one way: connection, queue, engine, published frames, cursor, connection. Threads are joined by bounded
//! queues. Only producers wait: for their own stream, or for the reader of stdout; nobody waits for a consumer on a
//! socket. A request to end finishes what was taken in, writes it and sends it, and waits for nobody for long. Threads
//! are named, and joined.
//!
//! Rooms: `streams` (engines, what they take in and publish) knows no connection; `connections` (sockets, readers,
//! writers) knows streams; [`HttpAccess`] is what the live page may use; `governor` ends what nobody uses and keeps
//! memory within its limit; `run` starts and ends all of them.
//!
//! # Locks
//!
//! A thread takes locks in this order, and waits for nothing while it holds one; [`Level`] has the same list, and debug
//! builds panic where it is broken.
//!
//! | lock | guards | taken under it |
//! | --- | --- | --- |
//! | `Directory` | watchers, engine threads | `Roster`, `Queue` |
//! | `Members` | the list of connections | |
//! | `Roster` | streams by name | |
//! | `Producers` | who feeds a stream | `Queue`, `Outbox` |
//! | `Queue` | what waits for an engine | |
//! | `Cursors` | the cursors of a connection | `Wanted`, `Requests`, `Cursor`, `Published` |
//! | `Wanted` | what a subscription wants | `Requests` |
//! | `Requests` | what consumers want of an engine | |
//! | `Cursor` | a consumer's position | `Published` |
//! | `Published` | logs of views and tracks, dots | |
//! | `Outbox` | answers to a peer | |
//! | `Transport`, `Leaf` | single values | |
//!
//! An engine takes `Requests`, `Cursor`, `Published` and `Outbox`, one after another. What it is sent waits in lines
//! that never make a sender of requests wait, so a connection may send under `Cursors`, and an engine that ends may
//! take `Cursors`.
//!
//! # Memory
//!
//! What is allocated for a stream or a peer is charged to its [`Account`] there and then. At the limit the
//! governor has history dropped first, then cuts off the peers for which most is held, then ends streams that nobody
//! uses. New consumers are refused before that, and points only when points alone take all that there may be.
//!
//! Must not know: how inputs are parsed, how frames are written, pictures.

mod address;
mod connections;
mod encoding;
mod error;
mod governor;
mod http_access;
mod input_errors;
mod locks;
mod log_limits;
mod memory;
mod report;
mod run;
mod settings;
mod signals;
mod stop;
mod streams;

pub use address::{Address, AddressError};
pub use connections::listener::{ListenError, bind_tcp};
pub use connections::socket::{Socket, Transport};
pub use error::DaemonError;
pub use http_access::{HttpAccess, SnapshotError, StartHttp, StopHttp};
pub use input_errors::{InputErrors, StrictStop};
pub use locks::{Level, Lock};
pub use memory::{Account, Charge, Charged};
pub use run::{Feed, Sink, Source, run};
pub use settings::{DEFAULT_STREAM, Limits, SOFTWARE, Settings, StreamSettings};
pub use stop::{Stop, Stopper};
pub use streams::convert::{cut, metric, spec, wire_metric, wire_window};
pub use streams::frame_times::FrameTimes;
pub use streams::input::{BATCH, Batch, Input, Point, Positions};
pub use streams::output::OutputFrame;
pub use streams::pipeline::{PipelineOptions, SpaceRule};
pub use streams::queue::Overload;
pub use streams::stream_state::Measured;
