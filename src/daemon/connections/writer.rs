//! The writer thread of a connection: replies and frames to the socket.
//!
//! In: the outbox and the cursors of the connection, wake-ups. Out: bytes.
//!
//! Invariants: replies go before frames; cursors take turns; small messages are sent together. A peer that takes longer
//! than the timeout for what it is sent is disconnected. Goodbye is the last message.
//!
//! Must not know: what messages say.

use std::io;
use std::net::Shutdown;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_channel::Receiver;
use hopes_protocol as wire;

use super::connection::Connection;
use crate::daemon::encoding::{Encoded, encoded};
use crate::daemon::locks::before_waiting;
use crate::daemon::memory::Charge;
use crate::daemon::settings::Limits;
use crate::daemon::streams::publishing::cursor::Cursor;

/// Messages are collected up to so many bytes before they are sent.
const TOGETHER: usize = 1 << 16;

/// How long the closing of a transport may take.
const LAST_WORD: Duration = Duration::from_secs(1);

/// Sends until goodbye was sent or the connection has ended.
pub fn run(connection: &Connection, wakes: &Receiver<()>, limits: &Limits) {
    let now = Instant::now();
    let held = connection.consumer.account.charge(0);
    let mut writer = Writer { connection, limits, buffer: Vec::new(), held, last: now, pinged: now };
    let finish = |()| connection.socket.finish(connection.is_ending(), LAST_WORD);
    if let Err(error) = writer.write_banner().and_then(|()| writer.run(wakes)).and_then(finish) {
        tracing::debug!("{}: cannot send: {error}", connection.label);
        // What a peer that has gone sent before is still taken; of one that does not read, nothing more is.
        if error.kind() == io::ErrorKind::TimedOut {
            connection.set_cut_off();
        }
    }
    if connection.outbox.is_overrun() {
        connection.set_cut_off();
    }
    connection.outbox.close();
    connection.socket.shutdown(Shutdown::Both);
}

struct Writer<'a> {
    connection: &'a Connection,
    limits: &'a Limits,
    buffer: Vec<u8>,
    /// What the buffer takes.
    held: Charge,
    /// When something was sent last.
    last: Instant,
    /// When it was pinged last.
    pinged: Instant,
}

impl Writer<'_> {
    fn run(&mut self, wakes: &Receiver<()>) -> io::Result<()> {
        // The peer pings when it receives nothing for half of the timeout; a heartbeat comes before.
        let patience = self.limits.heartbeat.min(self.limits.timeout / 4);
        loop {
            if self.connection.is_incompatible() {
                return Ok(());
            }
            while self.round()? {
                self.ping_if_silent()?;
            }
            self.ping_if_silent()?;
            self.flush()?;
            if let Some(goodbye) = self.connection.take_goodbye() {
                // Messages may have come between the last round and the goodbye.
                while self.round()? {}
                self.put(0, &goodbye)?;
                return self.flush();
            }
            before_waiting("something to send");
            if wakes.recv_timeout(patience / 2).is_err() {
                self.send_heartbeats(patience)?;
            }
        }
    }

    fn write_banner(&mut self) -> io::Result<()> {
        self.connection.socket.write(&wire::Banner::OURS.encode(), self.limits.timeout)
    }

    /// Sends all replies and one message of each cursor; whether there was anything.
    fn round(&mut self) -> io::Result<bool> {
        let mut has_sent = false;
        while let Some((channel, message)) = self.connection.outbox.pop() {
            self.put(channel, &message)?;
            has_sent = true;
        }
        let cursors: Vec<(u32, Arc<Cursor>)> = self.connection.cursors.lock().clone();
        let mut is_one_done = false;
        for (channel, cursor) in cursors {
            if let Some(message) = cursor.next(self.limits.consumer_queue) {
                self.put(channel, &message)?;
                has_sent = true;
            }
            is_one_done |= cursor.is_done();
        }
        if is_one_done {
            self.connection.cursors.lock().retain(|(_, cursor)| !cursor.is_done());
        }
        Ok(has_sent)
    }

    /// Pings a peer that has sent nothing for half of the timeout: one that only receives has nothing else to send.
    fn ping_if_silent(&mut self) -> io::Result<()> {
        let patience = self.limits.timeout / 2;
        if self.connection.silence() < patience || self.pinged.elapsed() < patience / 2 {
            return Ok(());
        }
        self.ping()
    }

    fn ping(&mut self) -> io::Result<()> {
        self.pinged = Instant::now();
        encoded(wire::Ping { token: 0 }, &self.connection.consumer.account).map_or(Ok(()), |ping| self.put(0, &ping))
    }

    /// Sends heartbeats on channels where nothing was sent for a while, and a ping if nothing was sent at all.
    fn send_heartbeats(&mut self, patience: Duration) -> io::Result<()> {
        let cursors: Vec<(u32, Arc<Cursor>)> = self.connection.cursors.lock().clone();
        for (channel, cursor) in cursors {
            if let Some(heartbeat) = cursor.heartbeat(self.limits.heartbeat) {
                self.put(channel, &heartbeat)?;
            }
        }
        if self.last.elapsed() >= patience {
            self.ping()?;
        }
        self.flush()
    }

    fn put(&mut self, channel: u32, message: &Encoded) -> io::Result<()> {
        self.last = Instant::now();
        self.buffer.extend(wire::header(self.connection.version(), message.kind, channel, message.length));
        if message.bytes.len() > TOGETHER {
            self.flush()?;
            self.count(message.bytes.len());
            let _share = self.connection.consumer.share(message.bytes());
            return self.connection.socket.write(&message.bytes, self.limits.timeout);
        }
        self.buffer.extend_from_slice(&message.bytes);
        if self.buffer.len() > TOGETHER { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.count(self.buffer.len());
        self.held.set(self.buffer.capacity() as u64);
        self.connection.socket.write(&self.buffer, self.limits.timeout)?;
        self.buffer.clear();
        Ok(())
    }

    fn count(&self, bytes: usize) {
        self.connection.counts.sent.fetch_add(bytes as u64, Ordering::Relaxed);
    }
}
