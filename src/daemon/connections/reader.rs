//! The reader thread of a connection: takes the peer's bytes apart and hands each message on.
//!
//! In: bytes of the socket. Out: items for the queues of streams, subscriptions, replies.
//! Invariants: a message that
//! cannot be used is answered with an error and counted, and the next one is read. Only bytes that are no frames end
//! the connection. A peer that sends nothing, or only part of a frame, for too long is disconnected. Everything that
//! was accepted before the end is answered.
//! Must not know: what engines do.

use std::collections::HashMap;
use std::io::ErrorKind;
use std::net::Shutdown;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hopes_protocol::{self as wire, ErrorCode, Message};

use super::connection::Connection;
use super::outbox::PendingAnswer;
use super::producer::ProducerChannel;
use super::report::report;
use super::subscription::{Pattern, Subscription};
use crate::daemon::locks::lock;
use crate::daemon::settings::SOFTWARE;
use crate::daemon::streams::convert;
use crate::daemon::streams::directory::Directory;
use crate::daemon::streams::input::{Batch, Input};
use crate::daemon::streams::queue::{Closed, Item, Origin};
use crate::daemon::streams::reply::{ReplySink, ReplyTo};
use crate::daemon::streams::stream::Stream;

/// How long a peer may take for its banner and its first message.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// How long a read waits before the reader looks whether it is to stop.
const TICK: Duration = Duration::from_millis(500);

/// Why a connection ends.
enum End {
    /// The peer has sent goodbye or disconnected, or the daemon is ending.
    Polite,
    /// It cannot go on.
    Failed(wire::Report),
    /// The two sides have no version in common, as the banners say.
    Incompatible(wire::NoCommonVersion),
}

/// What a channel is for.
enum Channel {
    Producer(Arc<ProducerChannel>, Arc<Stream>),
    Consumer(Arc<Subscription>),
}

/// Reads until the connection ends.
pub fn run(directory: &Arc<Directory>, connection: &Arc<Connection>) {
    let mut reader = Reader {
        directory,
        connection,
        decoder: wire::Decoder::new(directory.limits.largest_frame),
        channels: HashMap::new(),
        began: Instant::now(),
        is_greeted: false,
        has_banner: false,
    };
    let end = reader.read();
    reader.leave();
    let reason = match end {
        End::Polite => "goodbye".to_owned(),
        End::Failed(report) => {
            tracing::info!("{}: {}", connection.label, report.text);
            directory.count_refused_message();
            let text = report.text.clone();
            connection.send(0, report);
            text
        }
        End::Incompatible(error) => {
            tracing::info!("{}: {error}", connection.label);
            directory.count_refused_message();
            return connection.set_incompatible();
        }
    };
    if !connection.is_ending() {
        connection.say_goodbye(&reason, Vec::new());
    }
    tracing::debug!("{}: ends: {reason}", connection.label);
}

struct Reader<'a> {
    directory: &'a Arc<Directory>,
    connection: &'a Arc<Connection>,
    decoder: wire::Decoder,
    channels: HashMap<u32, Channel>,
    /// When the frame that has not come as a whole began.
    began: Instant,
    has_banner: bool,
    is_greeted: bool,
}

