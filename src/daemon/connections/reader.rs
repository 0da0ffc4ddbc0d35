//! The reader thread of a connection: takes the peer's bytes apart into messages.
//!
//! In: bytes of the socket. Out: messages, to the [`Session`].
//!
//! Invariants: only bytes that are no frames end the connection. A peer that sends nothing, or only part of a frame,
//! for too long is disconnected. What has not come as a whole is charged to the peer.
//!
//! Must not know: what messages say.

use std::io::ErrorKind;
use std::sync::Arc;
use std::time::{Duration, Instant};

use hopes_protocol::{self as wire, ErrorCode, Message};

use super::connection::Connection;
use super::control_pace::{ControlPace, REST, SNAPSHOT};
use super::members::Members;
use super::session::Session;
use crate::daemon::locks::before_waiting;
use crate::daemon::memory::Charge;
use crate::daemon::report::report;
use crate::daemon::settings::Limits;
use crate::daemon::streams::directory::Directory;

/// How long a peer may take for its banner and its first message.
const HANDSHAKE: Duration = Duration::from_secs(10);

/// How long a read waits before the reader looks whether it is to stop.
const TICK: Duration = Duration::from_millis(500);

/// How long the connection that is reserved for administration may last.
const RESERVED: Duration = Duration::from_secs(10);

/// The buffer of a read at first. It grows for peers that fill it.
const FIRST_BUFFER: usize = 1 << 12;

/// The largest buffer of a read.
const LARGEST_BUFFER: usize = 1 << 16;

/// Why a connection ends.
enum End {
    /// The peer has sent goodbye or disconnected, or the daemon is ending.
    Polite,
    /// It cannot go on.
    Failed(wire::Report),
    /// The two sides have no version in common, as the banners say.
    Incompatible(wire::NoCommonVersion),
}

/// Reads until the connection ends.
pub fn run(directory: &Arc<Directory>, members: &Arc<Members>, connection: &Arc<Connection>) {
    let mut reader = Reader {
        limits: &directory.limits,
        members,
        connection,
        session: Session::new(directory, members, connection),
        held: connection.consumer.account.charge(0),
        decoder: wire::Decoder::new(directory.limits.largest_frame),
        began: Instant::now(),
        pace: ControlPace::new(Instant::now()),
        has_banner: false,
    };
    let end = reader.read();
    reader.session.leave();
    let reason = match end {
        End::Polite => "goodbye".to_owned(),
        End::Failed(report) => {
            if let Some(note) = directory.logs.admits("failed", &connection.place) {
                tracing::info!("{}: {}{note}", connection.label, report.text);
            }
            directory.count_refused_message();
            let text = report.text.clone();
            connection.send(0, report);
            text
        }
        End::Incompatible(error) => {
            if let Some(note) = directory.logs.admits("version", &connection.place) {
                tracing::info!("{}: {error}{note}", connection.label);
            }
            directory.count_refused_message();
            return connection.set_incompatible();
        }
    };
    if !connection.is_ending() {
        connection.say_goodbye(&reason, Vec::new());
    }
    tracing::debug!("{}: ends: {reason}", connection.label);
}

struct Reader<'a> {
    limits: &'a Limits,
    members: &'a Members,
    connection: &'a Arc<Connection>,
    session: Session<'a>,
    /// What messages take that have not come as a whole.
    held: Charge,
    decoder: wire::Decoder,
    /// When the frame that has not come as a whole began.
    began: Instant,
    pace: ControlPace,
    has_banner: bool,
}

