//! The streams of a daemon, by name, and who wants to know of new ones.
//!
//! In: requests of peers to open, to follow and to list streams. Out: [`Stream`]s, each with an engine thread of its own that sleeps while there is nothing to do. Invariants: a name is one
//! stream at a time, and a stream that ends and begins again has another epoch; an engine that panics takes nobody along: its stream ends, the others
//! go on; there are never more streams, nor is more memory taken, than the limits say. Must not know: sockets, what engines compute.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crossbeam_channel::{Receiver, Sender, bounded};
use hopes::topology::{Options, TrackOptions};
use hopes_protocol as wire;

use super::board::Board;
use super::convert;
use super::engine::{Engine, Sources};
use super::frame_times::FrameTimes;
use super::inbox::{Inbox, Overload};
use super::peer::{ProducerChannel, Subscription};
use super::seat::{Control, Seat};
use super::{DaemonError, Limits, Settings, StreamSettings};

/// What consumers of a stream are told at its end.
pub const ENDED: &str = "the stream has ended";

/// What seats may ask of an engine before they have to wait.
const REQUESTS: usize = 1024;

/// A stream, as everybody sees it.
#[derive(Debug)]
pub struct Stream {
    /// As long as the daemon runs.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// Differs between streams of one name.
    pub epoch: u64,
    /// Which points stay.
    pub options: Options,
    /// What waits for the engine.
    pub inbox: Inbox,
    /// What it shows.
    pub board: Board,
    /// What is counted.
    pub stats: Stats,
    /// Who feeds it.
    pub producers: Mutex<Vec<Weak<ProducerChannel>>>,
    has_ended: AtomicBool,
    /// What seats ask; whoever asks when the engine is far behind has to wait, so nobody may hold a lock then that the engine takes.
    control: Sender<Control>,
}

impl Stream {
    /// Takes on somebody who feeds it, and welcomes them before anything else can be said to them; false once it takes nothing more.
    pub fn admit(&self, producer: &Arc<ProducerChannel>, welcome: impl FnOnce()) -> bool {
        let mut producers = lock(&self.producers);
        // Those who are on this list when the inbox is closed are told of the end.
        let is_open = !self.inbox.is_closed();
        if is_open {
            producers.retain(|other| other.strong_count() > 0);
            producers.push(Arc::downgrade(producer));
            welcome();
        }
        is_open
    }

    /// Asks the engine for something. An engine that has ended says so by itself.
    pub fn ask(&self, control: Control) {
        let _ = self.control.send(control);
    }

    /// Asks the engine for a place.
    pub fn join(&self, seat: &Arc<Seat>, view: wire::View, resume: Option<wire::Resume>) {
        self.ask(Control::Join(Arc::clone(seat), view, resume));
        if self.has_ended.load(Ordering::SeqCst) {
            seat.close(self.stats.frame(), ENDED);
        }
    }

    /// The newest frame as a whole, as soon as the engine comes to it; none, if there is none or that takes too long.
    pub fn snapshot_once(&self, view: wire::View, patience: Duration) -> Option<Arc<wire::Snapshot>> {
        let (answer, snapshot) = bounded(1);
        // An engine that ends lets go of the other end, and nobody waits.
        self.try_ask(Control::SnapshotOnce(view, answer)).then(|| snapshot.recv_timeout(patience).ok()).flatten()
    }

    /// Asks the engine for something, unless that would take waiting; whether it was asked.
    pub fn try_ask(&self, control: Control) -> bool {
        self.control.try_send(control).is_ok()
    }

    /// What it is.
    pub fn info(&self) -> wire::StreamInfo {
        let stats = &self.stats;
        let producers = lock(&self.producers).iter().filter(|channel| channel.strong_count() > 0).count();
        wire::StreamInfo {
            stream: self.number,
            name: self.name.clone(),
            epoch: self.epoch,
            window: convert::wire_window(self.options.window),
            resolution: self.options.resolution,
            frame: stats.frame(),
            points: stats.points.load(Ordering::Relaxed),
            vertices: stats.vertices.load(Ordering::Relaxed),
            producers: producers as u32,
            consumers: stats.consumers.load(Ordering::Relaxed) as u32,
        }
    }

