//! A client of a daemon: one connection, from the banner to the end, over a Unix socket or TCP.
//!
//! In: an address; messages to send.
//! Out: messages received. Two halves, so that one thread can send while another one receives.
//! Invariants: nothing waits for ever: connecting, greeting, receiving and sending fail when the daemon is silent
//! for too long. Pings are answered here, and sent when the daemon is silent. A frame has at most [`LARGEST_FRAME`]
//! bytes, and memory grows only with bytes that have come.
//! Must not know: what the messages are about.

use std::io::{self, Read, Write};
use std::net::ToSocketAddrs;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hopes_protocol::{
    Banner, Decoder, ErrorCode, FrameError, Goodbye, Hello, LARGEST_FRAME, Message, Ping, Pong, Welcome,
};
use socket2::{Domain, SockAddr, Socket, Type};

use super::error::ClientError;
use super::link::{Link, is_later};
use super::running::Running;
use crate::daemon::Address;
pub use crate::daemon::SOFTWARE;

/// How long a read or write waits before other duties are looked at.
const MOMENT: Duration = Duration::from_millis(50);

/// No daemon is given less time than this, whatever it announces.
const LEAST_TIMEOUT: Duration = Duration::from_millis(200);

/// How long the daemon's last bytes are waited for after a goodbye.
const PARTING: Duration = Duration::from_millis(300);

/// How long the beginning may take.
#[derive(Clone, Copy, Debug)]
pub struct Timeouts {
    /// Until the connection is there.
    pub connect: Duration,
    /// From there to the daemon's `Welcome`.
    pub greet: Duration,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self { connect: Duration::from_secs(10), greet: Duration::from_secs(10) }
    }
}

/// A connection after the greeting.
#[derive(Debug)]
pub struct Client {
    /// The daemon's answer to the greeting.
    pub welcome: Welcome,
    /// Sends.
    pub sending: Sending,
    /// Receives.
    pub receiving: Receiving,
}

/// The half that sends. Clones send on the same connection.
#[derive(Clone, Debug)]
pub struct Sending(Arc<Link>);

/// The half that receives; it also pings and answers pings.
#[derive(Debug)]
pub struct Receiving {
    link: Arc<Link>,
    incoming: Incoming,
    /// Whether a ping was sent since bytes of the daemon last came.
    has_pinged: bool,
    pings: u64,
}

/// The outcome of waiting.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "one at a time, and never kept")]
pub enum Received {
    /// A message, on a channel.
    Message(u32, Message),
    /// Nothing until the deadline.
    Nothing,
    /// The daemon has closed the connection between two frames.
    End,
}

/// Bytes on their way in.
#[derive(Debug)]
struct Incoming {
    socket: Socket,
    decoder: Decoder,
    buffer: Box<[u8]>,
}

enum Arrived {
    Bytes,
    Nothing,
    End,
}

impl Client {
    /// Connects and greets.
    ///
    /// # Errors
    /// [`ClientError`], within the timeouts.
    pub fn connect(address: &Address, software: &str, timeouts: Timeouts) -> Result<Self, ClientError> {
        let unreached = |error: io::Error| ClientError::Connect { address: address.clone(), reason: error.to_string() };
        let socket = connect(address, timeouts.connect).map_err(unreached)?;
        let sent = socket.try_clone().map_err(unreached)?;
        socket.set_read_timeout(Some(MOMENT)).map_err(unreached)?;
        socket.set_write_timeout(Some(timeouts.greet)).map_err(unreached)?;
        let incoming = Incoming { socket, decoder: Decoder::new(LARGEST_FRAME), buffer: vec![0; 1 << 16].into() };
        let mut greeting = Greeting { address, incoming, running: Running::new(), timeout: timeouts.greet };
        let version = greeting.agree()?;
        let welcome = greeting.hello(version, software)?;
        let incoming = greeting.incoming;
        incoming.socket.set_write_timeout(Some(MOMENT)).map_err(unreached)?;
        let timeout = Duration::from_millis(welcome.timeout_ms.into()).max(LEAST_TIMEOUT);
        let link = Arc::new(Link::new(address.clone(), version, timeout, sent));
        let receiving = Receiving { link: Arc::clone(&link), incoming, has_pinged: false, pings: 0 };
        Ok(Self { welcome, sending: Sending(link), receiving })
    }
}

