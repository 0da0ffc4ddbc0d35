//! `hopes replay`: a recording again, at its own pace or another.
//!
//! In: a recording.
//! Out: a line a frame, events, JSON lines, or a recording.
//! Invariants: every frame shown was proved. Of a recording that was cut off, all whole frames are shown. A damaged
//! one ends with an error that says where.
//! Must not know: where the recording comes from.

use std::io::{self, Read};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Args;
use hopes_protocol::{Elapsed, Message, SPACE_FILE_VERSION};

use super::args::rate;
use super::{Failure, files};
use crate::client::mirrors::{Mirrors, Taken};
use crate::daemon::Stop;
use crate::formats::messages::{MessageForm, MessageWriter};
use crate::formats::recording::{Frames, Next, RecordingError};

/// Play a recording again.
///
/// Plays what record, watch --output bin or serve --output bin have written, at the pace at which it was recorded.
/// Every frame is proved by its checksum. A recording that was cut off is played up to its last whole frame, with a
/// warning; one of an older hopes, which has no end, is taken for such a one.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes replay camera.hopes                                as it was
  hopes replay camera.hopes --speed 10                     ten times as fast
  hopes replay camera.hopes --fast --output jsonl | jq -c '[.frame, .view.cycles]'")]
pub struct Replay {
    /// The recording; - for stdin.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// As fast as possible.
    #[arg(long, conflicts_with = "speed")]
    fast: bool,
    /// X times as fast as it was recorded.
    #[arg(long, value_name = "X", default_value = "1", value_parser = rate)]
    speed: f64,
    /// Fail at the end if the recording was cut off (exit code 3).
    #[arg(long)]
    strict: bool,
    /// How frames are written on stdout.
    #[arg(long, value_enum, default_value_t)]
    output: MessageForm,
}

/// A longer pause before a frame is logged.
const LONG_PAUSE: Duration = Duration::from_secs(30);

/// How long a wait lasts before signals are looked for.
const MOMENT: Duration = Duration::from_millis(50);

/// Messages that may wait to be shown.
const WAITING: usize = 4;

impl Replay {
    pub fn run(self) -> Result<(), Failure> {
        let source = files::open(&self.file)?;
        let mut playing = Playing {
            read: read(source)?,
            writer: MessageWriter::new(self.output, files::buffered(files::message_stdout(self.output)?)),
            mirrors: Mirrors::default(),
            stop: Stop::listen().context("cannot listen to signals")?,
            speed: (!self.fast).then_some(self.speed),
            begun: Instant::now(),
            elapsed: Duration::ZERO,
            shown: Arc::default(),
        };
        files::end_in_time(Arc::clone(&playing.shown)).context("cannot listen to signals")?;
        let played = playing.play().with_context(|| self.file.display().to_string());
        tracing::debug!("{} frames", playing.shown.load(Relaxed));
        self.judge(played?, playing.shown.load(Relaxed))
    }

    /// What is said of how the recording ended.
    fn judge(&self, played: Played, shown: u64) -> Result<(), Failure> {
        let file = self.file.display();
        let missing = match played {
            Played::Stopped(signal) => {
                tracing::info!("{signal}: stopped after {shown} frames");
                return Ok(());
            }
            Played::Whole(reason) => {
                tracing::info!("{file} ends after {shown} frames: {reason}");
                return Ok(());
            }
            Played::CutOff { offset } => format!("{file} is cut off at byte {offset}: {shown} whole frames were there"),
            Played::Endless => {
                format!("{file} has no end after {shown} frames: it was cut off, or an older hopes has written it")
            }
        };
        if self.strict {
            return Err(Failure::Refused(format!("{missing} (--strict)")));
        }
        tracing::warn!("{missing}");
        Ok(())
    }
}

