//! Points that wait for their commit: those of one source, kept apart from what the cloud has.
//!
//! In: points and retractions of a source. Out: the same to the cloud at the source's commit (see `admission`), or
//! nothing if the source ends without one.
//! Invariants: what waits is in no frame, but its vertices have their ids already. Sources do not see each other's
//! points. In a window of N points, what came before the last N in a row has no effect at the commit, and is forgotten.
//! Must not know: who the sources are.

use std::collections::VecDeque;

use hashbrown::HashMap;

use super::clocks::SourceClock;
use super::position::Position;
use super::refusal::Refusal;
use super::site::Site;
use super::store::Cloud;
use super::vertex::{Awaiting, VertexId};
use super::window::Window;

/// What one source has sent since its last commit.
#[derive(Clone, Debug)]
pub struct Staging<S = Position> {
    pub(super) waiting: VecDeque<Staged<S>>,
    /// Points among what waits.
    points: u64,
    /// Points among these without a time of their own.
    pub(super) undated: u64,
    /// The newest event time of these points.
    newest_time: Option<f64>,
    /// Points since the last retraction.
    run: u64,
    /// Points less retractions that wait, by position; known while a retraction waits.
    balance: Option<HashMap<S, i64>>,
    /// Of the source, for a time window.
    pub(super) clock: SourceClock,
}

#[derive(Clone, Debug)]
pub(super) enum Staged<S> {
    Point(StagedPoint<S>),
    Retraction(S),
}

/// A point that waits.
#[derive(Clone, Debug)]
pub(super) struct StagedPoint<S> {
    pub place: Awaiting<S>,
    pub time: Option<f64>,
}

impl<S> Default for Staging<S> {
    fn default() -> Self {
        Self {
            waiting: VecDeque::new(),
            points: 0,
            undated: 0,
            newest_time: None,
            run: 0,
            balance: None,
            clock: SourceClock::default(),
        }
    }
}

impl<S: Site> Staging<S> {
    /// Points that wait.
    pub fn point_count(&self) -> u64 {
        self.points
    }

    /// The newest event time of points that wait.
    pub fn newest_time(&self) -> Option<f64> {
        self.newest_time
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        let balance = self.balance.as_ref().map_or(0, HashMap::capacity);
        let coordinates = self.waiting.front().map_or(0, |staged| match staged {
            Staged::Point(point) => point.place.position.heap_size(),
            Staged::Retraction(position) => position.heap_size(),
        });
        self.waiting.capacity() * size_of::<Staged<S>>()
            + self.waiting.len() * coordinates
            + balance * size_of::<(S, i64)>()
    }

    /// Takes all that waits.
    pub(super) fn take(&mut self) -> VecDeque<Staged<S>> {
        let clock = std::mem::take(&mut self.clock);
        std::mem::replace(self, Self { clock, ..Self::default() }).waiting
    }

    fn push(&mut self, staged: Staged<S>) {
        match &staged {
            Staged::Point(point) => {
                (self.points, self.run) = (self.points + 1, self.run + 1);
                self.undated += u64::from(point.time.is_none());
                self.newest_time = point.time.into_iter().chain(self.newest_time).reduce(f64::max);
                if let Some(balance) = &mut self.balance {
                    *balance.entry(point.place.position.clone()).or_default() += 1;
                }
            }
            Staged::Retraction(position) => {
                self.run = 0;
                *self.balance().entry(position.clone()).or_default() -= 1;
            }
        }
        self.waiting.push_back(staged);
    }

    /// Points less retractions that wait, by position.
    fn balance(&mut self) -> &mut HashMap<S, i64> {
        self.balance.get_or_insert_with(|| {
            let mut balance = HashMap::new();
            for staged in &self.waiting {
                if let Staged::Point(point) = staged {
                    *balance.entry(point.place.position.clone()).or_default() += 1;
                }
            }
            balance
        })
    }
}

impl<S: Site> Cloud<S> {
    /// Has a point wait for its source's commit, which dates it if it has no time of its own. Returns the vertex at its
    /// site, which may be one that is not there yet.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage_site(&mut self, staging: &mut Staging<S>, site: S, time: Option<f64>) -> Result<VertexId, Refusal> {
        let position = self.place_of(site)?;
        self.check_time(staging, time)?;
        let place = self.await_point(position)?;
        let vertex = place.vertex;
        staging.push(Staged::Point(StagedPoint { place, time }));
        self.drop_surplus(staging);
        Ok(vertex)
    }

    /// Has a retraction wait for its source's commit.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage_retraction_of(&mut self, staging: &mut Staging<S>, site: S) -> Result<(), Refusal> {
        let not_there = site.not_there();
        let position = self.place_of(site)?;
        let waiting = staging.balance().get(&position).copied().unwrap_or(0);
        if waiting + (self.points_at(&position) as i64) <= 0 {
            return Err(not_there);
        }
        staging.push(Staged::Retraction(position));
        Ok(())
    }

    /// Forgets what waits, and its source, which has ended.
    pub fn discard(&mut self, staging: &mut Staging<S>) {
        self.clocks.forget(&mut staging.clock);
        for staged in std::mem::take(staging).waiting {
            if let Staged::Point(point) = staged {
                self.give_up(&point.place);
            }
        }
    }

    /// Forgets what a run of more points than the window holds makes void: all before the last of them.
    fn drop_surplus(&mut self, staging: &mut Staging<S>) {
        let Window::Points(most) = self.window else { return };
        if staging.run <= most.get() {
            return;
        }
        // The rest are points of the run, without a retraction.
        staging.balance = None;
        while staging.waiting.len() as u64 > most.get() {
            if let Some(Staged::Point(oldest)) = staging.waiting.pop_front() {
                staging.points -= 1;
                staging.undated -= u64::from(oldest.time.is_none());
                self.give_up(&oldest.place);
            }
        }
        staging.run = staging.points;
    }
}
