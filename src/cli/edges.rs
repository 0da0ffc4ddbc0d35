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
use hopes::edges::Detector;
use indicatif::ProgressBar;

use super::args::{DetectionArgs, Place, USUAL, name, rate, window};
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
/// thresholds mean the same. Each picture or frame is a frame of points, x to the right and y up from the
/// bottom row. Event times are
/// frame number / rate. Pictures and frames that cannot be used are named, counted and passed over; 2^26 pixels are the
/// most.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes edges photo.jpg -o edges.csv
  hopes edges frames/ --rate 25 --format jsonl | hopes serve --input jsonl --window frames:1
  hopes edges frames/ --rate 25 --to unix:/tmp/hopes.sock --stream pictures
  ffmpeg -loglevel error -f v4l2 -i /dev/video0 -pix_fmt gray -f yuv4mpegpipe - |
    hopes edges - | hopes serve --window frames:1
  ffmpeg -loglevel error -i film.mp4 -f yuv4mpegpipe - |
    hopes edges - --to unix:/tmp/hopes.sock --stream film
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
    #[command(flatten)]
    detection: DetectionArgs,
    /// Count y from the top row downwards, as in OpenCV's arrays; pictures of points are then upside down.
    #[arg(long, help_heading = "Output")]
    y_down: bool,
    /// Count y from the bottom row upwards: what happens anyway.
    #[arg(long, hide = true, conflicts_with = "y_down")]
    y_up: bool,
    /// At most so many frames a second; pictures, and video that does not say its rate, get event times by it.
    #[arg(long, value_name = "FPS", value_parser = rate, help_heading = "Output")]
    rate: Option<f64>,
    /// How points are written [default: as the suffix of --output says, else text].
    #[arg(long, value_enum, conflicts_with = "to", help_heading = "Output")]
    format: Option<PointForm>,
    /// Where to write points; - for stdout [default: -].
    ///
    /// Its suffix chooses the format: .csv or .txt, .jsonl, .hopes. A file that is there is replaced at the end, as a
    /// whole, or not at all. Only with stdin as the input, which may go on for ever, it grows frame by frame.
    #[arg(short, long, value_name = "FILE", conflicts_with = "to", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Send points to a daemon instead: unix:PATH or tcp:HOST:PORT [without an address: to $HOPES_ADDRESS, else to your
    /// own socket].
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = USUAL, help_heading = "Output")]
    to: Option<Place>,
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
            (Some(to), _) => self.send(&to.address()?, finder, inputs, &progress),
            (None, Some(path)) if !files::is_pipe(path) => {
                self.write_file(finder, inputs, &progress, path, &path.display().to_string())
            }
            (None, _) => self.write(finder, inputs, &progress, files::point_stdout(self.form()?)?, "stdout"),
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

    fn form(&self) -> Result<PointForm, Failure> {
        files::point_form(self.format, self.output.as_deref())
    }

    fn reads_stdin(&self) -> bool {
        self.inputs.iter().any(|name| name == Path::new(STDIN))
    }

    fn check(&self) -> Result<(), Failure> {
        if self.inputs.iter().filter(|name| *name == Path::new(STDIN)).count() > 1 {
            return Err(Failure::usage("stdin cannot be read twice: name - once"));
        }
        match (self.input, self.size) {
            (Some(InputForm::Gray), None) => Err(Failure::usage("--input gray needs the size of frames: --size WxH")),
            (Some(InputForm::Images | InputForm::Y4m), Some(_)) => {
                Err(Failure::usage("--size is for bare gray frames: pictures and YUV4MPEG2 say their size themselves"))
            }
            _ => Ok(()),
        }
    }

    fn finder(&self) -> anyhow::Result<Finder> {
        let range = self.range.map(|range| match range {
            RangeArg::Full => Range::Full,
            RangeArg::Limited => Range::Limited,
        });
        Ok(Finder {
            detector: Detector::new(self.detection.options())?,
            part: self.roi.map(|Part(part)| part),
            y_up: !self.y_down,
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
            space: None,
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
        let mut writer = PointWriter::new(self.form()?, files::buffered(sink));
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

fn part(word: &str) -> Result<Part, String> {
    let numbers: Result<Vec<u32>, _> = word.split(',').map(str::parse).collect();
    match numbers.ok().and_then(|numbers| <[u32; 4]>::try_from(numbers).ok()) {
        Some(part @ [_, _, width, height]) if width > 0 && height > 0 => Ok(Part(part)),
        _ => Err(format!("{word:?} is no part of a picture: write X,Y,W,H in whole pixels, such as 0,360,1280,360")),
    }
}
