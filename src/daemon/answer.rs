//! What a producer is told of a batch.
//!
//! In: point by point, whether it was taken. Out: one answer a batch. Invariants: every point is counted; only so many refusals are listed. Must not know: the engine.

use hopes::topology::{Refusal, VertexId};
use hopes_protocol as wire;
use thiserror::Error;

use super::convert;
use super::inbox::{Batch, Origin};

/// Why a point was not taken.
#[derive(Clone, Debug, Error)]
pub enum Problem {
    /// The cloud does not want it.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The stream may hold no more.
    #[error("the stream holds {limit} {what}, and may hold no more: use a window or a resolution, or allow more")]
    StreamFull {
        /// Points, or distinct positions.
        what: &'static str,
        /// So many.
        limit: u64,
    },
    /// The daemon may hold no more.
    #[error("all streams hold about {held} bytes, and may hold {limit}: end one, use windows, or allow more")]
    DaemonFull {
        /// So much.
        held: u64,
        /// Of so much.
        limit: u64,
    },
}

impl Problem {
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
pub struct Answer {
    accepted: u32,
    refused: u32,
    reasons: Vec<wire::Refusal>,
    placed: Vec<(u64, u64)>,
}

impl Answer {
    /// Nothing has been looked at yet.
    pub fn new(batch: &Batch) -> Self {
        let placed = Vec::with_capacity(batch.tags.len());
        Self { accepted: 0, refused: 0, reasons: Vec::new(), placed }
    }

    /// A point was taken.
    pub fn accept(&mut self, batch: &Batch, index: usize, vertex: VertexId) {
        self.accepted += 1;
        self.placed.extend(batch.tags.get(index).map(|&tag| (tag, vertex.0)));
    }

    /// A point was not taken.
    pub fn refuse(&mut self, index: usize, problem: &Problem) {
        self.refused += 1;
        if self.reasons.len() < wire::LISTED_REFUSALS {
            let text = problem.to_string();
            self.reasons.push(wire::Refusal { index: index as u32, code: problem.code() as u16, text });
        }
    }

    /// How many points were taken.
    pub fn accepted(&self) -> u64 {
        self.accepted.into()
    }

    /// How many were not.
    pub fn refused(&self) -> u64 {
        self.refused.into()
    }

    /// Tells whoever sent the batch.
    pub fn send(self, origin: &Origin) {
        let Self { accepted, refused, reasons, placed } = self;
        let Origin::Peer { channel, sequence, .. } = origin else { return };
        let sequence = *sequence;
        match refused {
            0 => channel.answer(wire::Accepted { sequence, points: accepted, placed }),
            _ => channel.answer(wire::Refused { sequence, accepted, refused, reasons, placed }),
        }
    }
}
