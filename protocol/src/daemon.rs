//! Messages of the connection itself (SPEC.md, section 5), and one that occurs only in recordings (section 8).
//!
//! Invariants: a released message never changes. Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::Window;

/// The first message of a client.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// The name of the client program, for logs.
    pub software: String,
    /// What the client supports beyond its version. Empty in version 1.
    pub capabilities: Vec<String>,
}

/// The daemon's answer to [`Hello`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// The name of the daemon program.
    pub software: String,
    /// What the daemon supports beyond its version. Empty in version 1.
    pub capabilities: Vec<String>,
    /// Differs each time the daemon is started.
    pub epoch: u64,
    /// The largest body that the daemon reads, in bytes.
    pub largest_frame: u32,
    /// The largest number of points in one message.
    pub largest_batch: u32,
    /// The longest time between two messages on a subscription, in milliseconds.
    pub heartbeat_ms: u32,
    /// A peer that sends nothing for this number of milliseconds is disconnected.
    pub timeout_ms: u32,
}

/// Asks the other side whether it is alive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ping {
    /// Any number. The answer repeats it.
    pub token: u64,
}

/// Answers [`Ping`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pong {
    /// The token of the ping.
    pub token: u64,
}

/// The last message that a side sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Goodbye {
    /// The reason, for people.
    pub reason: String,
    /// From the daemon: the last frame of each stream.
    pub streams: Vec<(String, u64)>,
}

/// A message could not be handled. On the wire it is called `Error`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// One of [`ErrorCode`], or a code that this version does not know.
    pub code: u16,
    /// The type of the message that caused the error. 0: none did.
    pub answers: u16,
    /// What was wrong and what to do, for people.
    pub text: String,
}

/// The values of [`Report::code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum ErrorCode {
    /// The body cannot be read.
    Unreadable = 1,
    /// The message is not expected here, or its type is unknown.
    Unexpected = 2,
    /// The channel is not open.
    NoChannel = 3,
    /// The channel is in use.
    ChannelInUse = 4,
    /// Not a valid name or pattern.
    BadName = 5,
    /// The stream exists with other options.
    OtherOptions = 6,
    /// The daemon has reached its limit of streams.
    TooManyStreams = 7,
    /// The connection has reached its limit of channels.
    TooManyChannels = 8,
    /// An invalid view, window or resolution.
    BadOptions = 9,
    /// The message holds more than is allowed.
    TooLarge = 10,
    /// The stream has failed.
    StreamFailed = 11,
    /// The frame cannot be read. The connection ends.
    BadFrame = 12,
    /// The daemon has reached its limit of connections. This one ends.
    TooManyConnections = 13,
    /// The peer sent nothing, or an incomplete frame, for too long. The connection ends.
    TooSlow = 14,
    /// The stream, or the peer, follows as many distinct views as it may.
    TooManyViews = 15,
    /// The daemon has reached its limit of memory. It takes no new reader.
    NoMemory = 16,
    /// There is no stream of this name.
    NoStream = 17,
    /// There is no peer of this number.
    NoPeer = 18,
    /// The stream is of another space than the message: of the plane, or of R^d.
    OtherSpace = 19,
    /// The stream is of points in R^d, which the agreed version does not have.
    NeedsVersion = 20,
}

/// Asks for a list of streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ListStreams {
    /// Streams whose names match are listed.
    pub pattern: String,
}

/// Answers [`ListStreams`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Streams {
    /// The streams, by name.
    pub streams: Vec<StreamInfo>,
}

/// Asks for the daemon's status. On the wire it is called `GetStatus`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StatusWanted {}

/// The daemon's status.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The name of the daemon program.
    pub software: String,
    /// The time since the daemon was started, in milliseconds.
    pub uptime_ms: u64,
    /// As in [`Welcome`].
    pub epoch: u64,
    /// Open connections, this one among them.
    pub connections: u32,
    /// Messages that could not be read or were not expected.
    pub refused_messages: u64,
    /// Estimated memory of all streams, in bytes.
    pub memory: u64,
    /// The limit of that memory, in bytes. 0: no limit.
    pub memory_limit: u64,
    /// The streams, by name.
    pub streams: Vec<StreamStatus>,
}

/// A stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamInfo {
    /// The stream's number. It is not used again as long as the daemon runs.
    pub stream: u32,
    /// The stream's name.
    pub name: String,
    /// Differs between streams that had the same name.
    pub epoch: u64,
    /// Which points are kept.
    pub window: Window,
    /// The step of the grid to which positions are snapped.
    pub resolution: Option<f64>,
    /// The newest frame; 0 if there is none.
    pub frame: u64,
    /// Points in the window.
    pub points: u64,
    /// Distinct positions.
    pub vertices: u64,
    /// Channels of its producers.
    pub producers: u32,
    /// Channels of its consumers.
    pub consumers: u32,
}

/// The status of a stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamStatus {
    /// The stream.
    pub info: StreamInfo,
    /// Skeletons computed.
    pub computed: u64,
    /// Points accepted.
    pub accepted: u64,
    /// Points refused.
    pub refused: u64,
    /// Points dropped by overload.
    pub dropped: u64,
    /// Points in the queue of the engine.
    pub waiting: u64,
    /// Frames that were not sent one by one to lagging consumers.
    pub lagged: u64,
    /// Estimated memory of the stream, in bytes.
    pub memory: u64,
}

/// In a recording: the time at which the next frame was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elapsed {
    /// Nanoseconds since the recording began.
    pub nanoseconds: u64,
}
