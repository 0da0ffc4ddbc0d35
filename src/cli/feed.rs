//! `hopes feed`: points of a file or a pipe, sent to a stream of a daemon.
//!
//! In: options; text, JSON lines, or the bytes of the protocol.
//! Out: messages to a daemon; input errors about points that it refuses.
//! Invariants: a thread of its own reads, with a bounded queue to the delivery. A reader that is blocked is not
//! waited for.
//! Must not know: the skeleton, the protocol.

use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;

use super::args::{ProjectArgs, StreamSpace, StreamSpaceArgs, To, form, from_one, name, rate, resolution, window};
use super::{Failure, files, progress};
use crate::client::delivery::{Delivery, Terms};
use crate::daemon::{BATCH, Input};
use crate::formats::input::Format;
use crate::formats::points::{Form, Origin, PointSource};

/// Send points to a stream of a daemon.
///
/// The file is a table, JSON lines, a JSON array, GeoJSON, NPY, PLY or PCD, or any of these compressed by gzip.
///
/// A frame is closed by a blank line, {"commit":true,"time":t}, --frame-points or the end of the input. Points that the
/// daemon refuses are reported with their line, and counted.
///
/// Ctrl-C and SIGTERM close the open frame. At the end it says how many points were read, sent, accepted, refused,
/// dropped and not answered. Answers that have not come five seconds after the signal are a failure (exit code 1).
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes feed edges.jsonl --input jsonl --stream camera
  sensor | hopes feed - --to unix:/tmp/hopes.sock --stream sensor --window points:10000
  hopes feed edges.jsonl --input jsonl --to tcp:127.0.0.1:7878 --stream camera --rate 25 --loop
  hopes feed cloud.csv --metric euclidean --to unix:/tmp/hopes.sock --stream space
  hopes feed points.hopes --input bin --to unix:/tmp/hopes.sock --stream scene")]
pub struct Feed {
    /// File of points; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    to: To,
    /// Name of the stream; it is created if it is not there.
    #[arg(long, value_name = "NAME", default_value = "default", value_parser = name)]
    stream: String,
    /// Which points stay: all, points:N (the last N), frames:N (the last N frames), time:T (the last T of event time;
    /// where it is in seconds also as 30s, 500ms, 2h) [default: as the stream has it, else all].
    #[arg(long, value_name = "WINDOW", value_parser = window)]
    window: Option<hopes::topology::Window>,
    /// Snap positions to a grid of this step [default: as the stream has it, else none].
    #[arg(long, value_name = "STEP", value_parser = resolution)]
    resolution: Option<f64>,
    /// How points are written.
    #[arg(long, value_enum, default_value_t)]
    input: InputFormat,
    /// Columns of a table, by number from 1 or by name in the header; a third one is the event time [default: what the
    /// header calls x and y, or lon and lat, and if the stream's window is time:T also t or time; else 1,2; with
    /// --metric all].
    #[arg(long, value_name = "X,Y[,T]")]
    columns: Option<String>,
    #[command(flatten)]
    project: ProjectArgs,
    #[command(flatten)]
    space: StreamSpaceArgs,
    /// Close at most so many frames a second.
    #[arg(long, value_name = "FPS", value_parser = rate)]
    rate: Option<f64>,
    /// Begin anew at the end of the file, until Ctrl-C.
    #[arg(long = "loop")]
    loops: bool,
    /// Close a frame after so many points were sent.
    #[arg(long, value_name = "N", value_parser = from_one)]
    frame_points: Option<u64>,
    /// Stop at the first line or point that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum InputFormat {
    /// By the file's name, else its first bytes: text or JSON lines.
    #[default]
    Auto,
    /// A table: comma, semicolon, tab or blank separated.
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
        let is_stdin = files::is_pipe(&self.file);
        if self.loops && is_stdin {
            return Err(Failure::usage("--loop needs a file: stdin cannot be read twice"));
        }
        // A mistyped name must not create a stream.
        files::open(&self.file)?;
        let to = self.to.address()?;
        let space = self.space.space()?;
        let source = self.source(space)?;
        let delivery = Delivery {
            to: &to,
            stream: &self.stream,
            window: self.window,
            window_if_new: None,
            resolution: self.resolution,
            space: space.map(StreamSpace::wanted),
            strict: self.strict,
            origin: files::name(&self.file),
            rate: self.rate,
            whole_frames: false,
        };
        let progress = self.progress();
        Ok(delivery.run(&|step| progress::show(&progress, step), |terms| self.read(source, terms, &progress))?)
    }

    /// Starts the reading thread. It is not waited for: it may be blocked in a read that never returns, and owns
    /// nothing that has to be finished.
    fn read(&self, source: PointSource, terms: Terms, progress: &ProgressBar) -> io::Result<Receiver<Input>> {
        let source = PointSource { form: source.form.with_times(terms.wants_times), batch: terms.batch, ..source };
        let (sender, inputs) = sync_channel(WAITING);
        let mut projector = self.project.projector();
        let progress = progress.clone();
        let read = move || {
            let mut send = |input| sender.send(input).is_ok();
            let mut send = |input| match &mut projector {
                Some(projector) => projector.send(input, &mut send),
                None => send(input),
            };
            let read = source.read(&mut send, &|bytes| progress.set_position(bytes));
            if let Err(error) = read {
                // A delivery that has ended does not need the reason.
                drop(sender.send(Input::Failed(format!("{:#}", anyhow::Error::from(error)))));
            }
        };
        thread::Builder::new().name("reader".to_owned()).spawn(read)?;
        Ok(inputs)
    }

    fn source(&self, space: Option<StreamSpace>) -> Result<PointSource, Failure> {
        let columns = self.columns.as_deref();
        Ok(PointSource {
            origin: if files::is_pipe(&self.file) { Origin::Stdin } else { Origin::File(self.file.clone()) },
            form: match self.input {
                InputFormat::Auto => form(space, None, columns, self.project)?,
                InputFormat::Text => form(space, Some(Format::Text), columns, self.project)?,
                InputFormat::Jsonl => form(space, Some(Format::JsonLines), columns, self.project)?,
                InputFormat::Bin => Form::Binary,
            },
            frame_points: self.frame_points,
            closes_last: true,
            loops: self.loops,
            batch: BATCH,
            is_projected: self.project.is_on(),
        })
    }

    fn progress(&self) -> ProgressBar {
        if files::is_pipe(&self.file) {
            return ProgressBar::hidden();
        }
        let template = "{spinner} {msg:20} {wide_bar} {bytes}/{total_bytes} {elapsed}";
        progress::bar(progress::length(&self.file), template)
    }
}
