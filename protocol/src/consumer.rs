//! Messages between a consumer and the daemon (SPEC.md, section 7).
//!
//! Invariants: a released message is never changed; all lists of a skeleton are sorted by id, or by both ends, without repetitions. Must not know: bytes.

use serde::{Deserialize, Serialize};

use crate::types::{Critical, Dot, DotsWanted, Edge, FrameInfo, Vertex, View, Window};

/// Follows streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subscribe {
    /// Those whose names match, now or later.
    pub pattern: String,
    /// What to see of the skeleton.
    pub view: View,
    /// What to see of the persistence diagram.
    pub dots: DotsWanted,
    /// What the consumer had before it lost its connection.
    pub resume: Option<Resume>,
}

/// Where a consumer was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resume {
    /// The stream's.
    pub epoch: u64,
    /// The last frame that it has.
    pub frame: u64,
}

/// Sees something else from here on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChangeView {
    /// What to see of the skeleton.
    pub view: View,
    /// What to see of the persistence diagram.
    pub dots: DotsWanted,
}

/// Follows no more.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unsubscribe {}

/// Nothing more comes on this channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unsubscribed {}

/// A stream that the subscription follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamOpened {
    /// Its number in later messages.
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
}

/// A stream has ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamClosed {
    /// Its number.
    pub stream: u32,
    /// Its last frame.
    pub frame: u64,
    /// For people.
    pub reason: String,
}

/// Why a snapshot comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// The subscription has just begun.
    Start,
    /// The view was changed.
    ViewChanged,
    /// The consumer was too slow for diffs.
    Lagged,
    /// What it had is not known any more.
    CannotResume,
}

/// All of a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The stream's number.
    pub stream: u32,
    /// Why it comes.
    pub cause: Cause,
    /// The frame that it shows.
    pub frame: FrameInfo,
    /// All vertices of the cloud, by id.
    pub vertices: Vec<Vertex>,
    /// The view's tree edges.
    pub edges: Vec<Edge>,
    /// The view's critical edges.
    pub critical: Vec<Critical>,
    /// Proves it.
    pub checksum: u64,
}

/// What has changed in a view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diff {
    /// The stream's number.
    pub stream: u32,
    /// Number of the frame that it starts from; 0: from nothing.
    pub from: u64,
    /// The frame that it leads to.
    pub frame: FrameInfo,
    /// New vertices.
    pub vertices_added: Vec<Vertex>,
    /// Vertices that are gone.
    pub vertices_removed: Vec<u64>,
    /// New tree edges.
    pub edges_added: Vec<Edge>,
    /// Tree edges that are gone.
    pub edges_removed: Vec<Edge>,
    /// Critical edges that are new or have a new label.
    pub critical_set: Vec<Critical>,
    /// Critical edges that are gone.
    pub critical_removed: Vec<Edge>,
    /// Proves what it leads to.
    pub checksum: u64,
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dots {
    /// The stream's number.
    pub stream: u32,
    /// The frame.
    pub frame: u64,
    /// How many dots it has in all.
    pub total: u64,
    /// By persistence, largest first.
    pub dots: Vec<Dot>,
}

/// Nothing is new, and the daemon is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heartbeat {
    /// The stream's number.
    pub stream: u32,
    /// Its newest frame; 0 if there is none.
    pub frame: u64,
}

/// Frames that are not sent singly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lagged {
    /// The stream's number.
    pub stream: u32,
    /// The first of them.
    pub first: u64,
    /// The last of them.
    pub last: u64,
}

/// Diffs go on from where the consumer was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resumed {
    /// The stream's number.
    pub stream: u32,
    /// The frame that they go on from.
    pub frame: u64,
}
