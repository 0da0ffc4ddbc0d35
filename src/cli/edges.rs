//! `hopes edges`: the edges of pictures and video, as points.
//!
//! In: options; pictures, or video. Out: a batch and a commit for each picture or frame, to stdout, a file or a daemon.
//! Two threads: one decodes and finds edges, the other writes or [sends](super::delivery). Invariants: whoever takes
//! points slowly slows the reading, and a bounded number of frames is under way; a frame that was begun is finished on
//! a signal. Must not know: how edges are found.

use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::{Args, ValueEnum};
use hopes::edges::{Detector, Options};
use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use super::args::{name, number, rate, window};
use crate::client::delivery::Delivery;
use crate::client::pace::Pace;
use crate::daemon::{Address, Batch, Input, InputErrors, Stop};
use crate::formats::images::files;
use crate::formats::images::finder::{Finder, Found, InputForm};
use crate::formats::images::video::{Range, Size};
use crate::formats::point_writer::{PointForm, PointWriter};

/// Find the edges of pictures and video, as points.
///
/// Edges are those of OpenCV's Canny (aperture 3, L1 norm, no blur), pixel by pixel, on gray levels from 0 to 255;
/// thresholds mean the same. Each picture or frame is a frame of points, x to the right and y down.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes edges photo.jpg > edges.csv
  hopes edges frames/ --rate 25 --format jsonl | hopes serve --input jsonl --window frames:1
  ffmpeg -loglevel error -i /dev/video0 -f yuv4mpegpipe -strict -1 - | hopes edges - | hopes serve --window frames:1
  ffmpeg -loglevel error -i film.mp4 -f yuv4mpegpipe - | hopes edges - --y-up --to unix:/tmp/hopes.sock --stream cam
  ffmpeg -loglevel error -i film.mp4 -pix_fmt gray -f rawvideo - | hopes edges - --size 1280x720 --rate 25")]
