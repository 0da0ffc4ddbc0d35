//! A frame as a JSON line; its keys stand in `hopes serve --help`.
//!
//! In: a stream's name, and what has changed in a view of it.
//! Out: a value that serializes.
//! Invariants: its size is that of the diff; numbers that are not finite are null.
//! Must not know: channels, the core.

use hopes_protocol::{
    Critical, Cut, Edge, FrameInfo, Happening, Message, Simplify, SpaceTrack, SpaceTrackEvent, Track, TrackEvent,
    Vertex,
};
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

/// One line of output.
#[derive(Debug, Serialize)]
pub struct FrameLine<'a> {
    stream: &'a str,
    frame: u64,
    from: u64,
    time: Option<f64>,
    points: u64,
    rejected: u64,
    view: ViewLine,
    vertices: Vertices<'a>,
    edges: Edges<'a>,
    critical: CriticalEdges<'a>,
    #[serde(serialize_with = "as_text")]
    checksum: u64,
    #[serde(flatten)]
    tracks: Option<TracksPart<'a>>,
}

/// What a line says of tracks.
#[derive(Debug, Serialize)]
struct TracksPart<'a> {
    tracks: Vec<EventLine<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alive: Option<Vec<AliveLine<'a>>>,
}

/// A list: id, the centre's coordinates, radius, birth, death.
#[derive(Debug)]
struct AliveLine<'a> {
    id: u64,
    center: Place<'a>,
    radius: f64,
    birth: f64,
    death: f64,
}

/// Coordinates, as a list.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
enum Place<'a> {
    Plane([f64; 2]),
    Space(&'a [f64]),
}

impl Place<'_> {
    fn coordinates(&self) -> &[f64] {
        match self {
            Self::Plane(coordinates) => coordinates,
            Self::Space(coordinates) => coordinates,
        }
    }
}

#[derive(Debug, Serialize)]
struct EventLine<'a> {
    id: u64,
    event: &'static str,
    age: u64,
    birth: f64,
    death: f64,
    center: Place<'a>,
    radius: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<f64>,
    velocity: Place<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    into: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    changed: Option<Vec<&'static str>>,
}

/// Tracks alone, where they come apart from frames.
#[derive(Debug, Serialize)]
pub struct TracksLine<'a> {
    stream: &'a str,
    frame: u64,
    from: u64,
    time: Option<f64>,
    #[serde(flatten)]
    tracks: TracksPart<'a>,
}

impl<'a> TracksLine<'a> {
    /// The line of a message; none for one that is not about tracks.
    pub fn new(stream: &'a str, message: &'a Message) -> Option<Self> {
        let (frame, from, time) = match message {
            Message::Tracks(tracks) => (tracks.frame, tracks.from, tracks.time),
            Message::SpaceTracks(tracks) => (tracks.frame, tracks.from, tracks.time),
            _ => return None,
        };
        Some(Self { stream, frame, from, time, tracks: TracksPart::new(message)? })
    }
}

impl<'a> TracksPart<'a> {
    fn new(message: &'a Message) -> Option<Self> {
        match message {
            Message::Tracks(message) => {
                let alive = message.alive.as_ref().map(|alive| alive.iter().map(AliveLine::of_plane).collect());
                Some(Self { tracks: message.events.iter().map(EventLine::of_plane).collect(), alive })
            }
            Message::SpaceTracks(message) => {
                let alive = message.alive.as_ref().map(|alive| alive.iter().map(AliveLine::of_space).collect());
                Some(Self { tracks: message.events.iter().map(EventLine::of_space).collect(), alive })
            }
            _ => None,
        }
    }
}

impl<'a> AliveLine<'a> {
    fn of_plane(track: &Track) -> Self {
        let &Track { id, birth, death, center, radius, .. } = track;
        Self { id, center: Place::Plane(center.into()), radius, birth, death }
    }

