//! `hopes tracks`: the lives of tracks, from what `serve --track` has written, as a table and a picture.
//!
//! In: JSON lines from a file or stdin. Out: the table on stdout, the picture in a file, both at the end of the input or at a signal. Invariants: lines that cannot be used are reported, counted and left out, unless `--strict` stops at the
//! first; memory grows with tracks, not with frames. Must not know: how tracks are made.
//!
//! Data flows from `frame` (a line) to `lives` (what was), then to `table` and, through `order`, to `chart` (what is shown).

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use clap::Args;

use super::Failure;
use crate::daemon::{InputErrors, Stop};
use crate::formats::input::{Line, Lines};
use crate::formats::picture;
use crate::formats::tracks::chart::{Axis, chart};
use crate::formats::tracks::frame::{self, Fault, Said};
use crate::formats::tracks::lives::Lives;
use crate::formats::tracks::table::TableFormat;

/// Show the lives of tracks: a table of all of them, and a picture.
///
/// Reads the JSON lines that serve --track writes, to their end or until Ctrl-C.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes serve --window frames:1 --track view < points.txt > frames.jsonl
  hopes tracks frames.jsonl                                a line a track
  hopes tracks frames.jsonl --svg lives.svg --most 30      and a picture of the 30 most persistent
  produce | hopes serve --track top:5 | hopes tracks - --format csv > tracks.csv")]
pub struct Tracks {
    /// What serve --track has written; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// How the table is written.
    #[arg(short, long, value_enum, default_value_t)]
    format: TableFormat,
    /// Also draw the lives as bars, into this file.
    #[arg(long, value_name = "PICTURE")]
    svg: Option<PathBuf>,
    /// Draw the N most persistent tracks only.
    #[arg(long, value_name = "N", default_value = "100", requires = "svg", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    most: u32,
    /// Draw over frames, or over their times.
    #[arg(long, value_enum, default_value_t, requires = "svg")]
    axis: Axis,
    /// Stop at the first line that cannot be used (exit code 3).
    #[arg(long)]
    strict: bool,
}

/// A line of serve lists all points of a frame that is new: some millions of them.
const LONGEST_LINE: usize = 256 << 20;

/// Lines that may wait to be taken.
const WAITING: usize = 16;

/// How long anything is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

/// Ctrl-C reaches all of a pipeline: whoever writes to us has so long to finish what it has begun.
const LAST_WORDS: Duration = Duration::from_secs(1);

impl Tracks {
    pub fn run(self) -> Result<(), Failure> {
        let name = self.file.display().to_string();
        let source: Box<dyn Read + Send> = if self.file == Path::new("-") {
            Box::new(io::stdin())
        } else {
            Box::new(File::open(&self.file).with_context(|| format!("cannot open {name}"))?)
        };
        // Whether it can be written is known before the reading starts, not after it.
        let picture = self.svg.as_ref().map(|path| {
            File::create(path).map(|file| (path, file)).with_context(|| format!("cannot write {}", path.display()))
        });
        let picture = picture.transpose()?;
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let mut reading = Reading { lives: Lives::default(), input_errors: InputErrors::new(self.strict), frames: 0 };
        reading.read(&start(source)?, &mut stop).map_err(|failure| failure.of(&name))?;
        let Reading { lives, input_errors, frames } = reading;
        input_errors.sum_up();
        if frames == 0 && input_errors.count() > 0 {
            return Err(anyhow!("{name} has no frame: this must be what hopes serve --track has written").into());
        }
        if let Some((path, file)) = picture {
            self.draw(&lives, file).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let mut stdout = BufWriter::with_capacity(1 << 16, io::stdout().lock());
        self.format.write(&lives, input_errors.count(), &mut stdout).context("cannot write to stdout")?;
        Ok(())
    }

    fn draw(&self, lives: &Lives, mut file: File) -> anyhow::Result<()> {
        let name = self.file.file_stem().and_then(|stem| stem.to_str()).filter(|&stem| stem != "-");
        let chart = chart(lives, self.most as usize, self.axis, name)?;
        file.write_all(picture::barcode(&chart).as_bytes())?;
        Ok(())
    }
}

/// A line that was read.
struct Taken {
    line: u64,
    said: Result<Said, Fault>,
}

/// Reads and parses in a thread of its own. Nobody waits for it: it may be blocked in a read that never returns, and owns nothing that has to be finished.
fn start(source: Box<dyn Read + Send>) -> anyhow::Result<Receiver<io::Result<Taken>>> {
    let (sender, receiver) = sync_channel(WAITING);
    let mut lines = Lines::new(source, LONGEST_LINE);
    let read = move || {
        loop {
            let taken = match lines.next() {
                Ok(None) => return,
                Ok(Some(Line::Whole(line))) if line.trim_ascii().is_empty() => continue,
                Ok(Some(Line::Whole(line))) => Ok(frame::read(line)),
                Ok(Some(Line::TooLong)) => Ok(Err(Fault::TooLong { limit: LONGEST_LINE })),
                Err(error) => Err(error),
            };
            let is_last = taken.is_err();
            if sender.send(taken.map(|said| Taken { line: lines.number(), said })).is_err() || is_last {
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

/// A error, with its line.
struct At<'a>(u64, &'a dyn fmt::Display);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.0, self.1)
    }
}

/// What a frame without tracks lacks.
const UNTRACKED: &str = "this frame has no tracks: run hopes serve with --track, such as --track view";

impl Reading {
    /// To the end of the lines, or until a signal comes.
    fn read(&mut self, lines: &Receiver<io::Result<Taken>>, stop: &mut Stop) -> Result<(), Failure> {
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
                Ok(taken) => self.take(taken.context("reading failed")?)?,
            }
        }
    }

    fn take(&mut self, Taken { line, said }: Taken) -> Result<(), Failure> {
        match said {
            Ok(Said::Nothing) => {}
            Ok(Said::Tracks(frame)) => {
                self.frames += 1;
                for contradiction in self.lives.take(&frame) {
                    self.input_errors.add(&At(line, &contradiction))?;
                }
            }
            // Nothing of such a file would be of use.
            Ok(Said::Untracked) if self.frames == 0 => return Err(anyhow!("line {line}: {UNTRACKED}").into()),
            Ok(Said::Untracked) => self.input_errors.add(&At(line, &UNTRACKED))?,
            Err(fault) => self.input_errors.add(&At(line, &fault))?,
        }
        Ok(())
    }
}
