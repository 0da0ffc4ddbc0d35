//! The forms in which messages about streams are written: a line a frame for people, what happens to tracks, JSON
//! lines, a recording.
//!
//! In: messages that were checked against a mirror, each with the name of its stream.
//! Out: text or bytes on a sink, flushed with every message.
//! Invariants: the JSON line of a frame is that of `serve`; a gap is always announced (`lagged`); what a peer has
//! named is printable.
//! Must not know: where messages come from.

use std::fmt;
use std::io::{self, Write};
use std::time::Duration;

use hopes_protocol::{
    Cause, Cut, Dots, Edge, FrameInfo, Happening, Lagged, Message, Snapshot, SpaceDots, SpaceSnapshot, SpaceTrack,
    SpaceTrackEvent, Track, TrackEvent,
};
use serde::Serialize;

use super::frame_line::{FrameLine, TracksLine};
use super::recording::Recording;
use super::short::Short;

/// How messages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MessageForm {
    /// A line a frame, for people.
    #[default]
    Text,
    /// What happens to tracks and nothing else, for people.
    Events,
    /// JSON lines, as of `serve`.
    Jsonl,
    /// A recording, for `replay`.
    Bin,
}

/// Writes messages in one of the forms.
pub enum MessageWriter<W> {
    /// For people.
    Text(W),
    /// For people who follow tracks only.
    Events(W),
    /// For programs.
    Jsonl(W),
    /// For `replay`.
    Bin(Recording<W>),
}

impl<W: Write> MessageWriter<W> {
    /// Nothing is written yet.
    pub fn new(form: MessageForm, sink: W) -> Self {
        match form {
            MessageForm::Text => Self::Text(sink),
            MessageForm::Events => Self::Events(sink),
            MessageForm::Jsonl => Self::Jsonl(sink),
            MessageForm::Bin => Self::Bin(Recording::new(sink)),
        }
    }

    /// Streams of the plane and in spaces may come: a recording must have both.
    pub fn set_mixed(&mut self) {
        if let Self::Bin(recording) = self {
            recording.set_mixed();
        }
    }

    /// Writes a message about the stream of that name, which came so long after the first message.
    pub fn write(&mut self, name: &str, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        match self {
            Self::Text(sink) => as_text(sink, name, message).and_then(|()| sink.flush()),
            Self::Events(sink) => as_events(sink, name, message).and_then(|()| sink.flush()),
            Self::Jsonl(sink) => as_json(sink, name, message).and_then(|()| sink.flush()),
            Self::Bin(recording) => recording.write(name, elapsed, channel, message),
        }
    }

    /// Ends the output; only a recording says so, and why.
    pub fn finish(&mut self, elapsed: Duration, reason: &str) -> io::Result<()> {
        match self {
            Self::Text(_) | Self::Events(_) | Self::Jsonl(_) => Ok(()),
            Self::Bin(recording) => recording.finish(elapsed, reason),
        }
    }

    /// Whether the output says in words what the message reports, so that a log line would only repeat it.
    pub fn announces(&self, message: &Message) -> bool {
        match self {
            Self::Text(_) => matches!(message, Message::Lagged(_) | Message::StreamClosed(_)),
            Self::Events(_) => matches!(message, Message::StreamClosed(_)),
            Self::Jsonl(_) => matches!(message, Message::Lagged(_)),
            Self::Bin(_) => false,
        }
    }

    /// Bytes of the recording so far.
    pub fn bytes_written(&self) -> u64 {
        match self {
            Self::Text(_) | Self::Events(_) | Self::Jsonl(_) => 0,
            Self::Bin(recording) => recording.bytes(),
        }
    }
}

