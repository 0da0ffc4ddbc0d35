//! Frames as server-sent events: a transport whose other side speaks for a client that knows nothing of the protocol.
//!
//! ```text
//! daemon ◀── the words of a consumer (speaker) ◀──┐
//! daemon ──▶ messages ──▶ translator ──▶ events ──┴─▶ client
//! ```
//!
//! In: a client's request for the frames of a stream; the protocol's bytes from a connection of the daemon.
//! Out: to the daemon, the bytes of a consumer that subscribes to the stream and answers pings; to the client, the
//! response to its request.
//! Invariants: the client is a consumer as any other: what it does not read is merged for it, and it is disconnected
//! after the timeout; what is held for it is charged to its account. Nothing that it sends after its request is used.
//! No lock is held while bytes are read or written.
//! Must not know: how frames are made, how they become text.

mod request;
mod speaker;
mod translator;

use std::io::{self, BufWriter, ErrorKind, Write};
use std::net::Shutdown;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub use self::request::{FramesRequest, LastId};
use self::speaker::Speaker;
use self::translator::Translator;
use crate::daemon::{Account, Level, Lock, Socket, Transport};

/// The media type of events.
pub const MEDIA_TYPE: &str = "text/event-stream";

/// Bytes of text that are collected before they are sent.
const TOGETHER: usize = 1 << 16;

/// Bytes that a client may send after its request.
const MAX_NOISE: usize = 1 << 14;

/// A client's events.
#[derive(Debug)]
pub struct EventStream {
    socket: Arc<Socket>,
    speaker: Lock<Speaker>,
    /// None while the writer of the connection, the only one who takes it, is at work.
    translator: Lock<Option<Box<Translator>>>,
}

impl EventStream {
    /// The events of a request, of which nothing is sent yet. What is held for them is charged to an account.
    pub fn new(socket: Arc<Socket>, request: FramesRequest, account: &Arc<Account>) -> Self {
        let speaker = Lock::new(Level::Transport, Speaker::new(&request));
        let translator = Lock::new(Level::Transport, Some(Box::new(Translator::new(request, account))));
        Self { socket, speaker, translator }
    }

    /// Has the translator write to the client.
    fn write_events<T>(
        &self,
        patience: Duration,
        write: impl FnOnce(&mut Translator, &mut BufWriter<Sending<'_>>) -> io::Result<T>,
    ) -> io::Result<T> {
        // Taken out of its lock, since writing waits for the client.
        let translator = self.translator.lock().take();
        let mut translator = translator.ok_or_else(|| io::Error::other("an event could not be written"))?;
        let sending = Sending { socket: &self.socket, by: Instant::now() + patience };
        let mut output = BufWriter::with_capacity(TOGETHER, sending);
        let written = write(&mut translator, &mut output).and_then(|written| output.flush().map(|()| written));
        if written.is_err() {
            // A part of an event may have been sent: nothing can follow it. What was not sent is given up.
            let _ = output.into_parts();
        } else {
            drop(output);
            *self.translator.lock() = Some(translator);
        }
        written
    }
}

impl Transport for EventStream {
    fn read(&self, buffer: &mut [u8], patience: Duration) -> io::Result<Option<usize>> {
        let said = {
            let mut speaker = self.speaker.lock();
            speaker.take(buffer)
        };
        if let Some(length) = said {
            return Ok(Some(length));
        }
        match self.socket.read(buffer, patience)? {
            Some([]) => Ok(Some(0)),
            Some(noise) => {
                let heard = self.speaker.lock().hear(noise.len());
                let is_too_much = heard > MAX_NOISE;
                let text = "a client of events has sent more than its request";
                if is_too_much { Err(io::Error::new(ErrorKind::InvalidData, text)) } else { Ok(None) }
            }
            None => Ok(None),
        }
    }

    fn write(&self, bytes: &[u8], patience: Duration) -> io::Result<()> {
        let answers = self.write_events(patience, |translator, output| translator.take(bytes, output))?;
        self.speaker.lock().say(answers);
        Ok(())
    }

    fn has_pending(&self) -> bool {
        false
    }

    fn finish(&self, is_daemons_end: bool, patience: Duration) -> io::Result<()> {
        self.write_events(patience, |translator, output| translator.finish(is_daemons_end, output))
    }

    fn shutdown(&self, how: Shutdown) {
        self.socket.shutdown(how);
    }
}

/// A client that is sent text until some time.
struct Sending<'a> {
    socket: &'a Socket,
    by: Instant,
}

impl Write for Sending<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.socket.write(bytes, self.by.saturating_duration_since(Instant::now())).map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
