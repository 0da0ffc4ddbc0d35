//! Points from a file or stdin into a pipeline.
//!
//! In: a [`Source`]. Out: a pipeline fed, input errors about what could not be used, in order of the lines. Invariants: one thread reads while
//! another takes in, with a bounded way between them; a reader that nobody listens to any more stops at its next point, and nobody waits
//! for it. Must not know: what is computed of the points.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;

use anyhow::Context;
use hopes::topology::{CoordinateError, Pipeline, Position, Refusal};
use indicatif::ProgressBar;

use super::Failure;
use crate::daemon::InputErrors;
use crate::formats::input::{Columns, Format, Limits, Reader, Record};

/// Where points come from.
pub struct Source {
    /// The file; - for stdin.
    pub file: PathBuf,
    /// How the points are written; by default the file's name and first bytes tell.
    pub format: Option<Format>,
    /// Columns of a table.
    pub columns: Columns,
    /// Grid that positions snap to.
    pub resolution: Option<f64>,
}

/// How many bytes may tell the form of the input.
const SNIFFED: u64 = 4096;

/// Points that go to the other thread together.
const BATCH: usize = 16_384;

/// After so many lines the number of all points is estimated.
const SAMPLE: u64 = 1024;

/// Room is made for at most so many points that are only expected.
const FORESEEN: usize = 1 << 22;

/// Batches that may wait there.
const WAITING: usize = 4;

/// What the reading thread finds.
enum Found {
    Points(Batch),
    /// So many points are still to come, by the length of the file and what was read of it.
    More(usize),
    /// Something that cannot be used, and why.
    Bad(String),
}

/// Nobody takes points any more.
struct Disconnected;

impl Source {
    /// Reads all points into a pipeline.
    pub fn feed(
        self,
        pipeline: &mut Pipeline,
        input_errors: &mut InputErrors,
        progress: &ProgressBar,
    ) -> Result<(), Failure> {
        let (sender, receiver) = sync_channel(WAITING);
        let progress = progress.clone();
        let reading = thread::Builder::new()
            .name("reader".to_owned())
            .spawn(move || self.read(&sender, &progress))
            .context("cannot start the reader's thread")?;
        for found in receiver {
            match found {
                Found::Bad(reason) => input_errors.add(&reason)?,
                Found::More(points) => pipeline.reserve(points),
                Found::Points(batch) => {
                    for (index, refusal) in batch.feed(pipeline) {
                        input_errors.add(&refused(batch.points[index], batch.lines[index], &refusal))?;
                    }
                }
            }
        }
        Ok(reading.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?)
    }

    fn read(self, sender: &SyncSender<Found>, progress: &ProgressBar) -> anyhow::Result<()> {
        let (format, bytes) = self.opened()?;
        let length = std::fs::metadata(&self.file).map_or(0, |data| data.len());
        let mut reader = Reader::new(bytes, format, self.columns.clone(), Limits::default());
        let mut outbox = Outbox { sender, batch: Batch::default(), points: 0 };
        loop {
            let line = reader.line() + 1;
            // The error says its cause itself.
            let record = reader.next_record().map_err(|error| anyhow::anyhow!("in {}: {error}", self.file.display()));
            let sent = match record? {
                None => return outbox.flush().or(Ok(())),
                Some(Record::Points { points, .. }) => self.send(&mut outbox, points, line, false),
                Some(Record::Retract { points }) => self.send(&mut outbox, points, line, true),
                Some(Record::Commit { .. } | Record::Blank | Record::Nothing) => Ok(()),
                Some(Record::Bad(bad)) => outbox.report_error(&bad),
            };
            let told = if line == SAMPLE { outbox.tell_more(reader.bytes_read(), length) } else { Ok(()) };
            // Nothing waits here while the source has nothing more to say.
            let flushed = if reader.is_ready() { Ok(()) } else { outbox.flush() };
            if let Err(Disconnected) = sent.and(told).and(flushed) {
                return Ok(());
            }
            if line % 65_536 == 0 {
                progress.set_position(reader.bytes_read());
            }
        }
    }

