//! The second codec: its own types, read and written by `wincode`. It shares no code with the crate.
//!
//! In: a body. Out: the same as a value, or as this codec writes it again.
//!
//! Invariants: definitions follow SPEC.md.
//!
//! Must not know: the crate's types, frames.
#![allow(dead_code, missing_docs, reason = "each user takes a part")]

use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use wincode::config::{Configuration, DefaultConfig, deserialize_exact, serialize};
use wincode::int_encoding::{LittleEndian, VarInt};
use wincode::len::BincodeLen;
use wincode::{SchemaRead, SchemaWrite};

type Varint =
    Configuration<true, { wincode::config::DEFAULT_PREALLOCATION_SIZE_LIMIT }, BincodeLen, LittleEndian, VarInt>;

const VARINT: Varint = DefaultConfig::default().with_varint_encoding();

/// A type that both codecs of this file support.
pub trait Body: Debug + Serialize + DeserializeOwned {
    fn to_bytes(&self) -> Vec<u8>;
    fn from_bytes(bytes: &[u8]) -> Result<Self, String>;
}

/// Defines wire types.
macro_rules! wire {
    ($($definition:item)*) => {
        $(
            #[derive(Debug, Serialize, Deserialize, SchemaRead, SchemaWrite)]
            $definition
        )*
    };
}

/// Reads and writes bodies.
macro_rules! bodies {
    ($($name:ident $number:literal $body:ident,)*) => {
        $(
            impl Body for $body {
                fn to_bytes(&self) -> Vec<u8> {
                    serialize(self, VARINT).expect("it is short")
                }

                fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
                    deserialize_exact(bytes, VARINT).map_err(|error| error.to_string())
                }
            }
        )*

        /// Type and name of every message.
        pub const NUMBERS: &[(u16, &str)] = &[$(($number, stringify!($name)),)*];

        /// Reads a body and writes it again.
        pub fn again(number: u16, body: &[u8]) -> Result<Vec<u8>, String> {
            match number {
                $($number => $body::from_bytes(body).map(|body| body.to_bytes()),)*
                _ => Err(format!("{number} is not known")),
            }
        }
    };
}

/// Gives all messages to a macro: name, type, body.
macro_rules! each_body {
    ($then:ident) => {
        $then! {
            Hello 0x0001 Hello,
            Welcome 0x0002 Welcome,
            Ping 0x0003 Ping,
            Pong 0x0004 Pong,
            Goodbye 0x0005 Goodbye,
            Error 0x0006 Error,
            ListStreams 0x0007 ListStreams,
            Streams 0x0008 Streams,
            GetStatus 0x0009 GetStatus,
            Status 0x000A Status,
            ListSpaces 0x000B ListSpaces,
            Spaces 0x000C Spaces,
            Open 0x0101 Open,
            Opened 0x0102 Opened,
            Batch 0x0103 Batch,
            Retract 0x0104 Retract,
            Commit 0x0105 Commit,
            Close 0x0106 Close,
            Closed 0x0107 Closed,
            Accepted 0x0108 Accepted,
            Refused 0x0109 Refused,
            Committed 0x010A Committed,
            Overloaded 0x010B Overloaded,
            OpenSpace 0x010D OpenSpace,
            SpaceOpened 0x010E SpaceOpened,
            SpaceBatch 0x010F SpaceBatch,
            SpaceRetract 0x0110 SpaceRetract,
            Subscribe 0x0201 Subscribe,
            ChangeView 0x0202 ChangeView,
            Unsubscribe 0x0203 Unsubscribe,
            StreamOpened 0x0204 StreamOpened,
            StreamClosed 0x0205 StreamClosed,
            Snapshot 0x0206 Snapshot,
            Diff 0x0207 Diff,
            Dots 0x0208 Dots,
            Heartbeat 0x0209 Heartbeat,
            Lagged 0x020A Lagged,
            Resumed 0x020B Resumed,
            Unsubscribed 0x020C Unsubscribed,
            WantTracks 0x020D WantTracks,
            Tracks 0x020E Tracks,
            SpaceSnapshot 0x0210 SpaceSnapshot,
            SpaceDiff 0x0211 SpaceDiff,
            SpaceDots 0x0212 SpaceDots,
            SpaceTracks 0x0213 SpaceTracks,
            ListPeers 0x0301 ListPeers,
            Peers 0x0302 Peers,
            StopStream 0x0303 StopStream,
            StreamStopped 0x0304 StreamStopped,
            Disconnect 0x0305 Disconnect,
            Disconnected 0x0306 Disconnected,
            GetMemory 0x0307 GetMemory,
            Memory 0x0308 Memory,
            Elapsed 0x0F01 Elapsed,
        }
    };
}

