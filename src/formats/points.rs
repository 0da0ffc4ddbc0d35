//! Points as `serve` and `feed` read them: text, JSON lines or the bytes of the protocol, as one series of inputs.
//!
//! In: a file, stdin, or what a function opens.
//! Out: [`Input`]s. Points come in batches of bounded size, each point with its place: the line that it stands on,
//! or the byte at which its frame of the protocol begins.
//! Invariants: points that have arrived are sent on at once when no further bytes are waiting. Nothing is left
//! behind at the end, also if that is a failure. A sink that returns false ends the reading.
//! Must not know: where inputs go.

mod spaces;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use hopes_protocol::{Message, SpaceBatch};
use thiserror::Error;

use super::degrees::tell_choice;
use super::input::space::{MOST_COORDINATES, PointSettings, SpaceError};
use super::input::{Columns, Format, Limits, ReadError, Reader, Record, opened};
use super::recording::{Frames, Next, RecordingError};
use crate::daemon::{Batch, Input, Point, Positions};

/// How the points are written.
#[derive(Clone, Debug)]
pub enum Form {
    /// Lines; without a format, by the file's name or first bytes.
    Lines(Option<Format>, Columns),
    /// Lines of points of R^d.
    Space(PointSettings),
    /// Frames of the protocol.
    Binary,
}

impl Form {
    /// The same, with event times where the header names them, if these are wanted.
    #[must_use]
    pub fn with_times(self, wants_times: bool) -> Self {
        match self {
            Self::Lines(format, columns) => Self::Lines(format, columns.with_times(wants_times)),
            Self::Space(settings) => Self::Space(PointSettings { wants_times, ..settings }),
            Self::Binary => Self::Binary,
        }
    }
}

/// Where the bytes come from.
#[derive(Clone, Debug)]
pub enum Origin {
    Stdin,
    File(PathBuf),
    /// What the function opens: anything else that can be read, and read anew.
    Opened(fn() -> Box<dyn Read>),
}

/// Reads points.
#[derive(Clone, Debug)]
pub struct PointSource {
    pub origin: Origin,
    pub form: Form,
    /// Close a frame after so many points.
    pub frame_points: Option<u64>,
    /// Close the last frame too, unless the receiver does that itself.
    pub closes_last: bool,
    /// Begin anew at the end.
    pub loops: bool,
    /// Points of one batch, at most.
    pub batch: usize,
    /// Whether the caller makes metres of degrees.
    pub is_projected: bool,
}

/// Why points cannot be read on.
#[derive(Debug, Error)]
pub enum PointsError {
    /// No such file.
    #[error("cannot open {}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The source failed. The text names the cause.
    #[error("{0}")]
    Read(ReadError),
    /// The source failed, or has no points of one space. The text names the cause.
    #[error("{0}")]
    Space(SpaceError),
    /// The bytes are no frames of the protocol.
    #[error(transparent)]
    Frames(#[from] RecordingError),
    /// A recording of frames, not of points.
    #[error("at byte {offset} there is no point: this is a recording, see hopes replay")]
    Recording {
        /// Where.
        offset: u64,
    },
    /// A loop over an empty input.
    #[error("there is nothing to loop over")]
    NothingToLoop,
}

/// The sink takes no more.
struct Closed;

impl PointSource {
    /// Reads to the end, and over and over if it loops. From time to time, `progress` is called with the bytes read.
    ///
    /// # Errors
    /// [`PointsError`].
    pub fn read(&self, sink: &mut dyn FnMut(Input) -> bool, progress: &dyn Fn(u64)) -> Result<(), PointsError> {
        let mut batcher = Batcher {
            sink,
            batch: Batch::default(),
            most: self.batch.max(1),
            frame_points: self.frame_points,
            points: 0,
            is_open: false,
            has_frames: false,
            place: "line",
        };
        loop {
            let read = match &self.form {
                Form::Lines(format, columns) => self.lines(*format, columns.clone(), &mut batcher, progress),
                Form::Space(settings) => spaces::read_lines(self, settings, &mut batcher, progress),
                Form::Binary => self.binary(&mut batcher, progress),
            };
            let read = read.inspect_err(|_| {
                // What came before the failure is good. A closed sink has no use for either.
                let _ = batcher.flush();
            })?;
            let ended = read.and_then(|()| if self.closes_last { batcher.end() } else { batcher.flush() });
            let Ok(()) = ended else { return Ok(()) };
            if !self.loops {
                return Ok(());
            }
            if !batcher.has_frames {
                return Err(PointsError::NothingToLoop);
            }
        }
    }

    fn open(&self) -> Result<Box<dyn Read>, PointsError> {
        Ok(match &self.origin {
            Origin::Stdin => Box::new(io::stdin().lock()),
            Origin::Opened(open) => open(),
            Origin::File(path) => {
                Box::new(File::open(path).map_err(|source| PointsError::Open { path: path.clone(), source })?)
            }
        })
    }