    fn of_space(track: &'a SpaceTrack) -> Self {
        let &SpaceTrack { id, birth, death, ref center, radius, .. } = track;
        Self { id, center: Place::Space(center), radius, birth, death: death.unwrap_or(f64::INFINITY) }
    }
}

impl Serialize for AliveLine<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let center = self.center.coordinates();
        let mut list = serializer.serialize_seq(Some(center.len() + 4))?;
        list.serialize_element(&self.id)?;
        center
            .iter()
            .chain(&[self.radius, self.birth, self.death])
            .try_for_each(|number| list.serialize_element(number))?;
        list.end()
    }
}

/// What happens to a track in a word, with the other track that it names, or what has changed.
struct Event {
    word: &'static str,
    from: Option<u64>,
    into: Option<u64>,
    changed: Option<Vec<&'static str>>,
}

impl From<Happening> for Event {
    fn from(happening: Happening) -> Self {
        let (mut from, mut into, mut changed) = (None, None, None);
        let word = match happening {
            Happening::Born => "born",
            Happening::Split(other) => {
                from = Some(other);
                "split"
            }
            Happening::Updated(changes) => {
                let words = [(changes.center, "center"), (changes.birth, "birth"), (changes.death, "death")];
                changed = Some(words.into_iter().filter(|(has, _)| *has).map(|(_, word)| word).collect());
                "updated"
            }
            Happening::Unselected => "unselected",
            Happening::Reselected => "reselected",
            Happening::Merged(other) => {
                into = Some(other);
                "merged"
            }
            Happening::Died => "died",
        };
        Self { word, from, into, changed }
    }
}

impl<'a> EventLine<'a> {
    fn of_plane(event: &'a TrackEvent) -> Self {
        let &Track { id, age, birth, death, center, radius, area, velocity, .. } = &event.track;
        let (center, velocity) = (Place::Plane(center.into()), Place::Plane(velocity.into()));
        let Event { word: event, from, into, changed } = event.happening.into();
        Self { id, event, age, birth, death, center, radius, area: Some(area), velocity, from, into, changed }
    }

    fn of_space(event: &'a SpaceTrackEvent) -> Self {
        let &SpaceTrack { id, age, birth, death, ref center, radius, ref velocity, .. } = &event.track;
        let (death, center, velocity) = (death.unwrap_or(f64::INFINITY), Place::Space(center), Place::Space(velocity));
        let Event { word: event, from, into, changed } = event.happening.into();
        Self { id, event, age, birth, death, center, radius, area: None, velocity, from, into, changed }
    }
}

#[derive(Debug, Serialize)]
struct ViewLine {
    #[serde(flatten)]
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    simplify: Option<Threshold>,
    components: u64,
    cycles: u64,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Kind {
    Full,
    Reduced { alpha: f64 },
    Derived { k: u32, l: u32, ds: Option<f64>, vs: Option<f64> },
}

/// `true`, or a number.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Threshold {
    AtScale(bool),
    Below(f64),
}

#[derive(Debug, Serialize)]
struct Vertices<'a> {
    add: Points<'a>,
    del: &'a [u64],
}

/// Vertices: each a list of its id and its coordinates.
#[derive(Debug)]
enum Points<'a> {
    Plane(&'a [Vertex]),
    Space { ids: &'a [u64], coordinates: &'a [f64], dimension: u32 },
}

impl Serialize for Points<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Plane(vertices) => vertices.serialize(serializer),
            Self::Space { ids, coordinates, dimension } => {
                let points = coordinates.chunks_exact((*dimension).max(1) as usize);
                serializer.collect_seq(ids.iter().zip(points).map(|(&id, point)| PointLine { id, point }))
            }
        }
    }
}

struct PointLine<'a> {
    id: u64,
    point: &'a [f64],
}

impl Serialize for PointLine<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(1 + self.point.len()))?;
        list.serialize_element(&self.id)?;
        self.point.iter().try_for_each(|number| list.serialize_element(number))?;
        list.end()
    }
}

