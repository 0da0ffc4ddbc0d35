//! A connection to a peer: what its reader and its writer thread share.
//!
//! In: messages to the peer, cursors, the wish to end. Out: the same, to the writer thread.
//!
//! Invariants: the reader and the writer thread do not wait for another connection.
//!
//! Must not know: what messages say, what streams compute.

use std::net::Shutdown;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;

use super::outbox::Outbox;
use super::producer::ProducerChannel;
use super::socket::Socket;
use crate::daemon::encoding::{Encoded, encoded};
use crate::daemon::locks::{Level, Lock};
use crate::daemon::log_limits::LogLimits;
use crate::daemon::memory::Account;
use crate::daemon::streams::consumer::Consumer;
use crate::daemon::streams::publishing::cursor::Cursor;

/// A connection.
#[derive(Debug)]
pub struct Connection {
    /// For logs: its number and the address that it came to.
    pub label: String,
    /// The address that it came to.
    pub place: String,
    /// It has the connection that is reserved for administration.
    pub is_reserved: bool,
    /// The socket.
    pub socket: Arc<Socket>,
    /// What its cursors share.
    pub consumer: Arc<Consumer>,
    /// Messages that do not come from cursors.
    pub outbox: Arc<Outbox>,
    /// Its cursors, each with its channel. Requests are made under this lock, which never waits: so the request to join
    /// comes before the one to leave.
    pub cursors: Lock<Vec<(u32, Arc<Cursor>)>>,
    /// Channels that fed streams until the daemon's end, whose last replies are still sent.
    pub producers: Lock<Vec<Arc<ProducerChannel>>>,
    /// What is counted.
    pub counts: Counts,
    goodbye: Lock<Option<Encoded>>,
    /// When something was received last.
    received: Lock<Instant>,
    /// The peer does not take what it is sent, so nothing more is taken of it.
    is_cut_off: AtomicBool,
    /// Nothing more is to be read.
    is_ending: AtomicBool,
    /// Nothing more is to be sent: the peer would not understand it.
    is_incompatible: AtomicBool,
    /// The version of frames to the peer.
    version: AtomicU16,
}

/// What is counted of a connection.
#[derive(Debug)]
pub struct Counts {
    /// What the peer calls itself.
    pub software: Lock<String>,
    /// Since when it is connected.
    pub since: Instant,
    /// Channels that feed streams.
    pub producers: AtomicU64,
    /// Channels that follow streams.
    pub consumers: AtomicU64,
    /// Bytes received.
    pub received: AtomicU64,
    /// Bytes sent.
    pub sent: AtomicU64,
}

impl Counts {
    fn new() -> Self {
        let zero = || AtomicU64::new(0);
        let software = Lock::new(Level::Leaf, String::new());
        let since = Instant::now();
        Self { software, since, producers: zero(), consumers: zero(), received: zero(), sent: zero() }
    }
}

/// Where a connection comes from.
#[derive(Clone, Debug)]
pub struct Arrival {
    /// Its number, from 1.
    pub peer: u64,
    /// The address that it came to.
    pub place: String,
    /// It has the connection that is reserved for administration.
    pub is_reserved: bool,
}

impl Connection {
    /// A connection whose writer thread receives the wake-ups. What is held for it is charged to an account.
    pub fn new(arrival: Arrival, socket: Socket, wake: Sender<()>, account: Arc<Account>) -> Self {
        let Arrival { peer, place, is_reserved } = arrival;
        let (socket, consumer) = (Arc::new(socket), Arc::new(Consumer::new(peer, account, wake)));
        Self {
            label: format!("peer {peer} at {place}"),
            place,
            is_reserved,
            outbox: Arc::new(Outbox::new(Arc::clone(&consumer), Arc::clone(&socket))),
            socket,
            consumer,
            cursors: Lock::new(Level::Cursors, Vec::new()),
            producers: Lock::new(Level::Leaf, Vec::new()),
            counts: Counts::new(),
            goodbye: Lock::new(Level::Leaf, None),
            received: Lock::new(Level::Leaf, Instant::now()),
            is_cut_off: AtomicBool::new(false),
            is_ending: AtomicBool::new(false),
            is_incompatible: AtomicBool::new(false),
            version: AtomicU16::new(wire::Banner::OURS.lowest),
        }
    }

