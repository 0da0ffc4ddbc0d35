//! The points of a stream: which positions the cloud has now, and what has changed.
//!
//! In: points, retractions, event times, commits.
//! Out: vertices (distinct positions, in the plane or in R^d, with ids) and changes.
//! Must not know: triangulations, skeletons.

mod admission;
mod clocks;
mod coordinates;
mod expiry;
mod limit;
mod planar;
mod point_error;
mod position;
mod refusal;
mod site;
mod staging;
mod store;
mod vertex;
mod vertices;
mod window;

pub use admission::{Admission, Restart};
pub use clocks::Confirmation;
pub use coordinates::Coordinates;
pub use point_error::PointError;
pub use position::{
    Axis, CoordinateError, Located, MAX_COORDINATE, MIN_COORDINATE, Position, half_length_squared, quarter_square,
};
pub use refusal::{CONFIRMING, FirstCoordinates, Refusal};
pub use site::Site;
pub use staging::Staging;
pub use store::Cloud;
pub use vertex::{CloudChange, Slot, Vertex, VertexId};
pub use vertices::{Vertices, compare_coordinates};
pub use window::Window;
