//! Messages between a producer and the daemon (SPEC.md, section 6).
//!
//! Invariants: a released message is never changed. Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::Window;

/// How many refusals [`Refused::reasons`] lists at the most.
pub const LISTED_REFUSALS: usize = 1000;

/// Joins a stream, or creates it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Open {
    /// Its name.
    pub name: String,
    /// Which points stay; none: as it is, or all.
    pub window: Option<Window>,
    /// Step of the grid that positions snap to; none: as it is, or no grid.
    pub resolution: Option<f64>,
}

/// Answers [`Open`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opened {
    /// The stream's number.
    pub stream: u32,
    /// Differs between streams of one name.
    pub epoch: u64,
    /// Whether it was not there before.
    pub created: bool,
    /// Which points stay.
    pub window: Window,
    /// Step of the grid that positions snap to.
    pub resolution: Option<f64>,
    /// The newest frame; 0 if there is none.
    pub frame: u64,
    /// The largest number of points in one message to this stream.
    pub largest_batch: u32,
}

/// Points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// The producer's number for this message.
    pub sequence: u64,
    /// Where.
    pub points: Vec<(f64, f64)>,
    /// When: nothing, or one for each point.
    pub times: Vec<f64>,
    /// The producer's own numbers: nothing, or one for each point.
    pub tags: Vec<u64>,
}

/// Points to take back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Retract {
    /// The producer's number for this message.
    pub sequence: u64,
    /// The oldest point at each of these positions.
    pub points: Vec<(f64, f64)>,
}

/// Closes a frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Commit {
    /// The producer's number for this message.
    pub sequence: u64,
    /// What it shall carry.
    pub time: Option<f64>,
}

/// Ends the channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Close {
    /// And the stream, for everybody.
    pub end: bool,
}

/// The channel has ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closed {
    /// The stream's last frame.
    pub frame: u64,
}

/// All points of a message were taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accepted {
    /// Of the message.
    pub sequence: u64,
    /// How many.
    pub points: u32,
    /// If there were tags: tag and vertex of each point.
    pub placed: Vec<(u64, u64)>,
}

/// Some points of a message were not taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refused {
    /// Of the message.
    pub sequence: u64,
    /// How many were taken.
    pub accepted: u32,
    /// How many were not.
    pub refused: u32,
    /// Why; the first [`LISTED_REFUSALS`].
    pub reasons: Vec<Refusal>,
    /// If there were tags: tag and vertex of each point that was taken.
    pub placed: Vec<(u64, u64)>,
}

/// Why a point was not taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// Its place in the message.
    pub index: u32,
    /// One of [`RefusalCode`], or one that this version does not know.
    pub code: u16,
    /// For people.
    pub text: String,
}

/// What [`Refusal::code`] says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum RefusalCode {
    /// A coordinate is not finite, or out of range.
    Coordinate = 1,
    /// No event time, in a time window.
    NoTime = 2,
    /// An event time that is not finite.
    TimeNotFinite = 3,
    /// Too late for the time window.
    TooLate = 4,
    /// Nothing there to retract.
    NotThere = 5,
    /// The stream may hold no more.
    StreamFull = 6,
    /// The daemon may hold no more.
    DaemonFull = 7,
}

/// A frame was closed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Committed {
    /// Of the message.
    pub sequence: u64,
    /// The frame's number.
    pub frame: u64,
}

/// A message was dropped, since the stream did not keep up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Overloaded {
    /// Of the message.
    pub sequence: u64,
    /// Points in it.
    pub points: u32,
    /// Points dropped on this channel so far.
    pub total: u64,
    /// Why this one.
    pub policy: Policy,
}

/// What is dropped when a stream does not keep up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Policy {
    /// What has waited longest.
    DropOldest,
    /// What comes.
    DropNewest,
}
