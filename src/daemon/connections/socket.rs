//! A connected socket of any kind.
//!
//! In: a Unix or TCP stream, or a [`Transport`]. Out: reads and writes through a shared reference, so that one thread
//! reads while another writes.
//!
//! Invariants: no read and no write waits longer than it is told to.
//!
//! Must not know: the protocol.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use crate::daemon::locks::before_waiting;

/// A connected socket.
#[derive(Debug)]
pub enum Socket {
    /// On this machine.
    Unix(UnixStream),
    /// From anywhere.
    Tcp(TcpStream),
    /// Within another protocol, for peers that only read.
    Tunnel(Box<dyn Transport>),
}

/// Carries the bytes of our protocol within another one. One thread reads, another writes.
pub trait Transport: fmt::Debug + Send + Sync {
    /// As [`Socket::read`], but gives the number of bytes: 0 at the end. Of kind `InvalidData`, if what came cannot be
    /// carried bytes.
    fn read(&self, buffer: &mut [u8], patience: Duration) -> io::Result<Option<usize>>;
    /// As [`Socket::write`]. Without bytes, writes what the transport itself has pending.
    fn write(&self, bytes: &[u8], patience: Duration) -> io::Result<()>;
    /// Whether the transport has bytes of its own to write.
    fn has_pending(&self) -> bool;
    /// Writes the end of the transport, which names the daemon's end as its reason if it is that.
    fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()>;
    /// As [`Socket::shutdown`].
    fn shutdown(&self, how: Shutdown);
}

impl Socket {
    /// Reads what is there, and waits at most as long as `patience`. None if nothing came; an empty slice at the end.
    pub fn read<'a>(&self, buffer: &'a mut [u8], patience: Duration) -> io::Result<Option<&'a [u8]>> {
        before_waiting("a peer's bytes");
        let read = match self {
            Self::Unix(stream) => {
                stream.set_read_timeout(Some(patience))?;
                (&*stream).read(buffer)
            }
            Self::Tcp(stream) => {
                stream.set_read_timeout(Some(patience))?;
                (&*stream).read(buffer)
            }
            Self::Tunnel(transport) => {
                let length = transport.read(buffer, patience)?;
                return Ok(length.map(|length| &buffer[..length]));
            }
        };
        match read {
            Ok(length) => Ok(Some(&buffer[..length])),
            Err(error) if is_timeout(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes everything, or fails after `patience`.
    pub fn write(&self, mut bytes: &[u8], patience: Duration) -> io::Result<()> {
        before_waiting("a peer to read");
        if let Self::Tunnel(transport) = self {
            return transport.write(bytes, patience);
        }
        let deadline = Instant::now() + patience;
        while !bytes.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::Error::new(io::ErrorKind::TimedOut, "the peer does not read"));
            }
            match self.write_some(bytes, left) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(length) => bytes = &bytes[length..],
                Err(error) if is_timeout(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn write_some(&self, bytes: &[u8], patience: Duration) -> io::Result<usize> {
        match self {
            Self::Unix(stream) => {
                stream.set_write_timeout(Some(patience))?;
                (&*stream).write(bytes)
            }
            Self::Tcp(stream) => {
                stream.set_write_timeout(Some(patience))?;
                (&*stream).write(bytes)
            }
            Self::Tunnel(transport) => transport.write(bytes, patience).map(|()| bytes.len()),
        }
    }

    /// Whether the peer may only read.
    pub fn is_read_only(&self) -> bool {
        matches!(self, Self::Tunnel(_))
    }

    /// Whether the transport has bytes of its own to write: writing nothing writes them.
    pub fn has_pending(&self) -> bool {
        matches!(self, Self::Tunnel(transport) if transport.has_pending())
    }

    /// Writes the end of the transport, if it has one.
    pub fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()> {
        match self {
            Self::Tunnel(transport) => transport.finish(is_daemons_end, patience),
            _ => Ok(()),
        }
    }

    /// Ends one or both directions, and wakes the threads that wait there.
    pub fn shutdown(&self, how: Shutdown) {
        // A connection that is gone already has nothing to end.
        let _ = match self {
            Self::Unix(stream) => stream.shutdown(how),
            Self::Tcp(stream) => stream.shutdown(how),
            Self::Tunnel(transport) => {
                transport.shutdown(how);
                Ok(())
            }
        };
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}
