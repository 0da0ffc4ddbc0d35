//! Points as `serve` and `feed` read them: text, JSON lines or the bytes of the protocol, as one series of inputs.
//!
//! In: a file, stdin or memory. Out: [`Input`]s, points in batches of a given size at the most, each with the place that it stands on: a line, or the byte at which its frame begins. Invariants: points that have arrived are handed on at once when
//! nothing further is waiting; nothing is left behind at the end; whoever does not listen any more ends the reading. Must not know: where inputs go.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

use anyhow::{Context, bail};
use hopes_protocol::Message;
use indicatif::ProgressBar;

use super::input::{Columns, Format, Limits, Reader, Record};
use super::recording::{Frames, Next};
use crate::daemon::{Batch, Input};

/// How the points are written.
#[derive(Clone, Debug)]
pub enum Form {
    /// Lines.
    Lines(Format, Columns),
    /// Frames of the protocol.
    Binary,
}

/// Where the points stand.
#[derive(Clone, Debug)]
pub enum Place {
    Stdin,
    File(PathBuf),
    Memory(&'static [u8]),
}

/// Where points come from.
#[derive(Clone, Debug)]
pub struct Source {
    pub place: Place,
    pub form: Form,
    /// Close a frame by itself after so many points.
    pub frame_points: Option<u64>,
    /// Close the last frame too; who knows better when a frame is open does it itself.
    pub closes_last: bool,
    /// Begin anew at the end.
    pub loops: bool,
    /// Points that are handed on together at the most.
    pub batch: usize,
}

/// Nobody listens any more.
struct Disconnected;

impl Source {
    /// Reads to the end, and over and over if it loops.
    pub fn read(&self, listener: &mut dyn FnMut(Input) -> bool, progress: &ProgressBar) -> anyhow::Result<()> {
        let mut outbox = Outbox {
            listener,
            batch: Batch::default(),
            most: self.batch.max(1),
            frame_points: self.frame_points,
            points: 0,
            is_open: false,
            has_frames: false,
        };
        loop {
            let heard = match &self.form {
                Form::Lines(format, columns) => self.lines(*format, columns.clone(), &mut outbox, progress)?,
                Form::Binary => self.binary(&mut outbox, progress)?,
            };
            let ended = heard.and_then(|()| if self.closes_last { outbox.end() } else { outbox.flush() });
            let Ok(()) = ended else { return Ok(()) };
            if !self.loops {
                return Ok(());
            }
            if !outbox.has_frames {
                bail!("there is nothing to loop over");
            }
        }
    }

    fn open(&self) -> anyhow::Result<Box<dyn Read>> {
        Ok(match &self.place {
            Place::Stdin => Box::new(std::io::stdin().lock()),
            Place::File(path) => Box::new(File::open(path).with_context(|| format!("cannot open {}", path.display()))?),
            Place::Memory(bytes) => Box::new(*bytes),
        })
    }

    fn lines(
        &self,
        format: Format,
        columns: Columns,
        outbox: &mut Outbox<'_>,
        progress: &ProgressBar,
    ) -> anyhow::Result<Result<(), Disconnected>> {
        let mut reader = Reader::new(self.open()?, format, columns, Limits::default());
        loop {
            let line = reader.line() + 1;
            // The error says its cause itself.
            let record = reader.next_record().map_err(|error| anyhow::anyhow!("{error}"))?;
            let sent = match record {
                None => return Ok(Ok(())),
                Some(Record::Points { points, time }) => {
                    points.iter().try_for_each(|&[x, y]| outbox.add((x, y), time, line))
                }
                Some(Record::Retract { points }) => outbox.retract(points.iter().map(|&[x, y]| (x, y)), line),
                Some(Record::Commit { time }) => outbox.commit(time),
                Some(Record::Blank) => outbox.commit(None),
                Some(Record::Nothing) => Ok(()),
                Some(Record::Bad(bad)) => outbox.report_error(bad.to_string()),
            };
            // Nothing waits here while the source has nothing more to say.
            let flushed = if reader.is_ready() { Ok(()) } else { outbox.flush() };
            if sent.and(flushed).is_err() {
                return Ok(Err(Disconnected));
            }
            if line % 1024 == 0 {
                progress.set_position(reader.bytes_read());
            }
        }
    }

