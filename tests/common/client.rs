//! A client of a real daemon. It sends exactly what a test says, and returns each message that arrives.
//!
//! In: an address, messages, bytes. Out: messages.
//!
//! Invariants: every wait has a deadline. A message on a channel that the test does not read now is kept for later. The
//! client sends nothing by itself, except `Pong` where a test does not handle pings.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use hopes_protocol::{
    Banner, Decoder, Goodbye, Hello, LARGEST_FRAME, Message, Ping, Pong, Report, Status, StatusWanted, StreamInfo,
    Streams, VERSION, Welcome, encode,
};
use tungstenite::{ClientRequestBuilder, WebSocket};

/// The longest wait for a message of the daemon.
const TIMEOUT: Duration = Duration::from_secs(60);

/// The channel of questions about the daemon itself. No test uses it for other things.
const STATUS_CHANNEL: u32 = 0xA5C;

/// A connected socket of any kind.
pub enum Socket {
    Unix(UnixStream),
    Tcp(TcpStream),
    Web(Box<Web>),
}

impl Socket {
    /// Connects to `unix:PATH`, `tcp:HOST:PORT` or `ws:HOST:PORT`.
    pub fn connect(address: &str) -> io::Result<Self> {
        let socket = match address.split_once(':') {
            Some(("unix", path)) => Self::Unix(UnixStream::connect(path)?),
            Some(("tcp", host)) => Self::Tcp(TcpStream::connect(host)?),
            Some(("ws", host)) => Self::Web(Box::new(Web::connect(host)?)),
            _ => panic!("{address:?} is no address"),
        };
        socket.set_timeout(TIMEOUT)?;
        Ok(socket)
    }

    fn set_timeout(&self, timeout: Duration) -> io::Result<()> {
        let of_tcp = |stream: &TcpStream| {
            stream.set_read_timeout(Some(timeout)).and_then(|()| stream.set_write_timeout(Some(TIMEOUT)))
        };
        match self {
            Self::Unix(stream) => {
                stream.set_read_timeout(Some(timeout)).and_then(|()| stream.set_write_timeout(Some(TIMEOUT)))
            }
            Self::Tcp(stream) => of_tcp(stream),
            Self::Web(web) => of_tcp(&web.stream),
        }
    }

    fn set_write_timeout(&self, timeout: Duration) -> io::Result<()> {
        match self {
            Self::Unix(stream) => stream.set_write_timeout(Some(timeout)),
            Self::Tcp(stream) => stream.set_write_timeout(Some(timeout)),
            Self::Web(web) => web.stream.set_write_timeout(Some(timeout)),
        }
    }

    fn shutdown(&self, how: Shutdown) {
        // The other side may have closed already, which is no error here.
        let _ = match self {
            Self::Unix(stream) => stream.shutdown(how),
            Self::Tcp(stream) => stream.shutdown(how),
            Self::Web(web) => web.stream.shutdown(how),
        };
    }

    /// The same socket, for another thread.
    pub fn try_clone(&self) -> io::Result<Self> {
        match self {
            Self::Unix(stream) => stream.try_clone().map(Self::Unix),
            Self::Tcp(stream) => stream.try_clone().map(Self::Tcp),
            Self::Web(_) => Err(ErrorKind::Unsupported.into()),
        }
    }

    /// Writes without waiting. Returns the number of bytes that were accepted.
    pub fn write_nonblocking(&self, bytes: &[u8]) -> io::Result<usize> {
        let set = |is_nonblocking| match self {
            Self::Unix(stream) => stream.set_nonblocking(is_nonblocking),
            Self::Tcp(stream) => stream.set_nonblocking(is_nonblocking),
            Self::Web(_) => Err(ErrorKind::Unsupported.into()),
        };
        set(true)?;
        let written = match self {
            Self::Unix(stream) => (&*stream).write(bytes),
            Self::Tcp(stream) => (&*stream).write(bytes),
            Self::Web(_) => unreachable!("that was not set"),
        };
        set(false)?;
        match written {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(0),
            other => other,
        }
    }
}

impl Read for Socket {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Unix(stream) => stream.read(buffer),
            Self::Tcp(stream) => stream.read(buffer),
            Self::Web(web) => web.read(buffer),
        }
    }
}

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Unix(stream) => stream.write(bytes),
            Self::Tcp(stream) => stream.write(bytes),
            Self::Web(web) => web.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The protocol in a WebSocket, as a browser uses it. The library is not the daemon's own.
pub struct Web {
    /// The connection below.
    stream: TcpStream,
    pub socket: WebSocket<TcpStream>,
    /// Received bytes that are not read yet.
    rest: VecDeque<u8>,
    /// The code with which the daemon closed the WebSocket.
    pub closed: Option<u16>,
}