fn as_text(sink: &mut impl Write, name: &str, message: &Message) -> io::Result<()> {
    match message {
        Message::Snapshot(snapshot) => {
            let Snapshot { cause, vertices, edges, critical, .. } = snapshot;
            let size = vertices.len() + edges.len() + critical.len();
            snapshot_as_text(sink, Line { name, frame: &snapshot.frame }, size, *cause)
        }
        Message::SpaceSnapshot(snapshot) => {
            let SpaceSnapshot { cause, ids, edges, critical, .. } = snapshot;
            let size = ids.len() + edges.len() + critical.len();
            snapshot_as_text(sink, Line { name, frame: &snapshot.frame }, size, *cause)
        }
        Message::Diff(diff) => {
            let added = diff.vertices_added.len() + diff.edges_added.len() + diff.critical_set.len();
            let removed = diff.vertices_removed.len() + diff.edges_removed.len() + diff.critical_removed.len();
            writeln!(sink, "{}  +{added} -{removed}", Line { name, frame: &diff.frame })
        }
        Message::SpaceDiff(diff) => {
            let added = diff.ids_added.len() + diff.edges_added.len() + diff.critical_set.len();
            let removed = diff.vertices_removed.len() + diff.edges_removed.len() + diff.critical_removed.len();
            writeln!(sink, "{}  +{added} -{removed}", Line { name, frame: &diff.frame })
        }
        Message::Lagged(Lagged { first, last, .. }) => {
            writeln!(sink, "{name}  frames {first} to {last} come as one: this side was too slow")
        }
        Message::Dots(Dots { frame, total, dots, .. }) => {
            let listed = dots.iter().map(|dot| (dot.edge, dot.birth, dot.death));
            dots_as_text(sink, name, (*frame, *total), listed)
        }
        Message::SpaceDots(SpaceDots { frame, total, dots, .. }) => {
            let listed = dots.iter().map(|dot| (dot.edge, dot.birth, dot.death.unwrap_or(f64::INFINITY)));
            dots_as_text(sink, name, (*frame, *total), listed)
        }
        _ => as_events(sink, name, message),
    }
}

fn as_events(sink: &mut impl Write, name: &str, message: &Message) -> io::Result<()> {
    match message {
        Message::Tracks(tracks) => {
            let shown = |event: &TrackEvent| {
                let (x, y) = event.track.center;
                let Track { id, birth, radius, .. } = event.track;
                (event.frame, event.happening, id, place(&[x, y]), birth, radius)
            };
            let count = tracks.alive.as_ref().map(Vec::len);
            tracks_as_text(sink, name, (tracks.from, tracks.frame, count), tracks.events.iter().map(shown))
        }
        Message::SpaceTracks(tracks) => {
            let shown = |event: &SpaceTrackEvent| {
                let SpaceTrack { id, birth, death, ref center, .. } = event.track;
                (event.frame, event.happening, id, place(center), birth, death.unwrap_or(f64::INFINITY))
            };
            let count = tracks.alive.as_ref().map(Vec::len);
            tracks_as_text(sink, name, (tracks.from, tracks.frame, count), tracks.events.iter().map(shown))
        }
        Message::StreamClosed(closed) => {
            let reason: String = closed.reason.chars().filter(|character| !character.is_control()).collect();
            writeln!(sink, "{name}  closed after frame {}: {reason}", closed.frame)
        }
        _ => Ok(()),
    }
}

fn snapshot_as_text(sink: &mut impl Write, frame: Line<'_>, size: usize, cause: Cause) -> io::Result<()> {
    let why = match cause {
        Cause::Start => "start",
        Cause::ViewChanged => "new view",
        Cause::Lagged => "lagged",
        Cause::CannotResume => "cannot resume",
    };
    writeln!(sink, "{frame}  all {size} ({why})")
}

/// A critical edge, birth and death.
type ShownDot = (Edge, f64, f64);

fn dots_as_text(
    sink: &mut impl Write,
    name: &str,
    (frame, total): (u64, u64),
    dots: impl ExactSizeIterator<Item = ShownDot>,
) -> io::Result<()> {
    write!(sink, "{name}  frame {frame}  dots {} of {total}:", dots.len())?;
    for ((a, b), birth, death) in dots {
        write!(sink, "  {}..{} ({a}-{b})", Short(birth), Short(death))?;
    }
    writeln!(sink)
}

/// Frame, what has happened, the track's id, its centre, birth and death.
type ShownEvent = (u64, Happening, u64, String, f64, f64);

