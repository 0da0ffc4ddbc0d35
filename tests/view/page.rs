//! A daemon with a page, and an HTTP client of which every byte is chosen by the test.
//!
//! In: bytes of requests.
//! Out: parsed responses.
//! Invariants: all waiting has a deadline. A response has as many bytes as its `Content-Length` says.
//! Must not know: what tests check.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use crate::common::client::Client;
use crate::common::peers::{Consumer, Daemon, FULL, subscribe};

/// How long a response may take, on a slow and busy machine.
const PATIENCE: Duration = Duration::from_secs(100);

/// A daemon on a socket, with a page.
pub struct Page {
    pub daemon: Daemon,
    /// Host and port.
    pub host: String,
}

impl Page {
    /// Starts a daemon with further options of `serve`.
    pub fn start(options: &str) -> Self {
        Self::at("127.0.0.1:0", options)
    }

    /// Starts a daemon with its page at an address.
    pub fn at(address: &str, options: &str) -> Self {
        let mut daemon = Daemon::start(&format!("--view {address} {options}"));
        let line = daemon.running.until_log("the page is at http://");
        let (_, host) = line.trim_end().trim_end_matches('/').split_once("http://").unwrap();
        Self { host: host.to_owned(), daemon }
    }

    pub fn port(&self) -> &str {
        self.host.rsplit_once(':').unwrap().1
    }

    /// A client that has connected and sent nothing.
    pub fn client(&self) -> HttpClient {
        HttpClient::at(&format!("127.0.0.1:{}", self.port()))
    }

    /// The response to a valid request.
    pub fn get(&self, path: &str) -> Reply {
        self.request(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host))
    }

    /// The response to any bytes.
    pub fn request(&self, request: &str) -> Reply {
        let mut client = self.client();
        client.send(request.as_bytes());
        client.reply().expect("there is a response")
    }

    /// As `get`; none if there is no response.
    pub fn try_get(&self, path: &str) -> Option<Reply> {
        let mut client = self.client();
        let request = format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host);
        client.0.write_all(request.as_bytes()).ok()?;
        client.reply()
    }

    /// A consumer that is connected by WebSocket.
    pub fn websocket_consumer(&self, stream: &str) -> Consumer {
        Consumer::subscribe(self.websocket(), subscribe(stream, FULL))
    }

    /// A client of the protocol that is connected by WebSocket.
    pub fn websocket(&self) -> Client {
        Client::with_hello(&format!("ws:{}", self.host))
    }
}

/// A connection to the page.
pub struct HttpClient(pub TcpStream);

impl HttpClient {
    pub fn at(host: &str) -> Self {
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_write_timeout(Some(PATIENCE)).unwrap();
        Self(stream)
    }

    pub fn send(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).expect("the page accepts bytes");
    }

    /// All bytes until the page closes the connection.
    pub fn rest(&mut self) -> Vec<u8> {
        let mut all = Vec::new();
        match self.0.read_to_end(&mut all) {
            Ok(_) => all,
            Err(error) if matches!(error.kind(), ErrorKind::ConnectionReset | ErrorKind::BrokenPipe) => all,
            Err(error) => panic!("the page neither responds nor closes the connection: {error}"),
        }
    }

    /// The response; none if the page closes the connection without one.
    pub fn reply(&mut self) -> Option<Reply> {
        Reply::parse(&self.rest())
    }
}

/// A response.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    pub status: u16,
    /// Names are in lower case.
    pub fields: BTreeMap<String, String>,
    pub body: Vec<u8>,
}

impl Reply {
    fn parse(bytes: &[u8]) -> Option<Self> {
        if bytes.is_empty() {
            return None;
        }
        let end = bytes.windows(4).position(|window| window == b"\r\n\r\n").expect("the head has an end");
        let head = str::from_utf8(&bytes[..end]).unwrap();
        let mut lines = head.split("\r\n");
        let status = lines.next().unwrap().strip_prefix("HTTP/1.1 ").unwrap()[..3].parse().unwrap();
        let mut fields = BTreeMap::new();
        for line in lines {
            let (name, value) = line.split_once(": ").unwrap();
            let twice = fields.insert(name.to_ascii_lowercase(), value.to_owned());
            assert_eq!(twice, None, "{name} is there twice");
        }
        Some(Self { status, fields, body: bytes[end + 4..].to_vec() })
    }

    pub fn field(&self, name: &str) -> &str {
        self.fields.get(name).unwrap_or_else(|| panic!("{name} is missing in {self:?}"))
    }

    pub fn text(&self) -> &str {
        str::from_utf8(&self.body).unwrap()
    }

    /// The body of a response of status 200.
    pub fn ok(self) -> Vec<u8> {
        assert_eq!(self.status, 200, "{}", self.text());
        assert_eq!(self.field("content-length"), self.body.len().to_string());
        self.body
    }

    pub fn json(self) -> serde_json::Value {
        serde_json::from_slice(&self.ok()).unwrap()
    }

    /// A refusal whose text has these words.
    pub fn is_refused(&self, status: u16, words: &str) {
        assert_eq!(self.status, status, "{}", self.text());
        assert!(self.text().contains(words), "{words:?} is missing in {:?}", self.text());
    }
}

/// Host and port of the page, which a daemon without a socket logs next.
pub fn listening_page(running: &mut crate::common::process::Running) -> String {
    let line = running.until_log("the page is at http://");
    line.trim_end().trim_end_matches('/').split_once("http://").unwrap().1.to_owned()
}
