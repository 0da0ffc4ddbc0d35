//! The directory of streams: opening them, supervising their engines, announcing them to those who follow.
//!
//! In: requests to open streams; watchers that follow names. Out: [`Stream`]s, each with an engine thread of its own,
//! which sleeps while there is nothing to do.
//!
//! Invariants:
//! * A stream that ends and begins again has another epoch.
//! * An engine that panics ends its own stream only.
//! * There are never more streams than the limits say.
//! * A watcher is called for every stream that matches: for those that are there when it comes, and for each later
//!   one before that stream gets its first point.
//!
//! Must not know: sockets, connections, what engines compute.
//!
//! Locks: the directory's own before the roster's. Neither is held while a watcher or an engine is called.

mod wanted;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crossbeam_channel::{Receiver, Sender, bounded};
use hopes::topology::TrackOptions;
use hopes_protocol as wire;

use super::engine::{Engine, EngineSettings, Standard};
use super::error::EngineError;
use super::queue::{Overload, Queue};
use super::requests::{Request, Requests};
use super::roster::Roster;
use super::stream::{ENDED, Stream};
use super::stream_state::{Accounts, StreamState};
use crate::daemon::locks::{Guard, Level, Lock, before_waiting};
use crate::daemon::log_limits::LogLimits;
use crate::daemon::memory::Memory;
use crate::daemon::settings::{Limits, Settings, StreamSettings};

pub use self::wanted::Wanted;

/// Is called when streams begin and end. The side of the connection implements it.
pub trait StreamWatcher: fmt::Debug + Send + Sync {
    /// Whether it follows streams of this name.
    fn matches(&self, name: &str) -> bool;
    /// A stream is there.
    fn stream_opened(&self, stream: &Arc<Stream>, resume: Option<wire::Resume>);
    /// A stream has ended.
    fn stream_ended(&self, stream: &Arc<Stream>, reason: &str);
}

/// Why a stream cannot be opened.
#[derive(Debug)]
pub struct OpenError {
    /// The protocol's code.
    pub code: wire::ErrorCode,
    /// What was wrong, and what to do.
    pub text: String,
}

/// All streams.
#[derive(Debug)]
pub struct Directory {
    /// Differs each time the daemon is started.
    pub epoch: u64,
    /// The daemon's limits.
    pub limits: Limits,
    /// What is tracked in every stream, if anything.
    pub tracking: Option<TrackOptions>,
    overload: Overload,
    is_checking: bool,
    started: Instant,
    connections: AtomicU64,
    refused_messages: AtomicU64,
    /// What is held for peers and streams.
    pub memory: Arc<Memory>,
    /// Log lines that peers cause.
    pub logs: LogLimits,
    roster: Arc<Roster>,
    state: Lock<State>,
    ended: Sender<EngineEnded>,
}

#[derive(Debug, Default)]
struct State {
    watchers: Vec<Arc<dyn StreamWatcher>>,
    engines: Vec<JoinHandle<()>>,
    opened: u32,
    /// Nothing is opened any more.
    is_closing: bool,
}

/// An engine has ended.
#[derive(Debug)]
pub struct EngineEnded {
    /// Its stream.
    pub stream: Arc<Stream>,
    /// How it ended.
    pub result: Result<(), EngineError>,
}

