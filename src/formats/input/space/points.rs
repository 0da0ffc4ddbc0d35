//! Points of any dimension, line by line as they arrive; or the delay vectors of a series.
//!
//! In: a source, and which columns are coordinates.
//! Out: one [`PointRecord`] a line.
//! Invariants: all points have as many coordinates, finite and without negative zeros. A point that cannot be used
//! loses only itself, and is told with its place. Of a series, a sample or line that cannot be used is a gap, and no
//! vector holds samples from both of its sides.
//! Must not know: what becomes of the points.

use std::io::Read;
use std::path::Path;

use super::super::columns::Columns;
use super::super::error::{BadLineReason, Fault, Field};
use super::super::format::{Format, opened};
use super::super::jsonl::Faults;
use super::super::reader::{Limits, Reader};
use super::super::record::Record;
use super::super::text::{Choice, TableColumns};
use super::check::Check;
use super::columns::{Most, SpaceColumns};
use super::embedding::{Delays, Embedding};
use super::{MOST_COORDINATES, SpaceError};

/// What the coordinates are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// Numbers, as many as there are.
    Any(SpaceColumns),
    /// Longitude and latitude in degrees, found as x and y of the plane are.
    Degrees(Columns),
}

impl Default for Coordinates {
    fn default() -> Self {
        Self::Any(SpaceColumns::default())
    }
}

/// How points are read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PointSettings {
    /// How they are written; by default, by the file's name or first bytes.
    pub format: Option<Format>,
    /// What they are.
    pub coordinates: Coordinates,
    /// Whether a column of event times is read if the header names one.
    pub wants_times: bool,
    /// The points are samples of a series, and their delay vectors are read.
    pub embedding: Option<Embedding>,
}

/// What one line says. Coordinates are lent until the next record is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum PointRecord<'a> {
    /// Points to add, one after the other. There may be none.
    Points {
        /// Of all of them.
        coordinates: &'a [f64],
        /// When they were seen, if the line says so.
        time: Option<f64>,
    },
    /// Points to take back.
    Retract {
        /// Of all of them.
        coordinates: &'a [f64],
    },
    /// The end of a frame, asked for in so many words.
    Commit {
        /// The time of the frame, if the line says so.
        time: Option<f64>,
    },
    /// An empty line.
    Blank,
    /// A header or a comment.
    Nothing,
    /// Something that cannot be used: where, and why.
    Refused(String),
}

/// After so many coordinates, the other points of a line come as a record of their own. A long line of samples may
/// become much more than the line.
const LONGEST: usize = 1 << 16;

/// Reads points line by line.
pub struct PointReader<'a> {
    reader: AnyReader<'a>,
    judge: Judge,
    place: u64,
    unit: &'static str,
}

type Source<'a> = Box<dyn Read + 'a>;

