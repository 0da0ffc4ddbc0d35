//! The connections of a daemon, for those who ask about them or end them.
//!
//! In: connections as they begin. Out: their peers' numbers; ends of connections.
//!
//! Invariants: nobody waits for a peer while the list is locked. A connection is held weakly, so that its socket is
//! closed as soon as its threads have ended.
//!
//! Must not know: what peers send.

use std::net::Shutdown;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use hopes_protocol as wire;

use super::connection::Connection;
use super::control_pace::ControlPool;
use crate::daemon::locks::{Guard, Level, Lock, before_waiting};

/// A connection and its threads.
pub struct Member {
    /// For logs.
    pub label: String,
    /// The connection.
    pub connection: Weak<Connection>,
    /// The thread that reads.
    pub reader: JoinHandle<()>,
    /// The thread that writes.
    pub writer: JoinHandle<()>,
}

/// All connections.
pub struct Members {
    state: Lock<State>,
    /// Peers that were cut off.
    cut_off: AtomicU64,
    /// What they ask beyond what is their own.
    pub control_pool: ControlPool,
}

#[derive(Default)]
struct State {
    list: Vec<Member>,
    admitted: u64,
    is_closing: bool,
}

/// The place of a new connection.
pub enum Place {
    /// One of those that any peer may have.
    Ordinary,
    /// The one that is reserved for administration.
    Reserved,
    /// None.
    Full,
    /// The daemon is ending.
    Closing,
}

impl Default for Members {
    fn default() -> Self {
        Self {
            state: Lock::new(Level::Members, State::default()),
            cut_off: AtomicU64::new(0),
            control_pool: ControlPool::new(Instant::now()),
        }
    }
}

impl Members {
    /// The number of the next connection, and its place among `most` at the most.
    pub fn place(&self, most: usize) -> (u64, Place) {
        let mut state = self.lock();
        state.list.retain(|member| !(member.reader.is_finished() && member.writer.is_finished()));
        state.admitted += 1;
        let place = match state.list.len() {
            _ if state.is_closing => Place::Closing,
            length if length < most => Place::Ordinary,
            // The reserved one is above the limit.
            length if length == most => Place::Reserved,
            _ => Place::Full,
        };
        (state.admitted, place)
    }

    /// Adds a connection.
    pub fn add(&self, member: Member) {
        self.lock().list.push(member);
    }

    /// Takes no connection any more.
    pub fn close(&self) {
        self.lock().is_closing = true;
    }

    /// Removes all connections, for the end.
    pub fn take(&self) -> Vec<Member> {
        std::mem::take(&mut self.lock().list)
    }

    /// All connections.
    pub fn connections(&self) -> Vec<Arc<Connection>> {
        self.lock().list.iter().filter_map(|member| member.connection.upgrade()).collect()
    }

    /// What is known of all peers.
    pub fn peers(&self) -> Vec<wire::Peer> {
        self.connections().iter().map(|connection| connection.peer()).collect()
    }

    /// Disconnects a peer, with a goodbye if it reads. False if there is no such peer.
    pub fn disconnect(&self, peer: u64, reason: &str) -> bool {
        /// How long the peer may take to read the goodbye.
        const GOODBYE: Duration = Duration::from_millis(500);
        let Some(connection) = self.connections().into_iter().find(|other| other.consumer.peer == peer) else {
            return false;
        };
        connection.say_goodbye(reason, Vec::new());
        let deadline = Instant::now() + GOODBYE;
        before_waiting("a peer's goodbye");
        while !connection.outbox.is_closed() && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(2));
        }
        connection.socket.shutdown(Shutdown::Both);
        true
    }

    /// Peers that were cut off so far.
    pub fn cut_off_count(&self) -> u64 {
        self.cut_off.load(Ordering::Relaxed)
    }

    /// A peer has been cut off.
    pub fn note_cut_off(&self) {
        self.cut_off.fetch_add(1, Ordering::Relaxed);
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
    }
}