impl Directory {
    /// A directory without streams. A channel receives each engine that ends.
    pub fn new(settings: &Settings, ended: Sender<EngineEnded>) -> Self {
        let epoch = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_micros() as u64);
        Self {
            epoch,
            limits: settings.limits,
            tracking: settings.tracking,
            overload: settings.overload,
            is_checking: settings.check,
            started: Instant::now(),
            connections: AtomicU64::new(0),
            refused_messages: AtomicU64::new(0),
            memory: Arc::new(Memory::new(settings.limits.memory)),
            logs: LogLimits::default(),
            roster: Arc::default(),
            state: Lock::new(Level::Directory, State::default()),
            ended,
        }
    }

    /// The stream of a name, made if it is not there and the peer may make one; whether it was made.
    ///
    /// # Errors
    /// [`OpenError`]: the name, the options or the number of streams forbid it.
    pub fn open(self: &Arc<Self>, wanted: &Wanted, may_make: bool) -> Result<(Arc<Stream>, bool), OpenError> {
        let options = wanted.options(&self.limits)?;
        let mut state = self.lock();
        match self.roster.get(&wanted.name) {
            // It is about to go: it takes nothing more, and its name is free.
            Some(stream) if stream.queue.is_closed() => self.roster.remove(&stream),
            Some(stream) => {
                wanted.check(options, &stream)?;
                return Ok((stream, false));
            }
            None => {}
        }
        if !may_make {
            let most = self.limits.peer_streams;
            let text = format!("this connection has made {most} streams that are there, and may make no more: end one");
            return Err(OpenError { code: wire::ErrorCode::TooManyStreams, text });
        }
        let settings = StreamSettings { options, ..StreamSettings::default() };
        let stream = self.create(&mut state, &wanted.name, settings, None)?;
        announce(state, &stream);
        Ok((stream, true))
    }

    /// Makes a stream of the daemon's own.
    ///
    /// # Errors
    /// [`OpenError`].
    pub fn make(
        self: &Arc<Self>,
        name: &str,
        settings: StreamSettings,
        standard: Standard,
    ) -> Result<Arc<Stream>, OpenError> {
        let mut state = self.lock();
        if self.roster.get(name).is_some() {
            let text = format!("stream {name:?} is there already: give each a name of its own");
            return Err(OpenError { code: wire::ErrorCode::BadName, text });
        }
        let stream = self.create(&mut state, name, settings, Some(standard))?;
        announce(state, &stream);
        Ok(stream)
    }

    /// Creates a stream: the daemon's own, which has an input and an output, or that of a peer.
    fn create(
        self: &Arc<Self>,
        state: &mut State,
        name: &str,
        settings: StreamSettings,
        standard: Option<Standard>,
    ) -> Result<Arc<Stream>, OpenError> {
        let (is_permanent, standard) = (standard.is_some(), standard.unwrap_or_default());
        let streams = self.roster.len();
        if state.is_closing || streams >= self.limits.streams {
            let text = format!("there are {streams} streams, and no more may be: end one, or allow more");
            return Err(OpenError { code: wire::ErrorCode::TooManyStreams, text });
        }
        state.opened += 1;
        let epoch = self.epoch + u64::from(state.opened);
        let accounts = Accounts::new(&self.memory);
        let (wake, wakes) = bounded(1);
        let queue = Queue::new(self.limits.waiting_points, self.overload, wake.clone(), &accounts.queue);
        let of_stream = StreamState::new(state.opened, name.to_owned(), epoch, settings.options, accounts);
        let stream = Arc::new(Stream::new(of_stream, queue, Requests::new(wake), is_permanent));
        let settings = EngineSettings {
            stream: settings,
            limits: self.limits,
            tracking: self.tracking,
            is_checking: self.is_checking,
            standard,
        };
        let handle = self.start_engine(&stream, settings, wakes)?;
        state.engines.retain(|engine| !engine.is_finished());
        state.engines.push(handle);
        self.roster.insert(&stream);
        tracing::debug!("stream {name:?} opened: {}", wanted::in_words(&stream));
        Ok(stream)
    }

    fn start_engine(
        self: &Arc<Self>,
        stream: &Arc<Stream>,
        settings: EngineSettings,
        wakes: Receiver<()>,
    ) -> Result<JoinHandle<()>, OpenError> {
        let engine =
            Engine::new(Arc::clone(&self.roster), Arc::clone(&self.memory), Arc::clone(stream), wakes, settings)
                .map_err(|error| OpenError { code: wire::ErrorCode::BadOptions, text: error.to_string() })?;
        let (directory, supervised) = (Arc::clone(self), Arc::clone(stream));
        let spawned = thread::Builder::new()
            .name(format!("engine {}", stream.state.number))
            .spawn(move || directory.supervise(&supervised, || engine.run()));
        spawned.map_err(|error| OpenError {
            code: wire::ErrorCode::TooManyStreams,
            text: format!("the system gave no thread for stream {:?}: {error}", stream.state.name),
        })
    }

    /// Runs an engine, and cleans up after it however it ends.
    fn supervise(&self, stream: &Arc<Stream>, run: impl FnOnce() -> Result<(), EngineError>) {
        let result = catch_unwind(AssertUnwindSafe(run)).unwrap_or(Err(EngineError::Panicked));
        stream.set_ended();
        let frame = stream.state.stats.frame();
        // A cursor that has joined too late for the engine is closed here, or by its own side.
        for request in stream.requests.close() {
            if let Request::Cursor(wishes) = request {
                wishes.cursor.close(frame, ENDED);
            }
        }
        self.roster.remove(stream);
        // Watchers close those cursors that the engine has not closed.
        let watchers = self.lock().watchers.clone();
        let reason = result.as_ref().map_or_else(ToString::to_string, |()| ENDED.to_owned());
        watchers.iter().for_each(|watcher| watcher.stream_ended(stream, &reason));
        if let Err(error) = &result {
            tracing::error!("stream {:?} has failed: {error}", stream.state.name);
            stream.take_producers().iter().for_each(|producer| producer.fail(&error.to_string(), frame));
        }
        // What was sent after the end gets no answer. Dropping it ends the wait of its senders.
        while stream.queue.pop().is_some() {}
        // Once the daemon is ending, nobody receives this any more.
        let _ = self.ended.send(EngineEnded { stream: Arc::clone(stream), result });
    }

    /// Adds a watcher. It is called for all streams that it matches, now and later.
    pub fn watch(&self, watcher: Arc<dyn StreamWatcher>, resume: Option<wire::Resume>) {
        let mut state = self.lock();
        let mut streams = self.roster.all();
        streams.retain(|stream| watcher.matches(&stream.state.name));
        state.watchers.push(Arc::clone(&watcher));
        drop(state);
        streams.iter().for_each(|stream| watcher.stream_opened(stream, resume));
    }

    /// Removes a watcher.
    pub fn unwatch<W: StreamWatcher>(&self, watcher: &Arc<W>) {
        self.lock().watchers.retain(|other| !std::ptr::addr_eq(Arc::as_ptr(other), Arc::as_ptr(watcher)));
    }

    /// All streams, by name.
    pub fn streams(&self) -> Vec<Arc<Stream>> {
        self.roster.all()
    }

    /// The stream of a name.
    pub fn stream(&self, name: &str) -> Option<Arc<Stream>> {
        self.roster.get(name)
    }

    /// The daemon's status.
    pub fn status(&self, software: &str) -> wire::Status {
        wire::Status {
            software: software.to_owned(),
            uptime_ms: self.started.elapsed().as_millis() as u64,
            epoch: self.epoch,
            connections: self.connections.load(Ordering::Relaxed) as u32,
            refused_messages: self.refused_messages.load(Ordering::Relaxed),
            memory: self.memory.whole.held(),
            memory_limit: self.limits.memory,
            streams: self.streams().iter().map(|stream| stream.status()).collect(),
        }
    }

    /// Counts a message of a peer that could not be used.
    pub fn count_refused_message(&self) {
        self.refused_messages.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a new connection.
    pub fn add_connection(&self) {
        self.connections.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a connection that has ended.
    pub fn remove_connection(&self) {
        self.connections.fetch_sub(1, Ordering::Relaxed);
    }

    /// Opens nothing more, lets all engines finish what they have been given, and returns the last frame of each
    /// stream. An engine whose output is not read ends at `by`.
    pub fn finish(&self, by: Instant) -> Vec<(String, u64)> {
        let (streams, engines) = {
            let mut state = self.lock();
            state.is_closing = true;
            (self.roster.all(), std::mem::take(&mut state.engines))
        };
        streams.iter().for_each(|stream| stream.finish(by));
        before_waiting("engines");
        for engine in engines {
            // A panic was caught, and logged, inside.
            let _ = engine.join();
        }
        streams.iter().map(|stream| (stream.state.name.clone(), stream.state.stats.frame())).collect()
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
    }

    /// Whether the directory answers within `patience`: its locks are not held for long.
    pub fn answers(&self, patience: Duration) -> bool {
        self.state.lock_within(patience).is_some()
    }
}

/// Announces a new stream to all watchers that match. A watcher that comes from here on finds the stream by itself.
fn announce(state: Guard<'_, State>, stream: &Arc<Stream>) {
    let matches = |watcher: &&Arc<dyn StreamWatcher>| watcher.matches(&stream.state.name);
    let watchers: Vec<Arc<dyn StreamWatcher>> = state.watchers.iter().filter(matches).cloned().collect();
    drop(state);
    watchers.iter().for_each(|watcher| watcher.stream_opened(stream, None));
}
