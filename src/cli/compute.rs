//! `hopes compute`: a file of points in, its skeleton out, once.
//!
//! In: a file or stdin, and options. Out: JSON, CSV, GeoJSON, SVG or PNG, to a file or stdout. Invariants: points that cannot be used
//! are reported, counted and left out, unless `--strict` stops at the first. Must not know: how skeletons are computed or pictures drawn.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::{Args, ValueEnum};
use hopes::topology::{Frame, Options, Pipeline, Simplified, View, ViewSpec, simplify};
use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use super::args::{ViewArgs, resolution, scale};
use super::source::Source;
use crate::daemon::InputErrors;
use crate::formats::input::{Columns, Format};
use crate::formats::skeleton::{Answer, OutputFormat};

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

impl Compute {
    pub fn run(self) -> Result<(), Failure> {
        if self.simplify == Some(None) && self.view.spec() == ViewSpec::Full {
            return Err(Failure::Usage("--simplify with --full needs a radius: --simplify=RADIUS"));
        }
        let progress = self.progress();
        let mut input_errors = InputErrors::new(self.strict);
        let (frame, points) = self.compute(&progress, &mut input_errors)?;
        let view = frame.view(self.view.spec());
        let simplified = self.simplified(&frame, &view);
        let answer = Answer {
            name: self.file.file_stem().and_then(|stem| stem.to_str()).filter(|_| !self.is_stdin()),
            skeleton: &frame.skeleton,
            view: &view,
            simplified: simplified.as_ref().map(|(threshold, simplified)| (*threshold, simplified)),
            duplicates: points - frame.skeleton.vertices().len() as u64,
            rejected: input_errors.count(),
        };
        progress.set_message("writing");
        input_errors.sum_up();
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

    fn compute(&self, progress: &ProgressBar, input_errors: &mut InputErrors) -> Result<(Arc<Frame>, u64), Failure> {
        let mut pipeline = Pipeline::new(Options { resolution: self.resolution, ..Options::default() });
        let source = Source {
            file: self.file.clone(),
            format: match self.input {
                Input::Auto => None,
                Input::Text => Some(Format::Text),
                Input::Jsonl => Some(Format::JsonLines),
            },
            columns: self.columns.clone(),
            resolution: self.resolution,
        };
        source.feed(&mut pipeline, input_errors, progress)?;
        progress.set_message("computing the skeleton");
        progress.enable_steady_tick(std::time::Duration::from_millis(100));
        let points = pipeline.point_count();
        pipeline.commit(None);
        let frame = pipeline.poll_frame().context("the frame was taken before it was polled")?;
        std::mem::forget(pipeline);
        Ok((frame, points))
    }

    fn simplified(&self, frame: &Frame, view: &View) -> Option<(f64, Simplified)> {
        let threshold = self.simplify?.unwrap_or_else(|| view.scale());
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
