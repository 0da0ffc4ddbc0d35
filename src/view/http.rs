//! Requests and responses of HTTP/1.1: one of each on a connection.
//!
//! In: the bytes of a request's head.
//! Out: a [`Request`]; the bytes of a [`Response`].
//! Invariants: every response forbids what the page does not need.
//! Must not know: which resources there are.
//!
//! `httparse` parses the head. The rest is written here, since it is small: there are GET and HEAD without bodies, and
//! every response closes its connection. A server crate would bring keep-alive, bodies, and mostly an asynchronous
//! runtime, while the daemon needs its own limits of time, size and threads, and needs the plain socket after an
//! upgrade.

use std::fmt::Write;
use std::ops::Deref;
use std::sync::Arc;

use crate::daemon::Charged;

/// Bytes of a head at the most.
pub const MAX_HEAD: usize = 16 << 10;

/// Header fields of a request at the most.
const MAX_FIELDS: usize = 64;

/// Header fields of every response. The page needs nothing but its own files and its own daemon.
const COMMON_FIELDS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    X-Content-Type-Options: nosniff\r\n\
    Referrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Connection: close\r\n";

/// A refused request: the status and the text of its response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    status: u16,
    text: String,
    /// A header field that the status requires.
    field: Option<&'static str>,
}

impl Refusal {
    /// The text says what was wrong, and what to do.
    pub fn new(status: u16, text: impl Into<String>) -> Self {
        Self { status, text: text.into(), field: None }
    }

    /// Its status.
    #[cfg(test)]
    pub fn status(&self) -> u16 {
        self.status
    }

    /// For a request that is no valid request for a WebSocket.
    pub fn upgrade_required(text: &str) -> Self {
        let field = Some("Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n");
        Self { field, ..Self::new(426, text) }
    }
}

/// A request.
#[derive(Clone, Debug)]
pub struct Request {
    /// The method is HEAD.
    pub is_head: bool,
    /// The target up to a question mark, not decoded.
    pub path: String,
    /// The target after the question mark, not decoded.
    pub query: Option<String>,
    /// Names are in lower case.
    fields: Vec<(String, String)>,
}

impl Request {
    /// The request at the beginning of `bytes` and the length of its head; none if the head is incomplete.
    ///
    /// # Errors
    /// [`Refusal`]: it cannot be parsed, is too long, or its method is not GET or HEAD.
    pub fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Refusal> {
        let mut fields = [httparse::EMPTY_HEADER; MAX_FIELDS];
        let mut head = httparse::Request::new(&mut fields);
        let length = match head.parse(bytes) {
            Ok(httparse::Status::Complete(length)) if length <= MAX_HEAD => length,
            Ok(httparse::Status::Partial) if bytes.len() < MAX_HEAD => return Ok(None),
            Ok(_) => {
                return Err(Refusal::new(431, format!("the head of a request has at most {MAX_HEAD} bytes")));
            }
            Err(httparse::Error::TooManyHeaders) => {
                return Err(Refusal::new(431, format!("a request has at most {MAX_FIELDS} fields")));
            }
            Err(error) => return Err(Refusal::new(400, format!("this is no request: {error}"))),
        };
        let target = head.path.filter(|target| target.starts_with('/'));
        let target = target.ok_or_else(|| Refusal::new(400, "a request asks for a path that begins with /"))?;
        let (path, query) = target.split_once('?').map_or((target, None), |(path, query)| (path, Some(query)));
        let mut fields = Vec::new();
        for field in head.headers.iter() {
            let value = str::from_utf8(field.value)
                .map_err(|_| Refusal::new(400, format!("the field {} is no text", field.name)))?;
            fields.push((field.name.to_ascii_lowercase(), value.trim().to_owned()));
        }
        let is_head = head.method == Some("HEAD");
        if !is_head && head.method != Some("GET") {
            let text = "nothing can be changed here: use GET and HEAD";
            return Err(Refusal { field: Some("Allow: GET, HEAD\r\n"), ..Refusal::new(405, text) });
        }
        Ok(Some((Self { is_head, path: path.to_owned(), query: query.map(str::to_owned), fields }, length)))
    }

