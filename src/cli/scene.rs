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
use hopes::scene::signal::{Signal, SignalKind, SignalOptions};
use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene};
use hopes::scene::{AnyKind, Camera, Frame, Kind, OptionError, Options, Scene, UnknownCamera};

use super::args::{from_one, number, scene, whole};
use super::files::NewFile;
use super::{Failure, files};
use crate::daemon::Stop;
use crate::formats::point_writer::{Point, PointForm};
use crate::formats::scene::{Header, ScenePoints, Truth, WrittenHole};

/// Make points whose true holes are known.
///
/// Rings and other shapes drift, pinch, fuse, open, pass, vanish, breathe, hide behind a bar; the walls of cells open
/// and slide. Their points come as a stream, and their true holes, under ids that last, as JSON lines in a file. The
/// camera may move, and stray points may lie around. The same seed gives the same bytes on every machine.
///
/// Scenes in R^3 (torus, trefoil, rings3, links, pinch3, sphere) turn; circle, cube:D and delay:D are clouds of any
/// dimension that stay. One frame of a scene is a cloud for tests. A signal (gait, sine) is a number a line.
#[derive(Debug, Args)]
#[command(
    name = "scene",
    after_help = "Examples:
  hopes scene --list
  hopes scene pinch --frames 60 --truth pinch.truth | hopes serve --window frames:1
  hopes scene pinch --frames 60 | hopes serve --window frames:1 --track above:0.28 | hopes tracks -
  hopes scene crowd --format jsonl --churn 0.02 --frames 30 | hopes serve --input jsonl
  hopes scene drift --frames 60 -o drift.hopes
  hopes scene cells --camera pan:0.2 --frames 60 | hopes serve --window frames:1 --track above:0.2
  hopes scene sizes --clutter 0.05 --clumps --frames 1 -o cluttered.csv
  hopes scene links --points 300 --churn 0.05 --truth links.truth -o links.csv
  hopes scene torus --points 2000 --frames 1 --noise 0 -o torus.csv
  hopes scene gait --points 4 --frames 600 --truth gait.truth -o gait.csv"
)]
pub struct Play {
    /// The scene; --list lists all.
    #[arg(value_name = "NAME", required_unless_present = "list", value_parser = scene::<AnyKind>)]
    kind: Option<AnyKind>,
    /// List the scenes.
    #[arg(long, exclusive = true)]
    list: bool,
    /// How many frames, 30 to a second of event time.
    #[arg(long, value_name = "N", default_value = "600", value_parser = from_one)]
    frames: u64,
    /// Of all that is random.
    #[arg(long, value_name = "S", default_value = "1", value_parser = whole)]
    seed: u64,
    /// How dense, in the plane: so many points to a length of the hole's radius, along its wall [default: 16].
    #[arg(long, value_name = "D", value_parser = points_per_radius)]
    points_per_radius: Option<u32>,
    /// How many points, in R^d [default: 500]; of a signal, how many new samples a frame [default: 4].
    #[arg(long, value_name = "N", conflicts_with = "points_per_radius")]
    points: Option<u32>,
    /// How far off its place a point may be, uniformly in a disc or ball [default: 0.1].
    ///
    /// A share of the hole's radius, of a knot's tube, of a signal's amplitude: 0 to 0.3.
    #[arg(long, value_name = "E", value_parser = noise)]
    noise: Option<f64>,
    /// Which share of each wall's points is drawn anew in every frame, 0.01 to 1 [default: 0.1].
    ///
    /// The others are carried along.
    #[arg(long, value_name = "C", value_parser = churn)]
    churn: Option<f64>,
    /// Move the whole picture, and its true holes: pan, turn, zoom or shake, in the plane.
    ///
    /// SPEED, 0 to 100, is in radii of the smallest hole a frame. pan: all moves at this speed, in a large circle.
    /// turn: the picture turns around its middle; the ends of the row of shapes move at this speed. zoom: it swells and
    /// shrinks by a quarter around its middle; the ends move at this speed at most. shake: it jumps anywhere, at most
    /// so far.
    #[arg(long, value_name = "MOTION:SPEED", value_parser = camera)]
    camera: Option<Camera>,
    /// Stray points, uniform in the bounding box: so many for each point of a wall, 0 to 1 [default: 0].
    ///
    /// In the plane. The box is that of the walls' points, widened by 5% at each side. --churn holds for stray points
    /// too; those that stay move with the picture. They are the last points of each frame, unless it is shuffled; the
    /// truth says how many ("clutter").
    #[arg(long, value_name = "SHARE", value_parser = clutter)]
    clutter: Option<f64>,
    /// The stray points come in clumps of 2 to 6, within 0.06 radii of the smallest hole; SHARE holds in the mean.
    #[arg(long, requires = "clutter")]
    clumps: bool,
    /// Give the points of each frame in a random order.
    #[arg(long)]
    shuffle: bool,
    /// Where to write the true holes of every frame, and what happens to them, as JSON lines.
    ///
    /// Events: born (of a hole that never vanished but was less persistent, with "was", its id before), split, merged,
    /// died. A hole counts from a persistence of 0.4 times the smallest radius on ("above"
    /// in the first line; in R^d it is another for each scene). The centres of its largest empty discs lie at the
    /// distance "orbit" from its centre, or on the segment of plus and minus "ridge" (of slender holes) around it.
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
    /// All points of each frame, x,y (or all coordinates) a line, then a blank line: for windows of frames:1.
    Text,
    /// What changes from frame to frame, as JSON lines: retract, points, commit.
    Jsonl,
    /// What changes from frame to frame, as messages of the protocol: Retract, Batch, Commit. In the plane only.
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
        let frames = self.frames;
        match kind {
            AnyKind::Plane(kind) => {
                let options = self.plane_options(kind)?;
                let mut scene = Scene::new(kind, options).map_err(usage)?;
                let header = Header::of_plane(kind, &options, frames, &scene);
                self.write(2, &header, || scene.next_frame())
            }
            AnyKind::Space(kind) => {
                let options = self.space_options(kind)?;
                let mut scene = SpaceScene::new(kind, options).map_err(usage)?;
                let header = Header::of_space(kind, &options, frames, &scene);
                self.write(kind.dimension(), &header, || scene.next_frame())
            }
            AnyKind::Signal(kind) => {
                let options = self.signal_options(kind)?;
                let mut signal = Signal::new(kind, options).map_err(usage)?;
                let header = Header::of_signal(kind, &options, frames);
                self.write(1, &header, || signal.next_frame())
            }
        }
    }

    /// Writes the frames, and their truth.
    fn write<P: Point<f64>, H: WrittenHole>(
        &self,
        dimension: usize,
        header: &Header,
        next: impl FnMut() -> Frame<P, H>,
    ) -> Result<(), Failure> {
        let output = self.output.as_deref().filter(|&path| !files::is_pipe(path));
        self.check(dimension, output)?;
        let create = |path| Ok::<_, anyhow::Error>((path, files::create(path)?));
        let truth_file = self.truth.as_deref().map(create).transpose()?;
        let truth = truth_file.as_ref().map(|(path, file)| (*path, Truth::new(files::buffered(file))));
        match output.map(create).transpose()? {
            Some((path, file)) => {
                self.play(header, next, truth, files::buffered(&file), &path.display().to_string())?;
                finish(path, file)?;
            }
            None => {
                let stdout = files::buffered(files::point_stdout(self.form()?)?);
                self.play(header, next, truth, stdout, "stdout")?;
            }
        }
        Ok(truth_file.map_or(Ok(()), |(path, file)| finish(path, file))?)
    }

    fn form(&self) -> Result<PointForm, Failure> {
        files::point_form(self.format.map(PointForm::from), self.output.as_deref())
    }

    fn check(&self, dimension: usize, output: Option<&Path>) -> Result<(), Failure> {
        if dimension != 2 && self.form()? == PointForm::Bin {
            let reason = format!("points of {dimension} coordinates have no binary form: use --format text or jsonl");
            return Err(Failure::usage(reason));
        }
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

    fn plane_options(&self, kind: Kind) -> Result<Options, Failure> {
        refuse(kind.name(), "--points", self.points.is_some(), "how dense it is, is --points-per-radius")?;
        let usual = Options::default();
        Ok(Options {
            seed: self.seed,
            points_per_radius: self.points_per_radius.unwrap_or(usual.points_per_radius),
            noise: self.noise.unwrap_or(usual.noise),
            churn: self.churn.unwrap_or(usual.churn),
            shuffle: self.shuffle,
            camera: self.camera,
            clutter: self.clutter.unwrap_or(usual.clutter),
            clumps: self.clumps,
        })
    }

    /// Refuses what only scenes in the plane have.
    fn refuse_plane_options(&self, name: &str) -> Result<(), Failure> {
        refuse(name, "--camera", self.camera.is_some(), "only scenes in the plane have")?;
        refuse(name, "--clutter", self.clutter.is_some(), "only scenes in the plane have")
    }

    fn space_options(&self, kind: SpaceKind) -> Result<SpaceOptions, Failure> {
        let name = kind.name();
        let density = self.points_per_radius.is_some();
        self.refuse_plane_options(&name)?;
        refuse(&name, "--points-per-radius", density, "how many points it has, is --points")?;
        let noise = self.noise.is_some() && !kind.has_noise();
        refuse(&name, "--noise", noise, "its points fill it")?;
        let usual = SpaceOptions::default();
        Ok(SpaceOptions {
            seed: self.seed,
            points: self.points.unwrap_or(usual.points),
            noise: if kind.has_noise() { self.noise.unwrap_or(usual.noise) } else { 0.0 },
            churn: self.churn.unwrap_or(usual.churn),
            shuffle: self.shuffle,
        })
    }

    fn signal_options(&self, kind: SignalKind) -> Result<SignalOptions, Failure> {
        let density = self.points_per_radius.is_some();
        self.refuse_plane_options(kind.name())?;
        refuse(kind.name(), "--points-per-radius", density, "how many samples a frame has, is --points")?;
        refuse(kind.name(), "--churn", self.churn.is_some(), "a sample never changes")?;
        refuse(kind.name(), "--shuffle", self.shuffle, "the order of samples is the signal")?;
        let usual = SignalOptions::default();
        let (samples, noise) = (self.points.unwrap_or(usual.samples), self.noise.unwrap_or(usual.noise));
        Ok(SignalOptions { seed: self.seed, samples, noise })
    }

    fn play<P: Point<f64>, H: WrittenHole>(
        &self,
        header: &Header,
        mut next: impl FnMut() -> Frame<P, H>,
        mut truth: Option<(&Path, Truth<impl Write>)>,
        sink: impl Write,
        sink_name: &str,
    ) -> Result<(), Failure> {
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let unwritten = || format!("cannot write to {sink_name}");
        if let Some((path, truth)) = &mut truth {
            truth.header(header).with_context(|| files::cannot_write(path))?;
        }
        let mut points = ScenePoints::new(self.form()?, sink);
        for number in 1..=self.frames {
            if let Some(signal) = stop.asked() {
                tracing::info!("{signal}: stopped after {} frames", number - 1);
                break;
            }
            let frame = next();
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

/// Refuses an option that is given to a scene that has no use for it.
fn refuse(scene: &str, option: &str, is_given: bool, reason: &str) -> Result<(), Failure> {
    if is_given { Err(Failure::usage(format!("{scene} has no {option}: {reason}"))) } else { Ok(()) }
}

fn usage(error: OptionError) -> Failure {
    Failure::usage(error.to_string())
}

/// A block of lines for each family, with a blank line between.
fn list(sink: &mut impl Write) -> io::Result<()> {
    for (number, family) in AnyKind::all().iter().enumerate() {
        if number > 0 {
            writeln!(sink)?;
        }
        family.iter().try_for_each(|kind| writeln!(sink, "{:<10}  {}", kind.name(), kind.about()))?;
    }
    Ok(())
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

fn clutter(word: &str) -> Result<f64, String> {
    let clutter = number(word)?;
    checked(Options { clutter, ..Options::default() }).map(|()| clutter)
}

fn camera(word: &str) -> Result<Camera, String> {
    word.parse().map_err(|error: UnknownCamera| error.to_string())
}

fn checked(options: Options) -> Result<(), String> {
    options.check().map_err(|error: OptionError| error.to_string())
}