    /// The file, if it is one.
    fn path(&self) -> Option<&Path> {
        if let Origin::File(path) = &self.origin { Some(path) } else { None }
    }

    fn name(&self) -> String {
        match &self.origin {
            Origin::File(path) => path.display().to_string(),
            Origin::Stdin | Origin::Opened(_) => "stdin".to_owned(),
        }
    }

    fn with_format(&self, format: Option<Format>) -> Result<(Format, Box<dyn Read>), PointsError> {
        let source = self.open()?;
        opened(self.path(), format, source).map_err(PointsError::Read)
    }

    fn lines(
        &self,
        format: Option<Format>,
        columns: Columns,
        batcher: &mut Batcher<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Result<(), Closed>, PointsError> {
        let (format, source) = self.with_format(format)?;
        let mut reader = Reader::new(source, format, columns, Limits::default());
        batcher.place = reader.unit();
        loop {
            let line = reader.next_line();
            let sent = match reader.next_record().map_err(PointsError::Read)? {
                None => return Ok(Ok(())),
                Some(Record::Points { points, time }) => {
                    points.iter().try_for_each(|&[x, y]| batcher.add(Point::Plane(x, y), time, line))
                }
                Some(Record::Retract { points }) => batcher.retract(plane(points), line),
                Some(Record::Commit { time }) => batcher.commit(time),
                Some(Record::Blank) => batcher.commit(None),
                Some(Record::Nothing) => Ok(()),
                Some(Record::Bad(bad)) => batcher.report_error(bad.to_string()),
                Some(Record::Missed(reason)) => batcher.report_error(reason),
            };
            if let Some(choice) = reader.take_choice() {
                tell_choice(&self.name(), &choice, self.is_projected);
            }
            // Nothing waits here while the source has no further bytes.
            let flushed = if reader.is_ready() { Ok(()) } else { batcher.flush() };
            if sent.and(flushed).is_err() {
                return Ok(Err(Closed));
            }
            if line % 1024 == 0 {
                progress(reader.bytes_read());
            }
        }
    }

    fn binary(&self, batcher: &mut Batcher<'_>, progress: &dyn Fn(u64)) -> Result<Result<(), Closed>, PointsError> {
        let mut frames = Frames::new(self.open()?);
        batcher.place = "byte";
        loop {
            let (offset, message) = match frames.next()? {
                Next::End => return Ok(Ok(())),
                Next::CutOff { offset } => {
                    return Ok(
                        batcher.report_error(format!("the input is cut off at byte {offset}: all before it was sent"))
                    );
                }
                Next::Message { offset, message, .. } => (offset, message),
            };
            progress(frames.offset());
            let sent = take(batcher, offset, message)?;
            // Nothing waits here while the source has no further bytes.
            let flushed = if frames.has_more() { Ok(()) } else { batcher.flush() };
            if sent.and(flushed).is_err() {
                return Ok(Err(Closed));
            }
        }
    }
}

fn take(batcher: &mut Batcher<'_>, offset: u64, message: Message) -> Result<Result<(), Closed>, PointsError> {
    Ok(match message {
        Message::Batch(batch) if !batch.times.is_empty() && batch.times.len() != batch.points.len() => {
            let (points, times) = (batch.points.len(), batch.times.len());
            batcher.report_error(format!(
                "byte {offset}: {points} points with {times} times, where all or none must have one"
            ))
        }
        Message::Batch(batch) => {
            batch.points.iter().enumerate().try_for_each(|(index, &(x, y))| {
                batcher.add(Point::Plane(x, y), batch.times.get(index).copied(), offset)
            })
        }
        Message::Retract(retract) => batcher.retract(Positions::Plane(retract.points), offset),
        Message::SpaceBatch(batch) => space_points(batcher, offset, &batch),
        Message::SpaceRetract(retract) => match whole_points(retract.dimension, retract.coordinates) {
            Ok(points) => batcher.retract(points, offset),
            Err(reason) => batcher.report_error(format!("byte {offset}: {reason}")),
        },
        Message::Commit(commit) => batcher.commit(commit.time),
        Message::Elapsed(_) => Ok(()),
        message if matches!(message, Message::StreamOpened(_)) || message.frame().is_some() => {
            return Err(PointsError::Recording { offset });
        }
        other => batcher
            .report_error(format!("byte {offset}: a message of type {:#06x} has no place among points", other.kind())),
    })
}

fn space_points(batcher: &mut Batcher<'_>, offset: u64, batch: &SpaceBatch) -> Result<(), Closed> {
    let points = match whole_points(batch.dimension, batch.coordinates.clone()) {
        Ok(points) => points,
        Err(reason) => return batcher.report_error(format!("byte {offset}: {reason}")),
    };
    if !batch.times.is_empty() && batch.times.len() != points.len() {
        let (points, times) = (points.len(), batch.times.len());
        return batcher.report_error(format!(
            "byte {offset}: {points} points with {times} times, where all or none must have one"
        ));
    }
    (0..points.len()).try_for_each(|index| batcher.add(points.get(index), batch.times.get(index).copied(), offset))
}

fn whole_points(dimension: u32, coordinates: Vec<f64>) -> Result<Positions, String> {
    let (dimension, numbers) = (dimension as usize, coordinates.len());
    if !(1..=MOST_COORDINATES).contains(&dimension) || !numbers.is_multiple_of(dimension) {
        return Err(format!("{numbers} coordinates are no whole points of dimension {dimension}"));
    }
    Ok(Positions::Space { dimension, coordinates })
}

fn plane(points: &[[f64; 2]]) -> Positions {
    Positions::Plane(points.iter().map(|&[x, y]| (x, y)).collect())
}

/// Gathers points into batches, in order with all other inputs.
struct Batcher<'a> {
    sink: &'a mut dyn FnMut(Input) -> bool,
    batch: Batch,
    most: usize,
    frame_points: Option<u64>,
    /// Since the last frame.
    points: u64,
    /// Whether anything came since the last frame was closed.
    is_open: bool,
    /// Whether there was any frame.
    has_frames: bool,
    /// What the places of points count.
    place: &'static str,
}

impl Batcher<'_> {
    fn add(&mut self, point: Point, time: Option<f64>, line: u64) -> Result<(), Closed> {
        // A message has times for all of its points, or for none.
        let has_other_times = !self.batch.positions.is_empty() && self.batch.times.is_empty() == time.is_some();
        if has_other_times || !self.batch.positions.takes(point) {
            self.flush()?;
        }
        self.batch.positions.push(point);
        self.batch.times.extend(time);
        self.batch.lines.push(line);
        self.is_open = true;
        self.points += 1;
        if self.batch.positions.len() >= self.most {
            self.flush()?;
        }
        if self.frame_points.is_some_and(|limit| self.points >= limit) { self.commit(None) } else { Ok(()) }
    }

