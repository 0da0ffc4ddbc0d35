//! `hopes compute`: a file of points in, its skeleton out, once.
//!
//! In: a file or stdin, and options. Out: JSON, CSV, GeoJSON, SVG or PNG, to a file or stdout. Invariants: points that cannot be used
//! are reported, counted and left out, unless `--strict` stops at the first. Must not know: how skeletons are computed or pictures drawn.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufWriter, Cursor, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::{Args, ValueEnum};
use hopes::topology::{
    CoordinateError, Frame, Options, Pipeline, Position, Refusal, Simplified, View, ViewSpec, simplify,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::args::{ViewArgs, resolution, scale};
use super::formats::{Answer, OutputFormat};
use super::{Columns, Failure, Format, Limits, Reader, Record};
use crate::daemon::Complaints;

/// Compute the skeleton of a file of points, once.
///
/// Reads text (comma, semicolon, tab or blank separated, with or without a header, # comments) or JSON lines ([x,y] or
/// {"x":..,"y":..}). Writes the persistence diagram, the minimum spanning tree and the chosen view of the skeleton.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes compute points.csv                                 all of it as JSON
  hopes compute points.csv --format svg -o points.svg      a picture beside the persistence diagram
  hopes compute scan.tsv --columns lon,lat --k 2 --simplify --format geojson
  produce | hopes compute - --alpha 0.5                    the reduced skeleton at the scale 0.5")]
pub struct Compute {
    /// File of points; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How the points are written; by default the file's name and first bytes tell.
    #[arg(long, value_enum, default_value_t)]
    input: Input,
    /// Columns of a text file, by number from 1 or by name in the header.
    #[arg(long, value_name = "X,Y", default_value = "1,2")]
    columns: Columns,
    #[command(flatten)]
    view: ViewArgs,
    /// Snap positions to a grid of this step.
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// Also collapse the view's edges of half-length below RADIUS, the shortest first, keeping all cycles [default: vs, or alpha].
    #[arg(long, value_name = "RADIUS", value_parser = scale, num_args = 0..=1, require_equals = true)]
    simplify: Option<Option<f64>>,
    /// What to write.
    #[arg(short, long, value_enum, default_value_t)]
    format: OutputFormat,
    /// Where to write it [default: stdout].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Stop at the first line or point that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Input {
    /// By the file's name and first bytes.
    #[default]
    Auto,
    /// A table.
    Text,
    /// JSON lines.
    Jsonl,
}

/// Below this many bytes of input nobody waits long enough to want a bar.
const LONG_WORK: u64 = 8 << 20;

/// How many bytes may tell the form of the input.
const SNIFFED: u64 = 4096;

impl Compute {
    pub fn run(self) -> Result<(), Failure> {
        if self.simplify == Some(None) && self.view.spec() == ViewSpec::Full {
            return Err(Failure::Usage("--simplify with --full needs a radius: --simplify=RADIUS"));
        }
        let progress = self.progress();
        let (points, mut complaints) = self.read(&progress)?;
        progress.set_message("computing the skeleton");
        progress.enable_steady_tick(std::time::Duration::from_millis(100));
        let (frame, points) = self.compute(points, &mut complaints)?;
        let view = frame.view(self.view.spec());
        let simplified = self.simplified(&frame, &view);
        let answer = Answer {
            name: self.file.file_stem().and_then(|stem| stem.to_str()).filter(|_| !self.is_stdin()),
            skeleton: &frame.skeleton,
            view: &view,
            simplified: simplified.as_ref().map(|(threshold, simplified)| (*threshold, simplified)),
            duplicates: points - frame.skeleton.vertices().len() as u64,
            rejected: complaints.count(),
        };
        progress.set_message("writing");
        complaints.sum_up();
        self.write(&answer)?;
        progress.finish_and_clear();
        // The process ends here: giving back every page of a large skeleton first would only take time.
        std::mem::forget(frame);
        Ok(())
    }

    fn is_stdin(&self) -> bool {
        self.file == Path::new("-")
    }

    fn progress(&self) -> ProgressBar {
        let length = if self.is_stdin() { 0 } else { std::fs::metadata(&self.file).map_or(0, |data| data.len()) };
        if length < LONG_WORK || !io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let template = "{spinner} {msg:24} {wide_bar} {bytes}/{total_bytes} {elapsed}";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(length).with_style(style).with_message("reading points")
    }

    fn source(&self) -> Result<Box<dyn Read>, Failure> {
        if self.is_stdin() {
            return Ok(Box::new(io::stdin().lock()));
        }
        let file = File::open(&self.file).with_context(|| format!("cannot open {}", self.file.display()))?;
        Ok(Box::new(file))
    }

    /// The input's form, told from its first bytes where the file's name says nothing, and all of its bytes.
    fn sniffed(&self) -> Result<(Format, Box<dyn Read>), Failure> {
        let mut source = self.source()?;
        let format = match self.input {
            Input::Text => Format::Text,
            Input::Jsonl => Format::JsonLines,
            Input::Auto => {
                // A pipe may bring its first bytes one by one.
                let mut first = Vec::new();
                let read = source.by_ref().take(SNIFFED).read_to_end(&mut first);
                let read = read.with_context(|| format!("cannot read {}", self.file.display()))? as u64;
                let format = Format::sniff((!self.is_stdin()).then_some(self.file.as_path()), &first);
                let first = Cursor::new(first);
                source = if read < SNIFFED { Box::new(first) } else { Box::new(first.chain(source)) };
                format
            }
        };
        Ok((format, source))
    }

    fn read(&self, progress: &ProgressBar) -> Result<(Vec<Change>, Complaints), Failure> {
        let (format, source) = self.sniffed()?;
        let mut reader = Reader::new(source, format, self.columns.clone(), Limits::default());
        let mut complaints = Complaints::new(self.strict);
        let mut changes = vec![Change::default()];
        loop {
            let line = reader.line() + 1;
            // The error says its cause itself.
            let record =
                reader.next_record().map_err(|error| anyhow::anyhow!("in {}: {error}", self.file.display()))?;
            let Some(record) = record else { break };
            let retracts = matches!(record, Record::Retract { .. });
            match record {
                Record::Points { points, .. } | Record::Retract { points } => {
                    let change = Change::last(&mut changes, retracts);
                    for &point in points {
                        match self.position(point) {
                            Ok(_) => change.add(point, line),
                            Err(error) => complaints.add(&refused(point, line, &error))?,
                        }
                    }
                }
                Record::Commit { .. } | Record::Blank | Record::Nothing => {}
                Record::Bad(bad) => complaints.add(&bad)?,
            }
            if line % 65_536 == 0 {
                progress.set_position(reader.bytes_read());
            }
        }
        Ok((changes, complaints))
    }

    /// Where a point will be; those that have no position are refused while the line is known.
    fn position(&self, [x, y]: [f64; 2]) -> Result<Position, CoordinateError> {
        let position = Position::new(x, y)?;
        self.resolution.map_or(Ok(position), |step| position.snapped(step))
    }

    fn compute(&self, changes: Vec<Change>, complaints: &mut Complaints) -> Result<(Arc<Frame>, u64), Failure> {
        let mut pipeline = Pipeline::new(Options { resolution: self.resolution, ..Options::default() });
        for change in changes {
            for (index, refusal) in change.feed(&mut pipeline) {
                complaints.add(&refused(change.points[index], change.lines[index], &refusal))?;
            }
        }
        let points = pipeline.point_count();
        pipeline.commit(None);
        let frame = pipeline.poll_frame().context("the frame was taken before it was polled")?;
        std::mem::forget(pipeline);
        Ok((frame, points))
    }

    fn simplified(&self, frame: &Frame, view: &View) -> Option<(f64, Simplified)> {
        let threshold = match (self.simplify?, view.spec, &view.selection) {
            (Some(threshold), ..) => threshold,
            (None, ViewSpec::Reduced { alpha }, _) => alpha,
            (None, _, selection) => selection.as_ref().map_or(f64::INFINITY, |selection| selection.vs),
        };
        Some((threshold, simplify(&frame.skeleton, view, threshold)))
    }

    fn write(&self, answer: &Answer) -> Result<(), Failure> {
        match &self.output {
            None => {
                let mut stdout = BufWriter::with_capacity(1 << 16, io::stdout().lock());
                self.format.write(answer, &mut stdout).context("cannot write to stdout")?;
            }
            Some(path) => {
                let file = File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
                let mut file = BufWriter::with_capacity(1 << 16, file);
                let written = self.format.write(answer, &mut file).and_then(|()| Ok(file.flush()?));
                written.with_context(|| format!("cannot write {}", path.display()))?;
            }
        }
        Ok(())
    }
}

/// A run of points to insert, or to retract.
#[derive(Default)]
struct Change {
    points: Vec<[f64; 2]>,
    /// Of each point.
    lines: Vec<u64>,
    retracts: bool,
}

impl Change {
    /// The last change if it is of this kind, else a new one.
    fn last(changes: &mut Vec<Change>, retracts: bool) -> &mut Change {
        if changes.last().is_none_or(|last| last.retracts != retracts) {
            changes.push(Change { retracts, ..Change::default() });
        }
        let last = changes.len() - 1;
        &mut changes[last]
    }

    fn add(&mut self, point: [f64; 2], line: u64) {
        self.points.push(point);
        self.lines.push(line);
    }

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