impl Reader<'_> {
    fn read(&mut self) -> End {
        let mut buffer = vec![0; 1 << 16];
        let tick = TICK.min(self.directory.limits.timeout / 4);
        loop {
            let was_within = self.decoder.is_within_frame();
            let read = self.connection.socket.read(&mut buffer, tick);
            if self.connection.socket.has_pending() {
                self.connection.wake_writer();
            }
            match read {
                _ if self.connection.is_ending() => return End::Polite,
                Err(error) if error.kind() == ErrorKind::InvalidData => {
                    return End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
                }
                Err(_) | Ok(Some([])) => return End::Polite,
                Ok(None) => {}
                Ok(Some(bytes)) => {
                    self.connection.note_received();
                    self.decoder.push(bytes);
                    if let Err(end) = self.take_frames() {
                        return end;
                    }
                    // Handing things on may have taken its time, and the peer's frame is not older than its last byte
                    // then.
                    if !was_within || !self.decoder.is_within_frame() {
                        self.began = Instant::now();
                    }
                }
            }
            if let Some(reason) = self.is_too_slow() {
                return End::Failed(report(ErrorCode::TooSlow, 0, reason));
            }
        }
    }

    fn is_too_slow(&self) -> Option<&'static str> {
        let timeout = self.directory.limits.timeout;
        if !self.is_greeted && self.began.elapsed() > HANDSHAKE.min(timeout) {
            return Some("no banner and Hello came in time");
        }
        if self.connection.silence() > timeout {
            return Some("nothing was heard for too long: answer Ping with Pong");
        }
        let is_stuck = self.decoder.is_within_frame() && self.began.elapsed() > timeout;
        is_stuck.then_some("a frame took too long to come")
    }

    fn take_frames(&mut self) -> Result<(), End> {
        let broken = |error: wire::FrameError| End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
        if !self.has_banner {
            let Some(theirs) = self.decoder.banner().map_err(broken)? else { return Ok(()) };
            let version = wire::Banner::OURS.agree(theirs).map_err(End::Incompatible)?;
            self.decoder.set_version(version);
            self.connection.set_version(version);
            self.has_banner = true;
        }
        while let Some(frame) = self.decoder.frame().map_err(broken)? {
            // It counts as unanswered until this is dropped. This may wait, and the peer may be gone afterwards.
            let pending = self.connection.outbox.expect_answer();
            if self.connection.is_cut_off() {
                return Err(End::Polite);
            }
            match frame.message() {
                Ok(Message::Goodbye(_)) => return Err(End::Polite),
                Ok(message) => self.take(frame.channel, frame.kind, message, pending),
                Err(error) => {
                    let code = match error {
                        wire::BodyError::UnknownType { .. } => ErrorCode::Unexpected,
                        _ => ErrorCode::Unreadable,
                    };
                    self.refuse(frame.channel, code, frame.kind, error.to_string());
                }
            }
            self.connection.note_received();
        }
        Ok(())
    }

    fn refuse(&self, channel: u32, code: ErrorCode, answers: u16, text: impl Into<String>) {
        self.directory.count_refused_message();
        let report = report(code, answers, text);
        tracing::debug!("{}: {}", self.connection.label, report.text);
        self.connection.send(channel, report);
    }

    fn take(&mut self, channel: u32, kind: u16, message: Message, pending: PendingAnswer) {
        if let (false, message) = (self.is_greeted, &message) {
            return match message {
                Message::Hello(hello) if channel == 0 => self.welcome(hello),
                _ => {
                    self.refuse(channel, ErrorCode::Unexpected, kind, "the first message has to be Hello, on channel 0")
                }
            };
        }
        let taken = match message {
            Message::Open(_) | Message::Batch(_) | Message::Retract(_) | Message::Commit(_) | Message::Close(_)
                if self.connection.socket.is_read_only() =>
            {
                let text = "read-only: streams are fed at the daemon's sockets, not at its page".to_owned();
                Err((ErrorCode::Unexpected, text))
            }
            Message::Ping(wire::Ping { token }) => {
                self.connection.send(0, wire::Pong { token });
                Ok(())
            }
            Message::Pong(_) => Ok(()),
            Message::ListStreams(wanted) => self.list(channel, &wanted),
            Message::GetStatus(_) => self.status(channel),
            Message::Open(open) => self.open(channel, &open),
            Message::Subscribe(subscribe) => self.subscribe(channel, &subscribe),
            Message::Batch(batch) => self.batch(channel, batch, pending),
            Message::Retract(retract) => self.retract(channel, retract, pending),
            Message::Commit(commit) => self.feed(channel, Input::Commit(commit.time), commit.sequence, Some(pending)),
            Message::Close(close) => self.close(channel, close.end),
            Message::ChangeView(change) => self.change_view(channel, change),
            Message::WantTracks(wanted) => self.want_tracks(channel, wanted.tracks),
            Message::Unsubscribe(_) => self.unsubscribe(channel),
            _ => Err((ErrorCode::Unexpected, "this message is not for a daemon".to_owned())),
        };
        if let Err((code, text)) = taken {
            self.refuse(channel, code, kind, text);
        }
    }

    fn welcome(&mut self, hello: &wire::Hello) {
        tracing::debug!("{}: {:?}", self.connection.label, hello.software);
        self.is_greeted = true;
        let limits = &self.directory.limits;
        self.connection.send(
            0,
            wire::Welcome {
                software: SOFTWARE.to_owned(),
                capabilities: Vec::new(),
                epoch: self.directory.epoch,
                largest_frame: limits.largest_frame,
                largest_batch: limits.largest_batch,
                heartbeat_ms: limits.heartbeat.as_millis() as u32,
                timeout_ms: limits.timeout.as_millis() as u32,
            },
        );
    }

    fn list(&self, channel: u32, wanted: &wire::ListStreams) -> Result<(), Refused> {
        self.check_free(channel)?;
        let pattern = pattern(&wanted.pattern)?;
        let streams = self.directory.streams();
        let streams = streams.iter().filter(|stream| pattern.matches(&stream.state.name)).map(|stream| stream.info());
        self.connection.send(channel, wire::Streams { streams: streams.collect() });
        Ok(())
    }

    fn status(&self, channel: u32) -> Result<(), Refused> {
        self.check_free(channel)?;
        self.connection.send(channel, self.directory.status(SOFTWARE));
        Ok(())
    }

    fn open(&mut self, channel: u32, open: &wire::Open) -> Result<(), Refused> {
        self.check_room(channel)?;
        let producer = Arc::new(ProducerChannel::new(channel, Arc::clone(&self.connection.outbox)));
        let sink: Arc<dyn ReplySink> = Arc::clone(&producer) as _;
        loop {
            let (stream, created) = self.directory.open(open).map_err(|error| (error.code, error.text))?;
            let opened = wire::Opened {
                stream: stream.state.number,
                epoch: stream.state.epoch,
                created,
                window: convert::wire_window(stream.state.options.window),
                resolution: stream.state.options.resolution,
                frame: stream.state.stats.frame(),
                largest_batch: self.directory.limits.largest_batch,
            };
            // A stream that has just ended takes no producer; the next round opens another one.
            if stream.add_producer(&sink, || self.connection.send(channel, opened)) {
                self.channels.insert(channel, Channel::Producer(producer, stream));
                return Ok(());
            }
        }
    }

    fn batch(&mut self, channel: u32, batch: wire::Batch, pending: PendingAnswer) -> Result<(), Refused> {
        let wire::Batch { sequence, points, times, tags } = batch;
        for (what, count) in [("times", times.len()), ("tags", tags.len())] {
            if count != 0 && count != points.len() {
                let text = format!("there are {count} {what} for {} points: give none, or one for each", points.len());
                return Err((ErrorCode::Unreadable, text));
            }
        }
        self.check_size(points.len())?;
        let batch = Batch { positions: points, times, tags, lines: Vec::new() };
        self.feed(channel, Input::Points(batch), sequence, Some(pending))
    }

    fn retract(&mut self, channel: u32, retract: wire::Retract, pending: PendingAnswer) -> Result<(), Refused> {
        self.check_size(retract.points.len())?;
        let batch = Batch { positions: retract.points, ..Batch::default() };
        self.feed(channel, Input::Retract(batch), retract.sequence, Some(pending))
    }

    fn check_size(&self, points: usize) -> Result<(), Refused> {
        let largest = self.directory.limits.largest_batch;
        if points > largest as usize {
            return Err((
                ErrorCode::TooLarge,
                format!("a batch of {points} points, where the largest taken has {largest}"),
            ));
        }
        Ok(())
    }

    /// Hands something on to the stream of a channel; waits while the stream is full.
    fn feed(
        &mut self,
        channel: u32,
        input: Input,
        sequence: u64,
        pending: Option<PendingAnswer>,
    ) -> Result<(), Refused> {
        let Some(Channel::Producer(producer, stream)) = self.channels.get(&channel) else {
            return Err((ErrorCode::NoChannel, format!("channel {channel} feeds no stream: send Open on it first")));
        };
        let sink: Arc<dyn ReplySink> = Arc::clone(producer) as _;
        let reply_to = ReplyTo::new(sink, sequence, pending.map(|pending| Box::new(pending) as _));
        let origin = Origin::Producer(reply_to);
        stream.queue.push(Item { input, origin }).map_err(|Closed| {
            self.channels.remove(&channel);
            (ErrorCode::NoChannel, format!("the stream that channel {channel} fed has ended"))
        })
    }

    fn close(&mut self, channel: u32, end: bool) -> Result<(), Refused> {
        self.feed(channel, Input::Close { end }, 0, None)?;
        self.channels.remove(&channel);
        Ok(())
    }

    fn subscribe(&mut self, channel: u32, subscribe: &wire::Subscribe) -> Result<(), Refused> {
        self.check_room(channel)?;
        let pattern = pattern(&subscribe.pattern)?;
        convert::check_view(subscribe.view).map_err(|text| (ErrorCode::BadOptions, text.to_owned()))?;
        if subscribe.resume.is_some() && !wire::is_name(&subscribe.pattern) {
            return Err((ErrorCode::BadName, "only one stream can be resumed: name it without *".to_owned()));
        }
        let view = wire::ChangeView { view: subscribe.view, dots: subscribe.dots };
        let subscription = Arc::new(Subscription::new(channel, Arc::clone(self.connection), pattern, view));
        self.channels.insert(channel, Channel::Consumer(Arc::clone(&subscription)));
        self.directory.watch(subscription, subscribe.resume);
        Ok(())
    }

    fn change_view(&mut self, channel: u32, change: wire::ChangeView) -> Result<(), Refused> {
        let subscription = self.subscription(channel)?;
        convert::check_view(change.view).map_err(|text| (ErrorCode::BadOptions, text.to_owned()))?;
        subscription.change_view(change);
        Ok(())
    }

    fn want_tracks(&self, channel: u32, tracks: wire::TracksWanted) -> Result<(), Refused> {
        let subscription = self.subscription(channel)?;
        if self.directory.tracking.is_none() && tracks != wire::TracksWanted::No {
            let text = "this daemon follows no tracks: start it with --track".to_owned();
            return Err((ErrorCode::BadOptions, text));
        }
        subscription.want_tracks(tracks);
        Ok(())
    }

    fn unsubscribe(&mut self, channel: u32) -> Result<(), Refused> {
        let subscription = Arc::clone(self.subscription(channel)?);
        self.directory.unwatch(&subscription);
        self.channels.remove(&channel);
        subscription.end();
        self.connection.send(channel, wire::Unsubscribed {});
        Ok(())
    }

    fn subscription(&self, channel: u32) -> Result<&Arc<Subscription>, Refused> {
        match self.channels.get(&channel) {
            Some(Channel::Consumer(subscription)) => Ok(subscription),
            _ => {
                Err((ErrorCode::NoChannel, format!("channel {channel} follows no stream: send Subscribe on it first")))
            }
        }
    }

    fn check_free(&self, channel: u32) -> Result<(), Refused> {
        match (channel, self.channels.contains_key(&channel)) {
            (0, _) => {
                Err((ErrorCode::ChannelInUse, "channel 0 is the connection itself: take another number".to_owned()))
            }
            (_, true) => Err((ErrorCode::ChannelInUse, format!("channel {channel} is in use: take another number"))),
            _ => Ok(()),
        }
    }

    fn check_room(&self, channel: u32) -> Result<(), Refused> {
        self.check_free(channel)?;
        let most = self.directory.limits.channels;
        if self.channels.len() >= most {
            return Err((ErrorCode::TooManyChannels, format!("a connection may have {most} channels: close one")));
        }
        Ok(())
    }

    /// Ends all conversations. What producers have sent is still dealt with.
    fn leave(&mut self) {
        let is_ending = self.connection.is_ending();
        for (_, conversation) in self.channels.drain() {
            match conversation {
                Channel::Consumer(subscription) => {
                    self.directory.unwatch(&subscription);
                    // A daemon that ends still shows consumers what its engines have in hand.
                    if !is_ending {
                        subscription.end();
                    }
                }
                Channel::Producer(channel, _) if is_ending => lock(&self.connection.producers).push(channel),
                Channel::Producer(..) => {}
            }
        }
        if !is_ending {
            let deadline = Instant::now() + self.directory.limits.timeout;
            while !self.connection.outbox.is_all_answered() && Instant::now() < deadline {
                std::thread::sleep(Duration::from_millis(5));
            }
            self.connection.socket.shutdown(Shutdown::Read);
        }
    }
}

/// The protocol's word for what was wrong, and the same for people.
type Refused = (ErrorCode, String);

fn pattern(pattern: &str) -> Result<Pattern, Refused> {
    if wire::is_pattern(pattern) {
        Ok(Pattern::new(pattern))
    } else {
        let text = format!(
            "{pattern:?} is no name or pattern: it has 1 to {} bytes and no control character",
            wire::LONGEST_NAME
        );
        Err((ErrorCode::BadName, text))
    }
}
