//! The points of a scene, in the forms that `serve` and `feed` read.
//!
//! In: frames. Out: whole clouds as text, or changes as JSON lines or messages of the protocol. Invariants: numbers are
//! written so that they are read as the same; no line and no message has more than a bounded number of points; what
//! goes is said before what comes. Must not know: scenes, truth.

use std::io::{self, Write};

use hopes::scene::Frame;
use hopes_protocol::{Banner, Batch, Commit, Message, Retract, VERSION, encode};
use serde::Serialize;

use super::Format;
use crate::daemon::BATCH;

/// The channel on which messages stand.
const CHANNEL: u32 = 1;

/// Writes points.
pub struct Points<W> {
    format: Format,
    sink: W,
    /// Of the next message.
    sequence: u64,
}

/// A line of JSON.
#[derive(Serialize)]
#[serde(untagged)]
enum Line<'a> {
    Retract { retract: &'a [[f64; 2]] },
    Points { points: &'a [[f64; 2]] },
    Commit { commit: bool, time: f64 },
}

impl<W: Write> Points<W> {
    /// Begins.
    pub fn new(format: Format, mut sink: W) -> io::Result<Self> {
        if format == Format::Bin {
            sink.write_all(&Banner { lowest: VERSION, highest: VERSION }.encode())?;
        }
        Ok(Self { format, sink, sequence: 0 })
    }

    /// Writes a frame, and closes it.
    pub fn frame(&mut self, frame: &Frame) -> io::Result<()> {
        match self.format {
            Format::Text => self.text(frame),
            Format::Jsonl => self.json_lines(frame),
            Format::Bin => self.messages(frame),
        }
    }

    /// Ends.
    pub fn finish(mut self) -> anyhow::Result<()> {
        Ok(self.sink.flush()?)
    }

    fn text(&mut self, frame: &Frame) -> io::Result<()> {
        frame.points.iter().try_for_each(|[x, y]| writeln!(self.sink, "{x},{y}"))?;
        writeln!(self.sink)
    }

    fn json_lines(&mut self, frame: &Frame) -> io::Result<()> {
        frame.gone.chunks(BATCH).try_for_each(|retract| self.line(&Line::Retract { retract }))?;
        frame.come.chunks(BATCH).try_for_each(|points| self.line(&Line::Points { points }))?;
        self.line(&Line::Commit { commit: true, time: frame.time })
    }

    fn line(&mut self, line: &Line<'_>) -> io::Result<()> {
        serde_json::to_writer(&mut self.sink, line)?;
        writeln!(self.sink)
    }

    fn messages(&mut self, frame: &Frame) -> io::Result<()> {
        let pairs = |points: &[[f64; 2]]| points.iter().map(|&[x, y]| (x, y)).collect::<Vec<_>>();
        for points in frame.gone.chunks(BATCH) {
            self.message(|sequence| Retract { sequence, points: pairs(points) }.into())?;
        }
        for points in frame.come.chunks(BATCH) {
            let (times, tags) = (Vec::new(), Vec::new());
            self.message(|sequence| Batch { sequence, points: pairs(points), times, tags }.into())?;
        }
        self.message(|sequence| Commit { sequence, time: Some(frame.time) }.into())
    }

    fn message(&mut self, message: impl FnOnce(u64) -> Message) -> io::Result<()> {
        let message = message(self.sequence);
        self.sequence += 1;
        self.sink.write_all(&encode(VERSION, CHANNEL, &message).map_err(io::Error::other)?)
    }
}
