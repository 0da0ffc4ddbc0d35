//! Following streams of a daemon: subscribe, prove, show, and subscribe again after a gap.
//!
//! In: a [`Subscription`]. Out: its messages to a [`Show`]. Invariants: what is shown was proved; a gap is never silent: it is logged, and closed by a new snapshot; trying again has bounds in number, pace and time. Must not know: how
//! frames are shown, what is in them.

use std::collections::BTreeMap;
use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use hopes_protocol::{DotsWanted, ErrorCode, Message, Report, Subscribe, TracksWanted, Unsubscribe, View, WantTracks};
use indicatif::{HumanBytes, ProgressBar};

use super::connection::{Client, Received, Sending, Timeouts};
use super::error::ClientError;
use super::mirrors::{StreamError, Streams, Taken};
use super::verify::verify;
use crate::daemon::{Address, Stop};
use crate::formats::messages::Show;

/// Who we are, for the daemon's log.
pub const SOFTWARE: &str = concat!("hopes ", env!("CARGO_PKG_VERSION"));

/// How long a message is waited for before it is seen whether a signal has come.
const MOMENT: Duration = Duration::from_millis(50);

/// How long the dots and tracks of the last frame are waited for.
const DOTS_LATER: Duration = Duration::from_millis(300);

/// So many gaps one after the other, without a frame between them, are no accident.
const GAPS: u32 = 5;

/// Pauses between attempts to connect again, doubled from the first to the last.
const PAUSES: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(5)];

/// How long one such attempt may take, during which no signal is looked for.
const SHORT: Timeouts = Timeouts { connect: Duration::from_secs(2), greet: Duration::from_secs(2) };

/// After so long without a connection nobody tries again.
const PERSEVERANCE: Duration = Duration::from_secs(60);

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

/// How a connection came to its end in good order.
enum Ended {
    /// By us.
    Done,
    /// By the daemon.
    Goodbye,
}

/// What a message leads to.
enum Then {
    GoOn,
    /// What came does not lead on: only a new subscription helps.
    SubscribeAnew,
    Goodbye,
}

struct Following<'a, W> {
    wanted: &'a Subscription,
    show: &'a mut Show<W>,
    progress: &'a ProgressBar,
    stop: Stop,
    streams: Streams,
    /// That of the present subscription; older ones are not listened to any more.
    channel: u32,
    frames: u64,
    /// Since the last frame that was proved.
    gaps: u32,
    /// When the first message was shown.
    begun: Option<Instant>,
    /// When to end, once all wanted frames are there.
    ends: Option<Instant>,
    /// Since when there is no connection that says anything.
    lost: Option<Instant>,
    pause: Duration,
}

/// Follows to the end; says how many frames there were.
pub fn follow<W: Write>(
    wanted: &Subscription,
    show: &mut Show<W>,
    progress: &ProgressBar,
) -> Result<u64, anyhow::Error> {
    // Until there is a connection, there is nothing to end in good order.
    let client = Client::connect(&wanted.from, SOFTWARE, Timeouts::default())?;
    let stop = Stop::listen().context("cannot listen to signals")?;
    follow_until(stop, client, wanted, show, progress)
}

/// As [`follow`], on a connection that is there, until it is asked to stop.
pub fn follow_until<W: Write>(
    stop: Stop,
    client: Client,
    wanted: &Subscription,
    show: &mut Show<W>,
    progress: &ProgressBar,
) -> Result<u64, anyhow::Error> {
    let streams = Streams::default();
    let following = Following {
        wanted,
        show,
        progress,
        stop,
        streams,
        channel: 0,
        frames: 0,
        gaps: 0,
        begun: None,
        ends: None,
        lost: None,
        pause: PAUSES[0],
    };
    following.run(client)
}

