//! Messages for the administration of a daemon (SPEC.md, section 12). Since version 3.
//!
//! Invariants: a released message never changes. Each request has one answer, on the request's own channel.
//!
//! Must not know: bytes.

use serde::{Deserialize, Serialize};

/// Asks for a list of peers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListPeers {}

/// Answers [`ListPeers`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Peers {
    /// The peers, by number. The one that asks is among them.
    pub peers: Vec<Peer>,
}

/// A peer: the other end of a connection.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Peer {
    /// The peer's number. It is not used again as long as the daemon runs.
    pub peer: u64,
    /// The daemon's address to which it has connected.
    pub place: String,
    /// What it calls itself in its `Hello`. Empty before that.
    pub software: String,
    /// The time since it has connected, in milliseconds.
    pub connected_ms: u64,
    /// The time since it has sent something, in milliseconds.
    pub silent_ms: u64,
    /// Its channels that feed a stream.
    pub producers: u32,
    /// Its channels that follow streams.
    pub consumers: u32,
    /// What the daemon holds for it, in bytes.
    pub held: u64,
    /// Bytes that the daemon has received from it.
    pub received: u64,
    /// Bytes that the daemon has sent to it.
    pub sent: u64,
    /// Frames that it was not sent one by one.
    pub lagged: u64,
}

/// Ends a stream, for all its peers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StopStream {
    /// The stream's name.
    pub name: String,
}

/// Answers [`StopStream`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamStopped {
    /// The stream's name.
    pub name: String,
    /// The stream's last frame; 0 if it had none.
    pub frame: u64,
}

/// Ends the connection of a peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Disconnect {
    /// The peer's number.
    pub peer: u64,
}

/// Answers [`Disconnect`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Disconnected {
    /// The peer's number.
    pub peer: u64,
}

/// Asks what the daemon's memory is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetMemory {}

/// Answers [`GetMemory`]. All are estimates.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Memory {
    /// The limit of `held`, in bytes. 0: no limit.
    pub limit: u64,
    /// What the daemon holds in all, in bytes.
    pub held: u64,
    /// The part of `held` that is for peers, in bytes: answers, snapshots and merged frames under way, and messages of
    /// which a part has arrived.
    pub peers: u64,
    /// The streams, by name.
    pub streams: Vec<StreamMemory>,
}

/// What a stream's memory is used for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamMemory {
    /// The stream's name.
    pub name: String,
    /// Its points, positions and triangulation, in bytes.
    pub points: u64,
    /// The views that are followed and their history, in bytes.
    pub views: u64,
    /// What waits for its engine, in bytes.
    pub queue: u64,
}