impl Web {
    /// Connects to `/ws` of the page at `HOST:PORT` with the headers that the page sends.
    fn connect(host: &str) -> io::Result<Self> {
        let stream = TcpStream::connect(host)?;
        stream.set_read_timeout(Some(TIMEOUT))?;
        let request = ClientRequestBuilder::new(format!("ws://{host}/ws").parse().unwrap())
            .with_header("Origin", format!("http://{host}"))
            .with_sub_protocol("hopes");
        let (socket, answer) =
            tungstenite::client(request, stream.try_clone()?).map_err(|error| io::Error::other(error.to_string()))?;
        assert_eq!(answer.headers()["sec-websocket-protocol"], "hopes");
        Ok(Self { stream, socket, rest: VecDeque::new(), closed: None })
    }
}

impl Read for Web {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.rest.is_empty() {
            match self.socket.read() {
                Ok(tungstenite::Message::Binary(bytes)) => self.rest.extend(bytes.iter()),
                Ok(tungstenite::Message::Close(reason)) => self.closed = reason.map(|reason| reason.code.into()),
                Ok(tungstenite::Message::Text(text)) => panic!("the daemon sends no text such as {text:?}"),
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) => return Err(error),
                // Closed, with or without a closing handshake.
                Err(_) => return Ok(0),
            }
        }
        self.rest.read(buffer)
    }
}

impl Write for Web {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.socket.send(tungstenite::Message::binary(bytes.to_vec())) {
            Ok(()) => Ok(bytes.len()),
            Err(tungstenite::Error::Io(error)) => Err(error),
            Err(error) => Err(io::Error::new(ErrorKind::BrokenPipe, error.to_string())),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A client.
pub struct Client {
    pub socket: Socket,
    decoder: Decoder,
    /// Messages on channels that the test has not read yet.
    aside: VecDeque<(u32, Message)>,
    token: u64,
}

impl Client {
    /// Connects and sends nothing.
    pub fn without_banner(address: &str) -> Self {
        let socket = Socket::connect(address).unwrap_or_else(|error| panic!("cannot connect to {address}: {error}"));
        Self { socket, decoder: Decoder::new(LARGEST_FRAME), aside: VecDeque::new(), token: 0 }
    }

    /// Connects and exchanges banners.
    pub fn new(address: &str) -> Self {
        let mut client = Self::without_banner(address);
        client.write(&Banner::OURS.encode());
        assert_eq!(client.banner(), Banner::OURS);
        client
    }

    /// Connects, exchanges banners, sends `Hello` and reads `Welcome`.
    pub fn with_hello(address: &str) -> Self {
        let mut client = Self::new(address);
        client.hello();
        client
    }

    /// The daemon's banner.
    pub fn banner(&mut self) -> Banner {
        loop {
            if let Some(banner) = self.decoder.banner().unwrap() {
                return banner;
            }
            assert!(self.read(), "the daemon is gone before it has said anything");
        }
    }

    /// The daemon's banner. None if the daemon closes the connection.
    pub fn try_banner(&mut self) -> Option<Banner> {
        loop {
            match self.decoder.banner() {
                Ok(Some(banner)) => return Some(banner),
                Ok(None) if self.read() => {}
                _ => return None,
            }
        }
    }

    /// Sets the version of the frames to read.
    pub fn set_version(&mut self, version: u16) {
        self.decoder.set_version(version);
    }

    /// Sends `Hello` and reads `Welcome`.
    pub fn hello(&mut self) -> Welcome {
        match self.ask(0, hello()) {
            Message::Welcome(welcome) => welcome,
            other => panic!("Welcome is due, not {}", brief(&other)),
        }
    }

    // ---- sending

    pub fn try_write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.socket.write_all(bytes)
    }

    /// Writes what is accepted within that time, if anything is. Returns false once the connection is broken.
    pub fn try_write_for(&mut self, bytes: &[u8], timeout: Duration) -> bool {
        self.socket.set_write_timeout(timeout).is_ok()
            && match self.socket.write(bytes) {
                Ok(_) => true,
                Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
            }
    }

    /// Writes until everything is written. Returns false if nothing is accepted for that long.
    pub fn writes_within(&mut self, bytes: &[u8], timeout: Duration) -> bool {
        self.socket.set_write_timeout(timeout).unwrap();
        self.socket.write_all(bytes).is_ok()
    }

    pub fn write(&mut self, bytes: &[u8]) {
        self.try_write(bytes).expect("the daemon reads");
    }

    pub fn send(&mut self, channel: u32, message: impl Into<Message>) {
        self.write(&bytes(channel, message));
    }

    /// Sends a message and returns the answer on the same channel.
    pub fn ask(&mut self, channel: u32, message: impl Into<Message>) -> Message {
        self.send(channel, message);
        self.receive_on(channel)
    }

    /// Sends a message and expects an error. Returns its code.
    pub fn is_refused(&mut self, channel: u32, message: impl Into<Message>) -> u16 {
        let message = message.into();
        self.send(channel, message.clone());
        let report = self.expect_error_on(channel);
        assert_eq!(report.answers, message.kind(), "{report:?}");
        report.code
    }

    /// The next message on a channel, which must be an error.
    pub fn expect_error_on(&mut self, channel: u32) -> Report {
        match self.receive_on(channel) {
            Message::Error(report) => report,
            other => panic!("an error is due, not {}", brief(&other)),
        }
    }

