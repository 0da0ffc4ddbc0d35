//! What the sources of a stream have sent since their last commits.
//!
//! In: points and retractions of producers, and of stdin where its points wait. Out: the same to the pipeline at a
//! source's commit.
//!
//! Invariants: a frame has nothing of a source that has not committed it. What waits is charged to the stream. Sources
//! stay known until they end, since a time window knows their clocks.
//!
//! Must not know: frames, replies but as the identity of producers.

use std::sync::{Arc, Weak};

use hopes::topology::{Admission, FirstCoordinates, Refusal};

use crate::daemon::memory::{Account, Charge};
use crate::daemon::streams::pipeline::{AnyPipeline, Waiting};
use crate::daemon::streams::reply::ReplySink;

/// What a source has sent since its last commit.
#[derive(Debug)]
pub struct Source {
    /// None for stdin.
    producer: Option<Weak<dyn ReplySink>>,
    /// What waits.
    pub staging: Waiting,
    /// Points and retractions that were refused.
    pub rejected: u64,
    /// Of stdin: where all that waits stands in the input.
    pub places: Vec<Place>,
    /// Whether it was told that a commit of it is refused in part.
    is_told: bool,
    charge: Charge,
}

/// Where a point stands in the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its line, or what `unit` says.
    pub line: u64,
    /// What this counts.
    pub unit: &'static str,
    /// The point.
    pub point: FirstCoordinates,
}

/// What all sources of a stream have sent since their last commits.
#[derive(Debug)]
pub struct Uncommitted {
    sources: Vec<Source>,
    account: Arc<Account>,
}

/// What has become of what a source had sent.
#[derive(Debug, Default)]
pub struct Fed {
    /// Whether there was anything.
    pub is_any: bool,
    /// What was refused when it came.
    pub rejected: u64,
    /// What was refused now, and of the commit's time.
    pub admission: Admission,
    /// The newest event time of its points.
    pub newest_time: Option<f64>,
    /// Of stdin: what was refused now.
    pub refused: Vec<(Place, Refusal)>,
    /// Of a producer: the first that was refused now, if the commit before was not refused in part.
    pub first: Option<Refusal>,
}

impl Source {
    fn new(producer: Option<Weak<dyn ReplySink>>, staging: Waiting, charge: Charge) -> Self {
        Self { producer, staging, rejected: 0, places: Vec::new(), is_told: false, charge }
    }

    /// Keeps the account of what waits.
    pub fn note_size(&mut self) {
        self.charge.set((self.staging.bytes() + size_of_val(self.places.as_slice())) as u64);
    }

    fn feed(&mut self, pipeline: &mut AnyPipeline, time: Option<f64>) -> Fed {
        let rejected = std::mem::take(&mut self.rejected);
        let mut fed = Fed { is_any: !self.staging.is_empty() || rejected > 0, rejected, ..Fed::default() };
        fed.newest_time = self.staging.newest_time();
        let (places, mut first) = (std::mem::take(&mut self.places), None);
        let refused = &mut fed.refused;
        fed.admission = pipeline.feed_staged(&mut self.staging, time, &mut |index, refusal| {
            first = first.or(Some(refusal));
            refused.extend(places.get(index).map(|&place| (place, refusal)));
        });
        fed.first = first.filter(|_| !self.is_told);
        self.is_told = first.is_some() || (self.is_told && !fed.is_any);
        self.note_size();
        fed
    }

    fn is_of(&self, producer: Option<&Arc<dyn ReplySink>>) -> bool {
        match (&self.producer, producer) {
            // A weak reference keeps the address from being used again.
            (Some(one), Some(other)) => std::ptr::addr_eq(one.as_ptr(), Arc::as_ptr(other)),
            (None, None) => true,
            _ => false,
        }
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

    /// What a producer has sent since its last commit; none is stdin.
    pub fn of(&mut self, producer: Option<&Arc<dyn ReplySink>>, pipeline: &AnyPipeline) -> &mut Source {
        let place = self.place(producer).unwrap_or_else(|| {
            self.sources.push(Source::new(producer.map(Arc::downgrade), pipeline.waiting(), self.account.charge(0)));
            self.sources.len() - 1
        });
        &mut self.sources[place]
    }

    /// Feeds what a source has sent, for its commit with a time.
    pub fn feed(
        &mut self,
        producer: Option<&Arc<dyn ReplySink>>,
        pipeline: &mut AnyPipeline,
        time: Option<f64>,
    ) -> Fed {
        self.of(producer, pipeline).feed(pipeline, time)
    }

    /// Feeds what all sources have sent, one after the other, for a frame that nobody has committed.
    pub fn feed_all(&mut self, pipeline: &mut AnyPipeline) -> Vec<Fed> {
        let waiting = self.sources.iter_mut().filter(|source| !source.staging.is_empty() || source.rejected > 0);
        waiting.map(|source| source.feed(pipeline, None)).collect()
    }

    /// Forgets a producer and what it has sent. Returns the number of its points.
    pub fn discard(&mut self, producer: Option<&Arc<dyn ReplySink>>, pipeline: &mut AnyPipeline) -> u64 {
        let Some(place) = self.place(producer) else { return 0 };
        let mut source = self.sources.swap_remove(place);
        let points = source.staging.point_count();
        pipeline.discard_staged(&mut source.staging);
        points
    }

    fn place(&self, producer: Option<&Arc<dyn ReplySink>>) -> Option<usize> {
        self.sources.iter().position(|source| source.is_of(producer))
    }
}
