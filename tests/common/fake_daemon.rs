//! A scripted daemon: it listens on a Unix socket or over TCP, and the test sends every message.
//!
//! Every wait has a deadline.

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

/// The longest wait for a message of the client.
const TIMEOUT: Duration = Duration::from_secs(60);

/// A listener of either kind.
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

    /// The address at which it listens.
    pub fn address(&self) -> String {
        match self {
            Self::Unix(_, folder) => format!("unix:{}", folder.path().join("socket").display()),
            Self::Tcp(listener) => format!("tcp:{}", listener.local_addr().unwrap()),
        }
    }

    /// The next connection.
    pub fn accept(&self) -> Peer {
        let stream = eventually("a client comes", || match self.try_accept() {
            Ok(stream) => Some(stream),
            Err(error) if error.kind() == ErrorKind::WouldBlock => None,
            Err(error) => panic!("{error}"),
        });
        stream.set_timeout(TIMEOUT).unwrap();
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

    /// The next connection, after banners, `Hello` and `Welcome`.
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
    /// Sets the longest wait.
    fn set_timeout(&self, timeout: Duration) -> io::Result<()>;
}

impl Stream for UnixStream {
    fn set_timeout(&self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout)).and_then(|()| self.set_write_timeout(Some(TIMEOUT)))
    }
}

impl Stream for TcpStream {
    fn set_timeout(&self, timeout: Duration) -> io::Result<()> {
        self.set_read_timeout(Some(timeout)).and_then(|()| self.set_write_timeout(Some(TIMEOUT)))
    }
}

/// The `Welcome` of this daemon.
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

/// A client's connection, seen from the daemon.
pub struct Peer {
    stream: Box<dyn Stream>,
    decoder: Decoder,
}

impl Peer {
    /// The client's banner.
    pub fn banner(&mut self) -> Banner {
        loop {
            if let Some(banner) = self.decoder.banner().unwrap() {
                return banner;
            }
            assert!(self.read(), "the client is gone before it has said anything");
        }
    }

    /// Its next message, without what a follower asks when its stream does not come. None once it has closed the
    /// connection.
    pub fn next(&mut self) -> Option<(u32, Message)> {
        loop {
            if let Some(frame) = self.decoder.frame().unwrap() {
                match (frame.channel, frame.message().unwrap()) {
                    // It comes after a time of its own, which no test should depend on.
                    (u32::MAX, Message::GetStatus(_)) => continue,
                    message => return Some(message),
                }
            }
            if !self.read() {
                assert!(!self.decoder.is_within_frame(), "the client has closed the connection within a frame");
                return None;
            }
        }
    }

    /// Its next message, if one arrives within that time.
    pub fn next_within(&mut self, time: Duration) -> Option<(u32, Message)> {
        let deadline = Instant::now() + time;
        self.stream.set_timeout(Duration::from_millis(10)).unwrap();
        let next = loop {
            if let Some(frame) = self.decoder.frame().unwrap() {
                break Some((frame.channel, frame.message().unwrap()));
            }
            if Instant::now() >= deadline || !self.read() {
                break None;
            }
        };
        self.stream.set_timeout(TIMEOUT).unwrap();
        next
    }

    /// Whether bytes were received.
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

    /// Sends `Goodbye` and closes the connection.
    pub fn goodbye(mut self, streams: &[(&str, u64)]) {
        let streams = streams.iter().map(|&(name, frame)| (name.to_owned(), frame)).collect();
        self.send(0, Goodbye { reason: "going home".to_owned(), streams });
    }

    /// Answers a producer's `Open`. Returns its channel and the `Open`.
    pub fn open(&mut self, largest_batch: u32) -> (u32, Open) {
        let Some((channel, Message::Open(open))) = self.next() else { panic!("Open comes first") };
        let (window, resolution) = (open.window.unwrap_or(Window::All), open.resolution);
        self.send(channel, Opened { stream: 1, epoch: 9, created: true, window, resolution, frame: 0, largest_batch });
        (channel, open)
    }

    /// Answers nothing. Returns the channel and the `Subscribe` of a consumer.
    pub fn expect_subscribe(&mut self) -> (u32, Subscribe) {
        match self.next() {
            Some((channel, Message::Subscribe(subscribe))) => (channel, subscribe),
            other => panic!("Subscribe is due, not {other:?}"),
        }
    }

    /// Waits for the client's pong with this token. Other messages before it are ignored.
    pub fn ping_and_wait(&mut self, token: u64) {
        self.send(0, Ping { token });
        loop {
            match self.next() {
                Some((0, Message::Pong(pong))) => return assert_eq!(pong.token, token),
                Some(_) => {}
                None => panic!("the client is gone and has not answered the ping"),
            }
        }
    }

    /// Waits for the client's `Goodbye` and the end of the connection. Other messages before it are ignored. Returns
    /// the reason.
    pub fn expect_goodbye(&mut self) -> String {
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
