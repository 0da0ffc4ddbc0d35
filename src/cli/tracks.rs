//! `hopes tracks`: the lives of tracks, from what `serve --track` has written, as a table and a picture.
//!
//! In: JSON lines from a file or stdin.
//! Out: the table on stdout, the picture in a file, both at the end of the input or at a signal.
//! Invariants: lines that cannot be used are reported, counted and left out, unless `--strict` stops at the first.
//! Memory grows with tracks, not with frames.
//! Must not know: how lines are read, how tables and pictures are made.

use std::fmt;
use std::io::{self, Read, Write};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use clap::Args;

use super::args::within;
use super::files::NewFile;
use super::{Failure, files};
use crate::daemon::{InputErrors, Stop};
use crate::formats::picture;
use crate::formats::tracks::chart::{Axis, chart};
use crate::formats::tracks::frame::LineContent;
use crate::formats::tracks::lives::Lives;
use crate::formats::tracks::reader::{TrackLine, TrackLines};
use crate::formats::tracks::table::TableFormat;

/// Show the lives of tracks: a table of all of them, and a picture.
///
/// Reads the JSON lines that serve --track or watch --tracks --output jsonl have written, to their end or until Ctrl-C.
/// Writes a line a track: when it began and ended and how, and its persistence, centre and radius when it was most
/// persistent. Lines that report nothing known, or contradict earlier ones, are reported and left out.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{FACTS}"))]
pub struct Tracks {
    /// What serve --track has written; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How the table is written.
    #[arg(short, long, value_enum, default_value_t)]
    format: TableFormat,
    /// Also draw the lives as bars, into this file.
    ///
    /// Bars are coloured by persistence, and paler where a track is not selected. Splits and mergers are links;
    /// relatives are beside each other. A file that is there is replaced at the end, as a whole, or not at all.
    #[arg(long, value_name = "PICTURE")]
    svg: Option<PathBuf>,
    /// Draw the N most persistent tracks only; the picture says how many are left out.
    #[arg(
        long,
        value_name = "N",
        default_value = "100",
        requires = "svg",
        value_parser = within::<1, 10_000>
    )]
    most: u32,
    /// Draw over frames, or over their times.
    #[arg(long, value_enum, default_value_t, requires = "svg")]
    axis: Axis,
    /// Stop at the first line that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
}

const EXAMPLES: &str = "Examples:
  hopes serve --window frames:1 --track view < points.txt > tracked.jsonl
  hopes tracks frames.jsonl                                a line a track
  hopes tracks frames.jsonl --svg lives.svg --most 30      and a picture of the 30 most persistent
  camera-edges | hopes serve --input jsonl --window frames:1 --track top:5 |
    hopes tracks - --format csv > tracks.csv";

const FACTS: &str = "\
A track that was there before the first line has begun \"before\". Without --track-list the peak is
exact to --track-delta. Memory grows with tracks, not with frames. A line has at most 256 MiB.";

/// Lines that may wait to be taken.
const WAITING: usize = 16;

/// How long a wait lasts before signals are looked for.
const MOMENT: Duration = Duration::from_millis(50);

/// Ctrl-C reaches all of a pipeline: the program before this one has so long to finish its last frame.
const LAST_WORDS: Duration = Duration::from_secs(1);

impl Tracks {
    pub fn run(self) -> Result<(), Failure> {
        let name = self.file.display().to_string();
        let source = files::open(&self.file)?;
        // A picture that cannot be written is refused before the reading starts.
        let picture = self.svg.as_ref().map(|path| files::create(path).map(|file| (path, file))).transpose()?;
        let stdout = files::stdout()?;
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let input_errors = InputErrors::new(self.strict).of(files::name(&self.file));
        let mut reading = Reading { lives: Lives::default(), input_errors, frames: 0 };
        reading.read(&start(source)?, &mut stop).map_err(|failure| failure.of(&name))?;
        let Reading { lives, input_errors, frames } = reading;
        input_errors.sum_up();
        if frames == 0 && input_errors.count() > 0 {
            return Err(anyhow!("{name} has no frame: this must be what hopes serve --track has written").into());
        }
        if frames > 0 && lives.all().next().is_none() {
            tracing::warn!(
                "{name} has no track in {frames} {}: a track begins once its dot was selected in --track-confirm frames \
                 on end, which are 2 if serve is not told otherwise; for a single frame: hopes serve --track-confirm 1",
                if frames == 1 { "frame" } else { "frames" }
            );
        }
        if let Some((path, file)) = picture {
            self.draw(&lives, file).with_context(|| files::cannot_write(path))?;
        }
        let mut stdout = files::buffered(stdout);
        let written = self.format.write(&lives, input_errors.count(), &mut stdout);
        Ok(written.context(files::CANNOT_WRITE_TO_STDOUT)?)
    }

    fn draw(&self, lives: &Lives, file: NewFile) -> anyhow::Result<()> {
        let name = self.file.file_stem().and_then(|stem| stem.to_str()).filter(|&stem| stem != "-");
        let chart = chart(lives, self.most as usize, self.axis, name)?;
        (&file).write_all(picture::barcode(&chart).as_bytes())?;
        Ok(file.finish()?)
    }
}

/// Reads and parses in a thread of its own. It is not waited for: it may be blocked in a read that never returns, and
/// owns nothing that has to be finished.
fn start(source: Box<dyn Read + Send>) -> anyhow::Result<Receiver<io::Result<TrackLine>>> {
    let (sender, receiver) = sync_channel(WAITING);
    let mut lines = TrackLines::new(source);
    let read = move || {
        while let Some(line) = lines.next().transpose() {
            let is_last = line.is_err();
            if sender.send(line).is_err() || is_last {
                return;
            }
        }
    };
    thread::Builder::new().name("reader".to_owned()).spawn(read).context("cannot start the reader's thread")?;
    Ok(receiver)
}

/// What was read so far.
struct Reading {
    lives: Lives,
    input_errors: InputErrors,
    /// Frames with tracks.
    frames: u64,
}

/// An error, with its line.
struct At<'a>(u64, &'a dyn fmt::Display);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.0, self.1)
    }
}

/// What is said of a frame without tracks.
const UNTRACKED: &str = "this frame has no tracks: run hopes serve with --track, such as --track view";

impl Reading {
    /// To the end of the lines, or until a signal comes.
    fn read(&mut self, lines: &Receiver<io::Result<TrackLine>>, stop: &mut Stop) -> Result<(), Failure> {
        let mut deadline = None;
        loop {
            if let Some(signal) = stop.asked() {
                let deadline = *deadline.get_or_insert_with(|| Instant::now() + LAST_WORDS);
                if Instant::now() >= deadline {
                    tracing::info!("{signal}: stopped after {} frames", self.frames);
                    return Ok(());
                }
            }
            match lines.recv_timeout(MOMENT) {
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                Ok(line) => self.take(line.context("reading failed")?)?,
            }
        }
    }

    fn take(&mut self, TrackLine { number, content }: TrackLine) -> Result<(), Failure> {
        match content {
            Ok(LineContent::Other) => {}
            Ok(LineContent::Tracks(frame)) => {
                self.frames += 1;
                for contradiction in self.lives.take(&frame) {
                    self.input_errors.add(&At(number, &contradiction))?;
                }
            }
            // No line of such a file would be of use.
            Ok(LineContent::Untracked) if self.frames == 0 => return Err(anyhow!("line {number}: {UNTRACKED}").into()),
            Ok(LineContent::Untracked) => self.input_errors.add(&At(number, &UNTRACKED))?,
            Err(fault) => self.input_errors.add(&At(number, &fault))?,
        }
        Ok(())
    }
}