each_body!(bodies);

// ---- types shared by messages

type Vertex = (u64, f64, f64);
type Edge = (u64, u64);
type Critical = (u64, u64, f64, f64);

wire! {
    pub enum Window {
        All,
        Points(u64),
        Frames(u64),
        Time(f64),
    }

    pub enum Cut {
        Full,
        Reduced(f64),
        Derived(u32, u32),
    }

    pub enum Simplify {
        No,
        AtScale,
        Below(f64),
    }

    pub struct View {
        pub cut: Cut,
        pub simplify: Simplify,
    }

    pub enum DotsWanted {
        No,
        Top(u32),
        All,
    }

    pub struct Frame {
        pub number: u64,
        pub time: Option<f64>,
        pub points: u64,
        pub vertices: u64,
        pub rejected: u64,
        pub view: View,
        pub ds: Option<f64>,
        pub vs: Option<f64>,
        pub components: u64,
        pub cycles: u64,
    }
}

// ---- messages of the connection

wire! {
    pub struct Hello {
        pub software: String,
        pub capabilities: Vec<String>,
    }

    pub struct Welcome {
        pub software: String,
        pub capabilities: Vec<String>,
        pub epoch: u64,
        pub largest_frame: u32,
        pub largest_batch: u32,
        pub heartbeat_ms: u32,
        pub timeout_ms: u32,
    }

    pub struct Ping {
        pub token: u64,
    }

    pub struct Pong {
        pub token: u64,
    }

    pub struct Goodbye {
        pub reason: String,
        pub streams: Vec<(String, u64)>,
    }

    pub struct Error {
        pub code: u16,
        pub answers: u16,
        pub text: String,
    }

    pub struct ListStreams {
        pub pattern: String,
    }

    pub struct Streams {
        pub streams: Vec<StreamInfo>,
    }

    pub struct GetStatus {}

    pub struct Status {
        pub software: String,
        pub uptime_ms: u64,
        pub epoch: u64,
        pub connections: u32,
        pub refused_messages: u64,
        pub memory: u64,
        pub memory_limit: u64,
        pub streams: Vec<StreamStatus>,
    }

    pub struct StreamInfo {
        pub stream: u32,
        pub name: String,
        pub epoch: u64,
        pub window: Window,
        pub resolution: Option<f64>,
        pub frame: u64,
        pub points: u64,
        pub vertices: u64,
        pub producers: u32,
        pub consumers: u32,
    }

    pub struct StreamStatus {
        pub info: StreamInfo,
        pub computed: u64,
        pub accepted: u64,
        pub refused: u64,
        pub dropped: u64,
        pub waiting: u64,
        pub lagged: u64,
        pub memory: u64,
    }

    pub struct Elapsed {
        pub nanoseconds: u64,
    }
}

// ---- producers

wire! {
    pub struct Open {
        pub name: String,
        pub window: Option<Window>,
        pub resolution: Option<f64>,
    }

    pub struct Opened {
        pub stream: u32,
        pub epoch: u64,
        pub created: bool,
        pub window: Window,
        pub resolution: Option<f64>,
        pub frame: u64,
        pub largest_batch: u32,
    }

    pub struct Batch {
        pub sequence: u64,
        pub points: Vec<(f64, f64)>,
        pub times: Vec<f64>,
        pub tags: Vec<u64>,
    }

    pub struct Retract {
        pub sequence: u64,
        pub points: Vec<(f64, f64)>,
    }

    pub struct Commit {
        pub sequence: u64,
        pub time: Option<f64>,
    }

    pub struct Close {
        pub end: bool,
    }

    pub struct Closed {
        pub frame: u64,
    }

    pub struct Accepted {
        pub sequence: u64,
        pub points: u32,
        pub placed: Vec<(u64, u64)>,
    }

    pub struct Refused {
        pub sequence: u64,
        pub accepted: u32,
        pub refused: u32,
        pub reasons: Vec<Refusal>,
        pub placed: Vec<(u64, u64)>,
    }

    pub struct Refusal {
        pub index: u32,
        pub code: u16,
        pub text: String,
    }

    pub struct Committed {
        pub sequence: u64,
        pub frame: u64,
    }

    pub struct Overloaded {
        pub sequence: u64,
        pub points: u32,
        pub total: u64,
        pub policy: Policy,
    }

    pub enum Policy {
        DropOldest,
        DropNewest,
    }
}

