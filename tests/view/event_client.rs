//! A client of server-sent events that follows the rules of WHATWG, and knows nothing of the protocol.
//!
//! In: a page, a path. Out: events, one by one.
//! Invariants: every wait has a deadline. An event without its blank line is none.
//! Must not know: what tests check.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, ErrorKind};
use std::net::TcpStream;

use serde_json::Value;

use super::page::{HttpClient, Page};

/// An event.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    pub name: String,
    pub id: Option<String>,
    pub data: String,
}

impl Event {
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.data).unwrap_or_else(|error| panic!("{error} in {self:?}"))
    }

    /// The first frame that it changes, and the frame that it leads to.
    pub fn frames(&self) -> (u64, u64) {
        assert_eq!(self.name, "frame", "{self:?}");
        let json = self.json();
        let number = json["frame"].as_u64().unwrap();
        let id = self.id.as_ref().expect("a frame has an id");
        assert_eq!(id.split_once('-').unwrap().0, number.to_string());
        (json["from"].as_u64().unwrap(), number)
    }

    /// The first and the last frame that did not come.
    pub fn lagged(&self) -> (u64, u64) {
        assert_eq!(self.name, "lagged", "{self:?}");
        let json = self.json();
        (json["lagged"][0].as_u64().unwrap(), json["lagged"][1].as_u64().unwrap())
    }
}

/// A response that has begun.
pub struct Events {
    reader: BufReader<TcpStream>,
    /// Names are in lower case.
    pub fields: BTreeMap<String, String>,
    /// Lines that clients skip, so far.
    pub comments: usize,
}

impl Events {
    /// The events of a stream.
    pub fn of(page: &Page, stream: &str, query: &str) -> Self {
        Self::at(&page.host, &page.host, &format!("/api/streams/{stream}/frames{query}"), "")
    }

    /// The same after an event.
    pub fn after(page: &Page, stream: &str, query: &str, last: &str) -> Self {
        let path = format!("/api/streams/{stream}/frames{query}");
        Self::at(&page.host, &page.host, &path, &format!("Last-Event-ID: {last}\r\n"))
    }

    /// The events at a path of a server, which is asked by a name.
    pub fn at(server: &str, host: &str, path: &str, fields: &str) -> Self {
        let mut client = HttpClient::at(server);
        client.send(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{fields}\r\n").as_bytes());
        let mut reader = BufReader::new(client.0);
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            assert_ne!(reader.read_until(b'\n', &mut head).unwrap(), 0, "{}", String::from_utf8_lossy(&head));
        }
        let head = String::from_utf8(head).unwrap();
        let mut lines = head.trim_end().split("\r\n");
        assert_eq!(lines.next(), Some("HTTP/1.1 200 OK"), "{head}");
        let fields = lines.map(|line| line.split_once(": ").unwrap());
        let fields = fields.map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned())).collect();
        Self { reader, fields, comments: 0 }
    }

    /// The next event; none at the end.
    pub fn next(&mut self) -> Option<Event> {
        let (mut name, mut id, mut data) = (String::new(), None, Vec::new());
        loop {
            let mut line = String::new();
            match self.reader.read_line(&mut line) {
                Ok(0) => return None,
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::ConnectionReset => return None,
                Err(error) => panic!("no event comes: {error}"),
            }
            let line = line.trim_end_matches('\n');
            if line.is_empty() && data.is_empty() {
                continue;
            } else if line.is_empty() {
                return Some(Event { name, id, data: data.join("\n") });
            }
            match line.split_once(": ").unwrap_or((line, "")) {
                ("event", value) => name = value.to_owned(),
                ("id", value) => id = Some(value.to_owned()),
                ("data", value) => data.push(value.to_owned()),
                (":", "") => self.comments += 1,
                other => panic!("{other:?} is no line of an event"),
            }
        }
    }

    /// The next event, which is due.
    pub fn due(&mut self) -> Event {
        self.next().expect("an event is due")
    }

    /// The events before that of a frame, and that one.
    pub fn up_to(&mut self, frame: u64) -> Vec<Event> {
        let mut events = Vec::new();
        while events.last().is_none_or(|event: &Event| event.name != "frame" || event.frames().1 < frame) {
            events.push(self.due());
        }
        assert_eq!(events.last().unwrap().frames().1, frame);
        events
    }

    /// Waits for the next line that clients skip, where nothing else is due.
    pub fn until_comment(&mut self) {
        let mut line = String::new();
        while !line.starts_with(':') {
            line.clear();
            assert_ne!(self.reader.read_line(&mut line).unwrap(), 0, "the response has ended");
            assert!(line.starts_with(':') || line == "\n", "{line:?}");
        }
    }

    /// All events until the end.
    pub fn rest(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.next()).collect()
    }

    /// The connection below.
    pub fn stream(&self) -> &TcpStream {
        self.reader.get_ref()
    }
}