    fn retract(&mut self, points: Positions, line: u64) -> Result<(), Closed> {
        self.flush()?;
        self.is_open = true;
        (0..points.len()).step_by(self.most).try_for_each(|first| {
            let positions = points.some(first..points.len().min(first + self.most));
            let lines = vec![line; positions.len()];
            self.send(Input::Retract(Batch { positions, lines, place: self.place, ..Batch::default() }))
        })
    }

    fn commit(&mut self, time: Option<f64>) -> Result<(), Closed> {
        self.flush()?;
        (self.points, self.is_open, self.has_frames) = (0, false, true);
        self.send(Input::Commit(time))
    }

    fn report_error(&mut self, reason: String) -> Result<(), Closed> {
        self.flush()?;
        self.send(Input::Unreadable(reason))
    }

    /// The end of the input closes a frame that is not empty.
    fn end(&mut self) -> Result<(), Closed> {
        if self.is_open { self.commit(None) } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), Closed> {
        if self.batch.positions.is_empty() {
            return Ok(());
        }
        let batch = std::mem::take(&mut self.batch);
        self.send(Input::Points(Batch { place: self.place, ..batch }))
    }

    fn send(&mut self, input: Input) -> Result<(), Closed> {
        if (self.sink)(input) { Ok(()) } else { Err(Closed) }
    }
}

#[cfg(test)]
mod tests {
    use hopes_protocol::{Banner, Commit, VERSION, encode};

    use super::*;

    /// Two frames of the protocol, and then bytes that are none.
    fn damaged() -> Vec<u8> {
        let batch =
            hopes_protocol::Batch { sequence: 1, points: vec![(1.0, 2.0), (3.0, 4.0)], times: vec![], tags: vec![] };
        let mut bytes = Banner::OURS.encode().to_vec();
        for message in [Commit { sequence: 2, time: None }.into(), batch.into()] {
            bytes.extend(encode(VERSION, 1, &message).expect("it is short"));
        }
        bytes.extend([b'?'; 40]);
        bytes
    }

    #[test]
    fn points_before_damage_are_sent_though_they_arrived_with_it() {
        let source = PointSource {
            origin: Origin::Opened(|| Box::new(io::Cursor::new(damaged()))),
            form: Form::Binary,
            frame_points: None,
            closes_last: true,
            loops: false,
            batch: 4096,
            is_projected: false,
        };
        let mut inputs = Vec::new();
        let mut sink = |input| {
            inputs.push(input);
            true
        };
        assert!(matches!(source.read(&mut sink, &|_| ()), Err(PointsError::Frames(RecordingError::Frame { .. }))));
        let [Input::Commit(None), Input::Points(points)] = &inputs[..] else { panic!("{inputs:?}") };
        assert_eq!(points.positions, Positions::Plane(vec![(1.0, 2.0), (3.0, 4.0)]));
    }
}
