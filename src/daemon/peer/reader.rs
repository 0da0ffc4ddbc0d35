//! The reader thread of a peer: what it sends, taken apart and handed to whom it concerns.
//!
//! In: bytes of the socket. Out: items for streams' inboxes, seats, answers. Invariants: a message that cannot be used is answered with an error and counted, and the next one is
//! read; only bytes that are no frames end the connection; whoever is silent, or half way through something, for too long is cut off; everything that was
//! accepted before the end is answered. Must not know: what engines do.

use std::collections::HashMap;
use std::io::ErrorKind;
use std::net::Shutdown;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::{Debt, Pattern, Peer, ProducerChannel, Subscription, report};
use crate::daemon::convert;
use crate::daemon::inbox::{Batch, Ended, Input, Item, Origin};
use crate::daemon::streams::{Hub, Stream, lock};
use hopes_protocol::{self as wire, ErrorCode, Message};

/// What this daemon calls itself.
pub const SOFTWARE: &str = concat!("hopes ", env!("CARGO_PKG_VERSION"));

/// How long a peer may take for its banner and its first message.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// A reader looks so often whether it is to stop.
const TICK: Duration = Duration::from_millis(500);

/// Why a connection ends.
enum End {
    /// The peer has said goodbye, or hung up, or the daemon is ending.
    Polite,
    /// It cannot go on.
    Failed(wire::Report),
    /// The two have no version in common; the banners have said so.
    Strange(wire::NoCommonVersion),
}

/// What a channel is for.
enum Conversation {
    Producer(Arc<ProducerChannel>, Arc<Stream>),
    Consumer(Arc<Subscription>),
}

/// Reads until the connection ends.
pub fn run(hub: &Arc<Hub>, peer: &Arc<Peer>) {
    let mut reader = Reader {
        hub,
        peer,
        decoder: wire::Decoder::new(hub.limits.largest_frame),
        channels: HashMap::new(),
        began: Instant::now(),
        has_greeted: false,
        has_banner: false,
    };
    let end = reader.read();
    reader.leave();
    let reason = match end {
        End::Polite => "goodbye".to_owned(),
        End::Failed(report) => {
            tracing::info!("{}: {}", peer.label, report.text);
            hub.count_refused_message();
            let text = report.text.clone();
            peer.say(0, report);
            text
        }
        End::Strange(error) => {
            tracing::info!("{}: {error}", peer.label);
            hub.count_refused_message();
            return peer.hang_up();
        }
    };
    if !peer.is_ending.load(Ordering::Acquire) {
        peer.say_goodbye(&reason, Vec::new());
    }
    tracing::debug!("{}: ends: {reason}", peer.label);
}

struct Reader<'a> {
    hub: &'a Arc<Hub>,
    peer: &'a Arc<Peer>,
    decoder: wire::Decoder,
    channels: HashMap<u32, Conversation>,
    /// When the frame that has not come as a whole began.
    began: Instant,
    has_banner: bool,
    has_greeted: bool,
}

