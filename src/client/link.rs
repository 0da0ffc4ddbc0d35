//! The sending half of a connection, and what both halves share.
//!
//! In: messages.
//! Out: their bytes, in whole frames, one after the other.
//! Invariants: the receiving half never waits for the sending half. It leaves its pings and pongs to the sender if
//! that one is writing or the socket takes no bytes; else both sides of a connection could wait for each other for
//! ever. A sender that gets no byte through fails once the daemon has been silent for too long.
//! Must not know: what messages mean.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::net::Shutdown;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use hopes_protocol::{Message, encode};
use socket2::Socket;

use super::error::ClientError;
use super::running::Running;
use crate::daemon::Address;

/// Pings and pongs that may wait to be sent. Of more, the oldest are dropped, which only a daemon that sends pings
/// without end will notice.
const CONTROL: usize = 64;

/// A connection as its two halves see it.
#[derive(Debug)]
pub struct Link {
    pub address: Address,
    version: u16,
    /// How long the daemon may be silent.
    pub timeout: Duration,
    /// Since the beginning.
    running: Running,
    /// When bytes of the daemon last came, in milliseconds of running.
    received: AtomicU64,
    is_closed: AtomicBool,
    outgoing: Mutex<Outgoing>,
    control: Mutex<VecDeque<Message>>,
}

#[derive(Debug)]
struct Outgoing {
    /// Its writes give up after a while, so that it can be seen whether the daemon is still there.
    socket: Socket,
    /// Frames that are not written yet; the first may have begun.
    backlog: Vec<u8>,
}

impl Link {
    pub fn new(address: Address, version: u16, timeout: Duration, socket: Socket) -> Self {
        Self {
            address,
            version,
            timeout,
            running: Running::new(),
            received: AtomicU64::new(0),
            is_closed: AtomicBool::new(false),
            outgoing: Mutex::new(Outgoing { socket, backlog: Vec::new() }),
            control: Mutex::default(),
        }
    }

    /// Sends a message, and pings and pongs that wait, unless that takes too long. Whether it was sent.
    pub fn send(
        &self,
        channel: u32,
        message: &Message,
        is_too_long: &mut dyn FnMut() -> bool,
    ) -> Result<bool, ClientError> {
        if message.since() > self.version {
            let (spoken, needed) = (self.version, message.since());
            return Err(ClientError::Older { address: self.address.clone(), spoken, needed });
        }
        let frame = self.frame(channel, message)?;
        let mut outgoing = self.outgoing.lock().unwrap_or_else(PoisonError::into_inner);
        outgoing.backlog.extend(frame);
        while !outgoing.backlog.is_empty() {
            self.write_some(&mut outgoing)?;
            self.check_alive()?;
            if !outgoing.backlog.is_empty() && is_too_long() {
                return Ok(false);
            }
        }
        self.write_control(&mut outgoing).map(|()| true)
    }

    /// Sends a ping or a pong if that needs no waiting for the other half; else leaves it to that.
    pub fn send_control(&self, message: Message) -> Result<(), ClientError> {
        let mut control = self.control();
        if control.len() == CONTROL {
            control.pop_front();
        }
        control.push_back(message);
        drop(control);
        self.write_control_if_free()
    }

    /// Sends pings and pongs that wait, as [`send_control`](Self::send_control) does.
    pub fn write_control_if_free(&self) -> Result<(), ClientError> {
        let mut outgoing = match self.outgoing.try_lock() {
            Ok(outgoing) => outgoing,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Ok(()),
        };
        self.write_control(&mut outgoing)
    }

    /// Bytes of the daemon have come.
    pub fn note_received(&self) {
        self.received.store(self.running.elapsed().as_millis() as u64, Relaxed);
    }

    /// How long none have come, while this program could have heard it.
    pub fn silence(&self) -> Duration {
        self.running.elapsed().saturating_sub(Duration::from_millis(self.received.load(Relaxed)))
    }

    /// Why the connection ended, if this program has just stood still for so long that the daemon gave it up.
    pub fn stood_still(&self) -> Option<ClientError> {
        let now = self.running.elapsed();
        let last = self.running.standstill()?;
        // The daemon had last heard something up to half of its timeout before.
        let is_why = last.length >= self.timeout / 2 && now.saturating_sub(last.ended) <= self.timeout;
        let (stopped, timeout) = (last.length.as_secs_f64(), self.timeout.as_secs_f64());
        is_why.then(|| ClientError::StoodStill { address: self.address.clone(), stopped, timeout })
    }

    /// Nothing more can come: the sending half need not wait.
    pub fn close(&self) {
        self.is_closed.store(true, Relaxed);
    }

    /// Says that nothing more will be sent.
    pub fn finish(&self) {
        let outgoing = self.outgoing.lock().unwrap_or_else(PoisonError::into_inner);
        // A connection that is gone cannot be shut down, and need not be.
        drop(outgoing.socket.shutdown(Shutdown::Write));
    }

    /// # Errors
    /// [`ClientError::Silent`], and [`ClientError::Closed`] after [`close`](Self::close).
    pub fn check_alive(&self) -> Result<(), ClientError> {
        let address = || self.address.clone();
        if self.is_closed.load(Relaxed) {
            return Err(ClientError::Closed { address: address(), when: "while something was being sent" });
        }
        match self.silence() {
            silence if silence > self.timeout => {
                Err(ClientError::Silent { address: address(), seconds: self.timeout.as_secs_f64() })
            }
            _ => Ok(()),
        }
    }

    fn write_control(&self, outgoing: &mut Outgoing) -> Result<(), ClientError> {
        // Only if all before was written: both pings and pongs that wait and the backlog are bounded then.
        if outgoing.backlog.is_empty() {
            for message in self.control().drain(..) {
                outgoing.backlog.extend(self.frame(0, &message)?);
            }
        }
        if outgoing.backlog.is_empty() { Ok(()) } else { self.write_some(outgoing) }
    }

    /// Writes what goes through within a moment.
    fn write_some(&self, outgoing: &mut Outgoing) -> Result<(), ClientError> {
        match (&outgoing.socket).write(&outgoing.backlog) {
            Ok(0) => Err(ClientError::lost(&self.address, &io::ErrorKind::WriteZero.into())),
            Ok(written) => {
                outgoing.backlog.drain(..written);
                Ok(())
            }
            Err(error) if is_later(&error) => Ok(()),
            Err(error) => Err(self.stood_still().unwrap_or_else(|| ClientError::lost(&self.address, &error))),
        }
    }

    fn frame(&self, channel: u32, message: &Message) -> Result<Vec<u8>, ClientError> {
        encode(self.version, channel, message)
            .map_err(|source| ClientError::TooLong { address: self.address.clone(), source })
    }

    fn control(&self) -> MutexGuard<'_, VecDeque<Message>> {
        self.control.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Nothing went through yet, but may.
pub fn is_later(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}