pub struct Edges {
    /// Pictures (PNG, JPEG), folders of pictures, video (YUV4MPEG2); - for stdin.
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    /// What they hold [default: the first bytes tell, or gray with --size].
    #[arg(long, value_enum)]
    input: Option<InputForm>,
    /// Bare frames of gray pixels have this size.
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Black and white of video: full (0 and 255), limited (16 and 235) [default: as the video says, else limited, but
    /// full if it is gray].
    #[arg(long, value_enum, value_name = "LEVELS")]
    range: Option<RangeArg>,
    /// Gradients above LOW go on with an edge.
    #[arg(long, value_name = "LOW", default_value = "150", value_parser = threshold)]
    low: f64,
    /// Gradients above LOW times RATIO begin an edge.
    #[arg(long, value_name = "RATIO", default_value = "3", value_parser = ratio)]
    ratio: f64,
    /// Gradients above HIGH begin an edge.
    #[arg(long, value_name = "HIGH", value_parser = threshold, conflicts_with = "ratio")]
    high: Option<f64>,
    /// Blur before, by a Gaussian of this standard deviation in pixels, as OpenCV's GaussianBlur does.
    #[arg(long, value_name = "SIGMA", value_parser = sigma)]
    blur: Option<f64>,
    /// Look only there: a column and a row, and how many of each. Points stay where they are in the whole.
    #[arg(long, value_name = "X,Y,W,H", value_parser = part)]
    roi: Option<Part>,
    /// Count y from the bottom row upwards.
    #[arg(long)]
    y_up: bool,
    /// At most so many frames a second; pictures, and video that does not say its rate, get event times by it.
    #[arg(long, value_name = "FPS", value_parser = rate)]
    rate: Option<f64>,
    /// How points are written.
    #[arg(long, value_enum, default_value_t, conflicts_with = "to")]
    format: PointForm,
    /// Where to write points; - for stdout [default: -].
    #[arg(short, long, value_name = "FILE", conflicts_with = "to")]
    output: Option<PathBuf>,
    /// Send points to a daemon instead: unix:PATH or tcp:HOST:PORT.
    #[arg(long, value_name = "ADDRESS")]
    to: Option<Address>,
    /// Name of the stream; it is created if it is not there.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = name, requires = "to")]
    stream: String,
    /// Which points stay: all, points:N, frames:N, time:T [default: as the stream has it, frames:1 if it is not there].
    #[arg(long, value_name = "WINDOW", value_parser = window, requires = "to")]
    window: Option<hopes::topology::Window>,
    /// Stop at the first picture or frame that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
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

/// Frames that may wait.
const WAITING: usize = 2;

/// How long anything is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

impl Edges {
    pub fn run(self) -> Result<(), Failure> {
        self.check()?;
        let files = files::listed(&self.inputs)?;
        let finder = self.finder()?;
        let progress = self.progress(&files);
        match (&self.to, self.output.as_deref()) {
            (Some(to), _) => self.send(to, finder, files, &progress),
            (None, Some(path)) if path != Path::new(files::STDIN) => {
                let name = path.display().to_string();
                let file = File::create(path).with_context(|| format!("cannot write {name}"))?;
                self.write(finder, files, &progress, file, &name)
            }
            (None, _) => self.write(finder, files, &progress, io::stdout().lock(), "stdout"),
        }
    }

    fn check(&self) -> Result<(), Failure> {
        if self.inputs.iter().filter(|name| *name == Path::new(files::STDIN)).count() > 1 {
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

    fn progress(&self, files: &[PathBuf]) -> ProgressBar {
        // Points that fly by tell enough of how far it is.
        let writes_to_terminal = self.to.is_none() && self.output.is_none() && io::stdout().is_terminal();
        if files.len() < 2 || writes_to_terminal || !io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let template = "{spinner} {wide_bar} {pos}/{len} files {elapsed}";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(files.len() as u64).with_style(style)
    }

    /// Sends frames to a daemon.
    fn send(&self, to: &Address, finder: Finder, files: Vec<PathBuf>, progress: &ProgressBar) -> Result<(), Failure> {
        let delivery = Delivery {
            to,
            stream: &self.stream,
            window: self.window,
            window_if_new: Some(hopes::topology::Window::Frames(std::num::NonZeroU64::MIN)),
            resolution: None,
            strict: self.strict,
            place: "pixel",
            rate: self.rate,
            whole_frames: true,
        };
        delivery.run(progress, |batch| {
            let (sender, inputs) = sync_channel(WAITING);
            let failed = |error| Input::Failed(format!("{error:#}"));
            start(finder, files, progress, sender, move |found, sender| forward(found, batch, sender), failed)?;
            Ok(inputs)
        })
    }

    /// Writes frames.
    fn write(
        &self,
        finder: Finder,
        files: Vec<PathBuf>,
        progress: &ProgressBar,
        sink: impl Write,
        sink_name: &str,
    ) -> Result<(), Failure> {
        let unwritten = || format!("cannot write to {sink_name}");
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let mut input_errors = InputErrors::new(self.strict);
        let mut writer =
            PointWriter::new(self.format, BufWriter::with_capacity(1 << 16, sink)).with_context(unwritten)?;
        let mut pace = self.rate.map(Pace::new);
        let mut frames = 0_u64;
        let (sender, results) = sync_channel(WAITING);
        start(finder, files, progress, sender, |found, sender| sender.send(Ok(found)).is_ok(), Err)?;
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
        writer.flush().with_context(unwritten)?;
        progress.finish_and_clear();
        if let Some(signal) = stop.asked() {
            tracing::info!("{signal}: stopped after {frames} frames");
        }
        input_errors.sum_up();
        tracing::info!("{frames} frames, {} refused", input_errors.count());
        Ok(())
    }
}

/// Starts the thread that finds edges. Nobody waits for it: it may be blocked in a read that never returns, and owns
/// nothing that has to be finished.
fn start<T: Send + 'static>(
    finder: Finder,
    files: Vec<PathBuf>,
    progress: &ProgressBar,
    sender: SyncSender<T>,
    forward: impl Fn(Found, &SyncSender<T>) -> bool + Send + 'static,
    failed: impl Fn(anyhow::Error) -> T + Send + 'static,
) -> anyhow::Result<()> {
    let progress = progress.clone();
    let find = move || {
        if let Err(error) = finder.run(&files, &mut |found| forward(found, &sender), &progress) {
            // Nobody may listen any more, and then nobody needs to know.
            drop(sender.send(failed(error)));
        }
    };
    thread::Builder::new().name("edges".to_owned()).spawn(find).map(drop).context("cannot start a thread")
}

/// Hands on what was found, in messages of so many points; whether anybody listens.
fn forward(found: Found, batch: usize, sender: &SyncSender<Input>) -> bool {
    match found {
        Found::Bad(reason) => sender.send(Input::Unreadable(reason)).is_ok(),
        Found::Frame { points, time } => {
            let parts = points.chunks(batch).all(|points| {
                let positions = points.iter().map(|&[x, y]| (x.into(), y.into())).collect();
                sender.send(Input::Points(Batch { positions, ..Batch::default() })).is_ok()
            });
            parts && sender.send(Input::Commit(time)).is_ok()
        }
    }
}

/// What comes next; nothing at the end, or when a signal comes first.
fn next<T>(results: &Receiver<T>, stop: &mut Stop) -> Option<T> {
    while stop.asked().is_none() {
        match results.recv_timeout(MOMENT) {
            Ok(found) => return Some(found),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
    None
}

/// Waits for a time; whether it came before a signal did.
fn wait_for(due: Instant, stop: &mut Stop) -> bool {
    match due.checked_duration_since(Instant::now()) {
        Some(left) if !left.is_zero() => stop.wait(left).is_none(),
        _ => true,
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
