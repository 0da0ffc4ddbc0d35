//! `hopes feed`: points of a file or a pipe, sent to a stream of a daemon.
//!
//! In: options; text, JSON lines, or the bytes of the protocol. Out: messages to a daemon; input errors about what it
//! refuses. Invariants: one thread reads while others [deliver](super::delivery), with a bounded way between them;
//! nobody waits for a reader that is blocked. Must not know: the skeleton; what is said on the way to a daemon.

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use anyhow::Context;
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use super::args::{To, name, rate, resolution, window};
use crate::client::delivery::Delivery;
use crate::daemon::Input;
use crate::formats::input::{Columns, Format};
use crate::formats::points::{Form, Place, Source};

/// Send points to a stream of a daemon.
///
/// A blank line, {"commit":true,"time":t}, --frame-points or the end of the input closes a frame. Points that the
/// daemon refuses are reported with their line, and counted.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  sensor | hopes feed - --to unix:/tmp/hopes.sock --stream sensor --window points:10000 --frame-points 1000
  hopes feed edges.jsonl --input jsonl --to tcp:127.0.0.1:7878 --stream camera --window frames:1 --rate 25 --loop
  hopes feed points.hopes --input bin --to unix:/tmp/hopes.sock --stream default")]
pub struct Feed {
    /// File of points; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    to: To,
    /// Name of the stream; it is created if it is not there.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = name)]
    stream: String,
    /// Which points stay: all, points:N (the last N), frames:N (the last N frames), time:T (the last T of event time)
    /// [default: as the stream has it, else all].
    #[arg(long, value_name = "WINDOW", value_parser = window)]
    window: Option<hopes::topology::Window>,
    /// Snap positions to a grid of this step [default: as the stream has it, else none].
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// How points are written.
    #[arg(long, value_enum, default_value_t)]
    input: InputFormat,
    /// Columns of text input, by number from 1 or by name in the header; a third one is the event time.
    #[arg(long, value_name = "X,Y[,T]", default_value = "1,2")]
    columns: Columns,
    /// Close at most so many frames a second.
    #[arg(long, value_name = "FPS", value_parser = rate)]
    rate: Option<f64>,
    /// Begin anew at the end of the file, until Ctrl-C.
    #[arg(long = "loop")]
    loops: bool,
    /// Close a frame after so many points were sent.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frame_points: Option<u64>,
    /// Stop at the first line or point that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum InputFormat {
    /// A table: comma, semicolon, tab or blank separated.
    #[default]
    Text,
    /// JSON lines.
    Jsonl,
    /// Messages of the protocol: Batch, Retract and Commit.
    Bin,
}

/// Inputs that may wait to be sent.
const WAITING: usize = 4;

impl Feed {
    pub fn run(self) -> Result<(), Failure> {
        if self.loops && self.is_stdin() {
            return Err(Failure::Usage("--loop needs a file: stdin cannot be read twice"));
        }
        if !self.is_stdin() {
            // Whoever has mistyped a name shall not create a stream.
            std::fs::File::open(&self.file).with_context(|| format!("cannot open {}", self.file.display()))?;
        }
        let place = if self.input == InputFormat::Bin { "byte" } else { "line" };
        let delivery = Delivery {
            to: &self.to.to,
            stream: &self.stream,
            window: self.window,
            window_if_new: None,
            resolution: self.resolution,
            strict: self.strict,
            place,
            rate: self.rate,
            whole_frames: false,
        };
        let progress = self.progress();
        delivery.run(&progress, |batch| self.read(batch, &progress))
    }

    fn is_stdin(&self) -> bool {
        self.file == Path::new("-")
    }

    /// Starts the reading thread. Nobody waits for it: it may be blocked in a read that never returns, and owns nothing
    /// that has to be finished.
    fn read(&self, batch: usize, progress: &ProgressBar) -> anyhow::Result<Receiver<Input>> {
        let source = Source {
            place: if self.is_stdin() { Place::Stdin } else { Place::File(self.file.clone()) },
            form: match self.input {
                InputFormat::Text => Form::Lines(Format::Text, self.columns.clone()),
                InputFormat::Jsonl => Form::Lines(Format::JsonLines, self.columns.clone()),
                InputFormat::Bin => Form::Binary,
            },
            frame_points: self.frame_points,
            closes_last: true,
            loops: self.loops,
            batch,
        };
        let (sender, inputs) = sync_channel(WAITING);
        let progress = progress.clone();
        let read = move || {
            let read = source.read(&mut |input| sender.send(input).is_ok(), &progress);
            if let Err(error) = read {
                // Nobody may listen any more, and then nobody needs to know.
                drop(sender.send(Input::Failed(format!("{error:#}"))));
            }
        };
        thread::Builder::new().name("reader".to_owned()).spawn(read).context("cannot start the reader's thread")?;
        Ok(inputs)
    }

    fn progress(&self) -> ProgressBar {
        if self.is_stdin() || !io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let length = std::fs::metadata(&self.file).map_or(0, |data| data.len());
        let template = "{spinner} {msg:20} {wide_bar} {bytes}/{total_bytes} {elapsed}";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(length).with_style(style)
    }
}
