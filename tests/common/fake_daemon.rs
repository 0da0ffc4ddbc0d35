//! A daemon that does what a test tells it: it listens on a Unix socket or over TCP, and the test says every word.
//!
//! All waiting has a deadline.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::net::{UnixListener, UnixStream};
use std::time::{Duration, Instant};

use hopes_protocol::{
    Banner, Decoder, Goodbye, Hello, LARGEST_FRAME, Message, Open, Opened, Ping, Subscribe, VERSION, Welcome, Window,
    encode,
};
use tempfile::TempDir;

use super::process::eventually;

/// How long a client may take to say something.
const PATIENCE: Duration = Duration::from_secs(60);

/// Somebody who listens.
pub enum FakeDaemon {
    Unix(UnixListener, TempDir),
    Tcp(TcpListener),
}

impl FakeDaemon {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let listener = UnixListener::bind(folder.path().join("socket")).unwrap();
        listener.set_nonblocking(true).unwrap();
        Self::Unix(listener, folder)
    }

    pub fn over_tcp() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        Self::Tcp(listener)
    }

    /// Where it listens.
    pub fn address(&self) -> String {
        match self {
            Self::Unix(_, folder) => format!("unix:{}", folder.path().join("socket").display()),
            Self::Tcp(listener) => format!("tcp:{}", listener.local_addr().unwrap()),
        }
    }

    /// The next client, as it comes.
    pub fn accept(&self) -> Peer {
        let stream = eventually("a client comes", || match self.try_accept() {
            Ok(stream) => Some(stream),
            Err(error) if error.kind() == ErrorKind::WouldBlock => None,
            Err(error) => panic!("{error}"),
        });
        stream.set_patience(PATIENCE).unwrap();
        Peer { stream, decoder: Decoder::new(LARGEST_FRAME) }
    }

    fn try_accept(&self) -> io::Result<Box<dyn Stream>> {
        Ok(match self {
            Self::Unix(listener, _) => {
                let (stream, _) = listener.accept()?;
                stream.set_nonblocking(false)?;
                Box::new(stream)
            }
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept()?;
                stream.set_nonblocking(false)?;
                Box::new(stream)
            }
        })
    }

    /// The next client, greeted.
    pub fn greet(&self) -> Peer {
        self.greet_as(welcome())
    }

    pub fn greet_as(&self, welcome: Welcome) -> Peer {
        let mut peer = self.accept();
        assert_eq!(peer.banner(), Banner::OURS);
        peer.write(&Banner::OURS.encode());
        let Some((0, Message::Hello(Hello { software, .. }))) = peer.next() else { panic!("Hello comes first") };
        assert!(software.starts_with("hopes "), "{software}");
        peer.send(0, welcome);
        peer
    }
}

/// A socket of either kind.
trait Stream: Read + Write {
    /// How long it waits at the most.
    fn set_patience(&self, patience: Duration) -> io::Result<()>;
}

impl Stream for UnixStream {
    fn set_patience(&self, patience: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(patience)).and_then(|()| self.set_write_timeout(Some(PATIENCE)))
    }
}

impl Stream for TcpStream {
    fn set_patience(&self, patience: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(patience)).and_then(|()| self.set_write_timeout(Some(PATIENCE)))
    }
}

/// What a daemon says of itself.
pub fn welcome() -> Welcome {
    Welcome {
        software: "fake".to_owned(),
        capabilities: vec!["unheard-of".to_owned()],
        epoch: 42,
        largest_frame: 1 << 20,
        largest_batch: 5000,
        heartbeat_ms: 1000,
        timeout_ms: 60_000,
    }
}

/// A client, seen from the daemon.
pub struct Peer {
    stream: Box<dyn Stream>,
    decoder: Decoder,
}

impl Peer {
    /// What the client speaks.
    pub fn banner(&mut self) -> Banner {
        loop {
            if let Some(banner) = self.decoder.banner().unwrap() {
                return banner;
            }
            assert!(self.read(), "the client is gone before it has said anything");
        }
    }

    /// Its next message; none once it has closed the connection.
    pub fn next(&mut self) -> Option<(u32, Message)> {
        loop {
            if let Some(frame) = self.decoder.frame().unwrap() {
                return Some((frame.channel, frame.message().unwrap()));
            }
            if !self.read() {
                assert!(!self.decoder.is_within_frame(), "the client has closed the connection within a frame");
                return None;
            }
        }
    }

    /// Its next message, if one comes within that time.
    pub fn next_within(&mut self, time: Duration) -> Option<(u32, Message)> {
        let deadline = Instant::now() + time;
        self.stream.set_patience(Duration::from_millis(10)).unwrap();
        let next = loop {
            if let Some(frame) = self.decoder.frame().unwrap() {
                break Some((frame.channel, frame.message().unwrap()));
            }
            if Instant::now() >= deadline || !self.read() {
                break None;
            }
        };
        self.stream.set_patience(PATIENCE).unwrap();
        next
    }

    /// Whether anything can still come.
    fn read(&mut self) -> bool {
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(0) => false,
            Ok(count) => {
                self.decoder.push(&bytes[..count]);
                true
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => true,
            Err(error) => panic!("{error}"),
        }
    }

    pub fn write(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).unwrap();
    }

    pub fn send(&mut self, channel: u32, message: impl Into<Message>) {
        let bytes = encode(VERSION, channel, &message.into()).unwrap();
        self.write(&bytes);
    }

    /// Says goodbye and closes the connection.
    pub fn leave(mut self, streams: &[(&str, u64)]) {
        let streams = streams.iter().map(|&(name, frame)| (name.to_owned(), frame)).collect();
        self.send(0, Goodbye { reason: "going home".to_owned(), streams });
    }

    /// A producer opens a stream. What it asked for, and its channel.
    pub fn open(&mut self, largest_batch: u32) -> (u32, Open) {
        let Some((channel, Message::Open(open))) = self.next() else { panic!("Open comes first") };
        let (window, resolution) = (open.window.unwrap_or(Window::All), open.resolution);
        self.send(channel, Opened { stream: 1, epoch: 9, created: true, window, resolution, frame: 0, largest_batch });
        (channel, open)
    }

    /// A consumer subscribes.
    pub fn subscribed(&mut self) -> (u32, Subscribe) {
        match self.next() {
            Some((channel, Message::Subscribe(subscribe))) => (channel, subscribe),
            other => panic!("Subscribe is due, not {other:?}"),
        }
    }

    /// It answers a ping, whatever else it says before.
    pub fn pings(&mut self, token: u64) {
        self.send(0, Ping { token });
        loop {
            match self.next() {
                Some((0, Message::Pong(pong))) => return assert_eq!(pong.token, token),
                Some(_) => {}
                None => panic!("the client is gone and has not answered the ping"),
            }
        }
    }

    /// It says goodbye and goes, whatever else it says before. The reason.
    pub fn parts(&mut self) -> String {
        let mut reason = None;
        while let Some((_, message)) = self.next() {
            assert!(reason.is_none(), "goodbye is the last message, but {message:?} comes");
            if let Message::Goodbye(goodbye) = message {
                reason = Some(goodbye.reason);
            }
        }
        reason.expect("it has said goodbye")
    }
}
