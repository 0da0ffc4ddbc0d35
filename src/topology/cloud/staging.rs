//! Points that wait for their commit: those of one source, kept apart from what the cloud has.
//!
//! In: points and retractions of a source. Out: the same to the cloud at the source's commit, or nothing if the source
//! ends without one.
//! Invariants: what waits is in no frame, but its vertices have their ids already. Sources do not see each other's
//! points. In a window of N points, the last N of a source wait: those before them would leave at its commit.
//! Must not know: who the sources are.

use std::collections::VecDeque;

use hashbrown::HashMap;

use super::position::Position;
use super::refusal::Refusal;
use super::store::Cloud;
use super::vertex::{Slot, VertexId};
use super::window::Window;

/// What one source has sent since its last commit.
#[derive(Clone, Debug, Default)]
pub struct Staging {
    waiting: VecDeque<Staged>,
    /// Points among what waits.
    points: u64,
    /// The newest event time of these points.
    newest_time: Option<f64>,
    /// Points less retractions that wait, by slot; known once a retraction was staged.
    balance: Option<HashMap<Slot, i64>>,
}

#[derive(Clone, Copy, Debug)]
enum Staged {
    Point(StagedPoint),
    Retraction(Position),
}

/// A point that waits. Its vertex is there, unless it has vanished meanwhile.
#[derive(Clone, Copy, Debug)]
pub(super) struct StagedPoint {
    pub(super) position: Position,
    pub(super) slot: Slot,
    pub(super) vertex: VertexId,
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
        self.waiting.capacity() * size_of::<Staged>()
    }

    fn count(&mut self, slot: Slot, change: i64) {
        if let Some(balance) = &mut self.balance {
            *balance.entry(slot).or_default() += change;
        }
    }

    /// Points less retractions that wait in a slot.
    fn balance_of(&mut self, slot: Slot) -> i64 {
        let waiting = &self.waiting;
        let balance = self.balance.get_or_insert_with(|| {
            let mut balance = HashMap::new();
            for staged in waiting {
                if let Staged::Point(point) = staged {
                    *balance.entry(point.slot).or_default() += 1;
                }
            }
            balance
        });
        balance.get(&slot).copied().unwrap_or(0)
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
        let slot = self.await_point(position)?;
        let vertex = self.id(slot);
        staging.newest_time = newest;
        staging.waiting.push_back(Staged::Point(StagedPoint { position, slot, vertex, time }));
        staging.points += 1;
        staging.count(slot, 1);
        self.drop_surplus(staging);
        Ok(vertex)
    }

    /// Has a retraction wait for its source's commit.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage_retraction(&mut self, staging: &mut Staging, x: f64, y: f64) -> Result<(), Refusal> {
        let position = self.place_of(x, y)?;
        let slot = self.slot_at(position).ok_or(Refusal::NotThere { x, y })?;
        if staging.balance_of(slot) + self.points_in(slot) as i64 <= 0 {
            return Err(Refusal::NotThere { x, y });
        }
        staging.waiting.push_back(Staged::Retraction(position));
        staging.count(slot, -1);
        Ok(())
    }

    /// Gives the cloud what waits, in order. Returns how many points and retractions it refuses by now.
    pub fn admit(&mut self, staging: &mut Staging) -> u64 {
        let mut refused = 0;
        for staged in std::mem::take(staging).waiting {
            let admitted = match staged {
                Staged::Point(point) => self.admit_point(&point),
                Staged::Retraction(position) => self.retract(position.x(), position.y()).map(drop),
            };
            refused += u64::from(admitted.is_err());
        }
        refused
    }

    /// Forgets what waits.
    pub fn discard(&mut self, staging: &mut Staging) {
        for staged in std::mem::take(staging).waiting {
            if let Staged::Point(point) = staged {
                self.give_up(&point);
            }
        }
    }

    fn admit_point(&mut self, point: &StagedPoint) -> Result<(), Refusal> {
        match self.key(point.time) {
            Ok(key) => {
                let slot = self.take_staged(point)?;
                self.arrive(slot, key);
                Ok(())
            }
            Err(refusal) => {
                self.give_up(point);
                Err(refusal)
            }
        }
    }

    /// Forgets points that would leave a window of so many points as soon as they came.
    fn drop_surplus(&mut self, staging: &mut Staging) {
        let Window::Points(most) = self.window else { return };
        while staging.points > most.get() {
            match staging.waiting.pop_front() {
                Some(Staged::Point(oldest)) => {
                    staging.points -= 1;
                    staging.count(oldest.slot, -1);
                    self.give_up(&oldest);
                }
                Some(Staged::Retraction(_)) => {}
                None => return,
            }
        }
    }
}
