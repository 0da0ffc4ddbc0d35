//! Tracks in the plane, where a persistent cycle is identified by its hole.
//!
//! In: dots with their holes, and regions of holes on request.
//! Out: tracks with centre, area and velocity of their holes.
//! Must not know: triangulations, how holes and regions are found, formats.

mod detection;
mod elders;
mod hole_region;
mod last_seen;
mod motion;
mod recognition;
mod similarity;
mod state;
mod tracker;

pub use detection::Detection;
pub use hole_region::HoleRegion;
pub use state::HoleState;
