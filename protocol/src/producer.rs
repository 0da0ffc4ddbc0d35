//! Messages between a producer and the daemon (SPEC.md, section 6).
//!
//! Invariants: a released message never changes. Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::Window;

/// The largest number of refusals that [`Refused::reasons`] lists.
pub const LISTED_REFUSALS: usize = 1000;

/// Joins a stream, or creates it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Open {
    /// The stream's name.
    pub name: String,
    /// Which points are kept. None: the stream's own window; for a new stream, all points.
    pub window: Option<Window>,
    /// The step of the grid to which positions are snapped. None: the stream's own; for a new stream, no grid.
    pub resolution: Option<f64>,
}

/// Answers [`Open`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opened {
    /// The stream's number.
    pub stream: u32,
    /// Differs between streams that had the same name.
    pub epoch: u64,
    /// Whether the stream is new.
    pub created: bool,
    /// Which points are kept.
    pub window: Window,
    /// The step of the grid to which positions are snapped.
    pub resolution: Option<f64>,
    /// The newest frame; 0 if there is none.
    pub frame: u64,
    /// The largest number of points in one message to this stream.
    pub largest_batch: u32,
}

/// Points to add.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// The producer's number for this message.
    pub sequence: u64,
    /// The positions.
    pub points: Vec<(f64, f64)>,
    /// The event times: none, or one for each point.
    pub times: Vec<f64>,
    /// The producer's own numbers of the points: none, or one for each point.
    pub tags: Vec<u64>,
}

/// Points to remove.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Retract {
    /// The producer's number for this message.
    pub sequence: u64,
    /// At each of these positions the oldest point is removed.
    pub points: Vec<(f64, f64)>,
}

/// Closes a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commit {
    /// The producer's number for this message.
    pub sequence: u64,
    /// The frame's time.
    pub time: Option<f64>,
}

/// Closes the channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Close {
    /// Whether to end the stream too, for all producers and consumers.
    pub end: bool,
}

/// Answers [`Close`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closed {
    /// The stream's last frame.
    pub frame: u64,
}

/// All points of a message were accepted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// The sequence number of the message.
    pub sequence: u64,
    /// The number of points.
    pub points: u32,
    /// If the points had tags: tag and vertex of each point.
    pub placed: Vec<(u64, u64)>,
}

/// Some points of a message were refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// The sequence number of the message.
    pub sequence: u64,
    /// The number of accepted points.
    pub accepted: u32,
    /// The number of refused points.
    pub refused: u32,
    /// The reasons of the first [`LISTED_REFUSALS`] refusals.
    pub reasons: Vec<Refusal>,
    /// If the points had tags: tag and vertex of each accepted point.
    pub placed: Vec<(u64, u64)>,
}

/// Why a point was refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// The index of the point in the message.
    pub index: u32,
    /// One of [`RefusalCode`], or a code that this version does not know.
    pub code: u16,
    /// The reason, for people.
    pub text: String,
}

/// The values of [`Refusal::code`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum RefusalCode {
    /// A coordinate is not finite, or out of range.
    Coordinate = 1,
    /// The point has no event time, but the stream has a time window.
    NoTime = 2,
    /// The event time is not finite.
    TimeNotFinite = 3,
    /// The event time is too old for the time window.
    TooLate = 4,
    /// There is no point to remove at this position.
    NotThere = 5,
    /// The stream has reached its limit of points.
    StreamFull = 6,
    /// The daemon has reached its limit of memory.
    DaemonFull = 7,
}

/// Answers [`Commit`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Committed {
    /// The sequence number of the message.
    pub sequence: u64,
    /// The frame's number.
    pub frame: u64,
}

/// A message was dropped, since the engine did not keep up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overloaded {
    /// The sequence number of the message.
    pub sequence: u64,
    /// The number of points in it.
    pub points: u32,
    /// Points dropped on this channel so far.
    pub total: u64,
    /// The policy that dropped it.
    pub policy: Policy,
}

/// Which message is dropped when the engine does not keep up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Policy {
    /// The one that has waited longest.
    DropOldest,
    /// The one that arrives.
    DropNewest,
}
