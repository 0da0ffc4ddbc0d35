//! Replies to producers: what became of their batches, and where the answer goes.
//!
//! In: point by point, whether it was taken. Out: one reply per batch, through a [`ReplySink`].
//!
//! Invariants: every point is counted; a bounded number of refusals is listed; a reply never makes the engine wait.
//!
//! Must not know: the engine, connections.

use std::fmt;
use std::sync::Arc;

use hopes::topology::{Refusal, VertexId};
use hopes_protocol as wire;
use thiserror::Error;

use super::convert;
use super::input::Batch;

/// Where replies to one producer go. The side of the connection implements it; no method may wait.
pub trait ReplySink: fmt::Debug + Send + Sync {
    /// Sends a reply.
    fn reply(&self, message: wire::Message);
    /// Tells that a message was dropped, with its points.
    fn dropped(&self, sequence: u64, points: u32, policy: wire::Policy);
    /// Tells that nothing more comes from the stream, whose last frame is this.
    fn close(&self, frame: u64);
    /// Tells that the stream has failed, and closes.
    fn fail(&self, reason: &str, frame: u64);
}

/// A message counts as unanswered until this is dropped.
pub trait Unanswered: fmt::Debug + Send {}

/// Where the reply to one message goes.
#[derive(Debug)]
pub struct ReplyTo {
    sink: Arc<dyn ReplySink>,
    sequence: u64,
    /// Held for its drop.
    _unanswered: Option<Box<dyn Unanswered>>,
}

impl ReplyTo {
    /// The reply to a producer's message of this sequence number.
    pub fn new(sink: Arc<dyn ReplySink>, sequence: u64, unanswered: Option<Box<dyn Unanswered>>) -> Self {
        Self { sink, sequence, _unanswered: unanswered }
    }

    /// The producer.
    pub fn sink(&self) -> &Arc<dyn ReplySink> {
        &self.sink
    }

    /// Replies that the message was dropped.
    pub fn dropped(&self, points: u32, policy: wire::Policy) {
        self.sink.dropped(self.sequence, points, policy);
    }

    /// Replies that the frame was closed.
    pub fn committed(&self, frame: u64) {
        self.sink.reply(wire::Committed { sequence: self.sequence, frame }.into());
    }
}

/// Why a point was not taken.
#[derive(Clone, Debug, Error)]
pub enum RefusalReason {
    /// The cloud refuses it.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The stream is at a limit.
    #[error("the stream holds {limit} {what}, and may hold no more: use a window or a resolution, or allow more")]
    StreamFull {
        /// Points, or distinct positions.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// The daemon is at its limit.
    #[error("all streams hold about {held} bytes, and may hold {limit}: end one, use windows, or allow more")]
    DaemonFull {
        /// Bytes held.
        held: u64,
        /// The limit.
        limit: u64,
    },
}

impl RefusalReason {
    /// Whether the point's event time is at fault, which a commit may put right for those to come.
    pub fn is_outside_window(&self) -> bool {
        matches!(self, Self::Refused(Refusal::TooLate { .. } | Refusal::Unconfirmed { .. } | Refusal::Outdated { .. }))
    }

    fn code(&self) -> wire::RefusalCode {
        match self {
            Self::Refused(refusal) => convert::refusal_code(refusal),
            Self::StreamFull { .. } => wire::RefusalCode::StreamFull,
            Self::DaemonFull { .. } => wire::RefusalCode::DaemonFull,
        }
    }
}

/// What became of a batch.
#[derive(Debug)]
pub struct BatchReply {
    accepted: u32,
    refused: u32,
    reasons: Vec<wire::Refusal>,
    placed: Vec<(u64, u64)>,
}

impl BatchReply {
    /// A batch of which no point was looked at yet.
    pub fn new(batch: &Batch) -> Self {
        let placed = Vec::with_capacity(batch.tags.len());
        Self { accepted: 0, refused: 0, reasons: Vec::new(), placed }
    }

    /// Counts a point that was taken.
    pub fn accept(&mut self, batch: &Batch, index: usize, vertex: VertexId) {
        self.accepted += 1;
        self.placed.extend(batch.tags.get(index).map(|&tag| (tag, vertex.0)));
    }

    /// Counts a point that was not taken.
    pub fn refuse(&mut self, index: usize, reason: &RefusalReason) {
        self.refused += 1;
        if self.reasons.len() < wire::LISTED_REFUSALS {
            let text = reason.to_string();
            self.reasons.push(wire::Refusal { index: index as u32, code: reason.code() as u16, text });
        }
    }

    /// Points that were taken.
    pub fn accepted(&self) -> u64 {
        self.accepted.into()
    }

    /// Points that were not taken.
    pub fn refused(&self) -> u64 {
        self.refused.into()
    }

    /// Sends the reply.
    pub fn send(self, to: &ReplyTo) {
        let Self { accepted, refused, reasons, placed } = self;
        let sequence = to.sequence;
        to.sink.reply(match refused {
            0 => wire::Accepted { sequence, points: accepted, placed }.into(),
            _ => wire::Refused { sequence, accepted, refused, reasons, placed }.into(),
        });
    }
}
