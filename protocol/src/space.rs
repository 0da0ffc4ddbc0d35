//! Messages about streams of points in R^d under a metric (SPEC.md, section 13). Since version 4.
//!
//! In: field values. Out: the types of the messages.
//!
//! Invariants: a released message never changes, and the cases of an enum keep their order. Coordinates are a flat
//! list: point after point, `dimension` numbers each. Lists of a skeleton are sorted as in a
//! [`Snapshot`](crate::Snapshot).
//!
//! Must not know: bytes, how lengths are computed.

use serde::{Deserialize, Serialize};

use crate::consumer::Cause;
use crate::producer::Opened;
use crate::tracks::{Happening, TrackCycle};
use crate::types::{Critical, Edge, FrameInfo, Window};

/// How the distance of two points is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Metric {
    /// The root of the sum of squared differences.
    Euclidean,
    /// The sum of absolute differences.
    Manhattan,
    /// The largest absolute difference.
    Chebyshev,
    /// The angle between two vectors, in radians.
    Angular,
    /// The arc between two places on the Earth, in metres. Points are longitude and latitude in degrees.
    Haversine,
}

impl Metric {
    /// Its name in options and formats.
    pub fn name(self) -> &'static str {
        match self {
            Self::Euclidean => "euclidean",
            Self::Manhattan => "manhattan",
            Self::Chebyshev => "chebyshev",
            Self::Angular => "angular",
            Self::Haversine => "haversine",
        }
    }
}

/// Asks which streams have points in R^d.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListSpaces {}

/// Answers [`ListSpaces`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Spaces {
    /// The streams, by number. Streams of the plane are not among them.
    pub streams: Vec<SpaceInfo>,
}

/// The space of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SpaceInfo {
    /// The stream's number.
    pub stream: u32,
    /// How distances are measured.
    pub metric: Metric,
    /// The number of coordinates of a point. None: the first point fixes it.
    pub dimension: Option<u32>,
}

/// Joins a stream of points in R^d, or creates it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenSpace {
    /// The stream's name.
    pub name: String,
    /// Which points are kept. None: the stream's own window; for a new stream, all points.
    pub window: Option<Window>,
    /// The step of the grid to which positions are snapped. None: the stream's own; for a new stream, no grid.
    pub resolution: Option<f64>,
    /// How distances are measured. None: the stream's own; for a new stream, Euclidean.
    pub metric: Option<Metric>,
    /// The number of coordinates of a point. None: the stream's own; for a new stream, the first point fixes it.
    pub dimension: Option<u32>,
}

/// Answers [`OpenSpace`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceOpened {
    /// What the answer to [`Open`](crate::Open) says.
    pub opened: Opened,
    /// How distances are measured.
    pub metric: Metric,
    /// The number of coordinates of a point. None: the first point fixes it.
    pub dimension: Option<u32>,
    /// The largest number of distinct positions.
    pub max_vertices: u64,
}

/// Points to add.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceBatch {
    /// The producer's number for this message.
    pub sequence: u64,
    /// The number of coordinates of a point.
    pub dimension: u32,
    /// The coordinates, point after point.
    pub coordinates: Vec<f64>,
    /// The event times: none, or one for each point.
    pub times: Vec<f64>,
    /// The producer's own numbers of the points: none, or one for each point.
    pub tags: Vec<u64>,
}

/// Points to remove.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceRetract {
    /// The producer's number for this message.
    pub sequence: u64,
    /// The number of coordinates of a point.
    pub dimension: u32,
    /// The coordinates, point after point. At each of these positions the oldest point is removed.
    pub coordinates: Vec<f64>,
}

/// A complete view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceSnapshot {
    /// The stream's number.
    pub stream: u32,
    /// Why it is sent.
    pub cause: Cause,
    /// The frame that it shows.
    pub frame: FrameInfo,
    /// How distances are measured.
    pub metric: Metric,
    /// The number of coordinates of a vertex. 0: no point has come yet, and there are no vertices.
    pub dimension: u32,
    /// The ids of all vertices, sorted.
    pub ids: Vec<u64>,
    /// The coordinates of the vertices, in the order of `ids`.
    pub coordinates: Vec<f64>,
    /// The view's tree edges.
    pub edges: Vec<Edge>,
    /// The view's critical edges. The death of one that never dies is infinite.
    pub critical: Vec<Critical>,
    /// The checksum of the view.
    pub checksum: u64,
}

/// The changes of a view between two frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceDiff {
    /// The stream's number.
    pub stream: u32,
    /// The number of the frame that the diff starts from. 0: an empty view.
    pub from: u64,
    /// The frame that the diff leads to.
    pub frame: FrameInfo,
    /// The number of coordinates of a vertex. 0: no point has come yet, and there are no vertices.
    pub dimension: u32,
    /// The ids of new vertices, sorted.
    pub ids_added: Vec<u64>,
    /// The coordinates of new vertices, in the order of `ids_added`.
    pub coordinates_added: Vec<f64>,
    /// Removed vertices.
    pub vertices_removed: Vec<u64>,
    /// New tree edges.
    pub edges_added: Vec<Edge>,
    /// Removed tree edges.
    pub edges_removed: Vec<Edge>,
    /// Critical edges that are new or have a new birth or death. The death of one that never dies is infinite.
    pub critical_set: Vec<Critical>,
    /// Removed critical edges.
    pub critical_removed: Vec<Edge>,
    /// The checksum of the view after the diff.
    pub checksum: u64,
}

/// A dot of the persistence diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceDot {
    /// Its critical edge.
    pub edge: Edge,
    /// Half the length of the critical edge.
    pub birth: f64,
    /// The scale at which the cycle is filled. None: it never is.
    pub death: Option<f64>,
    /// The edge that fills the cycle. None: it never is filled.
    pub death_edge: Option<Edge>,
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceDots {
    /// The stream's number.
    pub stream: u32,
    /// The frame.
    pub frame: u64,
    /// The number of all dots of the frame.
    pub total: u64,
    /// By persistence, largest first.
    pub dots: Vec<SpaceDot>,
}

/// A persistent cycle that is followed over time, in its last seen state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceTrack {
    /// Unique within the stream's epoch.
    pub id: u64,
    /// The number of frames from the first to the last in which it was seen.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its cycle is filled. None: it never is.
    pub death: Option<f64>,
    /// The mean of its cycle's vertices: a coordinate for each dimension.
    pub center: Vec<f64>,
    /// Half the largest distance between two vertices of its cycle.
    pub radius: f64,
    /// The movement of the centre in one frame.
    pub velocity: Vec<f64>,
    /// Whether it is selected.
    pub selected: bool,
}

/// An event of a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceTrackEvent {
    /// The frame of the event.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// The kind of event.
    pub happening: Happening,
    /// The track after the event.
    pub track: SpaceTrack,
}

/// The events of tracks up to a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpaceTracks {
    /// The stream's number.
    pub stream: u32,
    /// The frame of the previous message. 0: the consumer drops what it has, and `alive` lists all living tracks.
    pub from: u64,
    /// The frame that the message leads to.
    pub frame: u64,
    /// That frame's time.
    pub time: Option<f64>,
    /// Sorted by frame, then by track.
    pub events: Vec<SpaceTrackEvent>,
    /// All living tracks, if the consumer asked for them or if the message starts from 0.
    pub alive: Option<Vec<SpaceTrack>>,
    /// Cycles that have changed, if the consumer asked for them. Each has one closed walk.
    pub cycles: Vec<TrackCycle>,
}
