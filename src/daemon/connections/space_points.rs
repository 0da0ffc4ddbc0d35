//! Points of a space, as a peer sends them.
//!
//! In: a dimension and a flat list of coordinates. Out: positions for a queue, or why they are not taken.
//!
//! Invariants: they are whole points. Those that are taken have the dimension of their stream.
//!
//! Must not know: queues, channels.

use hopes::topology::spaces::MAX_DIMENSION;
use hopes_protocol::ErrorCode;

use super::administration::Refused;
use crate::daemon::streams::input::Positions;
use crate::daemon::streams::stream_state::StreamState;

/// Whole points of a dimension.
#[derive(Debug)]
pub struct SpacePoints {
    dimension: usize,
    coordinates: Vec<f64>,
}

impl SpacePoints {
    /// Points of that dimension.
    ///
    /// # Errors
    /// [`Refused`]: there is no such dimension, or the last point is not whole.
    pub fn new(dimension: u32, coordinates: Vec<f64>) -> Result<Self, Refused> {
        let numbers = coordinates.len();
        if numbers > 0 && !numbers.is_multiple_of(dimension.max(1) as usize) {
            let text = format!("{numbers} coordinates are no whole points of dimension {dimension}");
            return Err((ErrorCode::Unreadable, text));
        }
        if !(1..=MAX_DIMENSION).contains(&(dimension as usize)) {
            let text = format!("a point has from 1 to {MAX_DIMENSION} coordinates, not {dimension}");
            return Err((ErrorCode::BadOptions, text));
        }
        Ok(Self { dimension: dimension as usize, coordinates })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.coordinates.len() / self.dimension
    }

    /// Whether a stream takes them. The first points settle its dimension.
    ///
    /// # Errors
    /// [`Refused`]: it is of the plane, or of another dimension.
    pub fn check(&self, stream: &StreamState) -> Result<(), Refused> {
        let Some(space) = &stream.space else {
            let text = format!("stream {:?} is of the plane: send Batch and Retract", stream.name);
            return Err((ErrorCode::OtherSpace, text));
        };
        let found = self.dimension as u32;
        // Where there is no point, nothing is settled.
        let settled = if self.len() == 0 { space.dimension().unwrap_or(found) } else { space.settle(found) };
        if settled != found {
            let text = format!("points of {found} coordinates, where those of stream {:?} have {settled}", stream.name);
            return Err((ErrorCode::BadOptions, text));
        }
        Ok(())
    }

    /// The same for a queue.
    pub fn into_positions(self) -> Positions {
        Positions::Space { dimension: self.dimension, coordinates: self.coordinates }
    }
}
