//! A handle to a stream: where items and requests for its engine go.
//!
//! In: items of producers, requests of consumers. Out: the same, to the engine.
//!
//! Invariants: a producer that is on the list when the queue is closed gets the end as a reply.
//!
//! Must not know: the engine, connections, other streams.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, bounded};
use hopes_protocol as wire;

use super::consumer::Consumer;
use super::publishing::cursor::Cursor;
use super::queue::Queue;
use super::reply::ReplySink;
use super::requests::Requests;
use super::stream_state::StreamState;
use crate::daemon::locks::{Level, Lock, before_waiting};
use crate::daemon::memory::Charged;

/// The reason that consumers get at a stream's end.
pub const ENDED: &str = "the stream has ended";

/// A stream.
#[derive(Debug)]
pub struct Stream {
    /// The daemon itself has made it: it stays, whether it is used or not.
    pub is_permanent: bool,
    /// Its public state.
    pub state: Arc<StreamState>,
    /// What waits for the engine.
    pub queue: Queue,
    producers: Lock<Vec<Weak<dyn ReplySink>>>,
    has_ended: AtomicBool,
    /// What can be made again is dropped by the engine.
    is_to_relieve: AtomicBool,
    /// When the engine has to end, whether its output is read or not.
    end_by: Lock<Option<Instant>>,
    /// Since when nobody feeds or follows it.
    unused_since: Lock<Option<Instant>>,
    /// Requests of consumers.
    pub requests: Arc<Requests<Cursor>>,
}

/// A question to an engine, whether it is alive.
#[derive(Debug)]
pub struct Probe(Receiver<()>);

impl Probe {
    /// Whether the engine answers within `patience`.
    pub fn is_answered_within(&self, patience: Duration) -> bool {
        before_waiting("a sign of life of an engine");
        // An engine that has ended drops the other end, and owes none.
        self.0.recv_timeout(patience) != Err(RecvTimeoutError::Timeout)
    }
}

impl Stream {
    /// A handle without producers.
    pub fn new(state: StreamState, queue: Queue, requests: Requests<Cursor>, is_permanent: bool) -> Self {
        Self {
            is_permanent,
            state: Arc::new(state),
            queue,
            producers: Lock::new(Level::Producers, Vec::new()),
            has_ended: AtomicBool::new(false),
            is_to_relieve: AtomicBool::new(false),
            end_by: Lock::new(Level::Leaf, None),
            unused_since: Lock::new(Level::Leaf, None),
            requests: Arc::new(requests),
        }
    }

    /// Adds a producer. `welcome` runs before anything else can be sent to it. False if the stream takes nothing more.
    pub fn add_producer(&self, producer: &Arc<dyn ReplySink>, welcome: impl FnOnce()) -> bool {
        let mut producers = self.producers.lock();
        let is_open = !self.queue.is_closed();
        if is_open {
            producers.retain(|other| other.strong_count() > 0);
            producers.push(Arc::downgrade(producer));
            welcome();
        }
        is_open
    }

    /// Removes a producer.
    pub fn remove_producer(&self, producer: &Arc<dyn ReplySink>) {
        self.producers.lock().retain(|other| !std::ptr::addr_eq(other.as_ptr(), Arc::as_ptr(producer)));
    }

    /// Removes all producers, and returns those whose connection is still there.
    pub fn take_producers(&self) -> Vec<Arc<dyn ReplySink>> {
        self.producers.lock().drain(..).filter_map(|producer| producer.upgrade()).collect()
    }

    /// A cursor in this stream, which reads nothing before it has [joined](Self::join).
    pub fn cursor(&self, consumer: &Arc<Consumer>, dots: wire::DotsWanted, tracks: wire::TracksWanted) -> Arc<Cursor> {
        let (state, requests) = (Arc::clone(&self.state), Arc::clone(&self.requests));
        Arc::new(Cursor::new(state, Arc::clone(consumer), requests, dots, tracks))
    }

    /// Requests that a cursor follows a view. If the engine has ended, the cursor is closed.
    pub fn join(&self, cursor: &Arc<Cursor>, view: wire::View, resume: Option<wire::Resume>) {
        let is_open = self.requests.join(cursor, view, resume);
        if !is_open || self.has_ended.load(Ordering::SeqCst) {
            cursor.close(self.state.stats.frame(), ENDED);
        }
    }

    /// Whether the engine has ended.
    pub fn has_ended(&self) -> bool {
        self.has_ended.load(Ordering::SeqCst)
    }

    /// Has the engine drop what can be made again.
    pub fn relieve(&self) {
        self.is_to_relieve.store(true, Ordering::Release);
        self.queue.wake_engine();
    }

    /// Whether the engine is to drop what can be made again; once for each request.
    pub fn takes_relief(&self) -> bool {
        self.is_to_relieve.swap(false, Ordering::AcqRel)
    }

    /// Takes nothing more. The engine finishes what it has, and waits for its output until `by`.
    pub fn finish(&self, by: Instant) {
        self.end_by.lock().get_or_insert(by);
        self.queue.close();
    }

    /// When the engine has to end at the latest, once it is to end.
    pub fn end_by(&self) -> Option<Instant> {
        *self.end_by.lock()
    }

    /// How long nobody has fed or followed it, as far as those know who ask this now and then.
    pub fn unused_for(&self, now: Instant) -> Option<Duration> {
        let is_used = self.info().producers > 0 || self.info().consumers > 0;
        let mut since = self.unused_since.lock();
        *since = (!is_used).then(|| since.unwrap_or(now));
        since.map(|since| now.saturating_duration_since(since))
    }

    /// Asks the engine for a sign of life.
    pub fn probe(&self) -> Probe {
        let (answer, alive) = bounded(1);
        self.requests.probe(answer);
        Probe(alive)
    }

    /// The engine has ended: cursors that join from now on are closed at once.
    pub fn set_ended(&self) {
        self.queue.close();
        self.has_ended.store(true, Ordering::SeqCst);
    }

    /// The newest frame as a whole, as soon as the engine answers; none if there is none, or if that takes too long.
    pub fn snapshot_once(&self, view: wire::View, patience: Duration) -> Option<Arc<Charged<wire::Message>>> {
        let (answer, snapshot) = bounded(1);
        let is_requested = self.requests.snapshot_once(view, answer);
        before_waiting("a snapshot");
        // An engine that ends drops the other end, which ends the wait.
        is_requested.then(|| snapshot.recv_timeout(patience).ok()).flatten()
    }

    /// Its entry in a list of streams.
    pub fn info(&self) -> wire::StreamInfo {
        let producers = self.producers.lock().iter().filter(|producer| producer.strong_count() > 0).count();
        self.state.info(producers)
    }

    /// Its status.
    pub fn status(&self) -> wire::StreamStatus {
        let stats = &self.state.stats;
        wire::StreamStatus {
            info: self.info(),
            computed: stats.computed.load(Ordering::Relaxed),
            accepted: stats.accepted.load(Ordering::Relaxed),
            refused: stats.refused.load(Ordering::Relaxed),
            dropped: self.queue.dropped(),
            waiting: self.queue.waiting() as u64,
            lagged: stats.lagged.load(Ordering::Relaxed),
            memory: self.state.accounts.held(),
        }
    }
}