enum AnyReader<'a> {
    Any(Reader<Source<'a>, SpaceColumns>),
    Degrees(Reader<Source<'a>>),
}

/// Calls the same of either reader.
macro_rules! either {
    ($reader:expr, $name:ident => $call:expr) => {
        match $reader {
            AnyReader::Any($name) => $call,
            AnyReader::Degrees($name) => $call,
        }
    };
}

impl<'a> PointReader<'a> {
    /// Reads `source`. The end of its path, if it has one, may say how points are written.
    ///
    /// # Errors
    /// Its first bytes cannot be read, or are of a kind that is not.
    pub fn new(path: Option<&Path>, source: impl Read + 'a, settings: &PointSettings) -> Result<Self, SpaceError> {
        let (format, source) = opened(path, settings.format, source)?;
        let (limits, times) = (Limits::default(), settings.wants_times);
        let reader = match settings.coordinates.clone() {
            Coordinates::Any(columns) => {
                let columns = columns.with(times, Most::Coordinates(MOST_COORDINATES));
                AnyReader::Any(Reader::new(source, format, columns, limits))
            }
            Coordinates::Degrees(columns) => {
                AnyReader::Degrees(Reader::new(source, format, columns.with_times(times), limits))
            }
        };
        let is_degrees = matches!(reader, AnyReader::Degrees(_));
        let delays = settings.embedding.map(Delays::new);
        let unit = either!(&reader, reader => reader.unit());
        Ok(Self { reader, judge: Judge::new(Check::new(is_degrees), delays), place: 0, unit })
    }

    /// The record of the next line; none at the end.
    ///
    /// # Errors
    /// [`SpaceError`]: the source fails, or holds what cannot be points of one space.
    pub fn next_record(&mut self) -> Result<Option<PointRecord<'_>>, SpaceError> {
        if let Some(fault) = self.judge.faults.next() {
            return Ok(Some(PointRecord::Refused(self.said(&fault))));
        }
        if !self.judge.has_points() {
            self.place = either!(&self.reader, reader => reader.next_line());
        }
        let place = || format!("{} {}", self.unit, self.place);
        let step = either!(&mut self.reader, reader => self.judge.step(reader, &place))?;
        let coordinates = &self.judge.good;
        Ok(step.map(|step| match step {
            Step::Points { time } => PointRecord::Points { coordinates, time },
            Step::Retract => PointRecord::Retract { coordinates },
            Step::Commit { time } => PointRecord::Commit { time },
            Step::Blank => PointRecord::Blank,
            Step::Nothing => PointRecord::Nothing,
            Step::Refused(reason) => PointRecord::Refused(reason),
        }))
    }

    /// How many coordinates points have, once it is known.
    pub fn dimension(&self) -> Option<usize> {
        let own = self.judge.check.dimension();
        self.judge.delays.as_ref().map_or(own, |delays| Some(delays.dimension()))
    }

    /// How often a series was interrupted.
    pub fn gaps(&self) -> u64 {
        self.judge.delays.as_ref().map_or(0, Delays::gaps)
    }

    /// Where the last record stands: its line, or in files without lines its point or element.
    pub fn place(&self) -> String {
        format!("{} {}", self.unit, self.place)
    }

    /// The same as a number: what [`unit`](Self::unit) says is counted from 1.
    pub fn number(&self) -> u64 {
        self.place
    }

    /// What places count: lines, unless the file has none.
    pub fn unit(&self) -> &'static str {
        self.unit
    }

    /// Whether the next record is at hand, so that asking for it would not wait for the source.
    pub fn is_ready(&mut self) -> bool {
        let has_more = !self.judge.faults.is_empty() || self.judge.has_points();
        has_more || either!(&mut self.reader, reader => reader.is_ready())
    }

    /// How many bytes of the source have been used.
    pub fn bytes_read(&self) -> u64 {
        either!(&self.reader, reader => reader.bytes_read())
    }

    /// What was chosen without being asked for, for people; once, after it is known.
    pub fn take_choice(&mut self) -> Option<Choice> {
        either!(&mut self.reader, reader => reader.take_choice())
    }

    fn said(&self, fault: &Fault) -> String {
        let place = self.place();
        match fault.field {
            Some(field) => format!("{place}, {field}: {}", fault.reason),
            None => format!("{place}: {}", fault.reason),
        }
    }
}

/// A record whose points are kept by the judge.
#[derive(Clone)]
enum Step {
    Points { time: Option<f64> },
    Retract,
    Commit { time: Option<f64> },
    Blank,
    Nothing,
    Refused(String),
}

/// Tells good points from bad ones.
struct Judge {
    check: Check,
    delays: Option<Delays>,
    /// The coordinates of the points of a line, and where each point ends.
    read: Vec<f64>,
    ends: Vec<usize>,
    /// How many of them were judged, and what their line says.
    judged: usize,
    line: Step,
    /// The coordinates of those that can be used.
    good: Vec<f64>,
    /// What is wrong with the others.
    faults: Faults,
}