impl Reader<'_> {
    fn read(&mut self) -> End {
        let mut buffer = vec![0; 1 << 16];
        let tick = TICK.min(self.hub.limits.timeout / 4);
        loop {
            let was_within = self.decoder.is_within_frame();
            let read = self.peer.socket.read(&mut buffer, tick);
            if self.peer.socket.has_to_say() {
                self.peer.ring_bell();
            }
            match read {
                _ if self.peer.is_ending.load(Ordering::Acquire) => return End::Polite,
                Err(error) if error.kind() == ErrorKind::InvalidData => {
                    return End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
                }
                Err(_) | Ok(Some([])) => return End::Polite,
                Ok(None) => {}
                Ok(Some(bytes)) => {
                    self.peer.is_heard();
                    self.decoder.push(bytes);
                    if let Err(end) = self.take_frames() {
                        return end;
                    }
                    // Handing things on may have taken its time, and the peer's frame is not older than its last byte then.
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
        let timeout = self.hub.limits.timeout;
        if !self.has_greeted && self.began.elapsed() > HANDSHAKE.min(timeout) {
            return Some("no banner and Hello came in time");
        }
        if self.peer.silence() > timeout {
            return Some("nothing was heard for too long: answer Ping with Pong");
        }
        let is_stuck = self.decoder.is_within_frame() && self.began.elapsed() > timeout;
        is_stuck.then_some("a frame took too long to come")
    }

    fn take_frames(&mut self) -> Result<(), End> {
        let broken = |error: wire::FrameError| End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
        if !self.has_banner {
            let Some(theirs) = self.decoder.banner().map_err(broken)? else { return Ok(()) };
            let version = wire::Banner::OURS.agree(theirs).map_err(End::Strange)?;
            self.decoder.set_version(version);
            self.peer.set_version(version);
            self.has_banner = true;
        }
        while let Some(frame) = self.decoder.frame().map_err(broken)? {
            // From here on until it is answered. A peer that hears nothing any more has meant what it has said.
            let debt = self.peer.outbox.owe();
            if self.peer.is_cut_off.load(Ordering::Acquire) {
                return Err(End::Polite);
            }
            match frame.message() {
                Ok(Message::Goodbye(_)) => return Err(End::Polite),
                Ok(message) => self.take(frame.channel, frame.kind, message, debt),
                Err(error) => {
                    let code = match error {
                        wire::BodyError::UnknownType { .. } => ErrorCode::Unexpected,
                        _ => ErrorCode::Unreadable,
                    };
                    self.refuse(frame.channel, code, frame.kind, error.to_string());
                }
            }
            self.peer.is_heard();
        }
        Ok(())
    }

    fn refuse(&self, channel: u32, code: ErrorCode, answers: u16, text: impl Into<String>) {
        self.hub.count_refused_message();
        let report = report(code, answers, text);
        tracing::debug!("{}: {}", self.peer.label, report.text);
        self.peer.say(channel, report);
    }

    fn take(&mut self, channel: u32, kind: u16, message: Message, debt: Debt) {
        if let (false, message) = (self.has_greeted, &message) {
            return match message {
                Message::Hello(hello) if channel == 0 => self.welcome(hello),
                _ => {
                    self.refuse(channel, ErrorCode::Unexpected, kind, "the first message has to be Hello, on channel 0")
                }
            };
        }
        let taken = match message {
            Message::Open(_) | Message::Batch(_) | Message::Retract(_) | Message::Commit(_) | Message::Close(_)
                if self.peer.socket.is_for_readers() =>
            {
                let text = "read-only: streams are fed at the daemon's sockets, not at its page".to_owned();
                Err((ErrorCode::Unexpected, text))
            }
            Message::Ping(wire::Ping { token }) => {
                self.peer.say(0, wire::Pong { token });
                Ok(())
            }
            Message::Pong(_) => Ok(()),
            Message::ListStreams(wanted) => self.list(channel, &wanted),
            Message::GetStatus(_) => self.status(channel),
            Message::Open(open) => self.open(channel, &open),
            Message::Subscribe(subscribe) => self.subscribe(channel, &subscribe),
            Message::Batch(batch) => self.batch(channel, batch, debt),
            Message::Retract(retract) => self.retract(channel, retract, debt),
            Message::Commit(commit) => self.feed(channel, Input::Commit(commit.time), commit.sequence, Some(debt)),
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
        tracing::debug!("{}: {:?}", self.peer.label, hello.software);
        self.has_greeted = true;
        let limits = &self.hub.limits;
        self.peer.say(
            0,
            wire::Welcome {
                software: SOFTWARE.to_owned(),
                capabilities: Vec::new(),
                epoch: self.hub.epoch,
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
        let streams = self.hub.streams();
        let streams = streams.iter().filter(|stream| pattern.matches(&stream.name)).map(|stream| stream.info());
        self.peer.say(channel, wire::Streams { streams: streams.collect() });
        Ok(())
    }

    fn status(&self, channel: u32) -> Result<(), Refused> {
        self.check_free(channel)?;
        self.peer.say(channel, self.hub.status(SOFTWARE));
        Ok(())
    }

    fn open(&mut self, channel: u32, open: &wire::Open) -> Result<(), Refused> {
        self.check_room(channel)?;
        let producer = Arc::new(ProducerChannel::new(channel, Arc::clone(&self.peer.outbox)));
        loop {
            let (stream, created) = self.hub.open(open).map_err(|error| (error.code, error.text))?;
            let opened = wire::Opened {
                stream: stream.number,
                epoch: stream.epoch,
                created,
                window: convert::wire_window(stream.options.window),
                resolution: stream.options.resolution,
                frame: stream.stats.frame(),
                largest_batch: self.hub.limits.largest_batch,
            };
            // Where it has just ended, another one is opened.
            if stream.admit(&producer, || self.peer.say(channel, opened)) {
                self.channels.insert(channel, Conversation::Producer(producer, stream));
                return Ok(());
            }
        }
    }

    fn batch(&mut self, channel: u32, batch: wire::Batch, debt: Debt) -> Result<(), Refused> {
        let wire::Batch { sequence, points, times, tags } = batch;
        for (what, count) in [("times", times.len()), ("tags", tags.len())] {
            if count != 0 && count != points.len() {
                let text = format!("there are {count} {what} for {} points: give none, or one for each", points.len());
                return Err((ErrorCode::Unreadable, text));
            }
        }
        self.check_size(points.len())?;
        let batch = Batch { positions: points, times, tags, lines: Vec::new() };
        self.feed(channel, Input::Points(batch), sequence, Some(debt))
    }

    fn retract(&mut self, channel: u32, retract: wire::Retract, debt: Debt) -> Result<(), Refused> {
        self.check_size(retract.points.len())?;
        let batch = Batch { positions: retract.points, ..Batch::default() };
        self.feed(channel, Input::Retract(batch), retract.sequence, Some(debt))
    }

    fn check_size(&self, points: usize) -> Result<(), Refused> {
        let largest = self.hub.limits.largest_batch;
        if points > largest as usize {
            return Err((
                ErrorCode::TooLarge,
                format!("a batch of {points} points, where the largest taken has {largest}"),
            ));
        }
        Ok(())
    }

    /// Hands something on to the stream of a channel; waits while the stream is full.
    fn feed(&mut self, channel: u32, input: Input, sequence: u64, debt: Option<Debt>) -> Result<(), Refused> {
        let Some(Conversation::Producer(producer, stream)) = self.channels.get(&channel) else {
            return Err((ErrorCode::NoChannel, format!("channel {channel} feeds no stream: send Open on it first")));
        };
        let origin = Origin::Peer { channel: Arc::clone(producer), sequence, debt };
        stream.inbox.push(Item { input, origin }).map_err(|Ended| {
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
        let look = wire::ChangeView { view: subscribe.view, dots: subscribe.dots };
        let (peer, look, tracks) = (Arc::clone(self.peer), Mutex::new(look), Mutex::default());
        let is_over = AtomicBool::new(false);
        let subscription = Arc::new(Subscription { channel, peer, pattern, look, tracks, is_over });
        self.channels.insert(channel, Conversation::Consumer(Arc::clone(&subscription)));
        self.hub.subscribe(subscription, subscribe.resume);
        Ok(())
    }

    fn change_view(&mut self, channel: u32, change: wire::ChangeView) -> Result<(), Refused> {
        let subscription = self.subscription(channel)?;
        convert::check_view(change.view).map_err(|text| (ErrorCode::BadOptions, text.to_owned()))?;
        subscription.change(change);
        Ok(())
    }

    fn want_tracks(&self, channel: u32, tracks: wire::TracksWanted) -> Result<(), Refused> {
        let subscription = self.subscription(channel)?;
        if self.hub.tracking.is_none() && tracks != wire::TracksWanted::No {
            let text = "this daemon follows no tracks: start it with --track".to_owned();
            return Err((ErrorCode::BadOptions, text));
        }
        subscription.want_tracks(tracks);
        Ok(())
    }

    fn unsubscribe(&mut self, channel: u32) -> Result<(), Refused> {
        let subscription = Arc::clone(self.subscription(channel)?);
        self.hub.unsubscribe(&subscription);
        self.channels.remove(&channel);
        subscription.end();
        self.peer.say(channel, wire::Unsubscribed {});
        Ok(())
    }

    fn subscription(&self, channel: u32) -> Result<&Arc<Subscription>, Refused> {
        match self.channels.get(&channel) {
            Some(Conversation::Consumer(subscription)) => Ok(subscription),
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
        let most = self.hub.limits.channels;
        if self.channels.len() >= most {
            return Err((ErrorCode::TooManyChannels, format!("a connection may have {most} channels: close one")));
        }
        Ok(())
    }

    /// Ends all conversations. What producers have sent is still dealt with.
    fn leave(&mut self) {
        let is_ending = self.peer.is_ending.load(Ordering::Acquire);
        for (_, conversation) in self.channels.drain() {
            match conversation {
                Conversation::Consumer(subscription) => {
                    self.hub.unsubscribe(&subscription);
                    // A daemon that ends still shows consumers what its engines have in hand.
                    if !is_ending {
                        subscription.end();
                    }
                }
                Conversation::Producer(channel, _) if is_ending => lock(&self.peer.feeds).push(channel),
                Conversation::Producer(..) => {}
            }
        }
        if !is_ending {
            let deadline = Instant::now() + self.hub.limits.timeout;
            while !self.peer.outbox.is_even() && Instant::now() < deadline {
                std::thread::sleep(Duration::from_millis(5));
            }
            self.peer.socket.shutdown(Shutdown::Read);
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
