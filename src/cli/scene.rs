//! `hopes scene`: points whose true holes are known.
//!
//! In: a scene's name and options.
//! Out: its points, and its truth in a file.
//! Invariants: every frame that was begun is written as a whole, in both. The truth of a frame is written before
//! its points.
//! Must not know: how scenes are made, how points and truth are written.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use hopes::scene::{Kind, OptionError, Options, Scene};

use super::args::{from_one, number, scene, whole};
use super::files::NewFile;
use super::{Failure, files};
use crate::daemon::Stop;
use crate::formats::point_writer::PointForm;
use crate::formats::scene::{ScenePoints, Truth};

/// Make points whose true holes are known.
///
/// Rings and other shapes drift, pinch, fuse, open, pass, vanish, breathe, hide behind a bar. Their points come as a
/// stream, and their true holes, under ids that last, as JSON lines in a file. The same seed gives the same bytes on
/// every machine.
#[derive(Debug, Args)]
#[command(
    name = "scene",
    after_help = "Examples:
  hopes scene --list
  hopes scene pinch --frames 60 --truth pinch.truth | hopes serve --window frames:1
  hopes scene pinch --frames 60 | hopes serve --window frames:1 --track above:0.28 | hopes tracks -
  hopes scene crowd --format jsonl --churn 0.02 --frames 30 | hopes serve --input jsonl
  hopes scene drift --frames 60 -o drift.hopes"
)]
pub struct Play {
    /// The scene; --list lists all.
    #[arg(value_name = "NAME", required_unless_present = "list", value_parser = scene)]
    kind: Option<Kind>,
    /// List the scenes.
    #[arg(long, exclusive = true)]
    list: bool,
    /// How many frames, 30 to a second of event time.
    #[arg(long, value_name = "N", default_value = "600", value_parser = from_one)]
    frames: u64,
    /// Of all that is random.
    #[arg(long, value_name = "S", default_value = "1", value_parser = whole)]
    seed: u64,
    /// How dense: so many points to a length of the hole's radius, along its wall.
    #[arg(long, value_name = "D", default_value = "16", value_parser = points_per_radius)]
    points_per_radius: u32,
    /// How far off its place a point may be, uniformly in a disc: a share of the hole's radius, 0 to 0.3.
    #[arg(long, value_name = "E", default_value = "0.1", value_parser = noise)]
    noise: f64,
    /// Which share of each wall's points is drawn anew in every frame, 0.01 to 1; the others are carried along.
    #[arg(long, value_name = "C", default_value = "0.1", value_parser = churn)]
    churn: f64,
    /// Give the points of each frame in a random order.
    #[arg(long)]
    shuffle: bool,
    /// Where to write the true holes of every frame, and what happens to them, as JSON lines.
    ///
    /// Events: born, split, merged, died. A hole counts from a persistence of 0.4 times the smallest radius on ("above"
    /// in the first line).
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// How the points are written [default: as the suffix of --output says, else text].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Where to write the points; - for stdout [default: -].
    ///
    /// Its suffix chooses the format: .csv or .txt, .jsonl, .hopes. A file that is there is replaced at the end, as a
    /// whole, or not at all; so is that of --truth.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// How points are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// All points of each frame, x,y a line, then a blank line: for windows of frames:1.
    Text,
    /// What changes from frame to frame, as JSON lines: retract, points, commit.
    Jsonl,
    /// What changes from frame to frame, as messages of the protocol: Retract, Batch, Commit.
    Bin,
}

impl From<Format> for PointForm {
    fn from(format: Format) -> Self {
        match format {
            Format::Text => Self::Text,
            Format::Jsonl => Self::Jsonl,
            Format::Bin => Self::Bin,
        }
    }
}

