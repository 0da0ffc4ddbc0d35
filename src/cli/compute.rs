//! `hopes compute`: a file of points in, its skeleton out, once.
//!
//! In: a file or stdin, and options.
//! Out: JSON, CSV, GeoJSON, SVG or PNG, to a file or stdout.
//! Invariants: points that cannot be used are reported, counted and left out, unless `--strict` stops at the first.
//! One thread reads while another inserts, with a bounded queue between them.
//! Must not know: how skeletons are computed or pictures drawn.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread;

use anyhow::{Context, anyhow};
use clap::{Args, ValueEnum};
use hopes::topology::{Frame, Options, Pipeline, Simplified, View, simplify};
use indicatif::ProgressBar;

use super::args::{SimplifiedViewArgs, Threshold, resolution};
use super::{Failure, files, progress};
use crate::daemon::InputErrors;
use crate::formats::input::{Columns, Format};
use crate::formats::runs::{Found, RunSource};
use crate::formats::skeleton::{Answer, OutputFormat};

/// Compute the skeleton of a file of points, once.
///
/// Reads a table (comma, semicolon, tab or blank separated, with or without a header line, # comments) or JSON lines:
/// [x,y], {"x":..,"y":..} or {"points":[[x,y],...]}. Writes the persistence diagram, the minimum spanning tree and the
/// chosen view of the skeleton.
#[derive(Debug, Args)]
#[command(
    after_help = EXAMPLES,
    after_long_help = format!("{EXAMPLES}\n\n{KEYS}"),
)]
pub struct Compute {
    /// File of points; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How the points are written.
    #[arg(long, value_enum, default_value_t)]
    input: Input,
    /// Columns of a table, by number from 1 or by name in the header [default: what the header calls x and y, or lon
    /// and lat; else 1,2].
    #[arg(long, value_name = "X,Y")]
    columns: Option<Columns>,
    /// Snap positions to a grid of this step.
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// What to write.
    #[arg(short, long, value_enum, default_value_t)]
    format: OutputFormat,
    /// Where to write it; - for stdout [default: -].
    ///
    /// A file that is there is replaced at the end, by the whole answer, or not at all.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Stop at the first line or point that cannot be used (exit code 3).
    ///
    /// Without it, such lines and points are reported with their line, counted and left out.
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    view: SimplifiedViewArgs,
}

const EXAMPLES: &str = "Examples:
  hopes compute points.csv                                 all of it as JSON
  hopes compute points.csv --format svg -o points.svg      a picture beside the persistence diagram
  hopes compute scan.tsv --columns lon,lat -k 2 --simplify --format geojson
  produce | hopes compute - --alpha 0.5                    the reduced skeleton at the scale 0.5";

const KEYS: &str = "Keys of the JSON output:
  points      how many distinct positions
  duplicates  points beyond the first on their position
  rejected    lines and points that could not be used
  vertices    [x,y] in order of first appearance; all indices refer to them
  dots        the persistence diagram, most persistent first:
              birth, death, edge [i,j], hole {center, radius}
  mst         edges [i,j] and length of the minimum spanning tree
  view        kind, k, l, ds, vs, edges, critical, components, cycles, length,
              margins {diagonal, vertical}; a reduced view has alpha in the place of
              k, l, ds, vs and margins
  simplified  with --simplify: threshold, vertices [x,y], edges [i,j]

Margins say how much noise on every point leaves the chosen gaps the chosen ones. A gap that is
not there counts as width 0. An infinite number is null: vs of a cloud without dots, the vertical
margin for l = 1.

A line of the CSV output: kind,i,j,x1,y1,x2,y2,length,birth,death,persistence";

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Input {
    /// By the file's name, else its first bytes.
    #[default]
    Auto,
    /// A table: comma, semicolon, tab or blank separated.
    Text,
    /// JSON lines: [x,y], {"x":..,"y":..}, {"points":[[x,y],...]}.
    Jsonl,
}

/// Below this many bytes of input, the work is too short for a progress bar.
const LONG_WORK: u64 = 8 << 20;

/// What is said where pictures cannot be made into pixels.
const NO_PNG: &str =
    "this hopes was built without PNG output: use --format svg, or build it again with the feature png (on by default)";

/// Runs of points that may wait to be inserted.
const WAITING: usize = 4;

