//! `hopes edges`: the edges of pictures and video, as points.
//!
//! In: options; pictures, or video.
//! Out: a batch and a commit for each picture or frame, to stdout, a file or a daemon.
//! Invariants: a frame that was begun is finished when a signal comes.
//! Must not know: how edges are found, how points are written.

mod finding;

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::sync_channel;

use anyhow::Context;
use clap::{Args, ValueEnum};
use hopes::edges::{Detector, Options};
use indicatif::ProgressBar;

use super::args::{name, number, rate, window};
use super::{Failure, files, progress};
use crate::client::delivery::{Delivery, Terms};
use crate::client::pace::Pace;
use crate::daemon::{Address, Input, InputErrors, Stop};
use crate::formats::images::files::{STDIN, listed};
use crate::formats::images::finder::{Finder, Found, InputForm};
use crate::formats::images::video::{Range, Size};
use crate::formats::point_writer::{PointForm, PointWriter};
use finding::{WAITING, forward, next, start, wait_for};

/// Find the edges of pictures and video, as points.
///
/// Edges are those of OpenCV's Canny (aperture 3, L1 norm), pixel by pixel, on gray levels from 0 to 255, so published
/// thresholds mean the same. Each picture or frame is a frame of points, x to the right and y down. Event times are
/// frame number / rate. Pictures and frames that cannot be used are named, counted and passed over; 2^26 pixels are the
/// most.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes edges photo.jpg > edges.csv
  hopes edges frames/ --rate 25 --format jsonl | hopes serve --input jsonl --window frames:1
  hopes edges frames/ --rate 25 --y-up --to unix:/tmp/hopes.sock --stream pictures
  ffmpeg -loglevel error -i /dev/video0 -f yuv4mpegpipe -strict -1 - |
    hopes edges - | hopes serve --window frames:1
  ffmpeg -loglevel error -i film.mp4 -f yuv4mpegpipe - |
    hopes edges - --y-up --to unix:/tmp/hopes.sock --stream film
  ffmpeg -loglevel error -i film.mp4 -pix_fmt gray -f rawvideo - |
    hopes edges - --size 1280x720 --rate 25")]
pub struct Edges {
    /// Pictures (PNG, JPEG), folders of pictures (2.png before 10.png), video (YUV4MPEG2); - for stdin.
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    /// What they hold [default: the first bytes tell, or gray with --size].
    #[arg(long, value_enum)]
    input: Option<InputForm>,
    /// The size of bare frames of gray pixels.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Black and white of video; limited levels are stretched to 0 to 255.
    ///
    /// [default: as the video says, else limited, but full if it is gray]
    #[arg(long, value_enum, value_name = "LEVELS")]
    range: Option<RangeArg>,
    /// Search only this part: a column and a row, and how many of each. Coordinates stay those of the whole.
    #[arg(long, value_name = "X,Y,W,H", value_parser = part)]
    roi: Option<Part>,
    /// Stop at the first picture or frame that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
    /// Gradients above LOW continue an edge.
    #[arg(long, value_name = "LOW", default_value = "150", value_parser = threshold, help_heading = "Detection")]
    low: f64,
    /// Gradients above LOW times RATIO begin an edge.
    #[arg(long, value_name = "RATIO", default_value = "3", value_parser = ratio, help_heading = "Detection")]
    ratio: f64,
    /// Gradients above HIGH begin an edge.
    #[arg(
        long,
        value_name = "HIGH",
        value_parser = threshold,
        conflicts_with = "ratio",
        help_heading = "Detection"
    )]
    high: Option<f64>,
    /// Blur before, by a Gaussian of this standard deviation in pixels, as OpenCV's GaussianBlur does.
    #[arg(long, value_name = "SIGMA", value_parser = sigma, help_heading = "Detection")]
    blur: Option<f64>,
    /// Count y from the bottom row upwards.
    #[arg(long, help_heading = "Output")]
    y_up: bool,
    /// At most so many frames a second; pictures, and video that does not say its rate, get event times by it.
    #[arg(long, value_name = "FPS", value_parser = rate, help_heading = "Output")]
    rate: Option<f64>,
    /// How points are written.
    #[arg(long, value_enum, default_value_t, conflicts_with = "to", help_heading = "Output")]
    format: PointForm,
    /// Where to write points; - for stdout [default: -].
    ///
    /// A file that is there is replaced at the end, as a whole, or not at all. Only with stdin as the input, which may
    /// go on for ever, it grows frame by frame.
    #[arg(short, long, value_name = "FILE", conflicts_with = "to", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Send points to a daemon instead: unix:PATH or tcp:HOST:PORT.
    #[arg(long, value_name = "ADDRESS", help_heading = "Output")]
    to: Option<Address>,
    /// Name of the stream; it is created if it is not there.
    #[arg(
        long,
        value_name = "NAME",
        default_value = "default",
        value_parser = name,
        requires = "to",
        help_heading = "Output"
    )]
    stream: String,
    /// Which points stay: all, points:N, frames:N, time:T [default: as the stream has it, else frames:1].
    #[arg(long, value_name = "WINDOW", value_parser = window, requires = "to", help_heading = "Output")]
    window: Option<hopes::topology::Window>,
}

