//! The cloud of points in the plane, by their x and y.
//!
//! In: pairs of doubles.
//! Out: the same points to the cloud of positions.
//! Must not know: other spaces.

use super::position::Position;
use super::refusal::Refusal;
use super::staging::Staging;
use super::store::Cloud;
use super::vertex::{Slot, VertexId};

impl Cloud {
    /// [`insert_site`](Self::insert_site) for a position.
    ///
    /// # Errors [`Refusal`]; the cloud is then unchanged.
    pub fn insert(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<Slot, Refusal> {
        self.insert_site(Position::new(x, y)?, time)
    }

    /// [`retract_site`](Self::retract_site) for a position.
    ///
    /// # Errors [`Refusal`]; the cloud is then unchanged.
    pub fn retract(&mut self, x: f64, y: f64) -> Result<Slot, Refusal> {
        self.retract_site(Position::new(x, y)?)
    }

    /// [`stage_site`](Self::stage_site) for a position.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage(&mut self, staging: &mut Staging, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, Refusal> {
        self.stage_site(staging, Position::new(x, y)?, time)
    }

    /// [`stage_retraction_of`](Self::stage_retraction_of) for a position.
    ///
    /// # Errors [`Refusal`]; nothing has changed then.
    pub fn stage_retraction(&mut self, staging: &mut Staging, x: f64, y: f64) -> Result<(), Refusal> {
        self.stage_retraction_of(staging, Position::new(x, y)?)
    }

    /// The position of the vertex in a slot; of the last one, if it is gone.
    #[inline]
    pub fn position(&self, slot: Slot) -> Position {
        *self.site(slot)
    }
}
