//! `hopes feed`: points of a file or a pipe, sent to a stream of a daemon.
//!
//! In: options; text, JSON lines, or the bytes of the protocol. Out: messages to a daemon; complaints about what it refuses. Three threads: one reads, one sends, one takes the answers. Invariants: a bounded number of messages waits for an answer, so
//! memory is bounded and a slow daemon slows the reading; all that was sent is answered before the end. Must not know: the skeleton.

mod ledger;

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use hopes_protocol::{self as wire, Close, Commit, Message, Open, Opened, Retract, Welcome};
use indicatif::{ProgressBar, ProgressStyle};

use self::ledger::{Counts, Ledger, Sent, hung_up};
use super::args::{To, name, rate, resolution, window};
use super::follow::SOFTWARE;
use super::points::{Form, Source};
use super::{Columns, Failure, Format};
use crate::daemon::{self, BATCH, Client, Input, Received, Receiving, Sending, Stop, Timeouts};

/// Send points to a stream of a daemon.
///
/// A blank line, {"commit":true,"time":t}, --frame-points or the end of the input closes a frame. Points that the daemon refuses are reported with their line, and counted.
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
    /// Which points stay: all, points:N (the last N), frames:N (the last N frames), time:T (the last T of event time) [default: as the stream has it, else all].
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

/// The one conversation.
const CHANNEL: u32 = 1;

/// Messages that may wait for their answers.
const UNANSWERED: usize = 64;

/// Inputs that may wait to be sent.
const WAITING: usize = 4;

/// How long anything is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

/// How long the daemon's reason is waited for when nothing can be sent any more.
const LAST_WORDS: Duration = Duration::from_millis(300);

impl Feed {
    pub fn run(self) -> Result<(), Failure> {
        if self.loops && self.is_stdin() {
            return Err(Failure::Usage("--loop needs a file: stdin cannot be read twice"));
        }
        if !self.is_stdin() {
            // Whoever has mistyped a name shall not create a stream.
            std::fs::File::open(&self.file).with_context(|| format!("cannot open {}", self.file.display()))?;
        }
        let connected = Client::connect(&self.to.to, SOFTWARE, Timeouts::default())?;
        let Client { welcome, sending, mut receiving } = connected;
        let mut stop = Stop::listen().context("cannot listen to signals")?;
        let Some(opened) = self.open(&sending, &mut receiving, &mut stop)? else {
            receiving.goodbye("a signal came");
            return Ok(());
        };
        let place = if self.input == InputFormat::Bin { "byte" } else { "line" };
        let ledger = Arc::new(Ledger::new(self.strict, place));
        let progress = self.progress();
        let inputs = self.read(largest_batch(&welcome, &opened), &progress)?;
        let listener = self.listen(receiving, &ledger)?;
        let mut sender = Sender { sending, ledger: &ledger, stop, progress: &progress, sequence: 0, is_open: false };
        let fed = sender.feed(&inputs, self.rate).and_then(|()| sender.close());
        if let Err(error) = fed {
            // If the daemon has said why, that counts.
            ledger.wait_for_end(LAST_WORDS);
            ledger.fail(error);
        }
        let receiving = listener.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        receiving.goodbye("that is all");
        progress.finish_and_clear();
        self.tell(ledger.counts());
        ledger.settle().map(drop)
    }

    fn is_stdin(&self) -> bool {
        self.file == Path::new("-")
    }

    /// Opens the stream; none if a signal comes first.
    fn open(&self, sending: &Sending, receiving: &mut Receiving, stop: &mut Stop) -> anyhow::Result<Option<Opened>> {
        let window = self.window.map(daemon::wire_window);
        sending.send(CHANNEL, Open { name: self.stream.clone(), window, resolution: self.resolution })?;
        while stop.asked().is_none() {
            match receiving.receive_until(Instant::now() + MOMENT)? {
                Received::Nothing => {}
                Received::Message(CHANNEL, Message::Opened(opened)) => return Ok(Some(opened)),
                Received::Message(_, Message::Error(report)) => {
                    bail!("the daemon at {} does not open stream {}: {}", self.to.to, self.stream, report.text)
                }
                Received::Message(_, Message::Goodbye(goodbye)) => {
                    bail!("the daemon at {} says goodbye: {}", self.to.to, goodbye.reason)
                }
                Received::Message(..) => {}
                Received::End => return Err(hung_up(&self.to.to).into()),
            }
        }
        Ok(None)
    }

