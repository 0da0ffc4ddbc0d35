//! The protocol in a WebSocket: the handshake, and a connection that carries bytes both ways.
//!
//! In: a request for an upgrade, then a client's frames. Out: the answer to it, then a [`Transport`] for the daemon's
//! peers. Invariants: a piece of the protocol's bytes is a binary message, and where it is cut means nothing; only the
//! peer's writer writes, so that no frame stands within another; pings are answered by its next turn. Must not know:
//! the protocol.

use std::io::{self, ErrorKind};
use std::net::Shutdown;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha1_smol::Sha1;

use super::framing::{self, Asked, Kind, Unframer};
use super::http::{Refusal, Request};
use crate::daemon::{Socket, Transport};

/// What the protocol is called in the handshake.
const SUBPROTOCOL: &str = "hopes";

/// The number that RFC 6455 has servers add to a client's key.
const MAGIC: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// Pieces up to this size are sent in one go with their heads.
const TOGETHER: usize = 1 << 17;

/// Close codes: done, the daemon ends.
const DONE: u16 = 1000;
const GOING_AWAY: u16 = 1001;

/// The answer that a request for a WebSocket gets.
///
/// # Errors
/// [`Refusal`]: it is no such request.
pub fn handshake(request: &Request) -> Result<Vec<u8>, Refusal> {
    if !request.lists("upgrade", "websocket") || !request.lists("connection", "upgrade") {
        return Err(Refusal::upgrade("this is a WebSocket: ask for an upgrade to it"));
    }
    if request.header("sec-websocket-version") != Some("13") {
        return Err(Refusal::upgrade("the version of WebSockets here is 13"));
    }
    let key = request.header("sec-websocket-key").unwrap_or_default();
    if STANDARD.decode(key).map_or(0, |key| key.len()) != 16 {
        return Err(Refusal::new(400, "a Sec-WebSocket-Key has 16 bytes, in base64"));
    }
    let is_offering = request.header("sec-websocket-protocol").is_some();
    if is_offering && !request.lists("sec-websocket-protocol", SUBPROTOCOL) {
        return Err(Refusal::new(400, "the subprotocol here is hopes: offer it, or none"));
    }
    let accept = STANDARD.encode(Sha1::from([key, MAGIC].concat()).digest().bytes());
    let chosen = if is_offering { format!("Sec-WebSocket-Protocol: {SUBPROTOCOL}\r\n") } else { String::new() };
    Ok(format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n{chosen}\r\n"
    )
    .into_bytes())
}

/// A connection after its handshake.
#[derive(Debug)]
pub struct WebSocket {
    socket: Arc<Socket>,
    incoming: Mutex<Incoming>,
    outgoing: Mutex<Outgoing>,
}

/// The reader's side.
#[derive(Debug)]
struct Incoming {
    /// What has come together with the request.
    early: Vec<u8>,
    unframer: Unframer,
    is_closed: bool,
}

/// What the writer is to say besides what it is given.
#[derive(Debug, Default)]
struct Outgoing {
    pong: Option<Vec<u8>>,
    /// Why the connection ends, if the client has given a reason for that.
    close: Option<u16>,
}

impl WebSocket {
    /// Takes on a connection; `early` has come after the request.
    pub fn new(socket: Arc<Socket>, early: Vec<u8>) -> Self {
        let incoming = Incoming { early, unframer: Unframer::default(), is_closed: false };
        Self { socket, incoming: Mutex::new(incoming), outgoing: Mutex::default() }
    }
}

impl Transport for WebSocket {
    fn read(&self, buffer: &mut [u8], patience: Duration) -> io::Result<Option<usize>> {
        let mut incoming = lock(&self.incoming);
        if incoming.is_closed {
            return Ok(Some(0));
        }
        let length = if incoming.early.is_empty() {
            match self.socket.read(buffer, patience)? {
                Some([]) => return Ok(Some(0)),
                Some(bytes) => bytes.len(),
                None => return Ok(None),
            }
        } else {
            let length = incoming.early.len().min(buffer.len());
            buffer[..length].copy_from_slice(&incoming.early[..length]);
            incoming.early.drain(..length);
            length
        };
        let mut asked = Asked::default();
        let carried = incoming.unframer.take(&mut buffer[..length], &mut asked);
        incoming.is_closed = asked.is_closed;
        let mut outgoing = lock(&self.outgoing);
        outgoing.pong = asked.ping.or(outgoing.pong.take());
        match carried {
            Ok(0) if asked.is_closed => {
                outgoing.close = Some(DONE);
                Ok(Some(0))
            }
            // Frames may have come without anything that they carry.
            Ok(0) => Ok(None),
            Ok(carried) => Ok(Some(carried)),
            Err(error) => {
                outgoing.close = Some(error.code());
                Err(io::Error::new(ErrorKind::InvalidData, error))
            }
        }
    }

    fn write(&self, bytes: &[u8], patience: Duration) -> io::Result<()> {
        let mut together = Vec::new();
        if let Some(pong) = lock(&self.outgoing).pong.take() {
            together.extend(framing::head(Kind::Pong, pong.len()));
            together.extend(pong);
        }
        if !bytes.is_empty() {
            together.extend(framing::head(Kind::Binary, bytes.len()));
        }
        if bytes.len() > TOGETHER {
            self.socket.write(&together, patience)?;
            return self.socket.write(bytes, patience);
        }
        together.extend_from_slice(bytes);
        self.socket.write(&together, patience)
    }

    fn has_pending(&self) -> bool {
        lock(&self.outgoing).pong.is_some()
    }

    fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()> {
        let code = lock(&self.outgoing).close.unwrap_or(if is_daemons_end { GOING_AWAY } else { DONE });
        let close = [framing::head(Kind::Close, 2), code.to_be_bytes().to_vec()].concat();
        self.socket.write(&close, patience)
    }

    fn shutdown(&self, how: Shutdown) {
        self.socket.shutdown(how);
    }
}

/// What these locks guard is whole between any two statements, so a panic elsewhere leaves it usable.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