    fn send(&self, outbox: &mut Outbox, points: &[[f64; 2]], line: u64, retracts: bool) -> Result<(), Disconnected> {
        for &point in points {
            match self.position(point) {
                Ok(_) => outbox.add(point, line, retracts)?,
                Err(error) => outbox.report_error(&refused(point, line, &error))?,
            }
        }
        Ok(())
    }

    /// Where a point will be; those that have no position are refused here, where the line is known.
    fn position(&self, [x, y]: [f64; 2]) -> Result<Position, CoordinateError> {
        let position = Position::new(x, y)?;
        self.resolution.map_or(Ok(position), |step| position.snapped(step))
    }

    /// The input's form, told from its first bytes where the file's name says nothing, and all of its bytes.
    fn opened(&self) -> anyhow::Result<(Format, Box<dyn Read>)> {
        let is_stdin = self.file == Path::new("-");
        let unread = || format!("cannot read {}", self.file.display());
        let mut source: Box<dyn Read> = if is_stdin {
            Box::new(io::stdin().lock())
        } else {
            Box::new(File::open(&self.file).with_context(|| format!("cannot open {}", self.file.display()))?)
        };
        if let Some(format) = self.format {
            return Ok((format, source));
        }
        // A pipe may bring its first bytes one by one.
        let mut first = Vec::new();
        let read = source.by_ref().take(SNIFFED).read_to_end(&mut first).with_context(unread)? as u64;
        let format = Format::sniff((!is_stdin).then_some(self.file.as_path()), &first);
        let first = Cursor::new(first);
        Ok((format, if read < SNIFFED { Box::new(first) } else { Box::new(first.chain(source)) }))
    }
}

/// Points of one kind on their way, in order with the input errors.
struct Outbox<'a> {
    sender: &'a SyncSender<Found>,
    batch: Batch,
    /// So far.
    points: u64,
}

impl Outbox<'_> {
    fn add(&mut self, point: [f64; 2], line: u64, retracts: bool) -> Result<(), Disconnected> {
        if self.batch.retracts != retracts || self.batch.points.len() == BATCH {
            self.flush()?;
            self.batch.retracts = retracts;
        }
        self.batch.points.push(point);
        self.batch.lines.push(line);
        self.points += 1;
        Ok(())
    }

    /// Tells what is to come if the rest of the file is like the lines before; only a guess, so it is held within bounds.
    fn tell_more(&mut self, bytes: u64, length: u64) -> Result<(), Disconnected> {
        let more = length.saturating_sub(bytes) as f64 / bytes.max(1) as f64 * self.points as f64;
        self.sender.send(Found::More((more as usize).min(FORESEEN))).map_err(|_| Disconnected)
    }

    fn report_error(&mut self, reason: &dyn Display) -> Result<(), Disconnected> {
        self.flush()?;
        self.sender.send(Found::Bad(reason.to_string())).map_err(|_| Disconnected)
    }

    fn flush(&mut self) -> Result<(), Disconnected> {
        if self.batch.points.is_empty() {
            return Ok(());
        }
        self.sender.send(Found::Points(std::mem::take(&mut self.batch))).map_err(|_| Disconnected)
    }
}

/// A run of points to insert, or to retract.
#[derive(Default)]
struct Batch {
    points: Vec<[f64; 2]>,
    /// Of each point.
    lines: Vec<u64>,
    retracts: bool,
}

impl Batch {
    fn feed(&self, pipeline: &mut Pipeline) -> Vec<(usize, Refusal)> {
        match self.retracts {
            true => pipeline.feed_retractions(&self.points),
            false => pipeline.feed_points(&self.points, None),
        }
    }
}

/// How `daemon` says it too.
fn refused([x, y]: [f64; 2], line: u64, reason: &dyn Display) -> String {
    format!("line {line}, point ({x}, {y}): {reason}")
}
