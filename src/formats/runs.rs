//! Points of a file as a pipeline takes them: long runs of points to insert or to retract.
//!
//! In: a [`RunSource`].
//! Out: [`Found`]: runs, what cannot be used, and a guess of how many points are still to come; in the order of the
//! lines.
//! Invariants: positions that cannot be are refused here, where the line is known. Points that have arrived are
//! sent on at once when no further bytes are waiting. A sink that returns false ends the reading.
//! Must not know: what is computed of the points.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use hopes::topology::{CoordinateError, Exact, Pipeline, Position, Refusal};
use thiserror::Error;

use super::degrees::tell_choice;
use super::input::{Columns, Format, Limits, ReadError, Reader, Record, opened};
use super::projection::Projector;

/// Where points come from.
#[derive(Clone)]
pub struct RunSource {
    /// The file; - for stdin.
    pub file: PathBuf,
    /// How the points are written; by default, by the file's name or first bytes.
    pub format: Option<Format>,
    /// Columns of a table.
    pub columns: Columns,
    /// Grid that positions snap to.
    pub resolution: Option<f64>,
    /// Whether the caller makes metres of degrees.
    pub is_projected: bool,
}

/// Points of one run, at most.
const LONGEST: usize = 16_384;

/// After so many lines the number of all points is estimated.
const SAMPLE: u64 = 1024;

/// The largest number of points that is ever announced.
const FORESEEN: usize = 1 << 22;

/// What is found in the file.
pub enum Found {
    /// Points.
    Run(Run),
    /// So many points are still to come, by the length of the file and what was read of it.
    More(usize),
    /// Something that cannot be used, and why.
    Bad(String),
}

/// Why a file cannot be read on.
#[derive(Debug, Error)]
pub enum RunsError {
    /// No such file.
    #[error("cannot open {}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Its first bytes cannot be read.
    #[error("cannot read {}", path.display())]
    Begin {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The rest of it. The text names the cause.
    #[error("in {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: ReadError,
    },
}

/// The sink takes no more.
struct Closed;

impl RunSource {
    /// Reads to the end. From time to time, `progress` is called with the bytes read.
    ///
    /// # Errors
    /// [`RunsError`].
    pub fn read(self, sink: &mut dyn FnMut(Found) -> bool, progress: &dyn Fn(u64)) -> Result<(), RunsError> {
        let (format, bytes) = self.open()?;
        let length = std::fs::metadata(&self.file).map_or(0, |data| data.len());
        let mut reader = Reader::new(bytes, format, self.columns.clone(), Limits::default());
        let mut gatherer = Gatherer { sink, run: Run::default(), points: 0, unit: reader.unit() };
        loop {
            let line = reader.next_line();
            let record = reader.next_record();
            let sent = match record.map_err(|reason| RunsError::Read { path: self.file.clone(), reason })? {
                None => return gatherer.flush().or(Ok(())),
                Some(Record::Points { points, .. }) => self.take(&mut gatherer, points, line, false),
                Some(Record::Retract { points }) => self.take(&mut gatherer, points, line, true),
                Some(Record::Commit { .. } | Record::Blank | Record::Nothing) => Ok(()),
                Some(Record::Bad(bad)) => gatherer.report_error(&bad),
                Some(Record::Missed(reason)) => gatherer.report_error(&reason),
            };
            if let Some(choice) = reader.take_choice() {
                tell_choice(&self.name(), &choice, self.is_projected);
            }
            let announced = if line == SAMPLE { gatherer.announce(reader.bytes_read(), length) } else { Ok(()) };
            // Nothing waits here while the source has no further bytes.
            let flushed = if reader.is_ready() { Ok(()) } else { gatherer.flush() };
            if let Err(Closed) = sent.and(announced).and(flushed) {
                return Ok(());
            }
            if line % 65_536 == 0 {
                progress(reader.bytes_read());
            }
        }
    }

    fn name(&self) -> String {
        if self.file == Path::new("-") { "stdin".to_owned() } else { self.file.display().to_string() }
    }

    fn take(&self, gatherer: &mut Gatherer, points: &[[f64; 2]], line: u64, retracts: bool) -> Result<(), Closed> {
        for &point in points {
            match self.position(point) {
                Ok(_) => gatherer.add(point, line, retracts)?,
                Err(error) => gatherer.report_error(&refused(point, gatherer.unit, line, &error))?,
            }
        }
        Ok(())
    }

