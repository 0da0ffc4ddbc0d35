//! What a peer is to be told on its channels, apart from what its seats have for it.
//!
//! In: answers, from the reader and from engines. Out: the same to the writer, in order. Invariants: nobody who answers ever waits; the reader takes on no further message while many answers are owed or not
//! yet sent, so the queue is bounded by what the peer itself does not read. Must not know: what is said.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crossbeam_channel::Sender;
use hopes_protocol::Shared;

/// Messages that are owed or not sent; a reader waits while there are so many.
const MOST: usize = 128;

/// Messages on their way to a peer.
#[derive(Debug)]
pub struct Outbox {
    state: Mutex<State>,
    room: Condvar,
    bell: Sender<()>,
}

#[derive(Debug, Default)]
struct State {
    queue: VecDeque<(u32, Shared)>,
    /// Messages of the peer that are not answered yet.
    owed: usize,
    is_closed: bool,
}

/// A message of the peer is being dealt with. Ends when this is dropped, answered or not.
#[derive(Debug)]
pub struct Debt(Arc<Outbox>);

impl Drop for Debt {
    fn drop(&mut self) {
        self.0.lock().owed -= 1;
        self.0.room.notify_all();
    }
}

impl Outbox {
    /// Nothing to say; the bell tells the writer of more.
    pub fn new(bell: Sender<()>) -> Self {
        Self { state: Mutex::default(), room: Condvar::new(), bell }
    }

    /// Takes on a message of the peer, once there is room for its answer; at once, if nothing is sent any more.
    pub fn owe(self: &Arc<Self>) -> Debt {
        let mut state = self.lock();
        while state.queue.len() + state.owed >= MOST && !state.is_closed {
            state = self.room.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.owed += 1;
        drop(state);
        Debt(Arc::clone(self))
    }

    /// Says something on a channel.
    pub fn push(&self, channel: u32, message: Shared) {
        let mut state = self.lock();
        if !state.is_closed {
            state.queue.push_back((channel, message));
            drop(state);
            // A bell that is full rings already.
            let _ = self.bell.try_send(());
        }
    }

    /// The next message to be sent.
    pub fn pop(&self) -> Option<(u32, Shared)> {
        let next = self.lock().queue.pop_front();
        if next.is_some() {
            self.room.notify_all();
        }
        next
    }

    /// Whether every message was answered.
    pub fn is_even(&self) -> bool {
        self.lock().owed == 0
    }

    /// Takes nothing more and forgets what it has.
    pub fn close(&self) {
        let mut state = self.lock();
        state.is_closed = true;
        state.queue.clear();
        drop(state);
        self.room.notify_all();
        let _ = self.bell.try_send(());
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
