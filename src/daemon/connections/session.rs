//! The conversations of a peer: what each of its messages does.
//!
//! In: messages of a peer. Out: items for the queues of streams, subscriptions, replies.
//!
//! Invariants: a message that cannot be used is answered with an error and counted, and the next one is read.
//! Everything that was accepted before the end is answered.
//!
//! Must not know: bytes, what engines do.

mod feeding;

use std::collections::HashMap;
use std::net::Shutdown;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use hopes_protocol::{self as wire, ErrorCode, Message};

use super::administration::{self, Refused};
use super::connection::Connection;
use super::members::Members;
use super::outbox::PendingAnswer;
use super::producer::ProducerChannel;
use super::subscription::{self, Pattern, Subscription};
use crate::daemon::locks::before_waiting;
use crate::daemon::report::report;
use crate::daemon::settings::SOFTWARE;
use crate::daemon::streams::convert;
use crate::daemon::streams::directory::{Directory, Wanted};
use crate::daemon::streams::input::Input;
use crate::daemon::streams::queue::{Item, Origin};
use crate::daemon::streams::reply::ReplyTo;
use crate::daemon::streams::stream::Stream;

/// What a channel is for.
enum Channel {
    Producer(Arc<ProducerChannel>, Arc<Stream>),
    Consumer(Arc<Subscription>),
}

/// The conversations of a peer.
pub struct Session<'a> {
    directory: &'a Arc<Directory>,
    members: &'a Arc<Members>,
    connection: &'a Arc<Connection>,
    channels: HashMap<u32, Channel>,
    /// Streams that the peer has made.
    made: Vec<Weak<Stream>>,
    is_greeted: bool,
    /// The peer wants more than the connection that is reserved for administration is for.
    has_no_place: bool,
}

impl<'a> Session<'a> {
    /// A peer that has said nothing.
    pub fn new(directory: &'a Arc<Directory>, members: &'a Arc<Members>, connection: &'a Arc<Connection>) -> Self {
        let (channels, made) = (HashMap::new(), Vec::new());
        Self { directory, members, connection, channels, made, is_greeted: false, has_no_place: false }
    }

    /// Whether the peer has said hello.
    pub fn is_greeted(&self) -> bool {
        self.is_greeted
    }

    /// Whether the peer wants more than its connection is for: all others are taken.
    pub fn has_no_place(&self) -> bool {
        self.has_no_place
    }

    /// Answers that a message could not be used.
    pub fn refuse(&self, channel: u32, code: ErrorCode, answers: u16, text: impl Into<String>) {
        self.directory.count_refused_message();
        let report = report(code, answers, text);
        tracing::debug!("{}: {}", self.connection.label, report.text);
        self.connection.send(channel, report);
    }

