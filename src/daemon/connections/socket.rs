//! A connected socket of any kind.
//!
//! In: a Unix or TCP stream, or a [`Transport`] of bytes. Out: reads and writes through a shared reference, so that one thread reads while another writes. Must not know: the protocol.

use std::fmt;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// A connection.
#[derive(Debug)]
pub enum Socket {
    /// On this machine.
    Unix(UnixStream),
    /// From anywhere.
    Tcp(TcpStream),
    /// In something else, for those who only read.
    Tunnel(Box<dyn Transport>),
}

/// What carries the protocol's bytes within a protocol of its own. One thread reads, another writes.
pub trait Transport: fmt::Debug + Send + Sync {
    /// As [`Socket::read`], but gives the number of bytes: 0 at the end. Of kind `InvalidData`, if what came cannot be carried bytes.
    fn read(&self, buffer: &mut [u8], patience: Duration) -> io::Result<Option<usize>>;
    /// As [`Socket::write`]. Of no bytes, writes what the transport itself has to say.
    fn write(&self, bytes: &[u8], patience: Duration) -> io::Result<()>;
    /// Whether the transport itself has something to say.
    fn has_to_say(&self) -> bool;
    /// Says that nothing more comes, and whether that is because the daemon ends.
    fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()>;
    /// As [`Socket::shutdown`].
    fn shutdown(&self, how: Shutdown);
}

impl Socket {
    /// Reads what is there; waits for so long at the most. Nothing, if nothing came; an empty slice at the end.
    pub fn read<'a>(&self, buffer: &'a mut [u8], patience: Duration) -> io::Result<Option<&'a [u8]>> {
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

    /// Writes everything within so long.
    pub fn write(&self, mut bytes: &[u8], patience: Duration) -> io::Result<()> {
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

    /// Whether those at the other end may only read.
    pub fn is_for_readers(&self) -> bool {
        matches!(self, Self::Tunnel(_))
    }

    /// Whether there is something to be written that nobody has given: writing nothing writes it.
    pub fn has_to_say(&self) -> bool {
        matches!(self, Self::Tunnel(transport) if transport.has_to_say())
    }

    /// Says that nothing more comes, where that is said at all.
    pub fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()> {
        match self {
            Self::Tunnel(transport) => transport.finish(is_daemons_end, patience),
            _ => Ok(()),
        }
    }

    /// Ends one or both directions; whoever waits there is woken.
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
