//! A daemon with a page, and an HTTP client whose every byte is written by the test.
//!
//! In: requests. Out: parsed answers. Invariants: every wait has a deadline. An answer has as many bytes as its length
//! says.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use crate::common::client::Client;
use crate::common::peers::{Consumer, Daemon, FULL, subscribe};

/// The longest wait for an answer, on a slow and busy machine.
const TIMEOUT: Duration = Duration::from_secs(100);

/// A daemon on a socket, with a page.
pub struct Page {
    pub daemon: Daemon,
    /// Host and port.
    pub host: String,
}

impl Page {
    /// Starts it with options of `serve`.
    pub fn start(options: &str) -> Self {
        Self::at("127.0.0.1:0", options)
    }

    /// Starts it with its page at an address.
    pub fn at(address: &str, options: &str) -> Self {
        let mut daemon = Daemon::start(&format!("--view {address} {options}"));
        let line = daemon.running.until_log("the page is at http://");
        let (_, host) = line.trim_end().trim_end_matches('/').split_once("http://").unwrap();
        Self { host: host.to_owned(), daemon }
    }

    pub fn port(&self) -> &str {
        self.host.rsplit_once(':').unwrap().1
    }

    /// A new connection that has sent nothing.
    pub fn http_client(&self) -> HttpClient {
        HttpClient::at(&format!("127.0.0.1:{}", self.port()))
    }

    /// The answer to a valid GET request.
    pub fn get(&self, path: &str) -> Reply {
        self.ask(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host))
    }

    /// The answer to any bytes.
    pub fn ask(&self, request: &str) -> Reply {
        let mut client = self.http_client();
        client.say(request.as_bytes());
        client.reply().expect("there is an answer")
    }

    /// The answer to a GET request. None if there is no answer.
    pub fn try_get(&self, path: &str) -> Option<Reply> {
        let mut client = self.http_client();
        let request = format!("GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host);
        client.0.write_all(request.as_bytes()).ok()?;
        client.reply()
    }

    /// A consumer that is connected by WebSocket.
    pub fn web_consumer(&self, stream: &str) -> Consumer {
        Consumer::subscribe(self.web_client(), subscribe(stream, FULL))
    }

    /// A client that is connected by WebSocket.
    pub fn web_client(&self) -> Client {
        Client::with_hello(&format!("ws:{}", self.host))
    }
}

/// An HTTP connection.
pub struct HttpClient(pub TcpStream);

impl HttpClient {
    pub fn at(host: &str) -> Self {
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(TIMEOUT)).unwrap();
        stream.set_write_timeout(Some(TIMEOUT)).unwrap();
        Self(stream)
    }

    pub fn say(&mut self, bytes: &[u8]) {
        self.0.write_all(bytes).expect("the page listens");
    }

    /// All bytes until the daemon closes the connection.
    pub fn rest(&mut self) -> Vec<u8> {
        let mut all = Vec::new();
        match self.0.read_to_end(&mut all) {
            Ok(_) => all,
            Err(error) if matches!(error.kind(), ErrorKind::ConnectionReset | ErrorKind::BrokenPipe) => all,
            Err(error) => panic!("the page neither answers nor hangs up: {error}"),
        }
    }

    /// The answer. None if the daemon closes the connection without one.
    pub fn reply(&mut self) -> Option<Reply> {
        Reply::parse(&self.rest())
    }
}

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Reply {
    pub status: u16,
    /// Names in lower case.
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
            assert_eq!(twice, None, "{name} stands there twice");
        }
        Some(Self { status, fields, body: bytes[end + 4..].to_vec() })
    }

    pub fn field(&self, name: &str) -> &str {
        self.fields.get(name).unwrap_or_else(|| panic!("{name} is missing in {self:?}"))
    }

    pub fn text(&self) -> &str {
        str::from_utf8(&self.body).unwrap()
    }

    /// Expects status 200. Returns the body.
    pub fn fine(self) -> Vec<u8> {
        assert_eq!(self.status, 200, "{}", self.text());
        assert_eq!(self.field("content-length"), self.body.len().to_string());
        self.body
    }

    pub fn json(self) -> serde_json::Value {
        serde_json::from_slice(&self.fine()).unwrap()
    }

    /// Expects this status and these words in the text.
    pub fn is_refused(&self, status: u16, words: &str) {
        assert_eq!(self.status, status, "{}", self.text());
        assert!(self.text().contains(words), "{words:?} is missing in {:?}", self.text());
    }
}

/// The next address of a page in the log of a daemon without a socket.
pub fn listening_page(running: &mut crate::common::process::Running) -> String {
    let line = running.until_log("the page is at http://");
    line.trim_end().trim_end_matches('/').split_once("http://").unwrap().1.to_owned()
}