fn connect(address: &Address, timeout: Duration) -> io::Result<Socket> {
    let place = match address {
        Address::Unix(path) => return connect_to(&SockAddr::unix(path)?, Domain::UNIX, timeout),
        Address::Tcp(host) => host,
    };
    let mut failure = io::Error::other("the host has no address");
    for place in place.to_socket_addrs()? {
        match connect_to(&place.into(), Domain::for_address(place), timeout) {
            Ok(socket) => {
                socket.set_tcp_nodelay(true)?;
                return Ok(socket);
            }
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

fn connect_to(place: &SockAddr, domain: Domain, timeout: Duration) -> io::Result<Socket> {
    let socket = Socket::new(domain, Type::STREAM, None)?;
    socket.connect_timeout(place, timeout)?;
    Ok(socket)
}

/// A connection before the end of the greeting.
struct Greeting<'a> {
    address: &'a Address,
    incoming: Incoming,
    /// Since the connection was there.
    running: Running,
    timeout: Duration,
}

impl Greeting<'_> {
    /// The version that both sides speak.
    fn agree(&mut self) -> Result<u16, ClientError> {
        self.write(&Banner::OURS.encode())?;
        let theirs = loop {
            let banner = self.incoming.decoder.banner();
            match banner.map_err(|reason| ClientError::NotHopes { address: self.address.clone(), reason })? {
                Some(banner) => break banner,
                None => self.read()?,
            }
        };
        let agreed = Banner::OURS.agree(theirs);
        agreed.map_err(|source| ClientError::Versions { address: self.address.clone(), source })
    }

    fn hello(&mut self, version: u16, software: &str) -> Result<Welcome, ClientError> {
        let address = || self.address.clone();
        let hello = Message::Hello(Hello { software: software.to_owned(), capabilities: Vec::new() });
        let hello = hopes_protocol::encode(version, 0, &hello);
        let hello = hello.map_err(|source| ClientError::TooLong { address: address(), source })?;
        // A daemon without room may have said so and be gone: then that reason is reported.
        let mut unsent = self.write(&hello).err();
        loop {
            match self.incoming.message(self.address)? {
                None => self.read().map_err(|closed| unsent.take().unwrap_or(closed))?,
                Some((_, Message::Welcome(welcome))) => {
                    // A daemon's messages before its Welcome, such as that it has no room, may be of its lowest
                    // version.
                    self.incoming.decoder.set_version(version);
                    return Ok(welcome);
                }
                Some((_, Message::Error(report))) => {
                    return Err(ClientError::Rejected { address: self.address.clone(), reason: report.text });
                }
                Some((_, Message::Goodbye(goodbye))) => {
                    return Err(ClientError::Rejected { address: self.address.clone(), reason: goodbye.reason });
                }
                Some(_) => {
                    let reason = FrameError::Malformed("it answers Hello with something else than Welcome");
                    return Err(ClientError::NotHopes { address: self.address.clone(), reason });
                }
            }
        }
    }

    fn write(&self, bytes: &[u8]) -> Result<(), ClientError> {
        (&self.incoming.socket).write_all(bytes).map_err(|error| ClientError::lost(self.address, &error))
    }

    fn read(&mut self) -> Result<(), ClientError> {
        let address = || self.address.clone();
        match self.incoming.read(self.address)? {
            Arrived::End => Err(ClientError::Closed { address: address(), when: "before it had greeted" }),
            _ if self.running.elapsed() > self.timeout => {
                Err(ClientError::Mute { address: address(), seconds: self.timeout.as_secs_f64() })
            }
            _ => Ok(()),
        }
    }
}

impl Incoming {
    /// Reads what there is, or waits for a moment.
    fn read(&mut self, address: &Address) -> Result<Arrived, ClientError> {
        match (&self.socket).read(&mut self.buffer) {
            Ok(0) if self.decoder.is_within_frame() => {
                Err(ClientError::Closed { address: address.clone(), when: "within a message" })
            }
            Ok(0) => Ok(Arrived::End),
            Ok(count) => {
                self.decoder.push(&self.buffer[..count]);
                Ok(Arrived::Bytes)
            }
            Err(error) if is_later(&error) => Ok(Arrived::Nothing),
            Err(error) => Err(ClientError::lost(address, &error)),
        }
    }

    fn message(&mut self, address: &Address) -> Result<Option<(u32, Message)>, ClientError> {
        let address = || address.clone();
        let frame = self.decoder.frame().map_err(|source| ClientError::Frame { address: address(), source })?;
        let Some(frame) = frame else { return Ok(None) };
        let message = frame.message().map_err(|source| ClientError::Body { address: address(), source })?;
        Ok(Some((frame.channel, message)))
    }
}

impl Sending {
    /// Sends a message; waits while the daemon is busy.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn send(&self, channel: u32, message: impl Into<Message>) -> Result<(), ClientError> {
        self.send_unless(channel, message, &mut || false).map(drop)
    }

    /// As [`send`](Self::send), but not beyond what takes too long; the rest of a message that has begun goes before
    /// the next one. Whether it was sent.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn send_unless(
        &self,
        channel: u32,
        message: impl Into<Message>,
        is_too_long: &mut dyn FnMut() -> bool,
    ) -> Result<bool, ClientError> {
        self.0.send(channel, &message.into(), is_too_long)
    }
}

