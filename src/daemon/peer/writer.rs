//! The writer thread of a peer: answers and frames to its socket.
//!
//! In: the peer's outbox and seats, a bell that tells of more. Out: bytes. Invariants: answers go before frames, seats take turns; what is small is sent together; a peer that takes longer than its timeout for what it is
//! sent is cut off; goodbye is the last message. Must not know: what messages say.

use std::io;
use std::net::Shutdown;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_channel::Receiver;
use hopes_protocol as wire;

use super::Peer;
use crate::daemon::Limits;
use crate::daemon::convert::encoded;
use crate::daemon::seat::Seat;
use crate::daemon::streams::lock;

/// Messages are collected up to so many bytes before they are sent.
const TOGETHER: usize = 1 << 16;

/// How long the last word of what carries the bytes may take.
const LAST_WORD: Duration = Duration::from_secs(1);

/// Sends until goodbye was said or the connection is gone.
pub fn run(peer: &Peer, rings: &Receiver<()>, limits: &Limits) {
    let now = Instant::now();
    let mut writer = Writer { peer, limits, buffer: Vec::new(), last: now, asked: now };
    let is_ending = || peer.is_ending.load(Ordering::Acquire);
    let finish = |()| peer.socket.finish(is_ending(), LAST_WORD);
    if let Err(error) = writer.write_banner().and_then(|()| writer.run(rings)).and_then(finish) {
        tracing::debug!("{}: cannot send: {error}", peer.label);
        // One that has gone has said before what it had to say.
        peer.is_cut_off.store(error.kind() == io::ErrorKind::TimedOut, Ordering::Release);
    }
    peer.outbox.close();
    peer.socket.shutdown(Shutdown::Both);
}

struct Writer<'a> {
    peer: &'a Peer,
    limits: &'a Limits,
    buffer: Vec<u8>,
    /// When something was sent last.
    last: Instant,
    /// When it was asked last whether it is there.
    asked: Instant,
}

impl Writer<'_> {
    fn run(&mut self, rings: &Receiver<()>) -> io::Result<()> {
        // Whoever hears nothing for half of the timeout asks: it need not come to that.
        let patience = self.limits.heartbeat.min(self.limits.timeout / 4);
        loop {
            if self.peer.is_strange.load(Ordering::Acquire) {
                return Ok(());
            }
            while self.round()? {
                self.ask_if_silent()?;
            }
            self.ask_if_silent()?;
            self.flush()?;
            let goodbye = lock(&self.peer.goodbye).take();
            if let Some(goodbye) = goodbye {
                // Something may have come between the last round and the farewell.
                while self.round()? {}
                self.put(0, &goodbye)?;
                return self.flush();
            }
            if rings.recv_timeout(patience / 2).is_err() {
                self.show_life(patience)?;
            }
        }
    }

    fn write_banner(&mut self) -> io::Result<()> {
        self.peer.socket.write(&wire::Banner::OURS.encode(), self.limits.timeout)
    }

    /// Sends all answers and one message of each seat; whether there was anything.
    fn round(&mut self) -> io::Result<bool> {
        let mut has_sent = false;
        while let Some((channel, message)) = self.peer.outbox.pop() {
            self.put(channel, &message)?;
            has_sent = true;
        }
        let seats: Vec<(u32, Arc<Seat>)> = lock(&self.peer.seats).clone();
        let mut is_one_done = false;
        for (channel, seat) in seats {
            if let Some(message) = seat.next(self.limits.consumer_queue) {
                self.put(channel, &message)?;
                has_sent = true;
            }
            is_one_done |= seat.is_done();
        }
        if is_one_done {
            lock(&self.peer.seats).retain(|(_, seat)| !seat.is_done());
        }
        Ok(has_sent)
    }

    /// Asks a peer that was not heard for half of its time, however much it is sent: it may have nothing else to say.
    fn ask_if_silent(&mut self) -> io::Result<()> {
        let patience = self.limits.timeout / 2;
        if self.peer.silence() < patience || self.asked.elapsed() < patience / 2 {
            return Ok(());
        }
        self.ask()
    }

    fn ask(&mut self) -> io::Result<()> {
        self.asked = Instant::now();
        encoded(wire::Ping { token: 0 }).map_or(Ok(()), |ping| self.put(0, &ping))
    }

    /// Heartbeats where nothing was sent for a while, and a ping if nothing was sent at all.
    fn show_life(&mut self, patience: Duration) -> io::Result<()> {
        let seats: Vec<(u32, Arc<Seat>)> = lock(&self.peer.seats).clone();
        for (channel, seat) in seats {
            if let Some(heartbeat) = seat.heartbeat(self.limits.heartbeat) {
                self.put(channel, &heartbeat)?;
            }
        }
        if self.last.elapsed() >= patience {
            self.ask()?;
        }
        self.flush()
    }

    fn put(&mut self, channel: u32, message: &wire::Shared) -> io::Result<()> {
        self.last = Instant::now();
        self.buffer.extend(wire::header(self.peer.version(), message.kind, channel, message.length));
        if message.bytes.len() > TOGETHER {
            self.flush()?;
            return self.peer.socket.write(&message.bytes, self.limits.timeout);
        }
        self.buffer.extend_from_slice(&message.bytes);
        if self.buffer.len() > TOGETHER { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.peer.socket.write(&self.buffer, self.limits.timeout)?;
        self.buffer.clear();
        Ok(())
    }
}