// ---- consumers

wire! {
    pub struct Subscribe {
        pub pattern: String,
        pub view: View,
        pub dots: DotsWanted,
        pub resume: Option<Resume>,
    }

    pub struct Resume {
        pub epoch: u64,
        pub frame: u64,
    }

    pub struct ChangeView {
        pub view: View,
        pub dots: DotsWanted,
    }

    pub struct Unsubscribe {}

    pub struct Unsubscribed {}

    pub struct StreamOpened {
        pub stream: u32,
        pub name: String,
        pub epoch: u64,
        pub window: Window,
        pub resolution: Option<f64>,
        pub frame: u64,
    }

    pub struct StreamClosed {
        pub stream: u32,
        pub frame: u64,
        pub reason: String,
    }

    pub enum Cause {
        Start,
        ViewChanged,
        Lagged,
        CannotResume,
    }

    pub struct Snapshot {
        pub stream: u32,
        pub cause: Cause,
        pub frame: Frame,
        pub vertices: Vec<Vertex>,
        pub edges: Vec<Edge>,
        pub critical: Vec<Critical>,
        pub checksum: u64,
    }

    pub struct Diff {
        pub stream: u32,
        pub from: u64,
        pub frame: Frame,
        pub vertices_added: Vec<Vertex>,
        pub vertices_removed: Vec<u64>,
        pub edges_added: Vec<Edge>,
        pub edges_removed: Vec<Edge>,
        pub critical_set: Vec<Critical>,
        pub critical_removed: Vec<Edge>,
        pub checksum: u64,
    }

    pub struct Dots {
        pub stream: u32,
        pub frame: u64,
        pub total: u64,
        pub dots: Vec<Dot>,
    }

    pub struct Dot {
        pub edge: Edge,
        pub birth: f64,
        pub death: f64,
        pub center: (f64, f64),
        pub radius: f64,
    }

    pub struct Heartbeat {
        pub stream: u32,
        pub frame: u64,
    }

    pub struct Lagged {
        pub stream: u32,
        pub first: u64,
        pub last: u64,
    }

    pub struct Resumed {
        pub stream: u32,
        pub frame: u64,
    }
}

// ---- tracks

wire! {
    pub enum TracksWanted {
        No,
        Events,
        Alive,
        Cycles,
    }

    pub struct WantTracks {
        pub tracks: TracksWanted,
    }

    pub struct Track {
        pub id: u64,
        pub age: u64,
        pub birth: f64,
        pub death: f64,
        pub center: (f64, f64),
        pub radius: f64,
        pub area: f64,
        pub velocity: (f64, f64),
        pub selected: bool,
    }

    pub struct TrackChanges {
        pub center: bool,
        pub birth: bool,
        pub death: bool,
    }

    pub enum Happening {
        Born,
        Split(u64),
        Updated(TrackChanges),
        Unselected,
        Reselected,
        Merged(u64),
        Died,
    }

    pub struct TrackEvent {
        pub frame: u64,
        pub time: Option<f64>,
        pub happening: Happening,
        pub track: Track,
    }

    pub struct TrackCycle {
        pub id: u64,
        pub walks: Vec<Vec<u64>>,
    }

    pub struct Tracks {
        pub stream: u32,
        pub from: u64,
        pub frame: u64,
        pub time: Option<f64>,
        pub events: Vec<TrackEvent>,
        pub alive: Option<Vec<Track>>,
        pub cycles: Vec<TrackCycle>,
    }
}

