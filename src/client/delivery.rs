//! Delivery of points to a stream of a daemon: opening the stream, sending, and taking the answers.
//!
//! In: [`Input`]s, from a thread of the caller.
//! Out: messages to a daemon; input errors about points that it refuses.
//! Threads: the caller's reads, one sends, one takes the answers.
//! Invariants: a bounded number of messages is unanswered, so memory is bounded and a slow daemon slows the
//! reading. All that was sent is answered before the end.
//! Must not know: where points come from, the skeleton, arguments.

mod error;
mod ledger;

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use hopes::topology::Window;
use hopes_protocol::{
    self as wire, Close, Commit, ErrorCode, Message, Open, OpenSpace, Opened, Report, Retract, Welcome,
};

use self::ledger::{Counts, Ledger, Sent};
use super::connection::{Client, Received, Receiving, SOFTWARE, Sending, Timeouts};
use super::error::ClientError;
use super::pace::Pace;
use super::running::Running;
use crate::daemon::{self, Address, BATCH, Input, InputErrors, Positions, Stop};

pub use self::error::DeliveryError;

/// The channel of the stream.
const CHANNEL: u32 = 1;

/// Messages that may be unanswered.
const UNANSWERED: usize = 64;

/// How long a wait lasts before signals are looked for.
const MOMENT: Duration = Duration::from_millis(50);

/// How long answers are waited for once a signal has come.
const GRACE: Duration = Duration::from_secs(5);

/// How long the daemon's reason is waited for when nothing can be sent any more.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// Where points go, and how.
#[derive(Debug)]
pub struct Delivery<'a> {
    /// The daemon.
    pub to: &'a Address,
    /// The name of the stream.
    pub stream: &'a str,
    /// Which points stay. A stream that exists must have this window.
    pub window: Option<Window>,
    /// Which points stay in a stream that is created, if no window is given.
    pub window_if_new: Option<Window>,
    /// Grid that positions snap to.
    pub resolution: Option<f64>,
    /// The space that points are of, if it is not the plane.
    pub space: Option<WantedSpace>,
    /// Stop at the first error.
    pub strict: bool,
    /// The file that points are from.
    pub origin: Option<String>,
    /// Close at most so many frames a second.
    pub rate: Option<f64>,
    /// A signal waits for the end of a frame that was begun. The reader must never block within a frame.
    pub whole_frames: bool,
}

/// A space of points of R^d. A stream that exists must be of this space.
#[derive(Clone, Copy, Debug)]
pub struct WantedSpace {
    /// The metric.
    pub metric: wire::Metric,
    /// The number of coordinates of a point, if it is known before the first one.
    pub dimension: Option<u32>,
}

/// What the stream expects.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    /// Points of a message: as many as the daemon takes, and not so many that gathering them delays the first ones.
    pub batch: usize,
    /// Its window is of event time.
    pub wants_times: bool,
}

/// How far a delivery is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// So many frames were committed.
    Frames(u64),
    /// All was answered, or the delivery failed.
    Done,
}

