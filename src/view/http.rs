//! Requests as they come, and answers as they go (HTTP/1.1): one on a connection.
//!
//! In: the bytes of a head. Out: a [`Request`], checked against what this place is called; the bytes of an [`Answer`].
//! Invariants: a request for another host, or from a page of another one, is refused before anybody looks at its path;
//! every answer forbids what the page does not need. Must not know: what there is to see.

use std::fmt::Write;

/// Bytes in a head at the most.
pub const LONGEST_HEAD: usize = 16 << 10;

/// Fields in a head at the most.
const MOST_FIELDS: usize = 64;

/// What every answer says. The page needs nothing but its own files and its own daemon.
const ALWAYS: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    X-Content-Type-Options: nosniff\r\n\
    Referrer-Policy: no-referrer\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Connection: close\r\n";

/// A question that is not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    status: u16,
    text: String,
    /// A field that has to go with it.
    field: Option<&'static str>,
}

impl Refusal {
    /// With what was wrong, and what to do.
    pub fn new(status: u16, text: impl Into<String>) -> Self {
        Self { status, text: text.into(), field: None }
    }

    /// Of whoever does not ask for a WebSocket.
    pub fn upgrade(text: &str) -> Self {
        let field = Some("Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n");
        Self { field, ..Self::new(426, text) }
    }
}

/// A question.
#[derive(Clone, Debug)]
pub struct Request {
    /// Only the head of the answer is wanted.
    pub is_head: bool,
    /// As it was sent, up to a question mark.
    pub path: String,
    /// What comes after the question mark.
    pub query: Option<String>,
    /// Names in small letters.
    fields: Vec<(String, String)>,
}

impl Request {
    /// The request at the beginning of `bytes`, and its length; none, if it has not come as a whole.
    ///
    /// # Errors
    /// [`Refusal`]: it cannot be read, is too long, or wants to change something.
    pub fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Refusal> {
        let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
        let mut head = httparse::Request::new(&mut fields);
        let length = match head.parse(bytes) {
            Ok(httparse::Status::Complete(length)) if length <= LONGEST_HEAD => length,
            Ok(httparse::Status::Partial) if bytes.len() < LONGEST_HEAD => return Ok(None),
            Ok(_) => {
                return Err(Refusal::new(431, format!("the head of a request has at most {LONGEST_HEAD} bytes")));
            }
            Err(httparse::Error::TooManyHeaders) => {
                return Err(Refusal::new(431, format!("a request has at most {MOST_FIELDS} fields")));
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
            let text = "nothing can be changed here: there are GET and HEAD";
            return Err(Refusal { field: Some("Allow: GET, HEAD\r\n"), ..Refusal::new(405, text) });
        }
        Ok(Some((Self { is_head, path: path.to_owned(), query: query.map(str::to_owned), fields }, length)))
    }

    /// A field that was given once.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut found = self.fields.iter().filter(|(other, _)| other == name);
        let (first, second) = (found.next(), found.next());
        first.filter(|_| second.is_none()).map(|(_, value)| &value[..])
    }

    fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|(other, _)| other == name)
    }

    /// Whether a word stands in the list of a field.
    pub fn lists(&self, name: &str, word: &str) -> bool {
        let of_name = self.fields.iter().filter(|(other, _)| other == name);
        of_name.flat_map(|(_, value)| value.split(',')).any(|listed| listed.trim().eq_ignore_ascii_case(word))
    }

    /// Whether the client has the newest version of a file.
    pub fn has_version(&self, tag: &str) -> bool {
        self.lists("if-none-match", tag)
            || self.lists("if-none-match", &format!("W/{tag}"))
            || self.lists("if-none-match", "*")
    }

    /// Refuses what was not meant for a place of these names, and what the page of another place asks for.
    ///
    /// A page of another site can make a browser ask here, and can have its own name lead here; it cannot hide either.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn check_origin(&self, is_name: impl Fn(&str) -> bool, needs_origin: bool) -> Result<(), Refusal> {
        let host = self.header("host").ok_or_else(|| Refusal::new(400, "a request names its Host, once"))?;
        let host = host.to_ascii_lowercase();
        if !is_name(&host) {
            let text = format!("this place is not called {host:?}: use its address, or allow the name by --view-host");
            return Err(Refusal::new(421, text));
        }
        let origin = self.header("origin").map(str::to_ascii_lowercase);
        let is_own = origin.as_deref().is_some_and(|origin| {
            let named = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
            named == Some(&host)
        });
        if is_own || !needs_origin && !self.has("origin") {
            return Ok(());
        }
        Err(Refusal::new(403, "only the page of this place may ask for that: Origin is missing, or another one"))
    }
}

/// How long something stays true.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Freshness {
    /// Until it is asked for again.
    Never,
    /// Until its version, which is given, is another one.
    Version(String),
}

/// What is answered.
#[derive(Clone, Debug)]
pub struct Answer {
    status: u16,
    /// What kind of body it is.
    kind: &'static str,
    body: Vec<u8>,
    freshness: Freshness,
    field: Option<&'static str>,
}

impl Answer {
    /// A body of some kind.
    pub fn new(kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status: 200, kind, body: body.into(), freshness: Freshness::Never, field: None }
    }

    /// With a version, of which the client may have a copy.
    pub fn version(self, tag: &str, is_known: bool) -> Self {
        let freshness = Freshness::Version(tag.to_owned());
        if is_known { Self { status: 304, body: Vec::new(), freshness, ..self } } else { Self { freshness, ..self } }
    }

    /// As bytes.
    pub fn encode(self, is_head: bool) -> Vec<u8> {
        let mut head = format!("HTTP/1.1 {} {}\r\n{ALWAYS}", self.status, reason(self.status));
        head.push_str(self.field.unwrap_or_default());
        // Writing into a string does not fail.
        let _ = match &self.freshness {
            Freshness::Never => write!(head, "Cache-Control: no-store\r\n"),
            Freshness::Version(tag) => write!(head, "Cache-Control: no-cache\r\nETag: {tag}\r\n"),
        };
        if self.status != 304 {
            let _ = write!(head, "Content-Type: {}\r\nContent-Length: {}\r\n", self.kind, self.body.len());
        }
        head.push_str("\r\n");
        let mut bytes = head.into_bytes();
        if !is_head {
            bytes.extend(self.body);
        }
        bytes
    }
}

impl From<Refusal> for Answer {
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
