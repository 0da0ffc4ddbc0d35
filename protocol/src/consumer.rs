//! Messages between a consumer and the daemon (SPEC.md, section 7).
//!
//! Invariants: a released message never changes. All lists of a skeleton are sorted by id, or by both ends, and have no
//! duplicates.
//!
//! Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::{Critical, Dot, DotsWanted, Edge, FrameInfo, Vertex, View, Window};

/// Subscribes to streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subscribe {
    /// Streams whose names match are followed, now or later.
    pub pattern: String,
    /// The part of the skeleton to send.
    pub view: View,
    /// The part of the persistence diagram to send.
    pub dots: DotsWanted,
    /// Where to resume after a lost connection.
    pub resume: Option<Resume>,
}

/// The position at which a consumer resumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resume {
    /// The stream's epoch.
    pub epoch: u64,
    /// The last frame that the consumer has.
    pub frame: u64,
}

/// Changes the view of a subscription from the next frame on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChangeView {
    /// The part of the skeleton to send.
    pub view: View,
    /// The part of the persistence diagram to send.
    pub dots: DotsWanted,
}

/// Ends a subscription.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unsubscribe {}

/// Answers [`Unsubscribe`]: nothing more comes on this channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unsubscribed {}

/// The subscription now follows a stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamOpened {
    /// The stream's number in later messages.
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
}

/// A stream has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamClosed {
    /// The stream's number.
    pub stream: u32,
    /// The stream's last frame.
    pub frame: u64,
    /// The reason, for people.
    pub reason: String,
}

/// Why a snapshot is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// The subscription has started.
    Start,
    /// The view has changed.
    ViewChanged,
    /// The consumer was too slow for diffs.
    Lagged,
    /// The daemon no longer knows the frame at which the consumer wants to resume.
    CannotResume,
}

/// A complete view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The stream's number.
    pub stream: u32,
    /// Why it is sent.
    pub cause: Cause,
    /// The frame that it shows.
    pub frame: FrameInfo,
    /// All vertices of the cloud, by id.
    pub vertices: Vec<Vertex>,
    /// The view's tree edges.
    pub edges: Vec<Edge>,
    /// The view's critical edges.
    pub critical: Vec<Critical>,
    /// The checksum of the view.
    pub checksum: u64,
}

/// The changes of a view between two frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diff {
    /// The stream's number.
    pub stream: u32,
    /// The number of the frame that the diff starts from. 0: an empty view.
    pub from: u64,
    /// The frame that the diff leads to.
    pub frame: FrameInfo,
    /// New vertices.
    pub vertices_added: Vec<Vertex>,
    /// Removed vertices.
    pub vertices_removed: Vec<u64>,
    /// New tree edges.
    pub edges_added: Vec<Edge>,
    /// Removed tree edges.
    pub edges_removed: Vec<Edge>,
    /// Critical edges that are new or have a new birth or death.
    pub critical_set: Vec<Critical>,
    /// Removed critical edges.
    pub critical_removed: Vec<Edge>,
    /// The checksum of the view after the diff.
    pub checksum: u64,
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dots {
    /// The stream's number.
    pub stream: u32,
    /// The frame.
    pub frame: u64,
    /// The number of all dots of the frame.
    pub total: u64,
    /// By persistence, largest first.
    pub dots: Vec<Dot>,
}

/// Sent when nothing has changed, to show that the daemon is alive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// The stream's number.
    pub stream: u32,
    /// Its newest frame; 0 if there is none.
    pub frame: u64,
}

/// Frames that are not sent one by one, since the consumer lags.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lagged {
    /// The stream's number.
    pub stream: u32,
    /// The first of them.
    pub first: u64,
    /// The last of them.
    pub last: u64,
}

/// The subscription resumes: diffs continue from the consumer's frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resumed {
    /// The stream's number.
    pub stream: u32,
    /// The frame from which they continue.
    pub frame: u64,
}
