//! Following streams of a daemon: subscribe, prove every frame, hand it on, and subscribe again after a gap.
//!
//! In: a [`Subscription`].
//! Out: its messages, to a [`MessageSink`].
//! Invariants: every frame that is handed on was proved by its checksum. A gap is never silent: it is logged, and
//! closed by a new snapshot. Attempts to subscribe or to connect again are bounded in number, pace and time.
//! Must not know: how messages are written, arguments.

mod absent;
mod error;

use std::collections::BTreeMap;
use std::io;
use std::time::{Duration, Instant};

use hopes_protocol::{
    DotsWanted, ErrorCode, Message, Report, StatusWanted, Subscribe, TracksWanted, Unsubscribe, View, WantTracks,
};

use super::chain::Chain;
use super::connection::{Client, Received, SOFTWARE, Sending, Timeouts};
use super::error::ClientError;
use super::mirrors::{Mirrors, MirrorsError, Taken};
use super::verify::verify;
use crate::daemon::{Address, Stop};

use self::absent::absent;
pub use self::error::FollowError;

/// How long a message is waited for before signals are looked for.
const MOMENT: Duration = Duration::from_millis(50);

/// How long the dots and tracks of the last frame are waited for.
const DOTS_LATER: Duration = Duration::from_millis(300);

/// After so long without a stream of the wanted name, the daemon is asked which there are.
const ABSENT: Duration = Duration::from_secs(1);

/// The channel of that question. No subscription comes so far.
const QUESTIONS: u32 = u32::MAX;

/// After so many gaps without a frame between them, the daemon is taken to be wrong.
const GAPS: u32 = 5;

/// Pauses between attempts to connect again, doubled from the first to the last.
const PAUSES: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(5)];

/// How long one such attempt may take. Signals are not looked for during an attempt.
const SHORT: Timeouts = Timeouts { connect: Duration::from_secs(2), greet: Duration::from_secs(2) };

/// After so long without a connection, no further attempt is made.
const PERSEVERANCE: Duration = Duration::from_secs(60);

/// The reason to end once all wanted frames have come.
const ALL_THERE: &str = "all wanted frames are there";

/// Where proved messages go.
pub trait MessageSink {
    /// Writes a message about the stream of that name, which came so long after the first message.
    ///
    /// # Errors
    /// Those of what it writes to.
    fn write(&mut self, name: &str, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()>;

    /// Whether the output says in words what the message reports, so that a log line would only repeat it.
    fn announces(&self, message: &Message) -> bool;

    /// Is called after every message, with the number of frames so far.
    fn progress(&self, frames: u64);
}

/// What is followed, and how far.
#[derive(Clone, Debug)]
pub struct Subscription {
    /// The daemon.
    pub from: Address,
    /// Name or pattern of the streams.
    pub pattern: String,
    /// The part of the skeleton.
    pub view: View,
    /// The part of the persistence diagram.
    pub dots: DotsWanted,
    /// What of tracks.
    pub tracks: TracksWanted,
    /// End after so many frames.
    pub frames: Option<u64>,
    /// Recompute every frame, and stop at a difference or a gap.
    pub check: bool,
    /// Connect again when the connection is lost.
    pub reconnect: bool,
}

impl Subscription {
    /// Whether streams of several names may match.
    pub fn has_many(&self) -> bool {
        self.pattern.contains('*')
    }
}

/// How following ended in good order.
#[derive(Debug)]
pub struct Followed {
    /// So many were handed on.
    pub frames: u64,
    /// For people.
    pub reason: String,
}

/// How a connection ended in good order, and why.
enum Ended {
    /// By this side.
    Done(String),
    /// By the daemon.
    Goodbye(String),
}

/// What is to be done after a message.
enum Then {
    GoOn,
    /// There is a gap, which only a new subscription closes.
    SubscribeAnew,
    /// The daemon has ended the connection, for this reason.
    Goodbye(String),
}

struct Following<'a, S> {
    wanted: &'a Subscription,
    sink: &'a mut S,
    stop: Stop,
    mirrors: Mirrors,
    /// That of the present subscription. Messages on older channels are ignored.
    channel: u32,
    frames: u64,
    /// When to ask which streams there are, if none of the wanted name is.
    asks: Option<Instant>,
    /// Since the last frame that was proved.
    gaps: u32,
    /// When the first message was written.
    begun: Option<Instant>,
    /// When to end, once all wanted frames are there.
    ends: Option<Instant>,
    /// How long there was no connection, until a message comes on a new one.
    lost: Option<Duration>,
    pause: Duration,
}