    /// Waits until the daemon has handled every message sent so far that needs no engine.
    pub fn ping(&mut self) {
        self.token += 1;
        let token = self.token;
        self.send(0, Ping { token });
        assert_eq!(self.receive_on(0), Message::Pong(Pong { token }));
    }

    /// All messages received so far that the test has not read.
    pub fn drain(&mut self) -> Vec<(u32, Message)> {
        // The writer thread sends what is queued everywhere before it sends the second pong.
        self.ping();
        self.ping();
        self.aside.drain(..).collect()
    }

    /// The daemon's status.
    pub fn status(&mut self) -> Status {
        match self.ask(STATUS_CHANNEL, StatusWanted {}) {
            Message::Status(status) => status,
            other => panic!("Status is due, not {}", brief(&other)),
        }
    }

    /// The streams that match.
    pub fn list(&mut self, pattern: &str) -> Vec<StreamInfo> {
        match self.ask(STATUS_CHANNEL, hopes_protocol::ListStreams { pattern: pattern.to_owned() }) {
            Message::Streams(Streams { streams }) => streams,
            other => panic!("Streams is due, not {}", brief(&other)),
        }
    }

    /// Sends `Goodbye`. Returns all messages until the daemon's `Goodbye`, which is the last.
    pub fn part(mut self) -> Vec<(u32, Message)> {
        self.send(0, Goodbye { reason: "done".to_owned(), streams: Vec::new() });
        self.rest()
    }

    /// Closes the sending direction.
    pub fn shutdown_write(&self) {
        self.socket.shutdown(Shutdown::Write);
    }

    // ---- receiving

    /// The next message. None once the daemon has closed the connection.
    pub fn next(&mut self) -> Option<(u32, Message)> {
        match self.aside.pop_front() {
            Some(kept) => Some(kept),
            None => self.receive_any(),
        }
    }

    /// The next message that is not a ping, pong or heartbeat. Pings are answered.
    pub fn receive(&mut self) -> Option<(u32, Message)> {
        match self.aside.pop_front() {
            Some(kept) => Some(kept),
            None => self.receive_skipping_heartbeats(),
        }
    }

    /// The next message on a channel.
    pub fn receive_on(&mut self, channel: u32) -> Message {
        if let Some(place) = self.aside.iter().position(|(other, _)| *other == channel) {
            return self.aside.remove(place).expect("it was there").1;
        }
        loop {
            match self.receive_skipping_heartbeats() {
                Some((on, message)) if on == channel => return message,
                Some(other) => self.aside.push_back(other),
                None => panic!("the connection ended while an answer was due; there came {}", brief(&self.aside)),
            }
        }
    }

    /// All messages until the daemon closes the connection.
    pub fn rest(&mut self) -> Vec<(u32, Message)> {
        std::iter::from_fn(|| self.receive()).collect()
    }

    /// Expects an error with this code, a `Goodbye`, and the end of the connection.
    pub fn expect_disconnect(&mut self, code: u16) {
        let rest = self.rest();
        let [.., (0, Message::Error(report)), (0, Message::Goodbye(_))] = &rest[..] else {
            panic!("an error and goodbye are due, not {}", brief(&rest))
        };
        assert_eq!((report.code, report.answers), (code, 0), "{report:?}");
    }

    fn receive_skipping_heartbeats(&mut self) -> Option<(u32, Message)> {
        loop {
            match self.receive_any() {
                Some((0, Message::Ping(Ping { token }))) => {
                    // A daemon that is shutting down reads no more.
                    let _ = self.try_write(&bytes(0, Pong { token }));
                }
                Some((_, Message::Heartbeat(_))) => {}
                other => return other,
            }
        }
    }

    fn receive_any(&mut self) -> Option<(u32, Message)> {
        loop {
            if let Some(frame) = self.decoder.frame().expect("the daemon sends frames") {
                return Some((frame.channel, frame.message().expect("the daemon sends what can be read")));
            }
            if !self.read() {
                return None;
            }
        }
    }

    /// Whether bytes were received.
    fn read(&mut self) -> bool {
        let mut bytes = [0; 1 << 16];
        match self.socket.read(&mut bytes) {
            Ok(0) => false,
            Ok(count) => {
                self.decoder.push(&bytes[..count]);
                true
            }
            Err(error) if matches!(error.kind(), ErrorKind::ConnectionReset | ErrorKind::BrokenPipe) => false,
            Err(error) => {
                panic!("the daemon says nothing within {TIMEOUT:?}: {error}; kept is {}", brief(&self.aside))
            }
        }
    }
}

/// The beginning of a message's debug output.
pub fn brief(message: &impl std::fmt::Debug) -> String {
    format!("{message:?}").chars().take(500).collect()
}

/// The frame of a message.
pub fn bytes(channel: u32, message: impl Into<Message>) -> Vec<u8> {
    encode(VERSION, channel, &message.into()).expect("it fits into a frame")
}

pub fn hello() -> Hello {
    Hello { software: "test".to_owned(), capabilities: vec!["unheard-of".to_owned()] }
}