/// Black and white of video.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RangeArg {
    /// 0 and 255.
    Full,
    /// 16 and 235.
    Limited,
}

/// A column and a row, and how many of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Part([u32; 4]);

impl Edges {
    pub fn run(self) -> Result<(), Failure> {
        self.check()?;
        if self.reads_stdin() {
            files::check_stdin()?;
        }
        let inputs = listed(&self.inputs)?;
        let finder = self.finder()?;
        let progress = self.progress(&inputs);
        match (&self.to, self.output.as_deref()) {
            (Some(to), _) => self.send(to, finder, inputs, &progress),
            (None, Some(path)) if !files::is_pipe(path) => {
                self.write_file(finder, inputs, &progress, path, &path.display().to_string())
            }
            (None, _) => self.write(finder, inputs, &progress, files::stdout()?, "stdout"),
        }
    }

    /// Writes frames of files into a file at its end, and those of stdin, which may go on for ever, as they come.
    fn write_file(
        &self,
        finder: Finder,
        inputs: Vec<PathBuf>,
        progress: &ProgressBar,
        path: &Path,
        name: &str,
    ) -> Result<(), Failure> {
        if self.reads_stdin() {
            return self.write(finder, inputs, progress, files::grow(path)?, name);
        }
        let file = files::create(path)?;
        self.write(finder, inputs, progress, &file, name)?;
        Ok(file.finish().with_context(|| files::cannot_write(path))?)
    }

    fn reads_stdin(&self) -> bool {
        self.inputs.iter().any(|name| name == Path::new(STDIN))
    }

    fn check(&self) -> Result<(), Failure> {
        if self.inputs.iter().filter(|name| *name == Path::new(STDIN)).count() > 1 {
            return Err(Failure::Usage("stdin cannot be read twice: name - once"));
        }
        match (self.input, self.size) {
            (Some(InputForm::Gray), None) => Err(Failure::Usage("--input gray needs the size of frames: --size WxH")),
            (Some(InputForm::Images | InputForm::Y4m), Some(_)) => {
                Err(Failure::Usage("--size is for bare gray frames: pictures and YUV4MPEG2 say their size themselves"))
            }
            _ => Ok(()),
        }
    }

    fn finder(&self) -> anyhow::Result<Finder> {
        let high = self.high.unwrap_or(self.low * self.ratio);
        let range = self.range.map(|range| match range {
            RangeArg::Full => Range::Full,
            RangeArg::Limited => Range::Limited,
        });
        Ok(Finder {
            detector: Detector::new(Options { low: self.low, high, blur: self.blur })?,
            part: self.roi.map(|Part(part)| part),
            y_up: self.y_up,
            rate: self.rate,
            input: self.input,
            size: self.size,
            range,
        })
    }

