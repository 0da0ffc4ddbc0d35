//! What the producers of a stream have sent since their last commits.
//!
//! In: points and retractions of producers. Out: the same to the pipeline at a producer's commit.
//!
//! Invariants: a frame has nothing of a producer that has not committed it. What waits is charged to the stream.
//!
//! Must not know: frames, replies but as the identity of producers.

use std::sync::{Arc, Weak};

use hopes::topology::{Pipeline, Staging};

use crate::daemon::memory::{Account, Charge};
use crate::daemon::streams::reply::ReplySink;

/// What a producer has sent since its last commit.
#[derive(Debug)]
pub struct Source {
    producer: Weak<dyn ReplySink>,
    /// What waits.
    pub staging: Staging,
    /// Points and retractions that were refused.
    pub rejected: u64,
    charge: Charge,
}

/// What all producers of a stream have sent since their last commits.
#[derive(Debug)]
pub struct Uncommitted {
    sources: Vec<Source>,
    account: Arc<Account>,
}

/// What has become of what a producer had sent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fed {
    /// Whether there was anything.
    pub is_any: bool,
    /// What was refused, when it came or now.
    pub rejected: u64,
    /// The newest event time of its points.
    pub newest_time: Option<f64>,
}

impl Source {
    /// Keeps the account of what waits.
    pub fn note_size(&mut self) {
        self.charge.set(self.staging.bytes() as u64);
    }
}

impl Uncommitted {
    /// Nothing waits. What will is charged to an account.
    pub fn new(account: Arc<Account>) -> Self {
        Self { sources: Vec::new(), account }
    }

    /// Points that wait.
    pub fn point_count(&self) -> u64 {
        self.sources.iter().map(|source| source.staging.point_count()).sum()
    }

    /// What a producer has sent since its last commit.
    pub fn of(&mut self, producer: &Arc<dyn ReplySink>) -> &mut Source {
        let place = self.place(producer).unwrap_or_else(|| {
            let (producer, charge) = (Arc::downgrade(producer), self.account.charge(0));
            self.sources.push(Source { producer, staging: Staging::default(), rejected: 0, charge });
            self.sources.len() - 1
        });
        &mut self.sources[place]
    }

    /// Feeds what a producer has sent, for its commit.
    pub fn feed(&mut self, producer: &Arc<dyn ReplySink>, pipeline: &mut Pipeline) -> Fed {
        let Some(mut source) = self.take(producer) else { return Fed::default() };
        let (is_any, newest_time) = (!source.staging.is_empty() || source.rejected > 0, source.staging.newest_time());
        let rejected = source.rejected + pipeline.feed_staged(&mut source.staging);
        Fed { is_any, rejected, newest_time }
    }

    /// Forgets what a producer has sent. Returns the number of its points.
    pub fn discard(&mut self, producer: &Arc<dyn ReplySink>, pipeline: &mut Pipeline) -> u64 {
        let Some(mut source) = self.take(producer) else { return 0 };
        let points = source.staging.point_count();
        pipeline.discard_staged(&mut source.staging);
        points
    }

    fn take(&mut self, producer: &Arc<dyn ReplySink>) -> Option<Source> {
        self.place(producer).map(|place| self.sources.swap_remove(place))
    }

    fn place(&self, producer: &Arc<dyn ReplySink>) -> Option<usize> {
        // A weak reference keeps the address from being used again.
        self.sources.iter().position(|source| std::ptr::addr_eq(source.producer.as_ptr(), Arc::as_ptr(producer)))
    }
}
