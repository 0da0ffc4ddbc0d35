//! Peers: connections, each with a reader and a writer thread, and their conversations with streams.
//!
//! ```text
//! socket ──▶ reader ──(items)──▶ inbox of a stream
//! socket ◀── writer ◀──(answers)── outbox
//!                   ◀──(frames)─── seats before streams
//! ```
//!
//! Invariants: whatever a peer sends, or does not read, is between it and its own two threads: the reader waits for nobody but the stream that it feeds and its own outbox, the
//! writer for nobody but the socket; no thread of another peer or stream waits for either. Must not know: what streams compute.

mod listener;
mod outbox;
mod reader;
mod registry;
mod socket;
mod writer;

use std::sync::atomic::{AtomicBool, AtomicU16, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;
use wildmatch::WildMatchPattern;

use super::convert::encoded;
use super::seat::{Control, Seat};
use super::streams::{Stream, lock};
pub use listener::{ListenError, Listener, bind_tcp};
pub use outbox::{Debt, Outbox};
pub use reader::SOFTWARE;
pub use registry::Registry;
pub use socket::{Socket, Transport};

/// A connection.
#[derive(Debug)]
pub struct Peer {
    /// For logs: what it is connected to, and its number.
    pub label: String,
    socket: Socket,
    outbox: Arc<Outbox>,
    /// Its places before streams, each with the channel that it belongs to. No engine takes this lock, so engines may be asked under it: a seat is
    /// then joined before it is left.
    seats: Mutex<Vec<(u32, Arc<Seat>)>>,
    /// Channels on which it fed streams until the daemon's end, of which they are still told.
    feeds: Mutex<Vec<Arc<ProducerChannel>>>,
    /// Tells the writer that there is something to send.
    bell: Sender<()>,
    /// The last message, once it is time for it.
    goodbye: Mutex<Option<wire::Shared>>,
    /// When something came last.
    heard: Mutex<Instant>,
    /// It does not take what it is sent, so nothing more is taken of it.
    is_cut_off: AtomicBool,
    /// Nothing more is to be read.
    is_ending: AtomicBool,
    /// Nothing more is to be said: it would not be understood.
    is_strange: AtomicBool,
    /// Of frames to it.
    version: AtomicU16,
}

impl Peer {
    fn new(label: String, socket: Socket, bell: Sender<()>) -> Self {
        Self {
            label,
            socket,
            outbox: Arc::new(Outbox::new(bell.clone())),
            seats: Mutex::default(),
            feeds: Mutex::default(),
            bell,
            goodbye: Mutex::default(),
            heard: Mutex::new(Instant::now()),
            is_cut_off: AtomicBool::new(false),
            is_ending: AtomicBool::new(false),
            is_strange: AtomicBool::new(false),
            version: AtomicU16::new(wire::Banner::OURS.lowest),
        }
    }

    /// It has said something.
    fn is_heard(&self) {
        *lock(&self.heard) = Instant::now();
    }

    /// How long it has said nothing, as far as anybody has listened.
    fn silence(&self) -> Duration {
        lock(&self.heard).elapsed()
    }

    /// Says something on a channel.
    fn say(&self, channel: u32, message: impl Into<wire::Message>) {
        if let Some(message) = encoded(message) {
            self.outbox.push(channel, message);
        }
    }

    /// Says goodbye when everything else was sent, and hangs up.
    fn say_goodbye(&self, reason: &str, streams: Vec<(String, u64)>) {
        *lock(&self.goodbye) = encoded(wire::Goodbye { reason: reason.to_owned(), streams });
        self.ring_bell();
    }

    /// Tells the writer that there is something to send. A bell that is full rings already.
    fn ring_bell(&self) {
        let _ = self.bell.try_send(());
    }

    /// Frames to it are of this version from now on.
    fn set_version(&self, version: u16) {
        self.version.store(version, Ordering::Release);
    }

    /// The version of frames to it: the lowest, until one is agreed on.
    fn version(&self) -> u16 {
        self.version.load(Ordering::Acquire)
    }

    /// Hangs up without a word.
    fn hang_up(&self) {
        self.is_strange.store(true, Ordering::Release);
        self.ring_bell();
    }

    /// Reads no more.
    fn stop_reading(&self) {
        self.is_ending.store(true, Ordering::Release);
        self.socket.shutdown(std::net::Shutdown::Read);
    }

    /// Leaves the streams that a channel follows.
    fn leave_seats(&self, of_channel: u32) {
        lock(&self.seats).retain(|(channel, seat)| {
            let leaves = *channel == of_channel;
            if leaves {
                seat.vacate();
                seat.stream.ask(Control::Leave(Arc::clone(seat)));
            }
            !leaves
        });
    }
}

/// A channel on which a peer feeds a stream.
#[derive(Debug)]
pub struct ProducerChannel {
    number: u32,
    outbox: Arc<Outbox>,
    dropped: AtomicU64,
}

impl ProducerChannel {
    fn new(number: u32, outbox: Arc<Outbox>) -> Self {
        Self { number, outbox, dropped: AtomicU64::new(0) }
    }

    /// Answers a message.
    pub fn answer(&self, message: impl Into<wire::Message>) {
        if let Some(message) = encoded(message) {
            self.outbox.push(self.number, message);
        }
    }

    /// Tells that a message was dropped.
    pub fn answer_dropped(&self, sequence: u64, points: u32, policy: wire::Policy) {
        let total = self.dropped.fetch_add(u64::from(points), Ordering::Relaxed) + u64::from(points);
        self.answer(wire::Overloaded { sequence, points, total, policy });
    }

    /// Says that nothing more comes on this channel.
    pub fn close(&self, frame: u64) {
        self.answer(wire::Closed { frame });
    }

    /// Says that the stream is no more.
    pub fn fail(&self, reason: &str, frame: u64) {
        self.answer(report(wire::ErrorCode::StreamFailed, 0, format!("the stream has failed: {reason}")));
        self.close(frame);
    }
}

/// Matches names in which `*` stands for any run of characters. No name has a NUL, so nothing stands for a single one.
type Pattern = WildMatchPattern<'*', '\0'>;

/// A channel on which a peer follows streams.
#[derive(Debug)]
pub struct Subscription {
    channel: u32,
    peer: Arc<Peer>,
    pattern: Pattern,
    /// What those streams are seen in that come later.
    look: Mutex<wire::ChangeView>,
    /// What of their tracks.
    tracks: Mutex<wire::TracksWanted>,
    /// Nothing is followed any more.
    is_over: AtomicBool,
}

impl Subscription {
    /// Whether it follows streams of this name.
    pub fn matches(&self, name: &str) -> bool {
        self.pattern.matches(name)
    }

    /// Takes a place before a stream.
    pub fn sit_down(&self, stream: &Arc<Stream>, resume: Option<wire::Resume>) {
        let mut seats = lock(&self.peer.seats);
        if self.is_over.load(Ordering::Acquire) {
            return;
        }
        let (look, tracks) = (*lock(&self.look), *lock(&self.tracks));
        let seat = Arc::new(Seat::new(Arc::clone(stream), look.dots, tracks, self.peer.bell.clone()));
        seats.push((self.channel, Arc::clone(&seat)));
        stream.join(&seat, look.view, resume);
        // There is the stream itself to tell of, even if it has no frame.
        seat.ring_bell();
    }

    /// Takes no place any more, and leaves those that it has.
    fn end(&self) {
        self.is_over.store(true, Ordering::Release);
        self.peer.leave_seats(self.channel);
    }

    /// Tells that a stream is no more, where that was not told yet.
    pub fn stream_ended(&self, stream: &Arc<Stream>, reason: &str) {
        let seats = lock(&self.peer.seats);
        let here = seats.iter().filter(|(channel, seat)| *channel == self.channel && Arc::ptr_eq(&seat.stream, stream));
        here.for_each(|(_, seat)| seat.close(stream.stats.frame(), reason));
    }

    fn change(&self, change: wire::ChangeView) {
        let seats = lock(&self.peer.seats);
        *lock(&self.look) = change;
        for (_, seat) in seats.iter().filter(|(channel, _)| *channel == self.channel) {
            seat.stream.ask(Control::ChangeView(Arc::clone(seat), change));
        }
    }

    fn want_tracks(&self, tracks: wire::TracksWanted) {
        let seats = lock(&self.peer.seats);
        *lock(&self.tracks) = tracks;
        for (_, seat) in seats.iter().filter(|(channel, _)| *channel == self.channel) {
            seat.stream.ask(Control::WantTracks(Arc::clone(seat), tracks));
        }
    }
}

fn report(code: wire::ErrorCode, answers: u16, text: impl Into<String>) -> wire::Report {
    wire::Report { code: code as u16, answers, text: text.into() }
}
