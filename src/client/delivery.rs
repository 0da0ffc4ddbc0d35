//! Delivering points to a stream of a daemon: opening it, sending, and answers to all that was sent.
//!
//! In: [`Input`]s, from a thread of the caller's. Out: messages to a daemon; input errors about what it refuses. Three
//! threads: the caller's reads, one sends, one takes the answers. Invariants: a bounded number of messages waits for an
//! answer, so memory is bounded and a slow daemon slows the reading; all that was sent is answered before the end. Must
//! not know: where points come from; the skeleton.

mod ledger;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use hopes::topology::Window;
use hopes_protocol::{self as wire, Close, Commit, ErrorCode, Message, Open, Opened, Report, Retract, Welcome};
use indicatif::ProgressBar;

use self::ledger::{Counts, Ledger, Sent, hung_up};
use super::connection::{Client, Received, Receiving, Sending, Timeouts};
use super::follow::SOFTWARE;
use super::pace::Pace;
use crate::cli::Failure;
use crate::daemon::{self, Address, BATCH, Input, Stop};

/// The one conversation.
const CHANNEL: u32 = 1;

/// Messages that may wait for their answers.
const UNANSWERED: usize = 64;

/// How long anything is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

/// How long the daemon's reason is waited for when nothing can be sent any more.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// Where points go, and how.
#[derive(Debug)]
pub struct Delivery<'a> {
    /// The daemon.
    pub to: &'a Address,
    /// The name of the stream.
    pub stream: &'a str,
    /// Which points stay; one that is there must have it so.
    pub window: Option<Window>,
    /// Which points stay in a stream that is not there yet, if nothing else was asked for.
    pub window_if_new: Option<Window>,
    /// Grid that positions snap to.
    pub resolution: Option<f64>,
    /// Stop at the first error.
    pub strict: bool,
    /// What the place of a point is: a line, or a byte.
    pub place: &'static str,
    /// Close at most so many frames a second.
    pub rate: Option<f64>,
    /// A signal waits for the end of a frame that was begun: the reader never waits for anybody within one.
    pub whole_frames: bool,
}

impl Delivery<'_> {
    /// Delivers all that `read` finds: it is told how many points go into a message, and starts a thread that reads.
    /// Nobody waits for that thread: it may be blocked in a read that never returns.
    pub fn run(
        &self,
        progress: &ProgressBar,
        read: impl FnOnce(usize) -> anyhow::Result<Receiver<Input>>,
    ) -> Result<(), Failure> {
        let client = Client::connect(self.to, SOFTWARE, Timeouts::default())?;
        let stop = Stop::listen().context("cannot listen to signals")?;
        self.deliver(client, stop, progress, read)
    }

    /// As [`run`](Self::run), on a connection that is there, until it is asked to stop.
    pub fn deliver(
        &self,
        client: Client,
        mut stop: Stop,
        progress: &ProgressBar,
        read: impl FnOnce(usize) -> anyhow::Result<Receiver<Input>>,
    ) -> Result<(), Failure> {
        let Client { welcome, sending, mut receiving } = client;
        let Some(opened) = self.open(&sending, &mut receiving, &mut stop)? else {
            receiving.goodbye("a signal came");
            return Ok(());
        };
        let ledger = Arc::new(Ledger::new(self.strict, self.place));
        let inputs = read(largest_batch(&welcome, &opened))?;
        let listener = self.listen(receiving, &ledger)?;
        let whole_frames = self.whole_frames;
        let mut sender = Sender { sending, ledger: &ledger, stop, progress, whole_frames, sequence: 0, is_open: false };
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

    /// Opens the stream; none if a signal comes first.
    fn open(&self, sending: &Sending, receiving: &mut Receiving, stop: &mut Stop) -> anyhow::Result<Option<Opened>> {
        let mut wish = self.window.or(self.window_if_new);
        loop {
            match self.open_with(wish, sending, receiving, stop)? {
                Answer::Opened(opened) => return Ok(Some(opened)),
                Answer::Signal => return Ok(None),
                // It is there, and has a window of its own.
                Answer::Refused(Report { code, .. })
                    if code == ErrorCode::OtherOptions as u16 && wish.is_some() && self.window.is_none() =>
                {
                    wish = None;
                }
                Answer::Refused(report) => {
                    bail!("the daemon at {} does not open stream {}: {}", self.to, self.stream, report.text)
                }
            }
        }
    }

    fn open_with(
        &self,
        window: Option<Window>,
        sending: &Sending,
        receiving: &mut Receiving,
        stop: &mut Stop,
    ) -> anyhow::Result<Answer> {
        let window = window.map(daemon::wire_window);
        sending.send(CHANNEL, Open { name: self.stream.to_owned(), window, resolution: self.resolution })?;
        while stop.asked().is_none() {
            match receiving.receive_until(Instant::now() + MOMENT)? {
                Received::Nothing => {}
                Received::Message(CHANNEL, Message::Opened(opened)) => return Ok(Answer::Opened(opened)),
                Received::Message(_, Message::Error(report)) => return Ok(Answer::Refused(report)),
                Received::Message(_, Message::Goodbye(goodbye)) => {
                    bail!("the daemon at {} says goodbye: {}", self.to, goodbye.reason)
                }
                Received::Message(..) => {}
                Received::End => return Err(hung_up(self.to).into()),
            }
        }
        Ok(Answer::Signal)
    }

    /// Starts the thread that takes answers, until it is over.
    fn listen(&self, mut receiving: Receiving, ledger: &Arc<Ledger>) -> anyhow::Result<JoinHandle<Receiving>> {
        let (ledger, address) = (Arc::clone(ledger), self.to.clone());
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

    fn tell(&self, counts: Counts) {
        let Counts { accepted, taken_back, refused, dropped, frames, newest } = counts;
        let back = if taken_back > 0 { format!(", {taken_back} taken back") } else { String::new() };
        let stream = self.stream;
        tracing::info!(
            "stream {stream}: {accepted} points accepted{back}, {refused} refused, {dropped} dropped; {frames} frames, the last is {newest}"
        );
    }
}

/// What came of asking for a stream.
enum Answer {
    Opened(Opened),
    Refused(Report),
    Signal,
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
    whole_frames: bool,
    sequence: u64,
    /// Whether anything was sent since the last commit.
    is_open: bool,
}

impl Sender<'_> {
    /// Sends until the input ends, a signal comes or it is over.
    fn feed(&mut self, inputs: &Receiver<Input>, rate: Option<f64>) -> anyhow::Result<()> {
        let mut pace = rate.map(Pace::new);
        while !self.may_stop() {
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
        if let Some(signal) = self.stop.asked() {
            tracing::info!("{signal}: finishing what is in hand");
        }
        if self.is_open { self.commit(None) } else { Ok(()) }
    }

    /// Whether a signal has come, and nothing is to be finished before.
    fn may_stop(&mut self) -> bool {
        self.stop.asked().is_some() && !(self.whole_frames && self.is_open)
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
                self.ledger.report_error(&reason);
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
