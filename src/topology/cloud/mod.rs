//! The points of a stream: which positions are there now, and what has changed.

mod expiry;
mod position;
mod refusal;
mod store;
mod vertex;
mod window;

pub use position::{
    Axis, CoordinateError, Located, MAX_COORDINATE, MIN_COORDINATE, Position, distance, half_length_squared,
};
pub use refusal::Refusal;
pub use store::Cloud;
pub use vertex::{CloudChange, Slot, Vertex, VertexId};
pub use window::Window;
