//! The points of a stream: which positions the cloud has now, and what has changed.
//!
//! In: points, retractions, event times, commits.
//! Out: vertices (distinct positions with ids) and changes.
//! Must not know: triangulations, skeletons.

mod admission;
mod clocks;
mod expiry;
mod position;
mod refusal;
mod staging;
mod store;
mod vertex;
mod window;

pub use admission::{Admission, Restart};
pub use clocks::Confirmation;
pub use position::{
    Axis, CoordinateError, Located, MAX_COORDINATE, MIN_COORDINATE, Position, distance, half_length_squared,
};
pub use refusal::{CONFIRMING, Refusal};
pub use staging::Staging;
pub use store::Cloud;
pub use vertex::{CloudChange, Slot, Vertex, VertexId};
pub use window::Window;