/// Starts the reading thread. It is not waited for: it may be blocked in a read that never returns, and owns nothing
/// that has to be finished.
fn read(source: Box<dyn Read + Send>) -> anyhow::Result<Receiver<Result<Next, RecordingError>>> {
    let (sender, receiver) = sync_channel(WAITING);
    let mut frames = Frames::new(source);
    let read = move || {
        loop {
            let next = frames.next();
            let is_last = !matches!(next, Ok(Next::Message { .. }));
            if sender.send(next).is_err() || is_last {
                return;
            }
        }
    };
    thread::Builder::new().name("reader".to_owned()).spawn(read).context("cannot start the reader's thread")?;
    Ok(receiver)
}

/// How the playing ended.
enum Played {
    /// The recording is whole, and says why it ended.
    Whole(String),
    /// It ends between two messages, without an end.
    Endless,
    /// It ends within what begins there.
    CutOff { offset: u64 },
    /// By a signal.
    Stopped(&'static str),
}

struct Playing<W: io::Write> {
    read: Receiver<Result<Next, RecordingError>>,
    writer: MessageWriter<W>,
    mirrors: Mirrors,
    stop: Stop,
    /// None: without any pause.
    speed: Option<f64>,
    begun: Instant,
    /// Since the recording began, at the present message.
    elapsed: Duration,
    shown: Arc<AtomicU64>,
}

impl<W: io::Write> Playing<W> {
    fn play(&mut self) -> anyhow::Result<Played> {
        let mut end = None;
        loop {
            if let Some(signal) = self.stop.asked() {
                self.writer.finish(self.elapsed, signal).context("cannot write frames")?;
                return Ok(Played::Stopped(signal));
            }
            let next = match self.read.recv_timeout(MOMENT) {
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => {
                    bail!("the reader's thread stopped by itself: please report this")
                }
                Ok(next) => next?,
            };
            match next {
                Next::End => return Ok(end.map_or(Played::Endless, Played::Whole)),
                Next::CutOff { offset } => return Ok(Played::CutOff { offset }),
                Next::Message { offset, .. } if end.is_some() => bail!("at byte {offset}: something follows the end"),
                Next::Message { channel, message: Message::Goodbye(goodbye), .. } => {
                    end = Some(goodbye.reason.replace(char::is_control, " "));
                    self.writer.write("", self.elapsed, channel, &goodbye.into()).context("cannot write frames")?;
                }
                Next::Message { message: Message::Elapsed(elapsed), .. } => self.wait(elapsed),
                Next::Message { offset, channel, version, message } => {
                    if version >= SPACE_FILE_VERSION {
                        self.writer.set_mixed();
                    }
                    self.message(channel, &message).with_context(|| format!("at byte {offset}"))?;
                }
            }
        }
    }

    fn message(&mut self, channel: u32, message: &Message) -> anyhow::Result<()> {
        if let Message::Batch(_) | Message::Retract(_) | Message::Commit(_) = message {
            bail!("these are points, and no recording: send them with hopes feed --input bin");
        }
        if self.mirrors.take_recorded(message).context("damaged: all before it is good")? == Taken::Frame {
            self.shown.fetch_add(1, Relaxed);
        }
        let name = self.mirrors.name_of(message);
        self.writer.write(name, self.elapsed, channel, message).context("cannot write frames")?;
        self.mirrors.forget_closed(message);
        Ok(())
    }

    /// Waits until the message that was recorded so long after the beginning is due.
    fn wait(&mut self, Elapsed { nanoseconds }: Elapsed) {
        self.elapsed = Duration::from_nanos(nanoseconds);
        let Some(speed) = self.speed else { return };
        // A pause that does not fit is as good as endless.
        let due = Duration::try_from_secs_f64(self.elapsed.as_secs_f64() / speed).unwrap_or(Duration::MAX);
        let mut is_logged = false;
        while let Some(left) = due.checked_sub(self.begun.elapsed()).filter(|left| !left.is_zero()) {
            if left > LONG_PAUSE && !is_logged {
                is_logged = true;
                let left = humantime::format_duration(Duration::from_secs(left.as_secs()));
                tracing::info!("the next frame is due in {left}; --fast does not wait");
            }
            if self.stop.wait(left.min(MOMENT)).is_some() {
                return;
            }
        }
    }
}