impl Compute {
    pub fn run(self) -> Result<(), Failure> {
        if !self.format.is_built_in() {
            return Err(Failure::Usage(NO_PNG));
        }
        let threshold = self.view.threshold()?;
        if files::is_pipe(&self.file) {
            files::check_stdin()?;
        }
        // A stdout that is closed is refused before the work.
        let output = self.output.as_deref().filter(|&path| !files::is_pipe(path));
        let stdout = if output.is_none() { Some(files::stdout()?) } else { None };
        let progress = self.progress();
        let mut input_errors = InputErrors::new(self.strict).of(files::name(&self.file));
        let (frame, points) = self.compute(&progress, &mut input_errors)?;
        let rejected = input_errors.count();
        input_errors.sum_up();
        if points == 0 && rejected > 0 {
            let name = files::name(&self.file).unwrap_or_else(|| "stdin".to_owned());
            let what = "nothing in it could be used";
            return Err(anyhow!("{name}: {what}, of {rejected} lines or points: see hopes help compute").into());
        }
        let view = frame.view(self.view.spec());
        let simplified = threshold.map(|threshold| simplified(&frame, &view, threshold));
        let answer = Answer {
            name: self.file.file_stem().and_then(|stem| stem.to_str()).filter(|_| !files::is_pipe(&self.file)),
            skeleton: &frame.skeleton,
            view: &view,
            simplified: simplified.as_ref().map(|(threshold, simplified)| (*threshold, simplified)),
            duplicates: points - frame.skeleton.vertices().len() as u64,
            rejected,
        };
        progress.set_message("writing");
        self.write(&answer, stdout, output)?;
        progress.finish_and_clear();
        // The process ends here: giving back every page of a large skeleton first would only take time.
        std::mem::forget(frame);
        Ok(())
    }

    fn progress(&self) -> ProgressBar {
        let length = if files::is_pipe(&self.file) { 0 } else { progress::length(&self.file) };
        if length < LONG_WORK {
            return ProgressBar::hidden();
        }
        let template = "{spinner} {msg:24} {wide_bar} {bytes}/{total_bytes} {elapsed}";
        progress::bar(length, template).with_message("reading points")
    }

    fn compute(&self, progress: &ProgressBar, input_errors: &mut InputErrors) -> Result<(Arc<Frame>, u64), Failure> {
        let mut pipeline = Pipeline::new(Options { resolution: self.resolution, ..Options::default() });
        feed(self.source(), &mut pipeline, input_errors, progress)?;
        progress.set_message("computing the skeleton");
        progress.enable_steady_tick(progress::TICK);
        let points = pipeline.point_count();
        pipeline.commit(None);
        let frame = pipeline.poll_frame().context("the frame was taken before it was polled")?;
        std::mem::forget(pipeline);
        Ok((frame, points))
    }

    fn source(&self) -> RunSource {
        RunSource {
            file: self.file.clone(),
            format: match self.input {
                Input::Auto => None,
                Input::Text => Some(Format::Text),
                Input::Jsonl => Some(Format::JsonLines),
            },
            columns: self.columns.clone().unwrap_or_default(),
            resolution: self.resolution,
        }
    }

    fn write(&self, answer: &Answer, stdout: Option<File>, output: Option<&Path>) -> Result<(), Failure> {
        if let Some(stdout) = stdout {
            let mut sink = files::buffered(stdout);
            self.format.write(answer, &mut sink).context(files::CANNOT_WRITE_TO_STDOUT)?;
        }
        if let Some(path) = output {
            let file = files::create(path)?;
            let written = self.format.write(answer, &mut files::buffered(&file));
            written.and_then(|()| file.finish()).with_context(|| files::cannot_write(path))?;
        }
        Ok(())
    }
}

/// Reads all points into a pipeline. If they cannot be taken, the reading thread ends at its next
/// point, and is not waited for.
fn feed(
    source: RunSource,
    pipeline: &mut Pipeline,
    input_errors: &mut InputErrors,
    progress: &ProgressBar,
) -> Result<(), Failure> {
    let (sender, receiver) = sync_channel(WAITING);
    let progress = progress.clone();
    let read = move || source.read(&mut |found| sender.send(found).is_ok(), &|bytes| progress.set_position(bytes));
    let reading = thread::Builder::new().name("reader".to_owned()).spawn(read);
    let reading = reading.context("cannot start the reader's thread")?;
    for found in receiver {
        match found {
            Found::Bad(reason) => input_errors.add(&reason)?,
            Found::More(points) => pipeline.reserve(points),
            Found::Run(run) => run.feed(pipeline).try_for_each(|refused| input_errors.add(&refused))?,
        }
    }
    Ok(reading.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?)
}

fn simplified(frame: &Frame, view: &View, threshold: Threshold) -> (f64, Simplified) {
    let threshold = match threshold {
        Threshold::AtScale => view.scale(),
        Threshold::Below(radius) => radius,
    };
    (threshold, simplify(&frame.skeleton, view, threshold))
}
