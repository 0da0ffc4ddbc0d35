//! The protocol in a WebSocket: the handshake, and a transport for the protocol's bytes.
//!
//! In: a request for an upgrade, then a client's frames.
//! Out: the answer to the request, then a [`Transport`] for a connection of the daemon.
//! Invariants: the protocol's bytes are the payload of binary messages; message boundaries have no meaning. Only the
//! connection's writer thread writes, so frames never interleave. It answers a ping at its next write.
//! Must not know: the protocol.

use std::io::{self, ErrorKind};
use std::net::Shutdown;
use std::sync::Arc;
use std::time::Duration;

use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::frame::coding::{CloseCode, Control, Data, OpCode};

use super::framing::{self, ControlRequests, FrameDecoder};
use super::http::{Refusal, Request};
use crate::daemon::{Level, Lock, Socket, Transport};

/// The protocol's name in the handshake.
const SUBPROTOCOL: &str = "hopes";

/// Payloads up to this size are copied, to be written together with their header.
const MAX_COPIED: usize = 1 << 17;

/// The answer to a request for a WebSocket.
///
/// # Errors
/// [`Refusal`]: it is no valid request for one.
pub fn handshake(request: &Request) -> Result<Vec<u8>, Refusal> {
    if !request.lists("upgrade", "websocket") || !request.lists("connection", "upgrade") {
        return Err(Refusal::upgrade_required("this is a WebSocket: request an upgrade to it"));
    }
    if request.header("sec-websocket-version") != Some("13") {
        return Err(Refusal::upgrade_required("the version of WebSockets here is 13"));
    }
    let key = request.header("sec-websocket-key").unwrap_or_default();
    if !is_key(key) {
        return Err(Refusal::new(400, "a Sec-WebSocket-Key has 16 bytes, in base64"));
    }
    let is_offering = request.header("sec-websocket-protocol").is_some();
    if is_offering && !request.lists("sec-websocket-protocol", SUBPROTOCOL) {
        return Err(Refusal::new(400, "the subprotocol here is hopes: offer it, or none"));
    }
    let accept = derive_accept_key(key.as_bytes());
    let chosen = if is_offering { format!("Sec-WebSocket-Protocol: {SUBPROTOCOL}\r\n") } else { String::new() };
    Ok(format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n{chosen}\r\n"
    )
    .into_bytes())
}

/// Whether a key is 16 bytes in base64.
fn is_key(key: &str) -> bool {
    let is_digit = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'/');
    key.strip_suffix("==").is_some_and(|digits| digits.len() == 22 && digits.bytes().all(is_digit))
}

/// A connection after its handshake.
#[derive(Debug)]
pub struct WebSocket {
    socket: Arc<Socket>,
    incoming: Lock<Incoming>,
    outgoing: Lock<Outgoing>,
}

/// The state of the reader.
#[derive(Debug)]
struct Incoming {
    /// Bytes that came together with the request and are not decoded yet.
    early: Vec<u8>,
    decoder: FrameDecoder,
    is_closed: bool,
}

/// Control frames that the writer has to send.
#[derive(Debug, Default)]
struct Outgoing {
    pong: Option<Vec<u8>>,
    /// Why the connection ends, if the client caused that.
    close: Option<CloseCode>,
}

impl WebSocket {
    /// A WebSocket on a socket; `early` came after the request.
    pub fn new(socket: Arc<Socket>, early: Vec<u8>) -> Self {
        let incoming = Incoming { early, decoder: FrameDecoder::default(), is_closed: false };
        let outgoing = Lock::new(Level::Leaf, Outgoing::default());
        Self { socket, incoming: Lock::new(Level::Transport, incoming), outgoing }
    }
}

/// What came together with the request.
enum Early {
    Closed,
    Bytes(usize),
    Nothing,
}

impl WebSocket {
    fn early(&self, buffer: &mut [u8]) -> Early {
        let mut incoming = self.incoming.lock();
        let length = incoming.early.len().min(buffer.len());
        if incoming.is_closed {
            return Early::Closed;
        } else if length == 0 {
            return Early::Nothing;
        }
        buffer[..length].copy_from_slice(&incoming.early[..length]);
        incoming.early.drain(..length);
        Early::Bytes(length)
    }
}

impl Transport for WebSocket {
    fn read(&self, buffer: &mut [u8], patience: Duration) -> io::Result<Option<usize>> {
        // Only the connection's reader thread reads, so nothing comes in between where no lock is held.
        let length = match self.early(buffer) {
            Early::Closed => return Ok(Some(0)),
            Early::Bytes(length) => length,
            Early::Nothing => match self.socket.read(buffer, patience)? {
                Some([]) => return Ok(Some(0)),
                Some(bytes) => bytes.len(),
                None => return Ok(None),
            },
        };
        let mut incoming = self.incoming.lock();
        let mut requests = ControlRequests::default();
        let decoded = incoming.decoder.decode(&mut buffer[..length], &mut requests);
        incoming.is_closed = requests.is_closed;
        let mut outgoing = self.outgoing.lock();
        outgoing.pong = requests.ping.or(outgoing.pong.take());
        match decoded {
            Ok(0) if requests.is_closed => {
                outgoing.close = Some(CloseCode::Normal);
                Ok(Some(0))
            }
            // Control frames and headers have no payload for the protocol.
            Ok(0) => Ok(None),
            Ok(decoded) => Ok(Some(decoded)),
            Err(error) => {
                outgoing.close = Some(error.code());
                Err(io::Error::new(ErrorKind::InvalidData, error))
            }
        }
    }

    fn write(&self, bytes: &[u8], patience: Duration) -> io::Result<()> {
        let mut output = Vec::new();
        if let Some(pong) = self.outgoing.lock().pong.take() {
            output.extend(framing::header(OpCode::Control(Control::Pong), pong.len()));
            output.extend(pong);
        }
        if !bytes.is_empty() {
            output.extend(framing::header(OpCode::Data(Data::Binary), bytes.len()));
        }
        if bytes.len() > MAX_COPIED {
            self.socket.write(&output, patience)?;
            return self.socket.write(bytes, patience);
        }
        output.extend_from_slice(bytes);
        self.socket.write(&output, patience)
    }

    fn has_pending(&self) -> bool {
        self.outgoing.lock().pong.is_some()
    }

    fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()> {
        let default = if is_daemons_end { CloseCode::Away } else { CloseCode::Normal };
        let code = u16::from(self.outgoing.lock().close.unwrap_or(default));
        let mut close = framing::header(OpCode::Control(Control::Close), size_of::<u16>());
        close.extend(code.to_be_bytes());
        self.socket.write(&close, patience)
    }

    fn shutdown(&self, how: Shutdown) {
        self.socket.shutdown(how);
    }
}
