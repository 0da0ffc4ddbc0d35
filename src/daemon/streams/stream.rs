//! A handle to a stream: where items and requests for its engine go.
//!
//! In: items of producers, requests of consumers. Out: the same, to the engine.
//!
//! Invariants: a producer that is on the list when the queue is closed gets the end as a reply.
//!
//! Must not know: the engine, connections, other streams.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

use crossbeam_channel::{Sender, bounded};
use hopes_protocol as wire;

use super::publishing::cursor::{Cursor, Request};
use super::queue::Queue;
use super::reply::ReplySink;
use super::stream_state::StreamState;
use crate::daemon::locks::lock;

/// The reason that consumers get at a stream's end.
pub const ENDED: &str = "the stream has ended";

/// A stream.
#[derive(Debug)]
pub struct Stream {
    /// Its public state.
    pub state: Arc<StreamState>,
    /// What waits for the engine.
    pub queue: Queue,
    producers: Mutex<Vec<Weak<dyn ReplySink>>>,
    has_ended: AtomicBool,
    /// Requests of consumers. A sender waits when the engine is far behind, so it must hold no lock that the engine
    /// takes.
    requests: Sender<Request>,
}

impl Stream {
    /// A handle without producers.
    pub fn new(state: StreamState, queue: Queue, requests: Sender<Request>) -> Self {
        let state = Arc::new(state);
        Self { state, queue, producers: Mutex::default(), has_ended: AtomicBool::new(false), requests }
    }

    /// Adds a producer. `welcome` runs before anything else can be sent to it. False if the stream takes nothing more.
    pub fn add_producer(&self, producer: &Arc<dyn ReplySink>, welcome: impl FnOnce()) -> bool {
        let mut producers = lock(&self.producers);
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
        lock(&self.producers).retain(|other| !std::ptr::addr_eq(other.as_ptr(), Arc::as_ptr(producer)));
    }

    /// Removes all producers, and returns those whose connection is still there.
    pub fn take_producers(&self) -> Vec<Arc<dyn ReplySink>> {
        lock(&self.producers).drain(..).filter_map(|producer| producer.upgrade()).collect()
    }

    /// A cursor in this stream, which reads nothing before it has [joined](Self::join).
    pub fn cursor(&self, dots: wire::DotsWanted, tracks: wire::TracksWanted, wake: Sender<()>) -> Arc<Cursor> {
        Arc::new(Cursor::new(Arc::clone(&self.state), self.requests.clone(), dots, tracks, wake))
    }

    /// Requests that a cursor follows a view. If the engine has ended, the cursor is closed.
    pub fn join(&self, cursor: &Arc<Cursor>, view: wire::View, resume: Option<wire::Resume>) {
        cursor.request(Request::Join(Arc::clone(cursor), view, resume));
        if self.has_ended.load(Ordering::SeqCst) {
            cursor.close(self.state.stats.frame(), ENDED);
        }
    }

    /// The engine has ended: cursors that join from now on are closed at once.
    pub fn set_ended(&self) {
        self.queue.close();
        self.has_ended.store(true, Ordering::SeqCst);
    }

    /// The newest frame as a whole, as soon as the engine answers; none if there is none, or if that takes too long.
    pub fn snapshot_once(&self, view: wire::View, patience: Duration) -> Option<Arc<wire::Snapshot>> {
        let (answer, snapshot) = bounded(1);
        let is_requested = self.requests.try_send(Request::SnapshotOnce(view, answer)).is_ok();
        // An engine that ends drops the other end, which ends the wait.
        is_requested.then(|| snapshot.recv_timeout(patience).ok()).flatten()
    }

    /// Its entry in a list of streams.
    pub fn info(&self) -> wire::StreamInfo {
        let producers = lock(&self.producers).iter().filter(|producer| producer.strong_count() > 0).count();
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
            memory: stats.memory.load(Ordering::Relaxed),
        }
    }
}