    fn binary(&self, outbox: &mut Outbox<'_>, progress: &ProgressBar) -> anyhow::Result<Result<(), Disconnected>> {
        let mut frames = Frames::new(self.open()?);
        loop {
            let (offset, message) = match frames.next()? {
                Next::End => return Ok(Ok(())),
                Next::CutOff { offset } => {
                    tracing::warn!("the input is cut off at byte {offset}: all before it was sent");
                    return Ok(Ok(()));
                }
                Next::Message { offset, message, .. } => (offset, message),
            };
            progress.set_position(frames.offset());
            let sent = take(outbox, offset, message)?;
            // Nothing waits here while the source has nothing more to say.
            let flushed = if frames.has_more() { Ok(()) } else { outbox.flush() };
            if sent.and(flushed).is_err() {
                return Ok(Err(Disconnected));
            }
        }
    }
}

fn take(outbox: &mut Outbox<'_>, offset: u64, message: Message) -> anyhow::Result<Result<(), Disconnected>> {
    Ok(match message {
        Message::Batch(batch) if !batch.times.is_empty() && batch.times.len() != batch.points.len() => {
            let (points, times) = (batch.points.len(), batch.times.len());
            outbox.report_error(format!(
                "byte {offset}: {points} points with {times} times, where all or none must have one"
            ))
        }
        Message::Batch(batch) => batch
            .points
            .iter()
            .enumerate()
            .try_for_each(|(index, &(x, y))| outbox.add((x, y), batch.times.get(index).copied(), offset)),
        Message::Retract(retract) => outbox.retract(retract.points.into_iter(), offset),
        Message::Commit(commit) => outbox.commit(commit.time),
        Message::Elapsed(_) => Ok(()),
        Message::StreamOpened(_) | Message::Snapshot(_) | Message::Diff(_) => {
            bail!("at byte {offset} there is no point: this is a recording, see hopes replay");
        }
        other => outbox
            .report_error(format!("byte {offset}: a message of type {:#06x} has no place among points", other.kind())),
    })
}

/// Inputs on their way.
struct Outbox<'a> {
    listener: &'a mut dyn FnMut(Input) -> bool,
    batch: Batch,
    most: usize,
    frame_points: Option<u64>,
    /// Since the last frame.
    points: u64,
    /// Whether anything came since the last frame.
    is_open: bool,
    /// Whether there was any frame.
    has_frames: bool,
}

impl Outbox<'_> {
    fn add(&mut self, position: (f64, f64), time: Option<f64>, line: u64) -> Result<(), Disconnected> {
        // A message has times for all of its points, or for none.
        if !self.batch.positions.is_empty() && self.batch.times.is_empty() == time.is_some() {
            self.flush()?;
        }
        self.batch.positions.push(position);
        self.batch.times.extend(time);
        self.batch.lines.push(line);
        self.is_open = true;
        self.points += 1;
        if self.batch.positions.len() >= self.most {
            self.flush()?;
        }
        if self.frame_points.is_some_and(|limit| self.points >= limit) { self.commit(None) } else { Ok(()) }
    }

    fn retract(&mut self, points: impl Iterator<Item = (f64, f64)>, line: u64) -> Result<(), Disconnected> {
        self.flush()?;
        self.is_open = true;
        let points: Vec<(f64, f64)> = points.collect();
        points.chunks(self.most).try_for_each(|points| {
            let lines = vec![line; points.len()];
            self.say(Input::Retract(Batch { positions: points.to_vec(), lines, ..Batch::default() }))
        })
    }

    fn commit(&mut self, time: Option<f64>) -> Result<(), Disconnected> {
        self.flush()?;
        (self.points, self.is_open, self.has_frames) = (0, false, true);
        self.say(Input::Commit(time))
    }

    fn report_error(&mut self, reason: String) -> Result<(), Disconnected> {
        self.flush()?;
        self.say(Input::Unreadable(reason))
    }

    /// The end closes a frame that anything has come into.
    fn end(&mut self) -> Result<(), Disconnected> {
        if self.is_open { self.commit(None) } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Disconnected> {
        if self.batch.positions.is_empty() {
            return Ok(());
        }
        let batch = std::mem::take(&mut self.batch);
        self.say(Input::Points(batch))
    }

    fn say(&mut self, input: Input) -> Result<(), Disconnected> {
        if (self.listener)(input) { Ok(()) } else { Err(Disconnected) }
    }
}