impl Judge {
    fn new(check: Check, delays: Option<Delays>) -> Self {
        let (read, ends, good, faults) = (Vec::new(), Vec::new(), Vec::new(), Faults::default());
        Self { check, delays, read, ends, judged: 0, line: Step::Nothing, good, faults }
    }

    /// Whether points of the last line were not judged yet.
    fn has_points(&self) -> bool {
        self.judged < self.ends.len()
    }

    /// Reads a line, and judges its points; or further points of the line before.
    fn step<R: Read, C>(
        &mut self,
        reader: &mut Reader<R, C>,
        place: &dyn Fn() -> String,
    ) -> Result<Option<Step>, SpaceError>
    where
        C: TableColumns,
        C::Point: AsRef<[f64]>,
    {
        self.good.clear();
        if self.has_points() {
            self.judge(place, |coordinate| reader.field(coordinate))?;
            return Ok(Some(self.line.clone()));
        }
        self.line = match reader.next_record()? {
            None => return Ok(None),
            Some(Record::Points { points, time }) => {
                self.load(points);
                Step::Points { time }
            }
            Some(Record::Retract { points }) => {
                self.load(points);
                Step::Retract
            }
            Some(Record::Commit { time }) => Step::Commit { time },
            Some(Record::Blank) => Step::Blank,
            Some(Record::Nothing) => Step::Nothing,
            Some(Record::Bad(bad)) => Step::Refused(bad.to_string()),
            Some(Record::Missed(reason)) => Step::Refused(reason),
        };
        let is_broken = reader.has_fault();
        let samples = self.ends.len();
        match (&self.line, &mut self.delays) {
            (Step::Retract, Some(_)) => return Ok(Some(self.leave_out(BadLineReason::NothingTakenBack))),
            // Nobody knows where in a broken list its gaps are.
            (Step::Points { .. }, Some(delays)) if is_broken => {
                delays.interrupt();
                return Ok(Some(self.leave_out(BadLineReason::BrokenList { samples })));
            }
            (Step::Points { .. } | Step::Retract, _) => self.judge(place, |coordinate| reader.field(coordinate))?,
            (Step::Refused(_), Some(delays)) => delays.interrupt(),
            _ => {}
        }
        Ok(Some(self.line.clone()))
    }

    /// The whole line cannot be used.
    fn leave_out(&mut self, reason: BadLineReason) -> Step {
        self.judged = self.ends.len();
        self.faults.add(Fault::of_line(reason));
        Step::Nothing
    }

    fn load<P: AsRef<[f64]>>(&mut self, points: &[P]) {
        self.read.clear();
        self.ends.clear();
        self.judged = 0;
        for point in points {
            self.read.extend_from_slice(point.as_ref());
            self.ends.push(self.read.len());
        }
    }

    /// Keeps the good points of a line; of a series, the vectors that end with its samples.
    fn judge(&mut self, place: &dyn Fn() -> String, field: impl Fn(usize) -> Field) -> Result<(), SpaceError> {
        let mut start = self.judged.checked_sub(1).map_or(0, |last| self.ends[last]);
        for &end in &self.ends[self.judged..] {
            if self.good.len() >= LONGEST {
                break;
            }
            self.judged += 1;
            let point = &mut self.read[start..end];
            start = end;
            let found = point.len();
            if self.delays.is_some() && found != 1 {
                return Err(SpaceError::Series { place: place(), found });
            }
            if found > MOST_COORDINATES {
                return Err(SpaceError::Dimension { place: place(), found, most: MOST_COORDINATES });
            }
            match (self.check.take(point), &mut self.delays) {
                (Ok(()), None) => self.good.extend_from_slice(point),
                (Ok(()), Some(delays)) => self.good.extend(delays.push(point[0]).into_iter().flatten()),
                (Err((coordinate, reason)), delays) => {
                    delays.iter_mut().for_each(Delays::interrupt);
                    self.faults.add(Fault { field: coordinate.map(&field), reason });
                }
            }
        }
        Ok(())
    }
}
