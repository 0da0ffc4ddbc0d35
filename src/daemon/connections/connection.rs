//! A connection to a peer: what its reader and its writer thread share.
//!
//! In: messages to the peer, cursors, the wish to end. Out: the same, to the writer thread.
//!
//! Invariants: the reader and the writer thread do not wait for another connection.
//!
//! Must not know: what messages say, what streams compute.

use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;

use super::outbox::Outbox;
use super::producer::ProducerChannel;
use super::socket::Socket;
use crate::daemon::encoding::encoded;
use crate::daemon::locks::lock;
use crate::daemon::streams::publishing::cursor::{Cursor, Request};

/// A connection.
#[derive(Debug)]
pub struct Connection {
    /// For logs: its number and the address that it came to.
    pub label: String,
    /// The socket.
    pub socket: Socket,
    /// Messages that do not come from cursors.
    pub outbox: Arc<Outbox>,
    /// Its cursors, each with its channel. No engine takes this lock, so requests may be sent to engines under it: the
    /// request to join then comes before the one to leave.
    pub cursors: Mutex<Vec<(u32, Arc<Cursor>)>>,
    /// Channels that fed streams until the daemon's end, whose last replies are still sent.
    pub producers: Mutex<Vec<Arc<ProducerChannel>>>,
    /// Wakes the writer thread.
    wake: Sender<()>,
    goodbye: Mutex<Option<wire::Shared>>,
    /// When something was received last.
    received: Mutex<Instant>,
    /// The peer does not take what it is sent, so nothing more is taken of it.
    is_cut_off: AtomicBool,
    /// Nothing more is to be read.
    is_ending: AtomicBool,
    /// Nothing more is to be sent: the peer would not understand it.
    is_incompatible: AtomicBool,
    /// The version of frames to the peer.
    version: AtomicU16,
}

impl Connection {
    /// A connection whose writer thread receives the wake-ups.
    pub fn new(label: String, socket: Socket, wake: Sender<()>) -> Self {
        Self {
            label,
            socket,
            outbox: Arc::new(Outbox::new(wake.clone())),
            cursors: Mutex::default(),
            producers: Mutex::default(),
            wake,
            goodbye: Mutex::default(),
            received: Mutex::new(Instant::now()),
            is_cut_off: AtomicBool::new(false),
            is_ending: AtomicBool::new(false),
            is_incompatible: AtomicBool::new(false),
            version: AtomicU16::new(wire::Banner::OURS.lowest),
        }
    }

    /// Something was received.
    pub fn note_received(&self) {
        *lock(&self.received) = Instant::now();
    }

    /// How long nothing was received.
    pub fn silence(&self) -> Duration {
        lock(&self.received).elapsed()
    }

    /// Sends a message on a channel.
    pub fn send(&self, channel: u32, message: impl Into<wire::Message>) {
        if let Some(message) = encoded(message) {
            self.outbox.push(channel, message);
        }
    }

    /// Sends goodbye after everything else, and disconnects.
    pub fn say_goodbye(&self, reason: &str, streams: Vec<(String, u64)>) {
        *lock(&self.goodbye) = encoded(wire::Goodbye { reason: reason.to_owned(), streams });
        self.wake_writer();
    }

    /// The last message, once it is time for it.
    pub fn take_goodbye(&self) -> Option<wire::Shared> {
        lock(&self.goodbye).take()
    }

    /// Wakes the writer thread.
    pub fn wake_writer(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    /// The sender of wake-ups of the writer thread.
    pub fn wake(&self) -> Sender<()> {
        self.wake.clone()
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

    /// Whether the peer does not take what it is sent.
    pub fn set_cut_off(&self, is_cut_off: bool) {
        self.is_cut_off.store(is_cut_off, Ordering::Release);
    }

    /// Whether nothing more is taken of the peer.
    pub fn is_cut_off(&self) -> bool {
        self.is_cut_off.load(Ordering::Acquire)
    }

    /// Reads no more.
    pub fn stop_reading(&self) {
        self.is_ending.store(true, Ordering::Release);
        self.socket.shutdown(std::net::Shutdown::Read);
    }

    /// Whether nothing more is read.
    pub fn is_ending(&self) -> bool {
        self.is_ending.load(Ordering::Acquire)
    }

    /// Ends the cursors of a channel.
    pub fn end_cursors(&self, of_channel: u32) {
        lock(&self.cursors).retain(|(channel, cursor)| {
            let ends = *channel == of_channel;
            if ends {
                cursor.cancel();
                cursor.request(Request::Leave(Arc::clone(cursor)));
            }
            !ends
        });
    }
}
