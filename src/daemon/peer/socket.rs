//! A connected socket of either kind.
//!
//! In: a Unix or TCP stream. Out: reads and writes through a shared reference, so that one thread reads while another writes. Must not know: the protocol.

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
        };
        match read {
            Ok(length) => Ok(Some(&buffer[..length])),
            Err(error) if is_timeout(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes everything within so long.
    pub fn write(&self, mut bytes: &[u8], patience: Duration) -> io::Result<()> {
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
        }
    }

    /// Ends one or both directions; whoever waits there is woken.
    pub fn shutdown(&self, how: Shutdown) {
        // A connection that is gone already has nothing to end.
        let _ = match self {
            Self::Unix(stream) => stream.shutdown(how),
            Self::Tcp(stream) => stream.shutdown(how),
        };
    }
}

fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}