    /// The value of a field; none if it is missing or given twice.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut found = self.fields.iter().filter(|(other, _)| other == name);
        let (first, second) = (found.next(), found.next());
        first.filter(|_| second.is_none()).map(|(_, value)| &value[..])
    }

    /// Whether a field is given, once or more often.
    pub fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|(other, _)| other == name)
    }

    /// Whether the comma-separated values of a field include a word.
    pub fn lists(&self, name: &str, word: &str) -> bool {
        let of_name = self.fields.iter().filter(|(other, _)| other == name);
        of_name.flat_map(|(_, value)| value.split(',')).any(|listed| listed.trim().eq_ignore_ascii_case(word))
    }

    /// Whether the client has a file of this entity tag.
    pub fn has_version(&self, tag: &str) -> bool {
        self.lists("if-none-match", tag)
            || self.lists("if-none-match", &format!("W/{tag}"))
            || self.lists("if-none-match", "*")
    }
}

/// How long a response may be cached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Freshness {
    /// Not at all.
    Never,
    /// As long as its entity tag, which is given, is the current one.
    Version(String),
}

/// The body of a response.
#[derive(Clone, Debug)]
pub enum Body {
    /// For one client.
    Own(Vec<u8>),
    /// Shared by all clients that request it.
    Shared(Arc<Charged<Vec<u8>>>),
}

impl Deref for Body {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Own(bytes) => bytes,
            Self::Shared(bytes) => bytes,
        }
    }
}

impl<B: Into<Vec<u8>>> From<B> for Body {
    fn from(bytes: B) -> Self {
        Self::Own(bytes.into())
    }
}

/// A response.
#[derive(Clone, Debug)]
pub struct Response {
    status: u16,
    /// Of the body.
    media_type: &'static str,
    body: Body,
    freshness: Freshness,
    field: Option<&'static str>,
}

impl Response {
    /// A response of status 200.
    pub fn new(media_type: &'static str, body: impl Into<Body>) -> Self {
        Self { status: 200, media_type, body: body.into(), freshness: Freshness::Never, field: None }
    }

    /// With an entity tag; of status 304 if the client has this version.
    pub fn version(self, tag: &str, is_known: bool) -> Self {
        let freshness = Freshness::Version(tag.to_owned());
        if is_known {
            Self { status: 304, body: Body::Own(Vec::new()), freshness, ..self }
        } else {
            Self { freshness, ..self }
        }
    }

    /// Of status 503, for what is not well.
    pub fn unavailable(self) -> Self {
        Self { status: 503, ..self }
    }

    /// The bytes of the head, and the body, which is empty if the method was HEAD.
    pub fn encode(self, is_head: bool) -> (Vec<u8>, Body) {
        let mut head = format!("HTTP/1.1 {} {}\r\n{COMMON_FIELDS}", self.status, reason(self.status));
        head.push_str(self.field.unwrap_or_default());
        // Writing into a string does not fail.
        let _ = match &self.freshness {
            Freshness::Never => write!(head, "Cache-Control: no-store\r\n"),
            Freshness::Version(tag) => write!(head, "Cache-Control: no-cache\r\nETag: {tag}\r\n"),
        };
        if self.status != 304 {
            let _ = write!(head, "Content-Type: {}\r\nContent-Length: {}\r\n", self.media_type, self.body.len());
        }
        head.push_str("\r\n");
        (head.into_bytes(), if is_head { Body::Own(Vec::new()) } else { self.body })
    }
}

/// The head of a response of status 200 whose body ends with the connection. Proxies that would collect it are told not
/// to.
pub fn endless(media_type: &str) -> Vec<u8> {
    let own = format!("Cache-Control: no-store\r\nX-Accel-Buffering: no\r\nContent-Type: {media_type}\r\n\r\n");
    format!("HTTP/1.1 200 {}\r\n{COMMON_FIELDS}{own}", reason(200)).into_bytes()
}

impl From<Refusal> for Response {
    fn from(refusal: Refusal) -> Self {
        let Refusal { status, text, field } = refusal;
        Self { status, field, ..Self::new("text/plain; charset=utf-8", text + "\n") }
    }
}

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        304 => "Not Modified",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        421 => "Misdirected Request",
        426 => "Upgrade Required",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Error",
    }
}