#[derive(Debug, Serialize)]
struct Edges<'a> {
    add: &'a [Edge],
    del: &'a [Edge],
}

#[derive(Debug, Serialize)]
struct CriticalEdges<'a> {
    set: &'a [Critical],
    del: &'a [Edge],
}

impl<'a> FrameLine<'a> {
    /// The line of a frame of a stream; none for a message that is no frame. A snapshot is a change from nothing, hence
    /// from frame 0.
    pub fn new(stream: &'a str, message: &'a Message) -> Option<Self> {
        Some(match message {
            Message::Diff(diff) => Self {
                vertices: Vertices { add: Points::Plane(&diff.vertices_added), del: &diff.vertices_removed },
                edges: Edges { add: &diff.edges_added, del: &diff.edges_removed },
                critical: CriticalEdges { set: &diff.critical_set, del: &diff.critical_removed },
                ..Self::empty(stream, &diff.frame, diff.from, diff.checksum)
            },
            Message::SpaceDiff(diff) => {
                let (ids, coordinates, dimension) = (&diff.ids_added, &diff.coordinates_added, diff.dimension);
                Self {
                    vertices: Vertices {
                        add: Points::Space { ids, coordinates, dimension },
                        del: &diff.vertices_removed,
                    },
                    edges: Edges { add: &diff.edges_added, del: &diff.edges_removed },
                    critical: CriticalEdges { set: &diff.critical_set, del: &diff.critical_removed },
                    ..Self::empty(stream, &diff.frame, diff.from, diff.checksum)
                }
            }
            Message::Snapshot(snapshot) => Self {
                vertices: Vertices { add: Points::Plane(&snapshot.vertices), del: &[] },
                edges: Edges { add: &snapshot.edges, del: &[] },
                critical: CriticalEdges { set: &snapshot.critical, del: &[] },
                ..Self::empty(stream, &snapshot.frame, 0, snapshot.checksum)
            },
            Message::SpaceSnapshot(snapshot) => {
                let (ids, coordinates, dimension) = (&snapshot.ids, &snapshot.coordinates, snapshot.dimension);
                Self {
                    vertices: Vertices { add: Points::Space { ids, coordinates, dimension }, del: &[] },
                    edges: Edges { add: &snapshot.edges, del: &[] },
                    critical: CriticalEdges { set: &snapshot.critical, del: &[] },
                    ..Self::empty(stream, &snapshot.frame, 0, snapshot.checksum)
                }
            }
            _ => return None,
        })
    }

    /// Adds what a message says of tracks up to the frame.
    pub fn add_tracks(&mut self, message: &'a Message) {
        self.tracks = TracksPart::new(message);
    }

    fn empty(stream: &'a str, frame: &FrameInfo, from: u64, checksum: u64) -> Self {
        Self {
            stream,
            frame: frame.number,
            from,
            time: frame.time,
            points: frame.vertices,
            rejected: frame.rejected,
            view: ViewLine::new(frame),
            vertices: Vertices { add: Points::Plane(&[]), del: &[] },
            edges: Edges { add: &[], del: &[] },
            critical: CriticalEdges { set: &[], del: &[] },
            checksum,
            tracks: None,
        }
    }
}

impl ViewLine {
    fn new(frame: &FrameInfo) -> Self {
        let &FrameInfo { ds, vs, components, cycles, .. } = frame;
        let kind = match frame.view.cut {
            Cut::Full => Kind::Full,
            Cut::Reduced(alpha) => Kind::Reduced { alpha },
            Cut::Derived(k, l) => Kind::Derived { k, l, ds, vs },
        };
        let simplify = match frame.view.simplify {
            Simplify::No => None,
            Simplify::AtScale => Some(Threshold::AtScale(true)),
            Simplify::Below(threshold) => Some(Threshold::Below(threshold)),
        };
        Self { kind, simplify, components, cycles }
    }
}

fn as_text<S: Serializer>(checksum: &u64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{checksum:016x}"))
}