    /// Starts the reading thread. Nobody waits for it: it may be blocked in a read that never returns, and owns nothing that has to be finished.
    fn read(&self, batch: usize, progress: &ProgressBar) -> anyhow::Result<Receiver<Input>> {
        let source = Source {
            file: (!self.is_stdin()).then(|| self.file.clone()),
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

    /// Starts the thread that takes answers, until it is over.
    fn listen(&self, mut receiving: Receiving, ledger: &Arc<Ledger>) -> anyhow::Result<JoinHandle<Receiving>> {
        let (ledger, address) = (Arc::clone(ledger), self.to.to.clone());
        let listen = move || {
            while ledger.wait(usize::MAX, Duration::ZERO).is_some() {
                match receiving.receive_until(Instant::now() + MOMENT) {
                    Ok(Received::Nothing) => {}
                    Ok(Received::Message(_, message)) => ledger.take(message),
                    Ok(Received::End) => ledger.fail(hung_up(&address)),
                    Err(error) => ledger.fail(error),
                }
            }
            receiving
        };
        thread::Builder::new().name("answers".to_owned()).spawn(listen).context("cannot start a thread")
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

    fn tell(&self, counts: Counts) {
        let Counts { accepted, taken_back, refused, dropped, frames, newest } = counts;
        let back = if taken_back > 0 { format!(", {taken_back} taken back") } else { String::new() };
        let stream = &self.stream;
        tracing::info!(
            "stream {stream}: {accepted} points accepted{back}, {refused} refused, {dropped} dropped; {frames} frames, the last is {newest}"
        );
    }
}

/// How many points go into a message: as many as the daemon takes, and no more than are worth waiting for.
fn largest_batch(welcome: &Welcome, opened: &Opened) -> usize {
    // Two coordinates and a time each; the rest of a message is less than a hundred bytes.
    let fitting = welcome.largest_frame.saturating_sub(100) / 24;
    BATCH.min(welcome.largest_batch.min(opened.largest_batch).min(fitting) as usize).max(1)
}

/// Who sends.
struct Sender<'a> {
    sending: Sending,
    ledger: &'a Ledger,
    stop: Stop,
    progress: &'a ProgressBar,
    sequence: u64,
    /// Whether anything was sent since the last commit.
    is_open: bool,
}

impl Sender<'_> {
    /// Sends until the input ends, a signal comes or it is over.
    fn feed(&mut self, inputs: &Receiver<Input>, rate: Option<f64>) -> anyhow::Result<()> {
        let mut pace = rate.map(Pace::new);
        while !self.is_stopped() {
            match self.ledger.wait(UNANSWERED, MOMENT) {
                None => return Ok(()),
                Some(UNANSWERED..) => continue,
                Some(_) => {}
            }
            match inputs.recv_timeout(MOMENT) {
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
                Ok(Input::Commit(time)) => {
                    if let Some(pace) = &mut pace {
                        self.wait_for(pace.next());
                    }
                    if self.ledger.wait_for_end(Duration::ZERO) {
                        return Ok(());
                    }
                    self.commit(time)?;
                }
                Ok(input) => self.send(input)?,
            }
        }
        if self.is_open { self.commit(None) } else { Ok(()) }
    }

    fn is_stopped(&mut self) -> bool {
        let signal = self.stop.asked();
        if let Some(signal) = signal {
            tracing::info!("{signal}: finishing what is in hand");
        }
        signal.is_some()
    }

    fn send(&mut self, input: Input) -> anyhow::Result<()> {
        match input {
            Input::Points(batch) => {
                let (points, times) = (batch.positions.clone(), batch.times.clone());
                let message = wire::Batch { sequence: self.sequence, points, times, tags: Vec::new() };
                self.message(Sent::Batch(batch), message.into())
            }
            Input::Retract(batch) => {
                let retract = Retract { sequence: self.sequence, points: batch.positions.clone() };
                self.message(Sent::Retract(batch), retract.into())
            }
            // What is read has an end of its own.
            Input::Close { .. } => Ok(()),
            Input::Commit(time) => self.commit(time),
            Input::Unreadable(reason) => {
                self.ledger.complain(&reason);
                Ok(())
            }
            Input::Failed(reason) => bail!("cannot read the input: {reason}"),
        }
    }

    fn commit(&mut self, time: Option<f64>) -> anyhow::Result<()> {
        let commit = Commit { sequence: self.sequence, time: time.filter(|time| time.is_finite()) };
        self.message(Sent::Commit, commit.into())?;
        self.is_open = false;
        self.progress.set_message(format!("{} frames", self.ledger.counts().frames));
        Ok(())
    }

    fn message(&mut self, sent: Sent, message: Message) -> anyhow::Result<()> {
        self.ledger.note(self.sequence, sent);
        self.sequence += 1;
        self.is_open = true;
        Ok(self.sending.send(CHANNEL, message)?)
    }

    /// Waits for all answers, and ends the conversation.
    fn close(&mut self) -> anyhow::Result<()> {
        while self.ledger.wait(1, MOMENT).is_some_and(|unanswered| unanswered > 0) {}
        if self.ledger.wait_for_end(Duration::ZERO) {
            return Ok(());
        }
        self.ledger.closes();
        self.sending.send(CHANNEL, Close { end: false })?;
        while !self.ledger.wait_for_end(MOMENT) {}
        Ok(())
    }

    /// Waits for a time, unless a signal comes or it is over.
    fn wait_for(&mut self, due: Instant) {
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if self.stop.asked().is_some() || self.ledger.wait_for_end(left.min(MOMENT)) {
                return;
            }
        }
    }
}

/// When the next frame is due.
struct Pace {
    period: Duration,
    due: Instant,
}

impl Pace {
    /// So many a second.
    fn new(rate: f64) -> Self {
        // A frame a year is as good as none.
        let longest = Duration::from_secs(365 * 24 * 3600);
        let period = Duration::try_from_secs_f64(1.0 / rate).unwrap_or(longest).min(longest);
        Self { period, due: Instant::now() }
    }

    /// The time of the next frame: a period after the one before, and where that is past, now.
    fn next(&mut self) -> Instant {
        let due = self.due.max(Instant::now());
        self.due = due + self.period;
        due
    }
}
