//! Points on their way out, in the forms that `serve` and `feed` read.
//!
//! In: points to add and to take back, ends of frames.
//! Out: text, JSON lines, or messages of the protocol.
//! Invariants: numbers are written so that they are read as the same; no line and no message has more than a
//! bounded number of points.
//! Must not know: where points come from.

use std::fmt::Display;
use std::io::{self, Write};

use hopes_protocol::{Banner, Batch, Commit, FILE_VERSION, Message, Retract, encode};
use serde::Serialize;

use crate::daemon::BATCH;

/// How points are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PointForm {
    /// x,y (or all coordinates) a line, and a blank line at the end of a frame.
    #[default]
    Text,
    /// JSON lines: `{"points":[[x,y],...]}`, and `{"commit":true,"time":t}` at the end of a frame.
    Jsonl,
    /// Messages of the protocol: Batch and Commit. They take points in the plane only.
    Bin,
}

/// A coordinate of a point.
pub trait Coordinate: Copy + Display + Serialize + Into<f64> {}

impl<T: Copy + Display + Serialize + Into<f64>> Coordinate for T {}

/// A point: its coordinates.
pub trait Point<C>: AsRef<[C]> + Serialize {}

impl<C, P: AsRef<[C]> + Serialize> Point<C> for P {}

/// The channel on which messages stand.
const CHANNEL: u32 = 1;

/// Writes points.
pub struct PointWriter<W> {
    form: PointForm,
    sink: W,
    /// Of the next message.
    sequence: u64,
}

/// A line of JSON.
#[derive(Serialize)]
#[serde(untagged)]
enum Line<'a, P> {
    Retract {
        retract: &'a [P],
    },
    Points {
        points: &'a [P],
    },
    Commit {
        commit: bool,
        #[serde(skip_serializing_if = "Option::is_none")]
        time: Option<f64>,
    },
}

impl<W: Write> PointWriter<W> {
    /// Nothing is written yet.
    pub fn new(form: PointForm, sink: W) -> Self {
        Self { form, sink, sequence: 0 }
    }

    /// Adds points.
    pub fn add<C: Coordinate>(&mut self, points: &[impl Point<C>]) -> io::Result<()> {
        match self.form {
            PointForm::Text => points.iter().try_for_each(|point| self.row(point.as_ref())),
            PointForm::Jsonl => points.chunks(BATCH).try_for_each(|points| self.line(&Line::Points { points })),
            PointForm::Bin => points.chunks(BATCH).try_for_each(|points| {
                let (points, times, tags) = (pairs(points)?, Vec::new(), Vec::new());
                self.message(|sequence| Batch { sequence, points, times, tags }.into())
            }),
        }
    }

    /// Takes points back; text has no way to say so.
    pub fn retract<C: Coordinate>(&mut self, points: &[impl Point<C>]) -> io::Result<()> {
        match self.form {
            PointForm::Text => Ok(()),
            PointForm::Jsonl => points.chunks(BATCH).try_for_each(|retract| self.line(&Line::Retract { retract })),
            PointForm::Bin => points.chunks(BATCH).try_for_each(|points| {
                let points = pairs(points)?;
                self.message(|sequence| Retract { sequence, points }.into())
            }),
        }
    }

    /// Closes a frame; text has no way to say its time.
    pub fn commit(&mut self, time: Option<f64>) -> io::Result<()> {
        match self.form {
            PointForm::Text => writeln!(self.sink),
            PointForm::Jsonl => self.line::<[f64; 2]>(&Line::Commit { commit: true, time }),
            PointForm::Bin => self.message(|sequence| Commit { sequence, time }.into()),
        }
    }

    /// Lets go of all that was written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }

    fn row<C: Coordinate>(&mut self, coordinates: &[C]) -> io::Result<()> {
        for (axis, coordinate) in coordinates.iter().enumerate() {
            write!(self.sink, "{}{coordinate}", if axis == 0 { "" } else { "," })?;
        }
        writeln!(self.sink)
    }

    fn line<P: Serialize>(&mut self, line: &Line<'_, P>) -> io::Result<()> {
        serde_json::to_writer(&mut self.sink, line)?;
        writeln!(self.sink)
    }

    /// Ends: messages have a banner, even if there are none.
    pub fn finish(&mut self) -> io::Result<()> {
        if self.form == PointForm::Bin && self.sequence == 0 {
            self.banner()?;
        }
        self.flush()
    }

    fn banner(&mut self) -> io::Result<()> {
        self.sink.write_all(&Banner { lowest: FILE_VERSION, highest: FILE_VERSION }.encode())
    }

    fn message(&mut self, message: impl FnOnce(u64) -> Message) -> io::Result<()> {
        if self.sequence == 0 {
            self.banner()?;
        }
        let message = message(self.sequence);
        self.sequence += 1;
        self.sink.write_all(&encode(FILE_VERSION, CHANNEL, &message).map_err(io::Error::other)?)
    }
}

fn pairs<C: Coordinate>(points: &[impl Point<C>]) -> io::Result<Vec<(f64, f64)>> {
    let pair = |point: &_| match AsRef::<[C]>::as_ref(point) {
        &[x, y] => Ok((x.into(), y.into())),
        other => {
            let reason =
                format!("the protocol's binary form takes points in the plane, not {} coordinates", other.len());
            Err(io::Error::new(io::ErrorKind::InvalidInput, reason))
        }
    };
    points.iter().map(pair).collect()
}