// ---- administration

wire! {
    pub struct ListPeers {}

    pub struct Peers {
        pub peers: Vec<Peer>,
    }

    pub struct Peer {
        pub peer: u64,
        pub place: String,
        pub software: String,
        pub connected_ms: u64,
        pub silent_ms: u64,
        pub producers: u32,
        pub consumers: u32,
        pub held: u64,
        pub received: u64,
        pub sent: u64,
        pub lagged: u64,
    }

    pub struct StopStream {
        pub name: String,
    }

    pub struct StreamStopped {
        pub name: String,
        pub frame: u64,
    }

    pub struct Disconnect {
        pub peer: u64,
    }

    pub struct Disconnected {
        pub peer: u64,
    }

    pub struct GetMemory {}

    pub struct Memory {
        pub limit: u64,
        pub held: u64,
        pub peers: u64,
        pub streams: Vec<StreamMemory>,
    }

    pub struct StreamMemory {
        pub name: String,
        pub points: u64,
        pub views: u64,
        pub queue: u64,
    }
}

// ---- spaces

wire! {
    pub enum Metric {
        Euclidean,
        Manhattan,
        Chebyshev,
        Angular,
        Haversine,
    }

    pub struct ListSpaces {}

    pub struct Spaces {
        pub streams: Vec<SpaceInfo>,
    }

    pub struct SpaceInfo {
        pub stream: u32,
        pub metric: Metric,
        pub dimension: Option<u32>,
    }

    pub struct OpenSpace {
        pub name: String,
        pub window: Option<Window>,
        pub resolution: Option<f64>,
        pub metric: Option<Metric>,
        pub dimension: Option<u32>,
    }

    pub struct SpaceOpened {
        pub opened: Opened,
        pub metric: Metric,
        pub dimension: Option<u32>,
        pub max_vertices: u64,
    }

    pub struct SpaceBatch {
        pub sequence: u64,
        pub dimension: u32,
        pub coordinates: Vec<f64>,
        pub times: Vec<f64>,
        pub tags: Vec<u64>,
    }

    pub struct SpaceRetract {
        pub sequence: u64,
        pub dimension: u32,
        pub coordinates: Vec<f64>,
    }

    pub struct SpaceSnapshot {
        pub stream: u32,
        pub cause: Cause,
        pub frame: Frame,
        pub metric: Metric,
        pub dimension: u32,
        pub ids: Vec<u64>,
        pub coordinates: Vec<f64>,
        pub edges: Vec<Edge>,
        pub critical: Vec<Critical>,
        pub checksum: u64,
    }

    pub struct SpaceDiff {
        pub stream: u32,
        pub from: u64,
        pub frame: Frame,
        pub dimension: u32,
        pub ids_added: Vec<u64>,
        pub coordinates_added: Vec<f64>,
        pub vertices_removed: Vec<u64>,
        pub edges_added: Vec<Edge>,
        pub edges_removed: Vec<Edge>,
        pub critical_set: Vec<Critical>,
        pub critical_removed: Vec<Edge>,
        pub checksum: u64,
    }

    pub struct SpaceDots {
        pub stream: u32,
        pub frame: u64,
        pub total: u64,
        pub dots: Vec<SpaceDot>,
    }

    pub struct SpaceDot {
        pub edge: Edge,
        pub birth: f64,
        pub death: Option<f64>,
        pub death_edge: Option<Edge>,
    }

    pub struct SpaceTrack {
        pub id: u64,
        pub age: u64,
        pub birth: f64,
        pub death: Option<f64>,
        pub center: Vec<f64>,
        pub radius: f64,
        pub velocity: Vec<f64>,
        pub selected: bool,
    }

    pub struct SpaceTrackEvent {
        pub frame: u64,
        pub time: Option<f64>,
        pub happening: Happening,
        pub track: SpaceTrack,
    }

    pub struct SpaceTracks {
        pub stream: u32,
        pub from: u64,
        pub frame: u64,
        pub time: Option<f64>,
        pub events: Vec<SpaceTrackEvent>,
        pub alive: Option<Vec<SpaceTrack>>,
        pub cycles: Vec<TrackCycle>,
    }
}
