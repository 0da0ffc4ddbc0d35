//! A client of a real daemon: it connects, says what a test wants it to say, and hears what comes, word by word.
//!
//! In: an address, messages, bytes. Out: messages. Invariants: all waiting has a deadline; what comes on a channel that nobody is asking for is kept for later; nothing is said
//! that the test does not say, but for `Pong` where a test does not look at pings.

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

/// How long a daemon may take to say something.
const PATIENCE: Duration = Duration::from_secs(60);

/// For questions about the daemon itself: a channel that no test takes.
const ASKING: u32 = 0xA5C;

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
        socket.set_patience(PATIENCE)?;
        Ok(socket)
    }

    fn set_patience(&self, patience: Duration) -> io::Result<()> {
        let of_tcp = |stream: &TcpStream| {
            stream.set_read_timeout(Some(patience)).and_then(|()| stream.set_write_timeout(Some(PATIENCE)))
        };
        match self {
            Self::Unix(stream) => {
                stream.set_read_timeout(Some(patience)).and_then(|()| stream.set_write_timeout(Some(PATIENCE)))
            }
            Self::Tcp(stream) => of_tcp(stream),
            Self::Web(web) => of_tcp(&web.stream),
        }
    }

    fn set_write_patience(&self, patience: Duration) -> io::Result<()> {
        match self {
            Self::Unix(stream) => stream.set_write_timeout(Some(patience)),
            Self::Tcp(stream) => stream.set_write_timeout(Some(patience)),
            Self::Web(web) => web.stream.set_write_timeout(Some(patience)),
        }
    }

    fn shutdown(&self, how: Shutdown) {
        // Who is gone already needs no farewell.
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

    /// Writes what is taken at once; how much that was.
    pub fn write_at_once(&self, bytes: &[u8]) -> io::Result<usize> {
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

/// The protocol's bytes in a WebSocket, as a browser has it: by a library that the daemon does not use.
pub struct Web {
    /// The connection below.
    stream: TcpStream,
    pub socket: WebSocket<TcpStream>,
    /// What has come in a message and was not read yet.
    rest: VecDeque<u8>,
    /// Why the daemon has closed it.
    pub closed: Option<u16>,
}

impl Web {
    /// Connects to the page at `HOST:PORT`, as that page does.
    fn connect(host: &str) -> io::Result<Self> {
        let stream = TcpStream::connect(host)?;
        stream.set_read_timeout(Some(PATIENCE))?;
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
                // Closed, politely or not.
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
    /// What came on channels that nobody has asked for yet.
    aside: VecDeque<(u32, Message)>,
    token: u64,
}

impl Client {
    /// Connects and says nothing.
    pub fn silent(address: &str) -> Self {
        let socket = Socket::connect(address).unwrap_or_else(|error| panic!("nobody at {address}: {error}"));
        Self { socket, decoder: Decoder::new(LARGEST_FRAME), aside: VecDeque::new(), token: 0 }
    }

    /// Connects and exchanges banners.
    pub fn new(address: &str) -> Self {
        let mut client = Self::silent(address);
        client.write(&Banner::OURS.encode());
        assert_eq!(client.banner(), Banner::OURS);
        client
    }

    /// Connects, exchanges banners, and is welcome.
    pub fn greeted(address: &str) -> Self {
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

    /// The daemon's banner, if it comes.
    pub fn try_banner(&mut self) -> Option<Banner> {
        loop {
            match self.decoder.banner() {
                Ok(Some(banner)) => return Some(banner),
                Ok(None) if self.read() => {}
                _ => return None,
            }
        }
    }

    /// Takes frames of this version from here on.
    pub fn speaks(&mut self, version: u16) {
        self.decoder.set_version(version);
    }

    /// Says hello and is welcome.
    pub fn hello(&mut self) -> Welcome {
        match self.ask(0, hello()) {
            Message::Welcome(welcome) => welcome,
            other => panic!("Welcome is due, not {}", brief(&other)),
        }
    }

    // ---- speaking

    pub fn try_write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.socket.write_all(bytes)
    }

    /// Writes as long as something is taken within some time; false once the connection is broken.
    pub fn try_write_for(&mut self, bytes: &[u8], patience: Duration) -> bool {
        self.socket.set_write_patience(patience).is_ok()
            && match self.socket.write(bytes) {
                Ok(_) => true,
                Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut),
            }
    }

    pub fn write(&mut self, bytes: &[u8]) {
        self.try_write(bytes).expect("the daemon reads");
    }

    pub fn send(&mut self, channel: u32, message: impl Into<Message>) {
        self.write(&bytes(channel, message));
    }

    /// Says something and hears the answer on the same channel.
    pub fn ask(&mut self, channel: u32, message: impl Into<Message>) -> Message {
        self.send(channel, message);
        self.hear_on(channel)
    }

    /// Says something that is answered with an error. Its code.
    pub fn is_refused(&mut self, channel: u32, message: impl Into<Message>) -> u16 {
        let message = message.into();
        self.send(channel, message.clone());
        let report = self.error_on(channel);
        assert_eq!(report.answers, message.kind(), "{report:?}");
        report.code
    }

    /// The next message on a channel, which is an error.
    pub fn error_on(&mut self, channel: u32) -> Report {
        match self.hear_on(channel) {
            Message::Error(report) => report,
            other => panic!("an error is due, not {}", brief(&other)),
        }
    }

    /// Waits until the daemon has dealt with everything said so far that needs no engine.
    pub fn ping(&mut self) {
        self.token += 1;
        let token = self.token;
        self.send(0, Ping { token });
        assert_eq!(self.hear_on(0), Message::Pong(Pong { token }));
    }

    /// Everything that has been said to this client until now and was not asked for.
    pub fn settle(&mut self) -> Vec<(u32, Message)> {
        // A writer takes from everywhere before it comes to the second answer.
        self.ping();
        self.ping();
        self.aside.drain(..).collect()
    }

    /// How the daemon is.
    pub fn status(&mut self) -> Status {
        match self.ask(ASKING, StatusWanted {}) {
            Message::Status(status) => status,
            other => panic!("Status is due, not {}", brief(&other)),
        }
    }

    /// Streams that match.
    pub fn list(&mut self, pattern: &str) -> Vec<StreamInfo> {
        match self.ask(ASKING, hopes_protocol::ListStreams { pattern: pattern.to_owned() }) {
            Message::Streams(Streams { streams }) => streams,
            other => panic!("Streams is due, not {}", brief(&other)),
        }
    }

    /// Says goodbye, and hears all that is still to come, the daemon's goodbye at last.
    pub fn part(mut self) -> Vec<(u32, Message)> {
        self.send(0, Goodbye { reason: "done".to_owned(), streams: Vec::new() });
        self.rest()
    }

    /// Sends nothing more, but goes on listening.
    pub fn stop_speaking(&self) {
        self.socket.shutdown(Shutdown::Write);
    }

    // ---- listening

    /// The next message; none once the daemon has closed the connection.
    pub fn next(&mut self) -> Option<(u32, Message)> {
        match self.aside.pop_front() {
            Some(kept) => Some(kept),
            None => self.receive(),
        }
    }

    /// The next message that is no sign of life; such are answered where they have to be.
    pub fn hear(&mut self) -> Option<(u32, Message)> {
        match self.aside.pop_front() {
            Some(kept) => Some(kept),
            None => self.receive_no_sign_of_life(),
        }
    }

    /// The next message on a channel.
    pub fn hear_on(&mut self, channel: u32) -> Message {
        if let Some(place) = self.aside.iter().position(|(other, _)| *other == channel) {
            return self.aside.remove(place).expect("it was there").1;
        }
        loop {
            match self.receive_no_sign_of_life() {
                Some((on, message)) if on == channel => return message,
                Some(other) => self.aside.push_back(other),
                None => panic!("the connection ended while an answer was due; there came {}", brief(&self.aside)),
            }
        }
    }

    /// All that still comes until the daemon closes the connection.
    pub fn rest(&mut self) -> Vec<(u32, Message)> {
        std::iter::from_fn(|| self.hear()).collect()
    }

    /// The daemon ends the connection, after an error of that code and its goodbye.
    pub fn is_cut_off(&mut self, code: u16) {
        let rest = self.rest();
        let [.., (0, Message::Error(report)), (0, Message::Goodbye(_))] = &rest[..] else {
            panic!("an error and goodbye are due, not {}", brief(&rest))
        };
        assert_eq!((report.code, report.answers), (code, 0), "{report:?}");
    }

    fn receive_no_sign_of_life(&mut self) -> Option<(u32, Message)> {
        loop {
            match self.receive() {
                Some((0, Message::Ping(Ping { token }))) => {
                    // A daemon that is ending reads no more.
                    let _ = self.try_write(&bytes(0, Pong { token }));
                }
                Some((_, Message::Heartbeat(_))) => {}
                other => return other,
            }
        }
    }

    fn receive(&mut self) -> Option<(u32, Message)> {
        loop {
            if let Some(frame) = self.decoder.frame().expect("the daemon sends frames") {
                return Some((frame.channel, frame.message().expect("the daemon sends what can be read")));
            }
            if !self.read() {
                return None;
            }
        }
    }

    /// Whether something came.
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
                panic!("the daemon says nothing within {PATIENCE:?}: {error}; kept is {}", brief(&self.aside))
            }
        }
    }
}

/// As much of a message as somebody wants to read.
pub fn brief(message: &impl std::fmt::Debug) -> String {
    format!("{message:?}").chars().take(500).collect()
}

/// A message as bytes.
pub fn bytes(channel: u32, message: impl Into<Message>) -> Vec<u8> {
    encode(VERSION, channel, &message.into()).expect("it fits into a frame")
}

pub fn hello() -> Hello {
    Hello { software: "test".to_owned(), capabilities: vec!["unheard-of".to_owned()] }
}