impl Play {
    pub fn run(self) -> Result<(), Failure> {
        let Some(kind) = self.kind else {
            let mut stdout = files::buffered(files::stdout()?);
            return Ok(list(&mut stdout).and_then(|()| stdout.flush()).context(files::CANNOT_WRITE_TO_STDOUT)?);
        };
        let output = self.output.as_deref().filter(|&path| !files::is_pipe(path));
        self.check(output)?;
        let mut scene = Scene::new(kind, self.options())?;
        let create = |path| Ok::<_, anyhow::Error>((path, files::create(path)?));
        let truth_file = self.truth.as_deref().map(create).transpose()?;
        let truth = truth_file.as_ref().map(|(path, file)| (*path, Truth::new(files::buffered(file))));
        match output.map(create).transpose()? {
            Some((path, file)) => {
                self.play(kind, &mut scene, truth, files::buffered(&file), &path.display().to_string())?;
                finish(path, file)?;
            }
            None => {
                self.play(kind, &mut scene, truth, files::buffered(files::point_stdout(self.form()?)?), "stdout")?
            }
        }
        Ok(truth_file.map_or(Ok(()), |(path, file)| finish(path, file))?)
    }

    fn form(&self) -> Result<PointForm, Failure> {
        files::point_form(self.format.map(PointForm::from), self.output.as_deref())
    }

    fn check(&self, output: Option<&Path>) -> Result<(), Failure> {
        match self.truth.as_deref() {
            Some(truth) if files::is_pipe(truth) => {
                Err(Failure::usage("--truth needs a file of its own: stdout carries the points"))
            }
            Some(truth) if Some(truth) == output => {
                Err(Failure::usage("--truth and --output name the same file: give each its own"))
            }
            _ => Ok(()),
        }
    }

    fn options(&self) -> Options {
        let Self { seed, points_per_radius, noise, churn, shuffle, .. } = *self;
        Options { seed, points_per_radius, noise, churn, shuffle }
    }

    fn play(
        &self,
        kind: Kind,
        scene: &mut Scene,
        mut truth: Option<(&Path, Truth<impl Write>)>,
        sink: impl Write,
        sink_name: &str,
    ) -> Result<(), Failure> {
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let unwritten = || format!("cannot write to {sink_name}");
        if let Some((path, truth)) = &mut truth {
            truth.header(kind, &self.options(), self.frames, scene).with_context(|| files::cannot_write(path))?;
        }
        let mut points = ScenePoints::new(self.form()?, sink);
        for number in 1..=self.frames {
            if let Some(signal) = stop.asked() {
                tracing::info!("{signal}: stopped after {} frames", number - 1);
                break;
            }
            let frame = scene.next_frame();
            if let Some((path, truth)) = &mut truth {
                truth.write(&frame).with_context(|| files::cannot_write(path))?;
            }
            points.write(&frame).with_context(unwritten)?;
        }
        if let Some((path, truth)) = truth {
            truth.finish().with_context(|| files::cannot_write(path))?;
        }
        Ok(points.finish().with_context(unwritten)?)
    }
}

fn finish(path: &Path, file: NewFile) -> anyhow::Result<()> {
    file.finish().with_context(|| files::cannot_write(path))
}

fn list(sink: &mut impl Write) -> io::Result<()> {
    Kind::ALL.iter().try_for_each(|kind| writeln!(sink, "{:<10}  {}", kind.name(), kind.about()))
}

fn points_per_radius(word: &str) -> Result<u32, String> {
    let points_per_radius = word.parse().map_err(|_| format!("{word:?} is not a whole number"))?;
    checked(Options { points_per_radius, ..Options::default() }).map(|()| points_per_radius)
}

fn noise(word: &str) -> Result<f64, String> {
    let noise = number(word)?;
    checked(Options { noise, ..Options::default() }).map(|()| noise)
}

fn churn(word: &str) -> Result<f64, String> {
    let churn = number(word)?;
    checked(Options { churn, ..Options::default() }).map(|()| churn)
}

fn checked(options: Options) -> Result<(), String> {
    options.check().map_err(|error: OptionError| error.to_string())
}
