//! Points that wait for their commit: those of one source, kept apart from what the cloud has.
//!
//! In: points and retractions of a source. Out: the same to the cloud at the source's commit, or nothing if the source
//! ends without one.
//! Invariants: what waits is in no frame, but its vertices have their ids already. Sources do not see each other's
//! points. In a window of N points, what came before the last N in a row has no effect at the commit, and is forgotten.
//! Must not know: who the sources are.

use std::collections::VecDeque;

use hashbrown::HashMap;

use super::position::Position;
use super::refusal::Refusal;
use super::store::Cloud;
use super::vertex::{Awaiting, VertexId};
use super::window::Window;

/// What one source has sent since its last commit.
#[derive(Clone, Debug, Default)]
pub struct Staging {
    waiting: VecDeque<Staged>,
    /// Points among what waits.
    points: u64,
    /// The newest event time of these points.
    newest_time: Option<f64>,
    /// Points since the last retraction.
    run: u64,
    /// Points less retractions that wait, by position; known while a retraction waits.
    balance: Option<HashMap<Position, i64>>,
}

#[derive(Clone, Copy, Debug)]
enum Staged {
    Point(StagedPoint),
    Retraction(Position),
}

/// A point that waits.
#[derive(Clone, Copy, Debug)]
struct StagedPoint {
    place: Awaiting,
    time: Option<f64>,
}

impl Staging {
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
        self.waiting.capacity() * size_of::<Staged>() + balance * size_of::<(Position, i64)>()
    }

    fn push(&mut self, staged: Staged) {
        match staged {
            Staged::Point(point) => {
                (self.points, self.run) = (self.points + 1, self.run + 1);
                if let Some(balance) = &mut self.balance {
                    *balance.entry(point.place.position).or_default() += 1;
                }
            }
            Staged::Retraction(position) => {
                self.run = 0;
                *self.balance().entry(position).or_default() -= 1;
            }
        }
        self.waiting.push_back(staged);
    }

    /// Points less retractions that wait, by position.
    fn balance(&mut self) -> &mut HashMap<Position, i64> {
        self.balance.get_or_insert_with(|| {
            let mut balance = HashMap::new();
            for staged in &self.waiting {
                if let Staged::Point(point) = staged {
                    *balance.entry(point.place.position).or_default() += 1;
                }
            }
            balance
        })
    }
}

impl Cloud {
    /// Has a point wait for its source's commit. Returns the vertex at its position, which may be one that is not there
    /// yet.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage(&mut self, staging: &mut Staging, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, Refusal> {
        let position = self.place_of(x, y)?;
        let newest = self.check_time(time, staging.newest_time)?;
        let place = self.await_point(position)?;
        staging.newest_time = newest;
        staging.push(Staged::Point(StagedPoint { place, time }));
        self.drop_surplus(staging);
        Ok(place.vertex)
    }

    /// Has a retraction wait for its source's commit.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage_retraction(&mut self, staging: &mut Staging, x: f64, y: f64) -> Result<(), Refusal> {
        let position = self.place_of(x, y)?;
        let waiting = staging.balance().get(&position).copied().unwrap_or(0);
        if waiting + (self.points_at(position) as i64) <= 0 {
            return Err(Refusal::NotThere { x, y });
        }
        staging.push(Staged::Retraction(position));
        Ok(())
    }

    /// Gives the cloud what waits, in order. Returns how many points and retractions it refuses by now.
    pub fn admit(&mut self, staging: &mut Staging) -> u64 {
        let mut refused = 0;
        for staged in std::mem::take(staging).waiting {
            let is_admitted = match staged {
                Staged::Point(point) => self.admit_point(&point).is_ok(),
                Staged::Retraction(position) => self.retract_at(position).is_some(),
            };
            refused += u64::from(!is_admitted);
        }
        refused
    }

    /// Forgets what waits.
    pub fn discard(&mut self, staging: &mut Staging) {
        for staged in std::mem::take(staging).waiting {
            if let Staged::Point(point) = staged {
                self.give_up(&point.place);
            }
        }
    }

    fn admit_point(&mut self, point: &StagedPoint) -> Result<(), Refusal> {
        match self.key(point.time) {
            Ok(key) => {
                let slot = self.take_awaited(&point.place)?;
                self.arrive(slot, key);
                Ok(())
            }
            Err(refusal) => {
                self.give_up(&point.place);
                Err(refusal)
            }
        }
    }

    /// Forgets what a run of more points than the window holds makes void: all before the last of them.
    fn drop_surplus(&mut self, staging: &mut Staging) {
        let Window::Points(most) = self.window else { return };
        if staging.run <= most.get() {
            return;
        }
        // The rest are points of the run, without a retraction.
        staging.balance = None;
        while staging.waiting.len() as u64 > most.get() {
            if let Some(Staged::Point(oldest)) = staging.waiting.pop_front() {
                staging.points -= 1;
                self.give_up(&oldest.place);
            }
        }
        staging.run = staging.points;
    }
}