    /// Takes a message of a channel. `pending` counts it as unanswered until it is dropped.
    pub fn take(&mut self, channel: u32, kind: u16, message: Message, pending: PendingAnswer) {
        if let (false, message) = (self.is_greeted, &message) {
            return match message {
                Message::Hello(hello) if channel == 0 => self.welcome(hello),
                _ => {
                    self.refuse(channel, ErrorCode::Unexpected, kind, "the first message has to be Hello, on channel 0")
                }
            };
        }
        let taken = match message {
            Message::Open(_)
            | Message::OpenSpace(_)
            | Message::Batch(_)
            | Message::Retract(_)
            | Message::SpaceBatch(_)
            | Message::SpaceRetract(_)
            | Message::Commit(_)
            | Message::Close(_)
            | Message::StopStream(_)
            | Message::Disconnect(_)
                if self.connection.socket.is_read_only() =>
            {
                let text = "read-only: streams are fed at the daemon's sockets, not at its page".to_owned();
                Err((ErrorCode::Unexpected, text))
            }
            Message::Open(_) | Message::OpenSpace(_) | Message::Subscribe(_) if self.connection.is_reserved => {
                self.has_no_place = true;
                return;
            }
            Message::Ping(wire::Ping { token }) => {
                self.connection.send(0, wire::Pong { token });
                Ok(())
            }
            Message::Pong(_) => Ok(()),
            Message::ListStreams(wanted) => self.list(channel, &wanted),
            Message::ListSpaces(_) => self.list_spaces(channel),
            Message::GetStatus(_)
            | Message::ListPeers(_)
            | Message::GetMemory(_)
            | Message::StopStream(_)
            | Message::Disconnect(_) => self.administer(channel, &message),
            Message::Open(open) => self.open(channel, &Wanted::from(&open)),
            Message::OpenSpace(open) => self.open(channel, &Wanted::from(&open)),
            Message::Subscribe(subscribe) => self.subscribe(channel, &subscribe),
            Message::Batch(batch) => self.batch(channel, batch, pending),
            Message::Retract(retract) => self.retract(channel, retract, pending),
            Message::SpaceBatch(batch) => self.space_batch(channel, batch, pending),
            Message::SpaceRetract(retract) => self.space_retract(channel, retract, pending),
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
        hello.software.clone_into(&mut self.connection.counts.software.lock());
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

    fn list_spaces(&self, channel: u32) -> Result<(), Refused> {
        self.check_free(channel)?;
        let streams = self.directory.streams();
        let mut streams: Vec<_> = streams.iter().filter_map(|stream| stream.state.space_info()).collect();
        streams.sort_unstable_by_key(|info| info.stream);
        self.connection.send(channel, wire::Spaces { streams });
        Ok(())
    }

    /// Answers a request of administration.
    fn administer(&self, channel: u32, request: &Message) -> Result<(), Refused> {
        self.check_free(channel)?;
        let own = self.connection.consumer.peer;
        if matches!(request, Message::Disconnect(disconnect) if disconnect.peer == own) {
            self.connection.send(channel, wire::Disconnected { peer: own });
            self.connection.say_goodbye("the peer has asked for it", Vec::new());
            return Ok(());
        }
        let answer = administration::answer(self.directory, self.members, request)?;
        self.connection.send(channel, answer);
        Ok(())
    }

    fn subscribe(&mut self, channel: u32, subscribe: &wire::Subscribe) -> Result<(), Refused> {
        self.check_room(channel)?;
        let pattern = pattern(&subscribe.pattern)?;
        convert::check_view(subscribe.view).map_err(|text| (ErrorCode::BadOptions, text.to_owned()))?;
        if subscribe.resume.is_some() && !wire::is_name(&subscribe.pattern) {
            return Err((ErrorCode::BadName, "only one stream can be resumed: name it without *".to_owned()));
        }
        self.check_views(channel, subscribe.view)?;
        self.check_version(&subscribe.pattern)?;
        if self.directory.memory.is_short() {
            let text = "the daemon is at its limit of memory, and takes no new reader: come back later, or allow more";
            return Err((ErrorCode::NoMemory, text.to_owned()));
        }
        let view = wire::ChangeView { view: subscribe.view, dots: subscribe.dots };
        let subscription = Arc::new(Subscription::new(channel, Arc::clone(self.connection), pattern, view));
        self.set_channel(channel, Channel::Consumer(Arc::clone(&subscription)));
        self.directory.watch(subscription, subscribe.resume);
        Ok(())
    }

    /// Whether the peer would understand the frames of the stream of that name, if there is one.
    fn check_version(&self, name: &str) -> Result<(), Refused> {
        let stream = self.directory.stream(name).filter(|_| wire::is_name(name));
        let too_new = stream.and_then(|stream| subscription::too_new(&stream.state, self.connection.version()));
        too_new.map_or(Ok(()), |text| Err((ErrorCode::NeedsVersion, text)))
    }

    fn change_view(&mut self, channel: u32, change: wire::ChangeView) -> Result<(), Refused> {
        let subscription = Arc::clone(self.subscription(channel)?);
        convert::check_view(change.view).map_err(|text| (ErrorCode::BadOptions, text.to_owned()))?;
        self.check_views(channel, change.view)?;
        subscription.change_view(change);
        Ok(())
    }

    /// Whether the peer may follow a view on a channel besides those on its other channels.
    fn check_views(&self, channel: u32, view: wire::View) -> Result<(), Refused> {
        let mut views = vec![view];
        for (other, conversation) in &self.channels {
            if let Channel::Consumer(subscription) = conversation
                && *other != channel
                && !views.contains(&subscription.view())
            {
                views.push(subscription.view());
            }
        }
        let most = self.directory.limits.peer_views.get();
        if views.len() > most {
            let text = format!("a connection may follow {most} different views: take one that it follows already");
            return Err((ErrorCode::TooManyViews, text));
        }
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
        self.end_channel(channel);
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

    fn set_channel(&mut self, channel: u32, conversation: Channel) {
        self.channels.insert(channel, conversation);
        self.count_channels();
    }

    fn end_channel(&mut self, channel: u32) {
        self.channels.remove(&channel);
        self.count_channels();
    }

    fn count_channels(&self) {
        let counts = &self.connection.counts;
        let producers = self.channels.values().filter(|other| matches!(other, Channel::Producer(..))).count();
        counts.producers.store(producers as u64, Ordering::Relaxed);
        counts.consumers.store((self.channels.len() - producers) as u64, Ordering::Relaxed);
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
    pub fn leave(&mut self) {
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
                Channel::Producer(channel, _) if is_ending => self.connection.producers.lock().push(channel),
                Channel::Producer(channel, stream) => {
                    let reply_to = ReplyTo::new(channel, 0, None);
                    // A stream that has ended has nothing to leave out.
                    let _ = stream.queue.push(Item { input: Input::Abandon, origin: Origin::Producer(reply_to) });
                }
            }
        }
        if !is_ending {
            let deadline = Instant::now() + self.directory.limits.timeout;
            while !self.connection.outbox.is_all_answered() && Instant::now() < deadline {
                before_waiting("answers");
                std::thread::sleep(Duration::from_millis(5));
            }
            self.connection.socket.shutdown(Shutdown::Read);
        }
    }
}

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
