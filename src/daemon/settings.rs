//! The settings of a daemon: its streams, its limits, where peers connect.
//!
//! In: values that the caller has checked. Out: the same, shared by all threads.
//!
//! Invariants: settings never change while the daemon runs.
//!
//! Must not know: arguments, threads, sockets.

use std::num::NonZeroUsize;
use std::time::Duration;

use hopes::topology::TrackOptions;
use hopes_protocol as wire;

use super::address::Address;
use super::streams::pipeline::PipelineOptions;
use super::streams::queue::Overload;

/// The name of this software in the protocol.
pub const SOFTWARE: &str = concat!("hopes ", env!("CARGO_PKG_VERSION"));

/// The stream that stdin feeds and that stdout shows.
pub const DEFAULT_STREAM: &str = "default";

/// What a stream does.
#[derive(Clone, Copy, Debug, Default)]
pub struct StreamSettings {
    /// Which points stay.
    pub options: PipelineOptions,
    /// Close a frame after so many points.
    pub frame_points: Option<u64>,
    /// Close a frame each time so much time has passed.
    pub frame_every: Option<Duration>,
}

/// The daemon's limits.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Connections at one time.
    pub connections: usize,
    /// Channels of a connection.
    pub channels: usize,
    /// Streams at one time.
    pub streams: usize,
    /// Of them, those that one connection has made.
    pub peer_streams: usize,
    /// How long a stream stays that a peer has made, without producers and consumers; none for ever.
    pub stream_ttl: Option<Duration>,
    /// Distinct views of a stream.
    pub views: NonZeroUsize,
    /// Distinct views that one connection follows.
    pub peer_views: NonZeroUsize,
    /// Points in the window of a stream.
    pub points: u64,
    /// Distinct positions in a stream of the plane.
    pub vertices: u64,
    /// Distinct positions in a stream in a space that a peer has made. A frame costs their square.
    pub space_vertices: usize,
    /// Estimated bytes of all streams; 0 for no limit.
    pub memory: u64,
    /// Points that wait in the queue of a stream.
    pub waiting_points: usize,
    /// Points in one message.
    pub largest_batch: u32,
    /// Bytes in the body of one message of a peer.
    pub largest_frame: u32,
    /// Bytes that a consumer may be behind before frames are merged for it.
    pub consumer_queue: usize,
    /// Bytes of changes that each view keeps for consumers that are behind or come back.
    pub history: usize,
    /// The longest time in which nothing is sent to a consumer.
    pub heartbeat: Duration,
    /// The longest time in which a peer may send nothing, or take for one message.
    pub timeout: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 1024,
            channels: 256,
            streams: 256,
            peer_streams: 64,
            stream_ttl: None,
            views: const { NonZeroUsize::new(64).unwrap() },
            peer_views: const { NonZeroUsize::new(16).unwrap() },
            points: 100_000_000,
            vertices: 20_000_000,
            space_vertices: 4096,
            memory: 0,
            waiting_points: 1 << 16,
            largest_batch: 1 << 16,
            largest_frame: 1 << 22,
            consumer_queue: 1 << 20,
            history: 1 << 24,
            heartbeat: Duration::from_secs(5),
            timeout: Duration::from_secs(60),
        }
    }
}

/// What the daemon does.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The stream that stdin feeds.
    pub default_stream: StreamSettings,
    /// The view of it that stdout shows.
    pub view: wire::View,
    /// What is tracked in every stream, if anything.
    pub tracking: Option<TrackOptions>,
    /// Stop at the first thing on stdin that cannot be used.
    pub strict: bool,
    /// Recompute every frame from scratch, and stop at a difference.
    pub check: bool,
    /// Threads that reduce tiles; without a number, one per processor.
    pub threads: Option<NonZeroUsize>,
    /// What happens to producers that are faster than their stream.
    pub overload: Overload,
    /// The daemon's limits.
    pub limits: Limits,
    /// Where peers connect. Without any, the daemon ends with stdin.
    pub listen: Vec<Address>,
    /// Whether peers may come from other machines.
    pub allow_remote: bool,
    /// Streams that exist from the start.
    pub streams: Vec<(String, StreamSettings)>,
}