    /// How it is.
    pub fn status(&self) -> wire::StreamStatus {
        let stats = &self.stats;
        wire::StreamStatus {
            info: self.info(),
            computed: stats.computed.load(Ordering::Relaxed),
            accepted: stats.accepted.load(Ordering::Relaxed),
            refused: stats.refused.load(Ordering::Relaxed),
            dropped: self.inbox.dropped(),
            waiting: self.inbox.waiting() as u64,
            lagged: stats.lagged.load(Ordering::Relaxed),
            memory: stats.memory.load(Ordering::Relaxed),
        }
    }
}

/// What is counted of a stream.
#[derive(Debug, Default)]
pub struct Stats {
    frame: AtomicU64,
    /// Points in the window.
    pub points: AtomicU64,
    /// Distinct positions.
    pub vertices: AtomicU64,
    /// Seats.
    pub consumers: AtomicU64,
    /// Skeletons computed.
    pub computed: AtomicU64,
    /// Points accepted.
    pub accepted: AtomicU64,
    /// Points refused.
    pub refused: AtomicU64,
    lagged: AtomicU64,
    /// Estimate of bytes held.
    pub memory: AtomicU64,
    /// How long frames take.
    pub times: FrameTimes,
}

impl Stats {
    /// The newest frame.
    pub fn frame(&self) -> u64 {
        self.frame.load(Ordering::Acquire)
    }

    /// Another frame was closed.
    pub fn set_frame(&self, frame: u64) {
        self.frame.store(frame, Ordering::Release);
    }

    /// So many frames were not sent singly to somebody.
    pub fn add_lagged(&self, frames: u64) {
        self.lagged.fetch_add(frames, Ordering::Relaxed);
    }
}

/// Why a stream cannot be opened.
#[derive(Debug)]
pub struct OpenError {
    /// The protocol's word for it.
    pub code: wire::ErrorCode,
    /// What was wrong, and what to do.
    pub text: String,
}

/// All streams.
#[derive(Debug)]
pub struct Hub {
    /// Differs each time the daemon is started.
    pub epoch: u64,
    /// How much of everything there may be.
    pub limits: Limits,
    /// What is tracked in every stream, if anything.
    pub tracking: Option<TrackOptions>,
    overload: Overload,
    is_checking: bool,
    started: Instant,
    connections: AtomicU64,
    refused_messages: AtomicU64,
    state: Mutex<State>,
    ended: Sender<Ended>,
}

#[derive(Debug, Default)]
struct State {
    streams: BTreeMap<String, Arc<Stream>>,
    subscriptions: Vec<Arc<Subscription>>,
    engines: Vec<JoinHandle<()>>,
    opened: u32,
    /// Nothing is opened any more.
    is_closing: bool,
}

/// An engine has ended.
#[derive(Debug)]
pub struct Ended {
    /// Whose.
    pub stream: Arc<Stream>,
    /// How.
    pub result: Result<(), DaemonError>,
}