    /// So many bytes were received.
    pub fn note_received(&self, bytes: usize) {
        self.counts.received.fetch_add(bytes as u64, Ordering::Relaxed);
        *self.received.lock() = Instant::now();
    }

    /// How long nothing was received.
    pub fn silence(&self) -> Duration {
        self.received.lock().elapsed()
    }

    /// Sends a message on a channel.
    pub fn send(&self, channel: u32, message: impl Into<wire::Message>) {
        if let Some(message) = encoded(message, &self.consumer.account) {
            self.outbox.push(channel, message);
        }
    }

    /// Sends goodbye after everything else, and disconnects.
    pub fn say_goodbye(&self, reason: &str, streams: Vec<(String, u64)>) {
        let goodbye = encoded(wire::Goodbye { reason: reason.to_owned(), streams }, &self.consumer.account);
        // The first reason is the one that counts.
        let mut first = self.goodbye.lock();
        if first.is_none() {
            *first = goodbye;
        }
        drop(first);
        self.wake_writer();
    }

    /// The last message, once it is time for it.
    pub fn take_goodbye(&self) -> Option<Encoded> {
        self.goodbye.lock().take()
    }

    /// Wakes the writer thread.
    pub fn wake_writer(&self) {
        self.consumer.wake();
    }

    /// Frames to the peer are of this version from now on.
    pub fn set_version(&self, version: u16) {
        self.version.store(version, Ordering::Release);
    }

    /// The version of frames to the peer: the lowest, until one is agreed on.
    pub fn version(&self) -> u16 {
        self.version.load(Ordering::Acquire)
    }

    /// Disconnects without a message, from a peer that would not understand it.
    pub fn set_incompatible(&self) {
        self.is_incompatible.store(true, Ordering::Release);
        self.wake_writer();
    }

    /// Whether the peer understands no message.
    pub fn is_incompatible(&self) -> bool {
        self.is_incompatible.load(Ordering::Acquire)
    }

    /// The peer does not take what it is sent.
    pub fn set_cut_off(&self) {
        self.is_cut_off.store(true, Ordering::Release);
    }

    /// Ends the connection at once: what is held for the peer is dropped.
    pub fn cut_off(&self) {
        self.set_cut_off();
        self.outbox.close();
        // The writer may be waiting for the peer to read.
        self.socket.shutdown(Shutdown::Both);
    }

    /// Tells in the log that the peer was cut off.
    pub fn log_cut_off(&self, logs: &LogLimits) {
        if let Some(note) = logs.admits("cut off", &self.place) {
            tracing::warn!("{}: cut off: it does not read what it is sent{note}", self.label);
        }
    }

    /// What is known of the peer.
    pub fn peer(&self) -> wire::Peer {
        let counts = &self.counts;
        let number = |count: &AtomicU64| count.load(Ordering::Relaxed);
        // Not in the expression below, whose other locks must not be taken under this one.
        let software = counts.software.lock().clone();
        wire::Peer {
            peer: self.consumer.peer,
            place: self.place.clone(),
            software,
            connected_ms: counts.since.elapsed().as_millis() as u64,
            silent_ms: self.silence().as_millis() as u64,
            producers: number(&counts.producers) as u32,
            consumers: number(&counts.consumers) as u32,
            held: self.consumer.held(),
            received: number(&counts.received),
            sent: number(&counts.sent),
            lagged: number(&self.consumer.lagged),
        }
    }

    /// Whether nothing more is taken of the peer.
    pub fn is_cut_off(&self) -> bool {
        self.is_cut_off.load(Ordering::Acquire)
    }

    /// Reads no more.
    pub fn stop_reading(&self) {
        self.is_ending.store(true, Ordering::Release);
        self.socket.shutdown(Shutdown::Read);
    }

    /// Whether nothing more is read.
    pub fn is_ending(&self) -> bool {
        self.is_ending.load(Ordering::Acquire)
    }

    /// Ends the cursors of a channel.
    pub fn end_cursors(&self, of_channel: u32) {
        self.cursors.lock().retain(|(channel, cursor)| {
            let ends = *channel == of_channel;
            if ends {
                cursor.leave();
            }
            !ends
        });
    }
}
