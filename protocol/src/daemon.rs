//! Messages of the connection itself (SPEC.md, section 5), and the one that only recordings have (section 8).
//!
//! Invariants: a released message is never changed. Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::Window;

/// The first message of a client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// What program it is, for logs.
    pub software: String,
    /// What it can do beyond its version; none in version 1.
    pub capabilities: Vec<String>,
}

/// The daemon's answer to [`Hello`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// What program it is.
    pub software: String,
    /// What it can do beyond its version; none in version 1.
    pub capabilities: Vec<String>,
    /// Differs each time the daemon is started.
    pub epoch: u64,
    /// The largest body that it reads, in bytes.
    pub largest_frame: u32,
    /// The largest number of points in one message.
    pub largest_batch: u32,
    /// How long it is silent on a subscription, in milliseconds.
    pub heartbeat_ms: u32,
    /// How long the other side may be silent, in milliseconds.
    pub timeout_ms: u32,
}

/// Are you there?
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ping {
    /// To be repeated.
    pub token: u64,
}

/// I am.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pong {
    /// That of the ping.
    pub token: u64,
}

/// The last message of whoever sends it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Goodbye {
    /// For people.
    pub reason: String,
    /// From the daemon: the last frame of each stream.
    pub streams: Vec<(String, u64)>,
}

/// Something could not be done. On the wire it is called `Error`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// One of [`ErrorCode`], or one that this version does not know.
    pub code: u16,
    /// Type of the message that this answers; 0 if none.
    pub answers: u16,
    /// For people: what was wrong, and what to do.
    pub text: String,
}

/// What [`Report::code`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum ErrorCode {
    /// The body cannot be read.
    Unreadable = 1,
    /// Not expected here, or not known.
    Unexpected = 2,
    /// The channel is not open.
    NoChannel = 3,
    /// The channel is in use.
    ChannelInUse = 4,
    /// Not a name, or not a pattern.
    BadName = 5,
    /// The stream is there with other options.
    OtherOptions = 6,
    /// The daemon has as many streams as it may have.
    TooManyStreams = 7,
    /// The connection has as many channels as it may have.
    TooManyChannels = 8,
    /// No such view, window or resolution.
    BadOptions = 9,
    /// More than a message may hold.
    TooLarge = 10,
    /// The stream has failed.
    StreamFailed = 11,
    /// The outer frame cannot be read; the connection ends.
    BadFrame = 12,
    /// The daemon has as many connections as it may have; this one ends.
    TooManyConnections = 13,
    /// The peer was silent, or half way through a frame, for too long; the connection ends.
    TooSlow = 14,
}

/// Asks which streams there are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ListStreams {
    /// Those whose names match.
    pub pattern: String,
}

/// Answers [`ListStreams`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Streams {
    /// By name.
    pub streams: Vec<StreamInfo>,
}

/// Asks how the daemon is. On the wire it is called `GetStatus`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatusWanted {}

/// How the daemon is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// What program it is.
    pub software: String,
    /// How long it runs, in milliseconds.
    pub uptime_ms: u64,
    /// As in [`Welcome`].
    pub epoch: u64,
    /// Open connections, this one among them.
    pub connections: u32,
    /// Messages that could not be read or were not expected.
    pub refused_messages: u64,
    /// Estimate of bytes held for streams.
    pub memory: u64,
    /// How many may be; 0 for no limit.
    pub memory_limit: u64,
    /// By name.
    pub streams: Vec<StreamStatus>,
}

/// A stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamInfo {
    /// Its number, as long as the daemon runs.
    pub stream: u32,
    /// Its name.
    pub name: String,
    /// Differs between streams of one name.
    pub epoch: u64,
    /// Which points stay.
    pub window: Window,
    /// Step of the grid that positions snap to.
    pub resolution: Option<f64>,
    /// The newest frame; 0 if there is none.
    pub frame: u64,
    /// Points in the window.
    pub points: u64,
    /// Distinct positions.
    pub vertices: u64,
    /// Channels that feed it.
    pub producers: u32,
    /// Channels that follow it.
    pub consumers: u32,
}

/// How a stream is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamStatus {
    /// What it is.
    pub info: StreamInfo,
    /// Skeletons computed.
    pub computed: u64,
    /// Points accepted.
    pub accepted: u64,
    /// Points refused.
    pub refused: u64,
    /// Points dropped by overload.
    pub dropped: u64,
    /// Points that wait for the engine.
    pub waiting: u64,
    /// Frames that consumers were not sent singly.
    pub lagged: u64,
    /// Estimate of bytes held.
    pub memory: u64,
}

/// Stands before a frame in a recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elapsed {
    /// Since the recording began.
    pub nanoseconds: u64,
}