/// Follows until the daemon or a signal ends it.
///
/// # Errors
/// [`FollowError`].
pub fn follow(wanted: &Subscription, sink: &mut impl MessageSink) -> Result<Followed, FollowError> {
    // Until there is a connection, a signal ends the process: there is nothing to end in good order.
    let client = Client::connect(&wanted.from, SOFTWARE, Timeouts::default())?;
    let stop = Stop::listen().map_err(FollowError::Signals)?;
    follow_until(stop, client, wanted, sink)
}

/// As [`follow`], on a connection that is there, until it is asked to stop.
///
/// # Errors
/// [`FollowError`].
pub fn follow_until(
    stop: Stop,
    client: Client,
    wanted: &Subscription,
    sink: &mut impl MessageSink,
) -> Result<Followed, FollowError> {
    let following = Following {
        wanted,
        sink,
        stop,
        mirrors: Mirrors::default(),
        channel: 0,
        frames: 0,
        asks: None,
        gaps: 0,
        begun: None,
        ends: None,
        lost: None,
        pause: PAUSES[0],
    };
    following.run(client)
}

impl<S: MessageSink> Following<'_, S> {
    fn run(mut self, mut client: Client) -> Result<Followed, FollowError> {
        loop {
            match self.converse(client) {
                Ok(Ended::Done(reason)) => return Ok(self.followed(reason)),
                Ok(Ended::Goodbye(reason)) if !self.wanted.reconnect => return Ok(self.followed(reason)),
                Ok(Ended::Goodbye(_)) => {}
                Err(FollowError::Client(error)) if self.wanted.reconnect => tracing::warn!("{}", Chain(&error)),
                Err(error) => return Err(error),
            }
            match self.reconnect()? {
                Ok(again) => client = again,
                Err(signal) => return Ok(self.followed(signal.to_owned())),
            }
        }
    }

    fn followed(&self, reason: String) -> Followed {
        Followed { frames: self.frames, reason }
    }

    fn converse(&mut self, mut client: Client) -> Result<Ended, FollowError> {
        self.subscribe(&client.sending, self.lost.is_some())?;
        loop {
            if let Some(signal) = self.stop.asked() {
                tracing::info!("{signal}: stopped after {} frames", self.frames);
                client.receiving.goodbye(signal);
                return Ok(Ended::Done(signal.to_owned()));
            }
            if self.ends.is_some_and(|ends| Instant::now() >= ends) {
                client.receiving.goodbye(ALL_THERE);
                return Ok(Ended::Done(ALL_THERE.to_owned()));
            }
            let soon = Instant::now() + MOMENT;
            match client.receiving.receive_until(self.ends.map_or(soon, |ends| ends.min(soon)))? {
                Received::Nothing => self.ask_for_names(&client.sending)?,
                Received::End => {
                    let address = self.wanted.from.clone();
                    return Err(ClientError::Closed { address, when: "without a goodbye" }.into());
                }
                Received::Message(channel, message) => match self.take(channel, &message)? {
                    Then::GoOn => {}
                    Then::SubscribeAnew => {
                        client.sending.send(self.channel, Unsubscribe {})?;
                        self.subscribe(&client.sending, false)?;
                    }
                    Then::Goodbye(reason) => return Ok(Ended::Goodbye(reason)),
                },
            }
        }
    }

    fn subscribe(&mut self, sending: &Sending, resumes: bool) -> Result<(), ClientError> {
        let Subscription { ref pattern, view, dots, tracks, .. } = *self.wanted;
        // 0 is the connection itself.
        self.channel = self.channel.checked_add(1).unwrap_or(1);
        let resume = if resumes && !self.wanted.has_many() { self.mirrors.resume(pattern) } else { None };
        self.asks = Some(Instant::now() + ABSENT);
        sending.send(self.channel, Subscribe { pattern: pattern.clone(), view, dots, resume })?;
        match tracks {
            TracksWanted::No => Ok(()),
            tracks => sending.send(self.channel, WantTracks { tracks }),
        }
    }

    /// Asks once which streams there are, if no wanted one has come for a while.
    fn ask_for_names(&mut self, sending: &Sending) -> Result<(), ClientError> {
        if self.asks.is_none_or(|asks| Instant::now() < asks) {
            return Ok(());
        }
        self.asks = None;
        match sending.send(QUESTIONS, StatusWanted {}) {
            // An older daemon cannot say it.
            Err(ClientError::Older { .. }) => Ok(()),
            asked => asked,
        }
    }

    fn take(&mut self, channel: u32, message: &Message) -> Result<Then, FollowError> {
        match message {
            Message::Status(status) if channel == QUESTIONS => {
                let names: Vec<&str> = status.streams.iter().map(|stream| stream.info.name.as_str()).collect();
                // It may have come meanwhile.
                if self.mirrors.iter().next().is_none() {
                    tracing::info!("{}", absent(&self.wanted.from, &self.wanted.pattern, &names));
                }
                return Ok(Then::GoOn);
            }
            Message::Goodbye(goodbye) => {
                self.part(&goodbye.reason, goodbye.streams.iter().cloned().collect());
                return Ok(Then::Goodbye(format!("the daemon says goodbye: {}", goodbye.reason)));
            }
            // One of several streams is left out: the daemon closes it, and the others go on.
            Message::Error(report) if channel == self.channel && self.leaves_out_one(report) => {
                tracing::warn!("the daemon at {}: {}", self.wanted.from, report.text);
                return Ok(Then::GoOn);
            }
            Message::Error(report) if [0, self.channel].contains(&channel) => return Err(self.refused(report)),
            _ if channel != self.channel => {
                tracing::debug!("a message of type {:#06x} on channel {channel} came too late", message.kind());
                return Ok(Then::GoOn);
            }
            // All that belongs to the last wanted frame comes before the next frame.
            message if message.frame().is_some() && self.ends.is_some() => {
                self.ends = Some(Instant::now());
                return Ok(Then::GoOn);
            }
            _ => {}
        }
        (self.lost, self.pause, self.asks) = (None, PAUSES[0], None);
        match self.mirrors.take(message) {
            Ok(Taken::Frame) => {
                self.gaps = 0;
                self.frame(message)?;
            }
            Ok(Taken::Other) => self.note(message),
            Err(error @ (MirrorsError::Mirror { .. } | MirrorsError::Tracks { .. })) => return self.gap(error),
            Err(source) => return Err(FollowError::Wrong { address: self.wanted.from.clone(), source }),
        }
        self.hand_on(channel, message)?;
        Ok(Then::GoOn)
    }

    fn hand_on(&mut self, channel: u32, message: &Message) -> Result<(), FollowError> {
        let begun = *self.begun.get_or_insert_with(Instant::now);
        let name = self.mirrors.name_of(message);
        self.sink.write(name, begun.elapsed(), channel, message).map_err(FollowError::Write)?;
        self.mirrors.forget_closed(message);
        self.sink.progress(self.frames);
        Ok(())
    }

    fn frame(&mut self, message: &Message) -> Result<(), FollowError> {
        self.frames += 1;
        let (Some(number), Some(frame)) = (message.stream(), message.frame()) else { return Ok(()) };
        if let (true, Some(stream)) = (self.wanted.check, self.mirrors.get(number)) {
            let differs = |source| FollowError::Differs { stream: stream.name.clone(), source };
            verify(&stream.mirror, frame).map_err(differs)?;
        }
        if self.wanted.frames.is_some_and(|wanted| self.frames >= wanted) && self.ends.is_none() {
            let is_all = self.wanted.dots == DotsWanted::No && self.wanted.tracks == TracksWanted::No;
            let later = if is_all { Duration::ZERO } else { DOTS_LATER };
            self.ends = Some(Instant::now() + later);
        }
        Ok(())
    }

    /// Logs what the output does not announce.
    fn note(&mut self, message: &Message) {
        let name = self.mirrors.name_of(message);
        match message {
            announced if self.sink.announces(announced) => {}
            Message::StreamOpened(opened) => tracing::debug!("stream {:?} is at frame {}", opened.name, opened.frame),
            Message::StreamClosed(closed) => tracing::info!("stream {name} has ended after frame {}", closed.frame),
            Message::Resumed(resumed) => tracing::info!("stream {name} goes on after frame {}", resumed.frame),
            Message::Lagged(lagged) => {
                tracing::warn!("stream {name}: frames {} to {} come as one", lagged.first, lagged.last);
            }
            // The last frame's dots are there. Its tracks come only if there are events.
            Message::Dots(_) | Message::SpaceDots(_)
                if self.ends.is_some() && self.wanted.tracks == TracksWanted::No =>
            {
                self.ends = Some(Instant::now());
            }
            _ => {}
        }
    }

    fn gap(&mut self, error: MirrorsError) -> Result<Then, FollowError> {
        self.gaps += 1;
        if self.wanted.check {
            return Err(FollowError::Gap(error));
        }
        if self.gaps > GAPS {
            return Err(FollowError::Gaps { tries: GAPS, source: error });
        }
        tracing::warn!("{}; subscribing again", Chain(&error));
        Ok(Then::SubscribeAnew)
    }

    fn leaves_out_one(&self, report: &Report) -> bool {
        let codes = [ErrorCode::TooManyViews, ErrorCode::NeedsVersion].map(|code| code as u16);
        codes.contains(&report.code) && self.wanted.has_many()
    }

    fn refused(&self, report: &Report) -> FollowError {
        let (address, reason) = (self.wanted.from.clone(), report.text.clone());
        // These end the connection. A later attempt may succeed.
        let ends = [ErrorCode::BadFrame, ErrorCode::TooManyConnections, ErrorCode::TooSlow];
        if ends.map(|code| code as u16).contains(&report.code) {
            ClientError::Rejected { address, reason }.into()
        } else {
            FollowError::Refused { address, reason }
        }
    }

    /// Logs how far each stream has come, here and at the daemon.
    fn part(&self, reason: &str, there: BTreeMap<String, u64>) {
        tracing::info!("the daemon at {} says goodbye: {reason}", self.wanted.from);
        for stream in self.mirrors.iter() {
            let (name, here) = (&stream.name, stream.mirror.number());
            match there.get(name) {
                Some(&last) if last != here => {
                    tracing::warn!("stream {name}: the last frame here is {here}, the daemon's is {last}");
                }
                _ => tracing::info!("stream {name}: the last frame is {here}"),
            }
        }
    }

    /// A new connection; the signal if one comes first.
    fn reconnect(&mut self) -> Result<Result<Client, &'static str>, FollowError> {
        loop {
            tracing::info!("connecting again in {}", humantime::format_duration(self.pause));
            if let Some(signal) = self.stop.wait(self.pause) {
                tracing::info!("{signal}: stopped after {} frames", self.frames);
                return Ok(Err(signal));
            }
            let begun = Instant::now();
            let connected = Client::connect(&self.wanted.from, SOFTWARE, SHORT);
            // A time during which this program was stopped does not count.
            let tried = self.pause + begun.elapsed().min(SHORT.connect + SHORT.greet);
            let lost = *self.lost.insert(self.lost.unwrap_or_default() + tried);
            self.pause = (self.pause * 2).min(PAUSES[1]);
            match connected {
                Ok(client) => return Ok(Ok(client)),
                Err(error @ ClientError::Versions { .. }) => return Err(error.into()),
                Err(error) if lost < PERSEVERANCE => tracing::debug!("{error}"),
                Err(reason) => return Err(FollowError::Unreachable { seconds: PERSEVERANCE.as_secs(), reason }),
            }
        }
    }
}
