//! A channel on which a peer feeds a stream: where the replies to its messages go.
//!
//! In: replies of engines and queues. Out: the same, to the outbox of the connection.
//!
//! Invariants: no reply waits.
//!
//! Must not know: engines, sockets.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use hopes_protocol as wire;

use super::outbox::Outbox;
use crate::daemon::encoding::encoded;
use crate::daemon::memory::Account;
use crate::daemon::report::report;
use crate::daemon::streams::reply::ReplySink;

/// A producer's channel.
#[derive(Debug)]
pub struct ProducerChannel {
    number: u32,
    outbox: Arc<Outbox>,
    account: Arc<Account>,
    /// Points dropped so far.
    dropped: AtomicU64,
}

impl ProducerChannel {
    /// The channel of this number, whose replies go to an outbox and are charged to an account.
    pub fn new(number: u32, outbox: Arc<Outbox>, account: Arc<Account>) -> Self {
        Self { number, outbox, account, dropped: AtomicU64::new(0) }
    }
}

impl ReplySink for ProducerChannel {
    fn reply(&self, message: wire::Message) {
        if let Some(message) = encoded(message, &self.account) {
            self.outbox.push(self.number, message);
        }
    }

    fn dropped(&self, sequence: u64, points: u32, policy: wire::Policy) {
        let total = self.dropped.fetch_add(u64::from(points), Ordering::Relaxed) + u64::from(points);
        self.reply(wire::Overloaded { sequence, points, total, policy }.into());
    }

    fn close(&self, frame: u64) {
        self.reply(wire::Closed { frame }.into());
    }

    fn fail(&self, reason: &str, frame: u64) {
        let text = format!("the stream has failed: {reason}");
        self.reply(report(wire::ErrorCode::StreamFailed, 0, text).into());
        self.close(frame);
    }
}
