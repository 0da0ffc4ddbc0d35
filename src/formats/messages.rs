//! The ways in which frames are shown: a line for people, what happens to tracks, JSON lines, a recording.
//!
//! In: messages about streams that were taken by [`Streams`]. Out: text or bytes on a sink, flushed with every message. Invariants: the JSON line of a frame is that of `serve`; a gap is always told (`lagged`); what a peer has
//! named is printable. Must not know: where messages come from.

use std::fmt;
use std::io::{self, Write};
use std::time::Duration;

use clap::ValueEnum;
use hopes_protocol::{
    Cause, Cut, Diff, Dot, Dots, FrameInfo, Happening, Lagged, Message, Snapshot, TrackEvent, Tracks,
};
use serde::Serialize;

use super::frame_line::{FrameLine, TracksLine};
use super::recording::Recording;
use crate::client::mirrors::Streams;

/// How frames are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Output {
    /// A line a frame, for people.
    #[default]
    Text,
    /// What happens to tracks and nothing else, for people.
    Events,
    /// JSON lines, as of serve.
    Jsonl,
    /// A recording, for replay.
    Bin,
}

/// Writes what it is shown.
pub enum Show<W> {
    /// For people.
    Text(W),
    /// For people who want to know of tracks only.
    Events(W),
    /// For programs.
    Jsonl(W),
    /// For replay.
    Bin(Recording<W>),
}

impl<W: Write> Show<W> {
    /// Writes what stands at the beginning.
    pub fn new(output: Output, sink: W) -> io::Result<Self> {
        Ok(match output {
            Output::Text => Self::Text(sink),
            Output::Events => Self::Events(sink),
            Output::Jsonl => Self::Jsonl(sink),
            Output::Bin => Self::Bin(Recording::new(sink)?),
        })
    }

    /// Shows a message that came so long after the first.
    pub fn message(&mut self, streams: &Streams, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        match self {
            Self::Text(sink) => as_text(sink, streams, message).and_then(|()| sink.flush()),
            Self::Events(sink) => as_events(sink, streams, message).and_then(|()| sink.flush()),
            Self::Jsonl(sink) => as_json(sink, streams, message).and_then(|()| sink.flush()),
            Self::Bin(recording) => recording.write(elapsed, channel, message),
        }
    }

    /// Whether whoever looks at the output sees this there.
    pub fn tells(&self, message: &Message) -> bool {
        match self {
            Self::Text(_) => matches!(message, Message::Lagged(_) | Message::StreamClosed(_)),
            Self::Events(_) => matches!(message, Message::StreamClosed(_)),
            Self::Jsonl(_) => matches!(message, Message::Lagged(_)),
            Self::Bin(_) => false,
        }
    }

    /// Bytes of the recording.
    pub fn recorded(&self) -> u64 {
        match self {
            Self::Text(_) | Self::Events(_) | Self::Jsonl(_) => 0,
            Self::Bin(recording) => recording.bytes(),
        }
    }
}

/// The name of a stream; those that are shown were announced.
fn name(streams: &Streams, number: u32) -> &str {
    streams.get(number).map_or("", |stream| stream.name.as_str())
}

fn as_text(sink: &mut impl Write, streams: &Streams, message: &Message) -> io::Result<()> {
    match message {
        Message::Snapshot(snapshot) => {
            let Snapshot { vertices, edges, critical, .. } = snapshot;
            let size = vertices.len() + edges.len() + critical.len();
            let why = match snapshot.cause {
                Cause::Start => "start",
                Cause::ViewChanged => "new view",
                Cause::Lagged => "lagged",
                Cause::CannotResume => "cannot resume",
            };
            let frame = Line { name: name(streams, snapshot.stream), frame: &snapshot.frame };
            writeln!(sink, "{frame}  all {size} ({why})")
        }
        Message::Diff(diff) => {
            let (added, removed) = size(diff);
            let frame = Line { name: name(streams, diff.stream), frame: &diff.frame };
            writeln!(sink, "{frame}  +{added} -{removed}")
        }
        Message::Lagged(Lagged { stream, first, last }) => {
            writeln!(sink, "{}  frames {first} to {last} come as one: this side was too slow", name(streams, *stream))
        }
        Message::Dots(dots) => dots_as_text(sink, name(streams, dots.stream), dots),
        _ => as_events(sink, streams, message),
    }
}

