//! The outbox of a connection: messages to the peer that do not come from cursors.
//!
//! In: replies, from the reader thread and from engines. Out: the same to the writer thread, in order.
//!
//! Invariants: a sender never waits. The reader thread takes no further message while many are unanswered or unsent, so
//! the queue is bounded by what the peer does not read.
//!
//! Must not know: what messages say.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crossbeam_channel::Sender;
use hopes_protocol::Shared;

use crate::daemon::locks::lock;
use crate::daemon::streams::reply::Unanswered;

/// Messages that are unanswered or unsent; the reader thread waits while there are so many.
const MOST: usize = 128;

/// Messages on their way to a peer.
#[derive(Debug)]
pub struct Outbox {
    state: Mutex<State>,
    has_room: Condvar,
    /// Wakes the writer thread.
    wake: Sender<()>,
}

#[derive(Debug, Default)]
struct State {
    queue: VecDeque<(u32, Shared)>,
    /// Messages of the peer that are not answered yet.
    unanswered: usize,
    is_closed: bool,
}

/// A message of the peer that is not answered yet. Dropping it counts as an answer.
#[derive(Debug)]
pub struct PendingAnswer(Arc<Outbox>);

impl Unanswered for PendingAnswer {}

impl Drop for PendingAnswer {
    fn drop(&mut self) {
        self.0.lock().unanswered -= 1;
        self.0.has_room.notify_all();
    }
}

impl Outbox {
    /// An empty outbox, which wakes the writer thread when something comes.
    pub fn new(wake: Sender<()>) -> Self {
        Self { state: Mutex::default(), has_room: Condvar::new(), wake }
    }

    /// Counts a message of the peer as unanswered, once there is room for its answer; at once, if the outbox is closed.
    pub fn expect_answer(self: &Arc<Self>) -> PendingAnswer {
        let mut state = self.lock();
        while state.queue.len() + state.unanswered >= MOST && !state.is_closed {
            state = self.has_room.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.unanswered += 1;
        drop(state);
        PendingAnswer(Arc::clone(self))
    }

    /// Appends a message on a channel.
    pub fn push(&self, channel: u32, message: Shared) {
        let mut state = self.lock();
        if !state.is_closed {
            state.queue.push_back((channel, message));
            drop(state);
            self.wake_writer();
        }
    }

    /// The next message to be sent.
    pub fn pop(&self) -> Option<(u32, Shared)> {
        let next = self.lock().queue.pop_front();
        if next.is_some() {
            self.has_room.notify_all();
        }
        next
    }

    /// Whether every message was answered.
    pub fn is_all_answered(&self) -> bool {
        self.lock().unanswered == 0
    }

    /// Takes nothing more and drops what it has.
    pub fn close(&self) {
        let mut state = self.lock();
        state.is_closed = true;
        state.queue.clear();
        drop(state);
        self.has_room.notify_all();
        self.wake_writer();
    }

    fn wake_writer(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }
}
