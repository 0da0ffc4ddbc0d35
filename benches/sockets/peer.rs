//! A minimal peer of a daemon: a socket, a decoder, messages.
//!
//! In: the path of a socket. Out: whole messages. Invariants: pings are answered. An error from the daemon is an error
//! here.

use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, bail};
use hopes_protocol::{
    Banner, Cut, Decoder, DotsWanted, Hello, LARGEST_FRAME, Message, Pong, Resume, Simplify, Subscribe, VERSION, View,
    encode,
};

/// A connection.
pub struct Peer {
    stream: UnixStream,
    decoder: Decoder,
    buffer: Vec<u8>,
    /// Bytes received so far.
    pub received: u64,
}

impl Peer {
    /// Connects and does the handshake.
    pub fn connect(socket: &Path) -> anyhow::Result<Self> {
        let stream = UnixStream::connect(socket).context("cannot connect")?;
        stream.set_read_timeout(Some(Duration::from_secs(60)))?;
        let mut peer = Self { stream, decoder: Decoder::new(LARGEST_FRAME), buffer: vec![0; 1 << 16], received: 0 };
        peer.stream.write_all(&Banner::OURS.encode())?;
        peer.send(0, Hello { software: "sockets".to_owned(), capabilities: Vec::new() })?;
        while peer.decoder.banner()?.is_none() {
            peer.fill()?;
        }
        match peer.receive()? {
            (0, Message::Welcome(_)) => Ok(peer),
            (_, other) => bail!("instead of Welcome came {other:?}"),
        }
    }

    /// Sends a message.
    pub fn send(&mut self, channel: u32, message: impl Into<Message>) -> anyhow::Result<()> {
        Ok(self.stream.write_all(&encode(VERSION, channel, &message.into())?)?)
    }

    /// Waits for the next message.
    pub fn receive(&mut self) -> anyhow::Result<(u32, Message)> {
        loop {
            if let Some(frame) = self.decoder.frame()? {
                match frame.message()? {
                    Message::Ping(ping) => self.send(0, Pong { token: ping.token })?,
                    Message::Error(report) => bail!("the daemon says: {}", report.text),
                    message => return Ok((frame.channel, message)),
                }
            } else {
                self.fill()?;
            }
        }
    }

    /// A clone of the socket for another thread.
    pub fn split(&self) -> anyhow::Result<UnixStream> {
        Ok(self.stream.try_clone()?)
    }

    /// The socket, to wait for.
    pub fn socket(&self) -> BorrowedFd<'_> {
        self.stream.as_fd()
    }

    /// Does not wait from now on, when it reads or writes.
    pub fn set_nonblocking(&self) -> anyhow::Result<()> {
        Ok(self.stream.set_nonblocking(true)?)
    }

    /// Reads what is there.
    pub fn read_now(&mut self) -> anyhow::Result<()> {
        let length = self.length_now()?;
        self.decoder.push(&self.buffer[..length]);
        Ok(())
    }

    /// Reads what is there, and forgets it.
    pub fn discard_now(&mut self) -> anyhow::Result<()> {
        self.length_now().map(drop)
    }

    /// The next message that was read.
    pub fn next_now(&mut self) -> anyhow::Result<Option<Message>> {
        Ok(self.decoder.frame()?.map(|frame| frame.message()).transpose()?)
    }

    /// Writes what the socket takes. Returns how much that is.
    pub fn write_now(&mut self, bytes: &[u8]) -> anyhow::Result<usize> {
        match self.stream.write(bytes) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            written => Ok(written?),
        }
    }

    fn length_now(&mut self) -> anyhow::Result<usize> {
        match self.stream.read(&mut self.buffer) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            Ok(0) => bail!("the daemon has hung up"),
            read => Ok(read?),
        }
    }

    fn fill(&mut self) -> anyhow::Result<()> {
        let length = loop {
            match self.stream.read(&mut self.buffer) {
                // After a stopped process continues, its reads are interrupted.
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        anyhow::ensure!(length > 0, "the daemon has hung up");
        self.received += length as u64;
        self.decoder.push(&self.buffer[..length]);
        Ok(())
    }
}

/// The message that subscribes to one stream.
pub fn subscribe(stream: &str, cut: Cut, simplify: Simplify, resume: Option<Resume>) -> Subscribe {
    Subscribe { pattern: stream.to_owned(), view: View { cut, simplify }, dots: DotsWanted::No, resume }
}