fn as_events(sink: &mut impl Write, streams: &Streams, message: &Message) -> io::Result<()> {
    match message {
        Message::Tracks(tracks) => tracks_as_text(sink, name(streams, tracks.stream), tracks),
        Message::StreamClosed(closed) => {
            let reason: String = closed.reason.chars().filter(|character| !character.is_control()).collect();
            writeln!(sink, "{}  closed after frame {}: {reason}", name(streams, closed.stream), closed.frame)
        }
        _ => Ok(()),
    }
}

/// How much is new, and how much is gone.
fn size(diff: &Diff) -> (usize, usize) {
    let added = diff.vertices_added.len() + diff.edges_added.len() + diff.critical_set.len();
    let removed = diff.vertices_removed.len() + diff.edges_removed.len() + diff.critical_removed.len();
    (added, removed)
}

fn dots_as_text(sink: &mut impl Write, name: &str, dots: &Dots) -> io::Result<()> {
    write!(sink, "{name}  frame {}  dots {} of {}:", dots.frame, dots.dots.len(), dots.total)?;
    for Dot { edge: (a, b), birth, death, .. } in &dots.dots {
        write!(sink, "  {}..{} ({a}-{b})", Short(*birth), Short(*death))?;
    }
    writeln!(sink)
}

/// What has happened, where it is more than a movement.
fn tracks_as_text(sink: &mut impl Write, name: &str, tracks: &Tracks) -> io::Result<()> {
    if let (0, Some(alive)) = (tracks.from, &tracks.alive) {
        writeln!(sink, "{name}  frame {}  {} tracks are alive", tracks.frame, alive.len())?;
    }
    for TrackEvent { frame, happening, track, .. } in &tracks.events {
        let what = match happening {
            Happening::Updated(_) => continue,
            Happening::Born => "is born".to_owned(),
            Happening::Split(from) => format!("splits off from {from}"),
            Happening::Unselected => "is not selected any more".to_owned(),
            Happening::Reselected => "is selected again".to_owned(),
            Happening::Merged(into) => format!("merges into {into}"),
            Happening::Died => "dies".to_owned(),
        };
        let (x, y) = track.center;
        let [x, y, radius, birth] = [x, y, track.radius, track.birth].map(Short);
        writeln!(sink, "{name}  frame {frame}  track {} {what}: at ({x}, {y}), {birth}..{radius}", track.id)?;
    }
    Ok(())
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

/// A number to four digits.
pub struct Short(pub f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = format!("{:.3e}", self.0);
        match rounded.parse::<f64>() {
            Ok(value) if value == 0.0 || (1e-4..1e7).contains(&value.abs()) => write!(f, "{value}"),
            _ => f.write_str(&rounded),
        }
    }
}

#[derive(Serialize)]
struct LaggedLine<'a> {
    stream: &'a str,
    lagged: [u64; 2],
}

#[derive(Serialize)]
struct DotsLine<'a> {
    stream: &'a str,
    frame: u64,
    dots: Vec<DotLine>,
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
struct HoleLine {
    center: (f64, f64),
    radius: f64,
}

fn as_json(sink: &mut impl Write, streams: &Streams, message: &Message) -> io::Result<()> {
    match message {
        Message::Snapshot(snapshot) => line(sink, &FrameLine::of_snapshot(name(streams, snapshot.stream), snapshot)),
        Message::Diff(diff) => line(sink, &FrameLine::new(name(streams, diff.stream), diff)),
        Message::Lagged(Lagged { stream, first, last }) => {
            line(sink, &LaggedLine { stream: name(streams, *stream), lagged: [*first, *last] })
        }
        Message::Dots(dots) => {
            let listed = dots.dots.iter().map(|dot| DotLine {
                birth: dot.birth,
                death: dot.death,
                edge: dot.edge,
                hole: HoleLine { center: dot.center, radius: dot.radius },
            });
            let (stream, dots, frame, total) = (name(streams, dots.stream), listed.collect(), dots.frame, dots.total);
            line(sink, &DotsLine { stream, frame, dots, total })
        }
        Message::Tracks(tracks) => line(sink, &TracksLine::new(name(streams, tracks.stream), tracks)),
        _ => Ok(()),
    }
}

fn line(sink: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *sink, value)?;
    sink.write_all(b"\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, shown) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123456, "0.1235"),
            (12345.6, "12350"),
            (1e-9, "1.000e-9"),
            (6.02e23, "6.020e23"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Short(value).to_string(), shown);
        }
    }
}