impl<W: Write> Following<'_, W> {
    fn run(mut self, mut client: Client) -> anyhow::Result<u64> {
        loop {
            match self.converse(client) {
                Ok(Ended::Done) => return Ok(self.frames),
                Ok(Ended::Goodbye) if !self.wanted.reconnect => return Ok(self.frames),
                Ok(Ended::Goodbye) => {}
                Err(error) if self.wanted.reconnect && error.is::<ClientError>() => tracing::warn!("{error:#}"),
                Err(error) => return Err(error),
            }
            match self.reconnect()? {
                Some(again) => client = again,
                None => return Ok(self.frames),
            }
        }
    }

    fn converse(&mut self, mut client: Client) -> anyhow::Result<Ended> {
        self.subscribe(&client.sending, self.lost.is_some())?;
        loop {
            if let Some(signal) = self.stop.asked() {
                tracing::info!("{signal}: stopped after {} frames", self.frames);
                client.receiving.goodbye(signal);
                return Ok(Ended::Done);
            }
            if self.ends.is_some_and(|ends| Instant::now() >= ends) {
                client.receiving.goodbye("all wanted frames are there");
                return Ok(Ended::Done);
            }
            let soon = Instant::now() + MOMENT;
            match client.receiving.receive_until(self.ends.map_or(soon, |ends| ends.min(soon)))? {
                Received::Nothing => {}
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
                    Then::Goodbye => return Ok(Ended::Goodbye),
                },
            }
        }
    }

    fn subscribe(&mut self, sending: &Sending, resumes: bool) -> Result<(), ClientError> {
        let Subscription { ref pattern, view, dots, tracks, .. } = *self.wanted;
        // 0 is the connection itself.
        self.channel = self.channel.checked_add(1).unwrap_or(1);
        let resume = if resumes && !pattern.contains('*') { self.streams.resume(pattern) } else { None };
        sending.send(self.channel, Subscribe { pattern: pattern.clone(), view, dots, resume })?;
        match tracks {
            TracksWanted::No => Ok(()),
            tracks => sending.send(self.channel, WantTracks { tracks }),
        }
    }

    fn take(&mut self, channel: u32, message: &Message) -> anyhow::Result<Then> {
        match message {
            Message::Goodbye(goodbye) => {
                self.part(&goodbye.reason, goodbye.streams.iter().cloned().collect());
                return Ok(Then::Goodbye);
            }
            Message::Error(report) if [0, self.channel].contains(&channel) => return Err(self.refused(report)),
            _ if channel != self.channel => {
                tracing::debug!("a message of type {:#06x} on channel {channel} came too late", message.kind());
                return Ok(Then::GoOn);
            }
            // What belongs to the last wanted frame comes before the next one.
            Message::Snapshot(_) | Message::Diff(_) if self.ends.is_some() => {
                self.ends = Some(Instant::now());
                return Ok(Then::GoOn);
            }
            _ => {}
        }
        (self.lost, self.pause) = (None, PAUSES[0]);
        match self.streams.take(message) {
            Ok(Taken::Frame) => {
                self.gaps = 0;
                self.frame(message)?;
            }
            Ok(Taken::Other) => self.note(message),
            Err(error @ (StreamError::Mirror { .. } | StreamError::Tracks { .. })) => return self.gap(error),
            Err(error) => return Err(error).context(format!("the daemon at {} is wrong", self.wanted.from)),
        }
        self.present(channel, message)?;
        Ok(Then::GoOn)
    }

    fn present(&mut self, channel: u32, message: &Message) -> anyhow::Result<()> {
        let begun = *self.begun.get_or_insert_with(Instant::now);
        let shown = self.show.message(&self.streams, begun.elapsed(), channel, message);
        shown.context("cannot write frames")?;
        self.streams.forget_closed(message);
        let bytes = HumanBytes(self.show.recorded());
        self.progress.set_message(format!("{} frames, {bytes}", self.frames));
        Ok(())
    }

    fn frame(&mut self, message: &Message) -> anyhow::Result<()> {
        self.frames += 1;
        let (number, frame) = match message {
            Message::Snapshot(snapshot) => (snapshot.stream, &snapshot.frame),
            Message::Diff(diff) => (diff.stream, &diff.frame),
            _ => return Ok(()),
        };
        if let (true, Some(stream)) = (self.wanted.check, self.streams.get(number)) {
            verify(&stream.mirror, frame).with_context(|| format!("stream {}", stream.name))?;
        }
        if self.wanted.frames.is_some_and(|wanted| self.frames >= wanted) && self.ends.is_none() {
            let is_all = self.wanted.dots == DotsWanted::No && self.wanted.tracks == TracksWanted::No;
            let later = if is_all { Duration::ZERO } else { DOTS_LATER };
            self.ends = Some(Instant::now() + later);
        }
        Ok(())
    }

    fn note(&mut self, message: &Message) {
        let name = |number| self.streams.get(number).map_or("", |stream| stream.name.as_str());
        match message {
            told if self.show.tells(told) => {}
            Message::StreamOpened(opened) => tracing::debug!("stream {:?} is at frame {}", opened.name, opened.frame),
            Message::StreamClosed(closed) => {
                tracing::info!("stream {} has ended after frame {}", name(closed.stream), closed.frame);
            }
            Message::Resumed(resumed) => {
                tracing::info!("stream {} goes on after frame {}", name(resumed.stream), resumed.frame);
            }
            Message::Lagged(lagged) => {
                tracing::warn!(
                    "stream {}: frames {} to {} come as one",
                    name(lagged.stream),
                    lagged.first,
                    lagged.last
                );
            }
            // The last frame's dots are there; its tracks come only if something has happened to them.
            Message::Dots(_) if self.ends.is_some() && self.wanted.tracks == TracksWanted::No => {
                self.ends = Some(Instant::now());
            }
            _ => {}
        }
    }

    fn gap(&mut self, error: StreamError) -> anyhow::Result<Then> {
        self.gaps += 1;
        if self.wanted.check {
            return Err(error).context("--check stops here");
        }
        if self.gaps > GAPS {
            return Err(error).context(format!("{GAPS} subscriptions did not help: the daemon is wrong"));
        }
        tracing::warn!("{:#}; subscribing again", anyhow::Error::from(error));
        Ok(Then::SubscribeAnew)
    }

    fn refused(&self, report: &Report) -> anyhow::Error {
        let text = format!("the daemon at {}: {}", self.wanted.from, report.text);
        // These end the connection, and may be over later.
        let ends = [ErrorCode::BadFrame, ErrorCode::TooManyConnections, ErrorCode::TooSlow];
        if ends.map(|code| code as u16).contains(&report.code) {
            ClientError::Rejected { address: self.wanted.from.clone(), reason: report.text.clone() }.into()
        } else {
            anyhow::anyhow!(text)
        }
    }

    /// Says how far each stream has come, here and there.
    fn part(&self, reason: &str, there: BTreeMap<String, u64>) {
        tracing::info!("the daemon at {} says goodbye: {reason}", self.wanted.from);
        for stream in self.streams.iter() {
            let (name, here) = (&stream.name, stream.mirror.number());
            match there.get(name) {
                Some(&last) if last != here => {
                    tracing::warn!("stream {name}: the last frame here is {here}, the daemon's is {last}");
                }
                _ => tracing::info!("stream {name}: the last frame is {here}"),
            }
        }
    }

    /// A new connection; none if a signal comes first.
    fn reconnect(&mut self) -> anyhow::Result<Option<Client>> {
        let lost = *self.lost.get_or_insert_with(Instant::now);
        loop {
            tracing::info!("connecting again in {}", humantime::format_duration(self.pause));
            if let Some(signal) = self.stop.wait(self.pause) {
                tracing::info!("{signal}: stopped after {} frames", self.frames);
                return Ok(None);
            }
            self.pause = (self.pause * 2).min(PAUSES[1]);
            match Client::connect(&self.wanted.from, SOFTWARE, SHORT) {
                Ok(client) => return Ok(Some(client)),
                Err(error @ ClientError::Versions { .. }) => return Err(error.into()),
                Err(error) if lost.elapsed() < PERSEVERANCE => tracing::debug!("{error}"),
                Err(error) => bail!("no connection for {} s: {error}", PERSEVERANCE.as_secs()),
            }
        }
    }
}
