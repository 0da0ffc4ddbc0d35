//! `hopes serve`: points on stdin, one JSON line a frame on stdout.
//!
//! In: options; text or JSON lines. Out: a running daemon; its [`Input`]s, read line by line. Invariants: points that have arrived are
//! handed on at once when no further line is waiting. Must not know: what the engine does with them.

use std::io::{self, Read};
use std::num::NonZeroUsize;
use std::time::Duration;

use clap::{Args, ValueEnum};
use hopes::topology::Options;

use super::args::{ViewArgs, duration, resolution, window};
use super::{Columns, Failure, Format, Limits, ReadError, Reader, Record};
use crate::daemon::{self, BATCH, DaemonError, Feed, Input, Point, Settings};

/// Follow a stream of points: stdin to stdout, one JSON line a frame with what changed.
///
/// A blank line, {"commit":true,"time":t}, --frame-points, --frame-every or the end of the input closes a frame.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  sensor | hopes serve --window points:10000 --frame-points 1000
  camera-edges | hopes serve --input jsonl --window frames:1 | jq -c '[.frame, .view.cycles]'
  tail -f log.csv | hopes serve --columns lon,lat --window time:60 --frame-every 100ms")]
pub struct Serve {
    /// How points are written on stdin.
    #[arg(long, value_enum, default_value_t)]
    input: InputFormat,
    /// Columns of text input, by number from 1 or by name in the header; a third one is the event time.
    #[arg(long, value_name = "X,Y[,T]", default_value = "1,2")]
    columns: Columns,
    /// Which points stay: all, points:N (the last N), frames:N (the last N frames), time:T (the last T of event time).
    #[arg(long, value_name = "WINDOW", default_value = "all", value_parser = window)]
    window: hopes::topology::Window,
    /// Snap positions to a grid of this step.
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    #[command(flatten)]
    view: ViewArgs,
    /// Close a frame after so many points.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frame_points: Option<u64>,
    /// Close a frame every so often, such as 100ms.
    #[arg(long, value_name = "DURATION", value_parser = duration)]
    frame_every: Option<Duration>,
    /// How frames are written on stdout.
    #[arg(long, value_enum, default_value_t)]
    output: OutputFormat,
    /// Stop at the first line or point that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
    /// Reduce tiles on so many threads; the output is the same on any number [default: one for each processor].
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Recompute every frame from scratch and compare; stop at a difference (exit code 1). Slow: for those who want to be sure.
    #[arg(long)]
    check: bool,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum InputFormat {
    /// A table: comma, semicolon, tab or blank separated.
    #[default]
    Text,
    /// JSON lines.
    Jsonl,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum OutputFormat {
    /// JSON lines.
    #[default]
    Jsonl,
}

impl Serve {
    pub fn run(self) -> Result<(), Failure> {
        let settings = Settings {
            options: Options { window: self.window, resolution: self.resolution },
            view: self.view.spec(),
            frame_points: self.frame_points,
            frame_every: self.frame_every,
            strict: self.strict,
            check: self.check,
            threads: self.threads,
        };
        let format = match self.input {
            InputFormat::Text => Format::Text,
            InputFormat::Jsonl => Format::JsonLines,
        };
        let OutputFormat::Jsonl = self.output;
        let reader = Reader::new(io::stdin(), format, self.columns, Limits::default());
        match daemon::run(settings, move |feed| read(reader, &feed), io::stdout()) {
            Err(DaemonError::Refused(stop)) => Err(stop.into()),
            other => Ok(other?),
        }
    }
}

/// Reads until the end or until nobody listens.
fn read(mut reader: Reader<impl Read>, feed: &Feed) {
    let mut batch = Vec::new();
    loop {
        let line = reader.line() + 1;
        let record = match reader.next_record() {
            Ok(Some(record)) => record,
            Ok(None) => break,
            Err(error) => return fail(feed, batch, &error),
        };
        let listening = match record {
            Record::Points { points, time } => {
                points.chunks(BATCH).all(|points| add(feed, &mut batch, points, time, line))
            }
            Record::Retract { points } => {
                let retract = |points: &[[f64; 2]]| Input::Retract(at_line(points, None, line).collect());
                flush(feed, &mut batch) && points.chunks(BATCH).all(|points| feed.send(retract(points)))
            }
            Record::Commit { time } => flush(feed, &mut batch) && feed.send(Input::Commit(time)),
            Record::Blank => flush(feed, &mut batch) && feed.send(Input::Commit(None)),
            Record::Nothing => true,
            Record::Bad(bad) => flush(feed, &mut batch) && feed.send(Input::Unreadable(bad.to_string())),
        };
        if !listening || !reader.is_ready() && !flush(feed, &mut batch) {
            return;
        }
    }
    flush(feed, &mut batch);
}

fn fail(feed: &Feed, mut batch: Vec<Point>, error: &ReadError) {
    if flush(feed, &mut batch) {
        feed.send(Input::Failed(error.to_string()));
    }
}

/// Adds points to the batch, and sends it when it is large.
fn add(feed: &Feed, batch: &mut Vec<Point>, points: &[[f64; 2]], time: Option<f64>, line: u64) -> bool {
    batch.extend(at_line(points, time, line));
    batch.len() < BATCH || flush(feed, batch)
}

fn at_line(points: &[[f64; 2]], time: Option<f64>, line: u64) -> impl Iterator<Item = Point> {
    points.iter().map(move |&position| Point { position, time, line })
}

/// Sends the batch, if there is one.
fn flush(feed: &Feed, batch: &mut Vec<Point>) -> bool {
    batch.is_empty() || feed.send(Input::Points(std::mem::take(batch)))
}
