//! Tracks in R^d, as they are reported.
//!
//! In: nothing.
//! Out: the type that a tracker gives.
//! Must not know: how tracks are found, formats.

use crate::topology::tracks::life::{Report, Status};
use crate::topology::tracks::track::TrackId;

/// A tracked persistent cycle of points in R^d, as it was last detected. Scales are radii.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceTrack {
    /// Its id.
    pub id: TrackId,
    /// The number of frames since its first detection, including that frame and this one.
    pub age: u64,
    /// The scale at which its cycle is born.
    pub birth: f64,
    /// The scale at which its cycle is filled; +infinity if the filtration ends before.
    pub death: f64,
    /// The mean of the vertices of its shortest cycle, coordinate by coordinate.
    pub center: Vec<f64>,
    /// Half the largest distance between two vertices of that cycle.
    pub radius: f64,
    /// The movement of the centre in a frame.
    pub velocity: Vec<f64>,
    /// Whether it is selected, as last reported.
    pub is_selected: bool,
}

impl SpaceTrack {
    /// Death minus birth.
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

impl Report for SpaceTrack {
    fn status(&self) -> Status {
        Status { id: self.id, age: self.age, is_selected: self.is_selected }
    }

    fn set_status(&mut self, status: Status) {
        (self.id, self.age, self.is_selected) = (status.id, status.age, status.is_selected);
    }

    fn label(&self) -> [f64; 2] {
        [self.birth, self.death]
    }
}