/// What has happened, where it is more than a movement.
fn tracks_as_text(
    sink: &mut impl Write,
    name: &str,
    (from, frame, alive): (u64, u64, Option<usize>),
    events: impl Iterator<Item = ShownEvent>,
) -> io::Result<()> {
    if let (0, Some(alive)) = (from, alive) {
        writeln!(sink, "{name}  frame {frame}  {alive} tracks are alive")?;
    }
    for (frame, happening, id, place, birth, death) in events {
        let what = match happening {
            Happening::Updated(_) => continue,
            Happening::Born => "is born".to_owned(),
            Happening::Split(from) => format!("splits off from {from}"),
            Happening::Unselected => "is not selected any more".to_owned(),
            Happening::Reselected => "is selected again".to_owned(),
            Happening::Merged(into) => format!("merges into {into}"),
            Happening::Died => "dies".to_owned(),
        };
        let [birth, death] = [birth, death].map(Short);
        writeln!(sink, "{name}  frame {frame}  track {id} {what}: at {place}, {birth}..{death}")?;
    }
    Ok(())
}

/// Coordinates for people: of many, the first ones.
fn place(coordinates: &[f64]) -> String {
    const SHOWN: usize = 8;
    let mut words: Vec<String> = coordinates.iter().take(SHOWN).map(|&number| Short(number).to_string()).collect();
    if coordinates.len() > SHOWN {
        words.push("..".to_owned());
    }
    format!("({})", words.join(", "))
}

/// A frame, for people.
struct Line<'a> {
    name: &'a str,
    frame: &'a FrameInfo,
}

impl fmt::Display for Line<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &FrameInfo { number, time, points, vertices, rejected, view, ds, vs, components, cycles } = self.frame;
        write!(f, "{}  frame {number}", self.name)?;
        if let Some(time) = time {
            write!(f, "  time {time}")?;
        }
        write!(f, "  points {points} ({vertices} distinct)  components {components}  cycles {cycles}")?;
        if let Cut::Derived(..) = view.cut {
            let or_infinite = |scale: Option<f64>| scale.map_or("inf".to_owned(), |scale| Short(scale).to_string());
            write!(f, "  ds {} vs {}", or_infinite(ds), or_infinite(vs))?;
        }
        if rejected > 0 {
            write!(f, "  rejected {rejected}")?;
        }
        Ok(())
    }
}

#[derive(Serialize)]
struct LaggedLine<'a> {
    stream: &'a str,
    lagged: [u64; 2],
}

#[derive(Serialize)]
struct DotsLine<'a, D> {
    stream: &'a str,
    frame: u64,
    dots: Vec<D>,
    total: u64,
}

#[derive(Serialize)]
struct DotLine {
    birth: f64,
    death: f64,
    edge: (u64, u64),
    hole: HoleLine,
}

#[derive(Serialize)]
struct SpaceDotLine {
    birth: f64,
    death: Option<f64>,
    edge: (u64, u64),
    death_edge: Option<(u64, u64)>,
}

#[derive(Serialize)]
struct HoleLine {
    center: (f64, f64),
    radius: f64,
}

/// Writes a message about the stream of that name as a JSON line; nothing for one that has no such form.
///
/// # Errors
/// Those of the sink.
pub fn as_json(sink: &mut impl Write, name: &str, message: &Message) -> io::Result<()> {
    match message {
        Message::Lagged(Lagged { first, last, .. }) => {
            line(sink, &LaggedLine { stream: name, lagged: [*first, *last] })
        }
        Message::Dots(dots) => {
            let listed = dots.dots.iter().map(|dot| DotLine {
                birth: dot.birth,
                death: dot.death,
                edge: dot.edge,
                hole: HoleLine { center: dot.center, radius: dot.radius },
            });
            let (stream, dots, frame, total) = (name, listed.collect(), dots.frame, dots.total);
            line(sink, &DotsLine { stream, frame, dots, total })
        }
        Message::SpaceDots(SpaceDots { frame, total, dots, .. }) => {
            let listed = dots.iter().map(|dot| SpaceDotLine {
                birth: dot.birth,
                death: dot.death,
                edge: dot.edge,
                death_edge: dot.death_edge,
            });
            line(sink, &DotsLine { stream: name, frame: *frame, dots: listed.collect(), total: *total })
        }
        message => {
            let frame = FrameLine::new(name, message).map_or(Ok(()), |frame| line(sink, &frame));
            frame.and_then(|()| TracksLine::new(name, message).map_or(Ok(()), |tracks| line(sink, &tracks)))
        }
    }
}

fn line(sink: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *sink, value)?;
    sink.write_all(b"\n")
}
