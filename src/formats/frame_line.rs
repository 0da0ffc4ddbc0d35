//! A frame as a JSON line; its keys stand in `hopes serve --help`.
//!
//! In: a stream's name, and what has changed in a view of it.
//! Out: a value that serializes.
//! Invariants: its size is that of the diff; numbers that are not finite are null.
//! Must not know: channels, the core.

use hopes_protocol::{
    Critical, Cut, Diff, Edge, FrameInfo, Happening, Simplify, Snapshot, Track, TrackEvent, Tracks, Vertex,
};
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
    tracks: Option<TracksPart>,
}

/// What a line says of tracks.
#[derive(Debug, Serialize)]
struct TracksPart {
    tracks: Vec<EventLine>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alive: Option<Vec<AliveLine>>,
}

/// Id, x, y, radius, birth, death.
type AliveLine = (u64, f64, f64, f64, f64, f64);

#[derive(Debug, Serialize)]
struct EventLine {
    id: u64,
    event: &'static str,
    age: u64,
    birth: f64,
    death: f64,
    center: (f64, f64),
    radius: f64,
    area: f64,
    velocity: (f64, f64),
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
    tracks: TracksPart,
}

impl<'a> TracksLine<'a> {
    /// The line of a message.
    pub fn new(stream: &'a str, message: &Tracks) -> Self {
        let Tracks { from, frame, time, events, alive, .. } = message;
        Self { stream, frame: *frame, from: *from, time: *time, tracks: TracksPart::new(events, alive.as_deref()) }
    }
}

impl TracksPart {
    fn new(events: &[TrackEvent], alive: Option<&[Track]>) -> Self {
        let line = |track: &Track| {
            let &Track { id, birth, death, center: (x, y), radius, .. } = track;
            (id, x, y, radius, birth, death)
        };
        Self {
            tracks: events.iter().map(EventLine::new).collect(),
            alive: alive.map(|alive| alive.iter().map(line).collect()),
        }
    }
}

impl EventLine {
    fn new(event: &TrackEvent) -> Self {
        let &Track { id, age, birth, death, center, radius, area, velocity, .. } = &event.track;
        let (mut from, mut into, mut changed) = (None, None, None);
        let event = match event.happening {
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
        Self { id, event, age, birth, death, center, radius, area, velocity, from, into, changed }
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
    add: &'a [Vertex],
    del: &'a [u64],
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
    /// The line of a frame of a stream.
    pub fn new(stream: &'a str, diff: &'a Diff) -> Self {
        Self {
            vertices: Vertices { add: &diff.vertices_added, del: &diff.vertices_removed },
            edges: Edges { add: &diff.edges_added, del: &diff.edges_removed },
            critical: CriticalEdges { set: &diff.critical_set, del: &diff.critical_removed },
            ..Self::empty(stream, &diff.frame, diff.from, diff.checksum)
        }
    }

    /// The line of a whole view: a change from nothing, hence from frame 0.
    pub fn of_snapshot(stream: &'a str, snapshot: &'a Snapshot) -> Self {
        Self {
            vertices: Vertices { add: &snapshot.vertices, del: &[] },
            edges: Edges { add: &snapshot.edges, del: &[] },
            critical: CriticalEdges { set: &snapshot.critical, del: &[] },
            ..Self::empty(stream, &snapshot.frame, 0, snapshot.checksum)
        }
    }

    /// Adds the events of tracks up to the frame and, if given, all living tracks.
    pub fn add_tracks(&mut self, events: &[TrackEvent], alive: Option<Vec<Track>>) {
        self.tracks = Some(TracksPart::new(events, alive.as_deref()));
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
            vertices: Vertices { add: &[], del: &[] },
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