impl Receiving {
    /// The next message, pings aside; none once the daemon has ended the connection in good order.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn receive(&mut self) -> Result<Option<(u32, Message)>, ClientError> {
        loop {
            match self.receive_until(Instant::now() + self.link.timeout)? {
                Received::Message(channel, message) => return Ok(Some((channel, message))),
                Received::Nothing => {}
                Received::End => return Ok(None),
            }
        }
    }

    /// As [`receive`](Self::receive), but waits no longer than that.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn receive_until(&mut self, deadline: Instant) -> Result<Received, ClientError> {
        let received = match self.wait(deadline) {
            Ok(Received::End) => self.link.stood_still().map_or(Ok(Received::End), Err),
            Err(error @ (ClientError::Closed { .. } | ClientError::Lost { .. })) => {
                Err(self.link.stood_still().unwrap_or(error))
            }
            received => received,
        };
        if matches!(received, Err(_) | Ok(Received::End)) {
            self.link.close();
        }
        received
    }

    fn wait(&mut self, deadline: Instant) -> Result<Received, ClientError> {
        loop {
            while let Some((channel, message)) = self.incoming.message(&self.link.address)? {
                match message {
                    Message::Ping(Ping { token }) => self.send_control(Pong { token }),
                    Message::Pong(_) => {}
                    Message::Error(report) if report.code == ErrorCode::TooSlow as u16 => {
                        let received = Received::Message(channel, report.into());
                        return self.link.stood_still().map_or(Ok(received), Err);
                    }
                    message => return Ok(Received::Message(channel, message)),
                }
            }
            if Instant::now() >= deadline {
                return Ok(Received::Nothing);
            }
            match self.incoming.read(&self.link.address)? {
                Arrived::End => return Ok(Received::End),
                Arrived::Bytes => {
                    self.link.note_received();
                    self.has_pinged = false;
                }
                Arrived::Nothing => self.check_alive()?,
            }
            // If this fails, so will the next read.
            drop(self.link.write_control_if_free());
        }
    }

    /// If this cannot be sent, the connection is lost. That is reported by the next read, after all messages that the
    /// daemon has sent before.
    fn send_control(&self, message: impl Into<Message>) {
        drop(self.link.send_control(message.into()));
    }

    fn check_alive(&mut self) -> Result<(), ClientError> {
        self.link.check_alive()?;
        if !self.has_pinged && self.link.silence() > self.link.timeout / 2 {
            self.has_pinged = true;
            self.pings += 1;
            self.send_control(Ping { token: self.pings });
        }
        Ok(())
    }

    /// Ends the connection in good order, if it still works: sends a goodbye, and waits a moment for the daemon to have
    /// read it, since closing a socket with unread bytes may discard what was sent.
    pub fn goodbye(mut self, reason: &str) {
        let goodbye = Goodbye { reason: reason.to_owned(), streams: Vec::new() };
        let begun = Instant::now();
        // A daemon that reads no further does not read this either.
        let sent = self.link.send(0, &goodbye.into(), &mut || begun.elapsed() > PARTING);
        if !matches!(sent, Ok(true)) {
            return;
        }
        self.link.finish();
        let begun = Instant::now();
        while begun.elapsed() < PARTING {
            match (&self.incoming.socket).read(&mut self.incoming.buffer) {
                Ok(1..) => {}
                Err(error) if is_later(&error) => {}
                Ok(0) | Err(_) => return,
            }
        }
    }
}