impl Reader<'_> {
    fn read(&mut self) -> End {
        let mut buffer = vec![0; FIRST_BUFFER];
        let tick = TICK.min(self.limits.timeout / 4);
        loop {
            let (was_within, buffer_size) = (self.decoder.is_within_frame(), buffer.len());
            let read = self.connection.socket.read(&mut buffer, tick);
            if self.connection.socket.has_pending() {
                self.connection.wake_writer();
            }
            match read {
                _ if self.connection.is_ending() => return End::Polite,
                Err(error) if error.kind() == ErrorKind::InvalidData => {
                    return End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
                }
                Err(_) | Ok(Some([])) => return End::Polite,
                Ok(None) => {}
                Ok(Some(bytes)) => {
                    let (length, is_full) = (bytes.len(), bytes.len() == buffer_size);
                    self.connection.note_received(length);
                    self.decoder.push(bytes);
                    if is_full && buffer_size < LARGEST_BUFFER {
                        buffer = vec![0; 4 * buffer_size];
                    }
                    self.held.set((self.decoder.capacity() + buffer.len()) as u64);
                    if let Err(end) = self.take_frames() {
                        return end;
                    }
                    // Handing things on may have taken its time, and the peer's frame is not older than its last byte
                    // then.
                    if !was_within || !self.decoder.is_within_frame() {
                        self.began = Instant::now();
                    }
                }
            }
            if let Some(reason) = self.is_too_slow() {
                return End::Failed(report(ErrorCode::TooSlow, 0, reason));
            }
        }
    }

    fn is_too_slow(&self) -> Option<&'static str> {
        let timeout = self.limits.timeout;
        if !self.session.is_greeted() && self.began.elapsed() > HANDSHAKE.min(timeout) {
            return Some("no banner and Hello came in time");
        }
        if self.connection.silence() > timeout {
            return Some("nothing was heard for too long: answer Ping with Pong");
        }
        if self.connection.is_reserved && self.connection.counts.since.elapsed() > RESERVED {
            return Some("the connection that is reserved for administration has been used for long enough");
        }
        let is_stuck = self.decoder.is_within_frame() && self.began.elapsed() > timeout;
        is_stuck.then_some("a frame took too long to come")
    }

    fn take_frames(&mut self) -> Result<(), End> {
        let broken = |error: wire::FrameError| End::Failed(report(ErrorCode::BadFrame, 0, error.to_string()));
        if !self.has_banner {
            let Some(theirs) = self.decoder.banner().map_err(broken)? else { return Ok(()) };
            let version = wire::Banner::OURS.agree(theirs).map_err(End::Incompatible)?;
            self.decoder.set_version(version);
            self.connection.set_version(version);
            self.has_banner = true;
        }
        while let Some(frame) = self.decoder.frame().map_err(broken)? {
            // It counts as unanswered until this is dropped. This may wait, and the peer may be gone afterwards.
            let pending = self.connection.outbox.expect_answer();
            if self.connection.is_cut_off() {
                return Err(End::Polite);
            }
            self.check_place()?;
            let message = frame.message();
            self.keep_pace(&message)?;
            match message {
                Ok(Message::Goodbye(_)) => return Err(End::Polite),
                Ok(message) => self.session.take(frame.channel, frame.kind, message, pending),
                Err(error) => {
                    let code = match error {
                        wire::BodyError::UnknownType { .. } => ErrorCode::Unexpected,
                        _ => ErrorCode::Unreadable,
                    };
                    self.session.refuse(frame.channel, code, frame.kind, error.to_string());
                }
            }
            self.connection.note_received(0);
        }
        self.check_place()
    }

    /// Counts a control message, and waits while the peer is ahead with them.
    fn keep_pace(&mut self, message: &Result<Message, wire::BodyError>) -> Result<(), End> {
        let counts_for = match message {
            Ok(Message::Batch(_) | Message::Retract(_) | Message::Commit(_)) => return Ok(()),
            Ok(Message::Subscribe(_) | Message::ChangeView(_)) => SNAPSHOT,
            _ => 1.0,
        };
        while !self.pace.takes(counts_for, &self.members.control_pool, Instant::now()) {
            before_waiting("a peer that asks too much");
            std::thread::sleep(REST);
            self.connection.note_received(0);
            if self.connection.is_ending() || self.connection.is_cut_off() {
                return Err(End::Polite);
            }
        }
        Ok(())
    }

    /// Above the limit of connections there is one, for administration only.
    fn check_place(&self) -> Result<(), End> {
        let text = "all connections are taken, but for one that is for administration: try again later";
        let is_right = !self.session.has_no_place();
        is_right.then_some(()).ok_or_else(|| End::Failed(report(ErrorCode::TooManyConnections, 0, text)))
    }
}
