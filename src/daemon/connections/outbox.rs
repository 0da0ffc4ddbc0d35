//! The outbox of a connection: messages to the peer that do not come from cursors.
//!
//! In: replies, from the reader thread and from engines. Out: the same to the writer thread, in order.
//!
//! Invariants: a sender never waits. Two limits hold what a peer does not read, as in Redis. Above the soft one, in
//! messages or in bytes, the reader thread takes nothing more of the peer. Above the hard one, which only replies to
//! what was taken before can reach, the peer is cut off and all is dropped.
//!
//! Must not know: what messages say.

use std::collections::VecDeque;
use std::net::Shutdown;
use std::sync::{Arc, Condvar};

use super::socket::Socket;
use crate::daemon::encoding::Encoded;
use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::streams::consumer::Consumer;
use crate::daemon::streams::reply::Unanswered;

/// Messages that are unanswered or unsent, above which the reader thread waits.
const SOFT_MESSAGES: usize = 128;

/// Bytes of them, above which it waits.
const SOFT_BYTES: usize = 1 << 20;

/// Bytes above which the peer is cut off.
const HARD_BYTES: usize = 16 << 20;

/// Messages on their way to a peer.
#[derive(Debug)]
pub struct Outbox {
    state: Lock<State>,
    has_room: Condvar,
    consumer: Arc<Consumer>,
    socket: Arc<Socket>,
}

#[derive(Debug, Default)]
struct State {
    queue: VecDeque<(u32, Encoded)>,
    /// Bytes in the queue.
    bytes: usize,
    /// Messages of the peer that are not answered yet.
    unanswered: usize,
    /// Bytes of the answers that they will have.
    expected: usize,
    is_overrun: bool,
    is_closed: bool,
}

impl State {
    fn has_room(&self) -> bool {
        self.queue.len() + self.unanswered < SOFT_MESSAGES && self.bytes + self.expected < SOFT_BYTES
    }
}

/// A message of the peer that is not answered yet. Dropping it counts as an answer.
#[derive(Debug)]
pub struct PendingAnswer {
    outbox: Arc<Outbox>,
    expected: usize,
}

impl Unanswered for PendingAnswer {}

impl PendingAnswer {
    /// Its answer will have about so many bytes.
    pub fn expect(&mut self, bytes: usize) {
        let mut state = self.outbox.lock();
        state.expected += bytes;
        self.expected += bytes;
    }
}

impl Drop for PendingAnswer {
    fn drop(&mut self) {
        let mut state = self.outbox.lock();
        state.unanswered -= 1;
        state.expected -= self.expected;
        drop(state);
        self.outbox.has_room.notify_all();
    }
}

impl Outbox {
    /// An empty outbox, which wakes the writer of a peer when something comes.
    pub fn new(consumer: Arc<Consumer>, socket: Arc<Socket>) -> Self {
        let state = Lock::new(Level::Outbox, State::default());
        Self { state, has_room: Condvar::new(), consumer, socket }
    }

    /// Counts a message of the peer as unanswered, once there is room for its answer; at once, if the outbox is closed.
    pub fn expect_answer(self: &Arc<Self>) -> PendingAnswer {
        let mut state = self.lock();
        while !state.has_room() && !state.is_closed {
            state = state.wait(&self.has_room);
        }
        state.unanswered += 1;
        drop(state);
        PendingAnswer { outbox: Arc::clone(self), expected: 0 }
    }

    /// Appends a message on a channel. One above the hard limit ends the connection.
    pub fn push(&self, channel: u32, message: Encoded) {
        let mut state = self.lock();
        if state.is_closed {
            return;
        }
        state.bytes += message.bytes();
        state.queue.push_back((channel, message));
        if state.bytes <= HARD_BYTES {
            drop(state);
            return self.consumer.wake();
        }
        state.is_overrun = true;
        drop(state);
        self.close();
        // The writer may be waiting for the peer to read.
        self.socket.shutdown(Shutdown::Both);
    }

    /// The next message to be sent.
    pub fn pop(&self) -> Option<(u32, Encoded)> {
        let mut state = self.lock();
        let next = state.queue.pop_front()?;
        state.bytes -= next.1.bytes();
        drop(state);
        self.has_room.notify_all();
        Some(next)
    }

    /// Whether every message was answered.
    pub fn is_all_answered(&self) -> bool {
        self.lock().unanswered == 0
    }

    /// Whether nothing more is sent.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    /// Whether the peer was cut off for what it did not read.
    pub fn is_overrun(&self) -> bool {
        self.lock().is_overrun
    }

    /// Takes nothing more and drops what it has.
    pub fn close(&self) {
        let mut state = self.lock();
        state.is_closed = true;
        state.queue.clear();
        state.bytes = 0;
        drop(state);
        self.has_room.notify_all();
        self.consumer.wake();
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixStream;

    use crossbeam_channel::bounded;
    use hopes_protocol as wire;

    use super::*;
    use crate::daemon::memory::Account;

    fn outbox() -> (Arc<Outbox>, Arc<Account>) {
        let account = Arc::<Account>::default();
        let consumer = Arc::new(Consumer::new(1, Arc::clone(&account), bounded(1).0));
        let (socket, _) = UnixStream::pair().unwrap();
        (Arc::new(Outbox::new(consumer, Arc::new(Socket::Unix(socket)))), account)
    }

    fn message(bytes: usize, account: &Arc<Account>) -> Encoded {
        let shared = wire::Shared { kind: 1, length: bytes as u32, bytes: vec![0; bytes].into() };
        Encoded::new(shared, account)
    }

    #[test]
    fn a_peer_above_the_hard_limit_is_cut_off_and_holds_nothing() {
        let (outbox, account) = outbox();
        for _ in 0..HARD_BYTES / 100_000 {
            outbox.push(1, message(100_000 - 100, &account));
        }
        assert!(!outbox.is_overrun() && account.held() > 15_000_000);
        (0..3).for_each(|_| outbox.push(1, message(100_000, &account)));
        assert!(outbox.is_overrun());
        assert_eq!((account.held(), outbox.pop().is_some()), (0, false));
    }

    #[test]
    fn nothing_is_taken_above_the_soft_limit() {
        let (outbox, account) = outbox();
        let mut pending = outbox.expect_answer();
        pending.expect(SOFT_BYTES / 2);
        outbox.push(1, message(SOFT_BYTES / 2, &account));
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| drop(outbox.expect_answer()));
            assert!(!outbox.lock().has_room());
            drop(pending);
            waiting.join().unwrap();
        });
        assert!(outbox.lock().has_room());
    }
}