    fn progress(&self, inputs: &[PathBuf]) -> ProgressBar {
        // Points that scroll by on a terminal show well enough how far it is.
        let writes_to_terminal = self.to.is_none() && self.output.is_none() && io::stdout().is_terminal();
        if inputs.len() < 2 || writes_to_terminal {
            return ProgressBar::hidden();
        }
        progress::bar(inputs.len() as u64, "{spinner} {wide_bar} {pos}/{len} files {elapsed}")
    }

    /// Sends frames to a daemon.
    fn send(&self, to: &Address, finder: Finder, inputs: Vec<PathBuf>, progress: &ProgressBar) -> Result<(), Failure> {
        let delivery = Delivery {
            to,
            stream: &self.stream,
            window: self.window,
            window_if_new: Some(hopes::topology::Window::Frames(std::num::NonZeroU64::MIN)),
            resolution: None,
            strict: self.strict,
            rate: self.rate,
            origin: None,
            whole_frames: true,
        };
        let read = |Terms { batch, .. }| {
            let (sender, received) = sync_channel(WAITING);
            let failed = |error| Input::Failed(format!("{:#}", anyhow::Error::from(error)));
            start(finder, inputs, progress, sender, move |found, sender| forward(found, batch, sender), failed)?;
            Ok(received)
        };
        Ok(delivery.run(&|step| progress::show(progress, step), read)?)
    }

    /// Writes frames.
    fn write(
        &self,
        finder: Finder,
        inputs: Vec<PathBuf>,
        progress: &ProgressBar,
        sink: impl Write,
        sink_name: &str,
    ) -> Result<(), Failure> {
        let unwritten = || format!("cannot write to {sink_name}");
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let mut input_errors = InputErrors::new(self.strict);
        let mut writer = PointWriter::new(self.format, files::buffered(sink));
        let mut pace = self.rate.map(Pace::new);
        let mut frames = 0_u64;
        let (sender, results) = sync_channel(WAITING);
        start(finder, inputs, progress, sender, |found, sender| sender.send(Ok(found)).is_ok(), Err)
            .context("cannot start a thread")?;
        while let Some(found) = next(&results, &mut stop) {
            match found? {
                Found::Bad(reason) => input_errors.add(&reason)?,
                Found::Frame { points, time } => {
                    if let Some(pace) = &mut pace
                        && !wait_for(pace.next(), &mut stop)
                    {
                        break;
                    }
                    let written = writer.add(&points).and_then(|()| writer.commit(time)).and_then(|()| writer.flush());
                    written.with_context(unwritten)?;
                    frames += 1;
                }
            }
        }
        writer.finish().with_context(unwritten)?;
        progress.finish_and_clear();
        if let Some(signal) = stop.asked() {
            tracing::info!("{signal}: stopped after {frames} frames");
        }
        input_errors.sum_up();
        tracing::info!("{frames} frames, {} refused", input_errors.count());
        Ok(())
    }
}

fn ratio(word: &str) -> Result<f64, String> {
    match number(word)? {
        ratio if ratio >= 1.0 => Ok(ratio),
        ratio => Err(format!("{ratio} is no ratio of the high threshold to the low one: it must be 1 or more")),
    }
}

fn threshold(word: &str) -> Result<f64, String> {
    checked(number(word)?, |low| Options { low, ..Options::default() })
}

fn sigma(word: &str) -> Result<f64, String> {
    checked(number(word)?, |sigma| Options { blur: Some(sigma), ..Options::default() })
}

fn checked(value: f64, options: impl Fn(f64) -> Options) -> Result<f64, String> {
    options(value).check().map_err(|error| error.to_string()).map(|()| value)
}

fn part(word: &str) -> Result<Part, String> {
    let numbers: Result<Vec<u32>, _> = word.split(',').map(str::parse).collect();
    match numbers.ok().and_then(|numbers| <[u32; 4]>::try_from(numbers).ok()) {
        Some(part @ [_, _, width, height]) if width > 0 && height > 0 => Ok(Part(part)),
        _ => Err(format!("{word:?} is no part of a picture: write X,Y,W,H in whole pixels, such as 0,360,1280,360")),
    }
}