    /// Where a point will be, if it can be anywhere.
    fn position(&self, [x, y]: [f64; 2]) -> Result<Position, CoordinateError> {
        let position = Position::new(x, y)?;
        self.resolution.map_or(Ok(position), |step| position.snapped(step))
    }

    /// The form of the input, guessed from its first bytes if the file's name does not say it, and all of its bytes.
    fn open(&self) -> Result<(Format, Box<dyn Read>), RunsError> {
        let is_stdin = self.file == Path::new("-");
        let path = || self.file.clone();
        let source: Box<dyn Read> = if is_stdin {
            Box::new(io::stdin().lock())
        } else {
            Box::new(File::open(&self.file).map_err(|source| RunsError::Open { path: path(), source })?)
        };
        opened((!is_stdin).then_some(self.file.as_path()), self.format, source).map_err(|reason| match reason {
            ReadError::Io { source, .. } => RunsError::Begin { path: path(), source },
            reason => RunsError::Read { path: path(), reason },
        })
    }
}

/// Gathers points of one kind into runs, in order with what cannot be used.
struct Gatherer<'a> {
    sink: &'a mut dyn FnMut(Found) -> bool,
    run: Run,
    /// So far.
    points: u64,
    /// What the places of points count.
    unit: &'static str,
}

impl Gatherer<'_> {
    fn add(&mut self, point: [f64; 2], line: u64, retracts: bool) -> Result<(), Closed> {
        if self.run.retracts != retracts || self.run.points.len() == LONGEST {
            self.flush()?;
            self.run.retracts = retracts;
        }
        self.run.unit = self.unit;
        self.run.points.push(point);
        self.run.lines.push(line);
        self.points += 1;
        Ok(())
    }

    /// Announces how many points are to come if the rest of the file is like the lines before. This is only a guess, so
    /// it is bounded.
    fn announce(&mut self, bytes: u64, length: u64) -> Result<(), Closed> {
        let more = length.saturating_sub(bytes) as f64 / bytes.max(1) as f64 * self.points as f64;
        self.send(Found::More((more as usize).min(FORESEEN)))
    }

    fn report_error(&mut self, reason: &dyn Display) -> Result<(), Closed> {
        self.flush()?;
        self.send(Found::Bad(reason.to_string()))
    }

    fn flush(&mut self) -> Result<(), Closed> {
        if self.run.points.is_empty() {
            return Ok(());
        }
        let run = std::mem::take(&mut self.run);
        self.send(Found::Run(run))
    }

    fn send(&mut self, found: Found) -> Result<(), Closed> {
        if (self.sink)(found) { Ok(()) } else { Err(Closed) }
    }
}

/// Points to insert, or to retract.
#[derive(Default)]
pub struct Run {
    points: Vec<[f64; 2]>,
    /// Of each point.
    lines: Vec<u64>,
    /// What these count.
    unit: &'static str,
    retracts: bool,
}

impl Run {
    /// Takes its points from degrees to metres. Those that have no place there are left out, each with its line and the
    /// reason.
    pub fn project(&mut self, projector: &mut Projector) -> Vec<String> {
        let mut refused = Vec::new();
        let (points, lines) = (std::mem::take(&mut self.points), std::mem::take(&mut self.lines));
        for (point, line) in points.into_iter().zip(lines) {
            match projector.metres(point) {
                Ok(metres) => {
                    self.points.push(metres);
                    self.lines.push(line);
                }
                Err(error) => refused.push(format!("{} {line}: {error}", self.unit)),
            }
        }
        refused
    }

    /// Feeds a pipeline. The points that it refuses, each with its line and the reason.
    pub fn feed(&self, pipeline: &mut Pipeline) -> impl Iterator<Item = String> + '_ {
        let refusals: Vec<(usize, Refusal)> = match self.retracts {
            true => pipeline.feed_retractions(&self.points),
            false => pipeline.feed_points(&self.points, None),
        };
        refusals.into_iter().map(|(index, refusal)| refused(self.points[index], self.unit, self.lines[index], &refusal))
    }
}

/// In the words of the daemon.
fn refused([x, y]: [f64; 2], unit: &str, line: u64, reason: &dyn Display) -> String {
    format!("{unit} {line}, point ({}, {}): {reason}", Exact(x), Exact(y))
}