impl Hub {
    /// No streams yet. Each engine that ends is told of on a channel.
    pub fn new(settings: &Settings, ended: Sender<Ended>) -> Self {
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
            state: Mutex::default(),
            ended,
        }
    }

    /// The stream of a name, made if it is not there; the latter is said.
    ///
    /// # Errors
    /// [`OpenError`]: the name, the options or the number of streams forbid it.
    pub fn open(self: &Arc<Self>, open: &wire::Open) -> Result<(Arc<Stream>, bool), OpenError> {
        let refuse = |code, text: String| OpenError { code, text };
        if !wire::is_name(&open.name) {
            let text = format!(
                "{:?} is no name: it has 1 to {} bytes, no control character and no *",
                open.name,
                wire::LONGEST_NAME
            );
            return Err(refuse(wire::ErrorCode::BadName, text));
        }
        let options = convert::options(open.window, open.resolution)
            .map_err(|text| refuse(wire::ErrorCode::BadOptions, text.to_owned()))?;
        let mut state = self.lock();
        if state.streams.get(&open.name).is_some_and(|stream| stream.inbox.is_closed()) {
            // It is about to go: nobody can feed it any more, and its name is free.
            state.streams.remove(&open.name);
        }
        if let Some(stream) = state.streams.get(&open.name) {
            let is_other = open.window.is_some() && options.window != stream.options.window
                || open.resolution.is_some() && options.resolution != stream.options.resolution;
            if is_other {
                let text = format!("stream {:?} has {:?}: open it so, or without options", open.name, stream.options);
                return Err(refuse(wire::ErrorCode::OtherOptions, text));
            }
            return Ok((Arc::clone(stream), false));
        }
        let settings = StreamSettings { options, ..StreamSettings::default() };
        let stream = self.create(&mut state, &open.name, settings, Sources::default())?;
        seat_all(state, &stream);
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
        sources: Sources,
    ) -> Result<Arc<Stream>, OpenError> {
        let mut state = self.lock();
        if state.streams.contains_key(name) {
            let text = format!("stream {name:?} is there already: give each a name of its own");
            return Err(OpenError { code: wire::ErrorCode::BadName, text });
        }
        let stream = self.create(&mut state, name, settings, sources)?;
        seat_all(state, &stream);
        Ok(stream)
    }

    fn create(
        self: &Arc<Self>,
        state: &mut State,
        name: &str,
        settings: StreamSettings,
        sources: Sources,
    ) -> Result<Arc<Stream>, OpenError> {
        if state.is_closing || state.streams.len() >= self.limits.streams {
            let text = format!("there are {} streams, and no more may be: end one, or allow more", state.streams.len());
            return Err(OpenError { code: wire::ErrorCode::TooManyStreams, text });
        }
        let (inbox, bell) = Inbox::new(self.limits.waiting_points, self.overload);
        let (control, requests) = bounded(REQUESTS);
        state.opened += 1;
        let stream = Arc::new(Stream {
            number: state.opened,
            name: name.to_owned(),
            epoch: self.epoch + u64::from(state.opened),
            options: settings.options,
            inbox,
            board: Board::default(),
            stats: Stats::default(),
            producers: Mutex::default(),
            has_ended: AtomicBool::new(false),
            control,
        });
        let engine = Engine::new(Arc::clone(self), Arc::clone(&stream), settings, self.is_checking, sources);
        let (hub, supervised) = (Arc::clone(self), Arc::clone(&stream));
        let spawned = thread::Builder::new()
            .name(format!("engine {}", stream.number))
            .spawn(move || hub.supervise(&supervised, &requests, || engine.run(&bell, &requests)));
        let handle = spawned.map_err(|error| OpenError {
            code: wire::ErrorCode::TooManyStreams,
            text: format!("the system gave no thread for stream {name:?}: {error}"),
        })?;
        state.engines.retain(|engine| !engine.is_finished());
        state.engines.push(handle);
        state.streams.insert(name.to_owned(), Arc::clone(&stream));
        tracing::debug!("stream {name:?} opened: {:?}", settings.options);
        Ok(stream)
    }

    /// Runs an engine to its end, whatever that is.
    fn supervise(
        &self,
        stream: &Arc<Stream>,
        requests: &Receiver<Control>,
        run: impl FnOnce() -> Result<(), DaemonError>,
    ) {
        let result = catch_unwind(AssertUnwindSafe(run)).unwrap_or(Err(DaemonError::Thread("engine")));
        stream.inbox.close();
        stream.has_ended.store(true, Ordering::SeqCst);
        // Whoever has sat down too late for the engine sees the end here, or by himself.
        for control in requests.try_iter() {
            if let Control::Join(seat, ..) = control {
                seat.close(stream.stats.frame(), ENDED);
            }
        }
        self.forget(stream);
        let subscriptions = self.lock().subscriptions.clone();
        // Whoever has come too late for the engine, or has not been told by it, is told here.
        let reason = result.as_ref().map_or_else(ToString::to_string, |()| ENDED.to_owned());
        subscriptions.iter().for_each(|subscription| subscription.stream_ended(stream, &reason));
        if let Err(error) = &result {
            tracing::error!("stream {:?} has failed: {error}", stream.name);
            let channels = lock(&stream.producers).drain(..).collect::<Vec<_>>();
            channels
                .iter()
                .filter_map(Weak::upgrade)
                .for_each(|channel| channel.fail(&error.to_string(), stream.stats.frame()));
        }
        // What was sent after the end is not owed an answer: whoever waits for one goes on.
        while stream.inbox.pop().is_some() {}
        stream.stats.memory.store(0, Ordering::Relaxed);
        // Nobody listens any more once the daemon is ending.
        let _ = self.ended.send(Ended { stream: Arc::clone(stream), result });
    }

    /// Lets go of a stream that takes nothing more: its name is free, and so is its place among so many.
    pub fn forget(&self, stream: &Arc<Stream>) {
        let mut state = self.lock();
        if state.streams.get(&stream.name).is_some_and(|current| Arc::ptr_eq(current, stream)) {
            state.streams.remove(&stream.name);
        }
    }

    /// Seats a subscription before all streams that it matches, now and later.
    pub fn subscribe(&self, subscription: Arc<Subscription>, resume: Option<wire::Resume>) {
        let mut state = self.lock();
        let streams: Vec<Arc<Stream>> =
            state.streams.values().filter(|stream| subscription.matches(&stream.name)).cloned().collect();
        state.subscriptions.push(Arc::clone(&subscription));
        drop(state);
        streams.iter().for_each(|stream| subscription.sit_down(stream, resume));
    }

    /// Forgets a subscription.
    pub fn unsubscribe(&self, subscription: &Arc<Subscription>) {
        self.lock().subscriptions.retain(|other| !Arc::ptr_eq(other, subscription));
    }

    /// All streams, by name.
    pub fn streams(&self) -> Vec<Arc<Stream>> {
        self.lock().streams.values().cloned().collect()
    }

    /// The stream of a name.
    pub fn stream(&self, name: &str) -> Option<Arc<Stream>> {
        self.lock().streams.get(name).cloned()
    }

    /// Estimate of bytes held for streams.
    pub fn memory(&self) -> u64 {
        self.lock().streams.values().map(|stream| stream.stats.memory.load(Ordering::Relaxed)).sum()
    }

    /// How everything is.
    pub fn status(&self, software: &str) -> wire::Status {
        wire::Status {
            software: software.to_owned(),
            uptime_ms: self.started.elapsed().as_millis() as u64,
            epoch: self.epoch,
            connections: self.connections.load(Ordering::Relaxed) as u32,
            refused_messages: self.refused_messages.load(Ordering::Relaxed),
            memory: self.memory(),
            memory_limit: self.limits.memory,
            streams: self.streams().iter().map(|stream| stream.status()).collect(),
        }
    }

    /// A message of some peer could not be used.
    pub fn count_refused_message(&self) {
        self.refused_messages.fetch_add(1, Ordering::Relaxed);
    }

    /// A peer has connected.
    pub fn count_connection(&self) {
        self.connections.fetch_add(1, Ordering::Relaxed);
    }

    /// A peer has gone.
    pub fn discount_connection(&self) {
        self.connections.fetch_sub(1, Ordering::Relaxed);
    }

    /// Opens nothing more, lets all engines finish what they have been given, and tells the last frame of each stream.
    pub fn finish(&self) -> Vec<(String, u64)> {
        let (streams, engines) = {
            let mut state = self.lock();
            state.is_closing = true;
            (state.streams.values().cloned().collect::<Vec<_>>(), std::mem::take(&mut state.engines))
        };
        streams.iter().for_each(|stream| stream.inbox.close());
        for engine in engines {
            // A panic was caught, and told of, inside.
            let _ = engine.join();
        }
        streams.iter().map(|stream| (stream.name.clone(), stream.stats.frame())).collect()
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }
}

/// Seats everybody before a new stream who wants to follow streams of its name. Whoever subscribes from here on finds it by himself.
fn seat_all(state: MutexGuard<'_, State>, stream: &Arc<Stream>) {
    let matches = |subscription: &&Arc<Subscription>| subscription.matches(&stream.name);
    let subscriptions: Vec<Arc<Subscription>> = state.subscriptions.iter().filter(matches).cloned().collect();
    drop(state);
    subscriptions.iter().for_each(|subscription| subscription.sit_down(stream, None));
}

/// What these locks guard is whole between any two statements, so a panic elsewhere leaves it usable.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