impl Delivery<'_> {
    /// Delivers all that is read, until a signal comes. `read` gets the terms of the stream, and starts a thread that
    /// reads. That thread is not waited for: it may be blocked in a read that never returns.
    ///
    /// # Errors
    /// [`DeliveryError`].
    pub fn run(
        &self,
        progress: &dyn Fn(Progress),
        read: impl FnOnce(Terms) -> io::Result<Receiver<Input>>,
    ) -> Result<(), DeliveryError> {
        let client = Client::connect(self.to, SOFTWARE, Timeouts::default())?;
        let stop = Stop::listen().map_err(DeliveryError::Signals)?;
        self.deliver(client, stop, progress, read)
    }

    /// As [`run`](Self::run), on a connection that is there, until it is asked to stop.
    ///
    /// # Errors
    /// [`DeliveryError`].
    pub fn deliver(
        &self,
        client: Client,
        mut stop: Stop,
        progress: &dyn Fn(Progress),
        read: impl FnOnce(Terms) -> io::Result<Receiver<Input>>,
    ) -> Result<(), DeliveryError> {
        let Client { welcome, sending, mut receiving } = client;
        let Some(opened) = self.open(&sending, &mut receiving, &mut stop)? else {
            tracing::info!("stream {}: a signal came before it was open: nothing was sent", self.stream);
            receiving.goodbye("a signal came");
            return Ok(());
        };
        let input_errors = InputErrors::new(self.strict).of(self.origin.clone());
        let ledger = Arc::new(Ledger::new(input_errors));
        let terms = Terms::of(&welcome, &opened);
        let inputs = read(terms).map_err(DeliveryError::Reader)?;
        let answers = self.take_answers(receiving, &ledger)?;
        let whole_frames = self.whole_frames;
        let mut sender = Sender {
            sending,
            ledger: &ledger,
            stop,
            progress,
            whole_frames,
            sequence: 0,
            is_open: false,
            stopping: None,
        };
        let fed = sender.feed(&inputs, self.rate).and_then(|()| sender.close());
        if let Err(error) = fed {
            // If the daemon has given a reason, that one is reported.
            ledger.wait_for_end(LAST_WORDS);
            ledger.fail(error);
        }
        let receiving = answers.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        receiving.goodbye("that is all");
        progress(Progress::Done);
        self.log(ledger.counts());
        ledger.settle()
    }

    /// Opens the stream; none if a signal comes first.
    fn open(
        &self,
        sending: &Sending,
        receiving: &mut Receiving,
        stop: &mut Stop,
    ) -> Result<Option<Opened>, DeliveryError> {
        let mut window = self.window.or(self.window_if_new);
        loop {
            match self.open_with(window, sending, receiving, stop)? {
                Answer::Opened(opened) => return Ok(Some(opened)),
                Answer::Signal => return Ok(None),
                // The stream exists, with another window.
                Answer::Refused(Report { code, .. })
                    if code == ErrorCode::OtherOptions as u16 && window.is_some() && self.window.is_none() =>
                {
                    window = None;
                }
                Answer::Refused(report) => {
                    let (address, stream) = (self.to.clone(), self.stream.to_owned());
                    return Err(DeliveryError::NotOpened { address, stream, reason: report.text });
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
    ) -> Result<Answer, DeliveryError> {
        let window = window.map(daemon::wire_window);
        sending.send(CHANNEL, self.request(window))?;
        while stop.asked().is_none() {
            match receiving.receive_until(Instant::now() + MOMENT)? {
                Received::Nothing => {}
                Received::Message(CHANNEL, Message::Opened(opened)) => return Ok(Answer::Opened(opened)),
                Received::Message(CHANNEL, Message::SpaceOpened(space)) => return Ok(Answer::Opened(space.opened)),
                Received::Message(_, Message::Error(report)) => return Ok(Answer::Refused(report)),
                Received::Message(_, Message::Goodbye(goodbye)) => {
                    let (address, reason) = (self.to.clone(), goodbye.reason);
                    return Err(DeliveryError::GoodbyeAtOnce { address, reason });
                }
                Received::Message(..) => {}
                Received::End => return Err(hung_up(self.to).into()),
            }
        }
        Ok(Answer::Signal)
    }

    /// What asks for the stream.
    fn request(&self, window: Option<wire::Window>) -> Message {
        let (name, resolution) = (self.stream.to_owned(), self.resolution);
        match self.space {
            None => Open { name, window, resolution }.into(),
            Some(WantedSpace { metric, dimension }) => {
                OpenSpace { name, window, resolution, metric: Some(metric), dimension }.into()
            }
        }
    }

    /// Starts the thread that takes answers, until the delivery ends.
    fn take_answers(
        &self,
        mut receiving: Receiving,
        ledger: &Arc<Ledger>,
    ) -> Result<JoinHandle<Receiving>, DeliveryError> {
        let (ledger, address) = (Arc::clone(ledger), self.to.clone());
        let take = move || {
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
        thread::Builder::new().name("answers".to_owned()).spawn(take).map_err(DeliveryError::Thread)
    }

    fn log(&self, counts: Counts) {
        let Counts { read, unusable, sent, unanswered, accepted, taken_back, refused, dropped, frames, newest } =
            counts;
        let back = if taken_back > 0 { format!(", {taken_back} taken back") } else { String::new() };
        let bad = if unusable > 0 { format!(", {unusable} times what could not be used") } else { String::new() };
        let stream = self.stream;
        tracing::info!(
            "stream {stream}: {accepted} points accepted{back}, {refused} refused, {dropped} dropped; \
             {frames} frames, the last is {newest}; {read} points were read{bad}, {sent} sent, \
             {unanswered} not answered"
        );
    }
}

/// The connection ended, without a reason.
fn hung_up(address: &Address) -> ClientError {
    ClientError::Closed { address: address.clone(), when: "before it had answered everything" }
}

/// The answer to opening a stream.
enum Answer {
    Opened(Opened),
    Refused(Report),
    Signal,
}

impl Terms {
    fn of(welcome: &Welcome, opened: &Opened) -> Self {
        // Two coordinates and a time each; the rest of a message is less than a hundred bytes.
        let fitting = welcome.largest_frame.saturating_sub(100) / 24;
        let batch = BATCH.min(welcome.largest_batch.min(opened.largest_batch).min(fitting) as usize).max(1);
        Self { batch, wants_times: matches!(opened.window, wire::Window::Time(_)) }
    }
}

/// The sending side.
struct Sender<'a> {
    sending: Sending,
    ledger: &'a Ledger,
    stop: Stop,
    progress: &'a dyn Fn(Progress),
    whole_frames: bool,
    sequence: u64,
    /// Whether anything was sent since the last commit.
    is_open: bool,
    /// Since the first look after a signal.
    stopping: Option<Running>,
}

impl Sender<'_> {
    /// Sends until the input ends, a signal comes or the delivery ends.
    fn feed(&mut self, inputs: &Receiver<Input>, rate: Option<f64>) -> Result<(), DeliveryError> {
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
                Ok(input @ (Input::Points(_) | Input::Retract(_))) => {
                    self.ledger.read(&input);
                    self.send(input)?;
                }
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
            tracing::info!("{signal}: finishing the open frame");
            inputs.try_iter().for_each(|input| self.ledger.read(&input));
        }
        if self.is_open { self.commit(None) } else { Ok(()) }
    }

    /// Whether a signal has come and no frame is to be finished first.
    fn may_stop(&mut self) -> bool {
        self.stop.asked().is_some() && !(self.whole_frames && self.is_open)
    }

    fn send(&mut self, input: Input) -> Result<(), DeliveryError> {
        match input {
            Input::Points(batch) => {
                let (sequence, times, tags) = (self.sequence, batch.times.clone(), Vec::new());
                let message = match batch.positions.clone() {
                    Positions::Plane(points) => wire::Batch { sequence, points, times, tags }.into(),
                    Positions::Space { dimension, coordinates } => {
                        let dimension = dimension as u32;
                        wire::SpaceBatch { sequence, dimension, coordinates, times, tags }.into()
                    }
                };
                self.message(Sent::Batch(batch), message)
            }
            Input::Retract(batch) => {
                let sequence = self.sequence;
                let message = match batch.positions.clone() {
                    Positions::Plane(points) => Retract { sequence, points }.into(),
                    Positions::Space { dimension, coordinates } => {
                        wire::SpaceRetract { sequence, dimension: dimension as u32, coordinates }.into()
                    }
                };
                self.message(Sent::Retract(batch), message)
            }
            // The end of the input closes the stream.
            Input::Close { .. } | Input::Abandon => Ok(()),
            Input::Commit(time) => self.commit(time),
            Input::Unreadable(reason) => {
                self.ledger.report_error(&reason);
                Ok(())
            }
            Input::Failed(reason) => Err(DeliveryError::Input(reason)),
        }
    }

    fn commit(&mut self, time: Option<f64>) -> Result<(), DeliveryError> {
        let commit = Commit { sequence: self.sequence, time: time.filter(|time| time.is_finite()) };
        self.message(Sent::Commit, commit.into())?;
        self.is_open = false;
        (self.progress)(Progress::Frames(self.ledger.counts().frames));
        Ok(())
    }

    fn message(&mut self, sent: Sent, message: Message) -> Result<(), DeliveryError> {
        self.ledger.note(self.sequence, sent);
        self.sequence += 1;
        self.is_open = true;
        self.put(message)
    }

    fn put(&mut self, message: impl Into<Message>) -> Result<(), DeliveryError> {
        let sending = self.sending.clone();
        let is_sent = sending.send_unless(CHANNEL, message, &mut || self.has_waited_enough())?;
        if is_sent { Ok(()) } else { Err(self.gives_up()) }
    }

    /// Waits for all answers, and closes the stream.
    fn close(&mut self) -> Result<(), DeliveryError> {
        while self.ledger.wait(1, MOMENT).is_some_and(|unanswered| unanswered > 0) {
            if self.has_waited_enough() {
                return Err(self.gives_up());
            }
        }
        if self.ledger.wait_for_end(Duration::ZERO) {
            return Ok(());
        }
        self.ledger.closes();
        self.put(Close { end: false })?;
        while !self.ledger.wait_for_end(MOMENT) {
            if self.has_waited_enough() {
                return Err(self.gives_up());
            }
        }
        Ok(())
    }

    /// Whether a signal has come so long ago that nothing more is waited for.
    fn has_waited_enough(&mut self) -> bool {
        self.stop.asked().is_some() && self.stopping.get_or_insert_with(Running::new).elapsed() > GRACE
    }

    fn gives_up(&self) -> DeliveryError {
        DeliveryError::Unanswered { seconds: GRACE.as_secs(), points: self.ledger.counts().unanswered }
    }

    /// Waits for a time, unless a signal comes or the delivery ends first.
    fn wait_for(&mut self, due: Instant) {
        while let Some(left) = due.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if self.stop.asked().is_some() || self.ledger.wait_for_end(left.min(MOMENT)) {
                return;
            }
        }
    }
}
