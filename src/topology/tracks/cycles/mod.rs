//! Tracks in R^d, where a persistent cycle is identified by its homology class.
//!
//! In: dots, short cycles of dots on request, and which dots of a frame the cycles of the frame before are the sum of.
//! Out: tracks with centre, radius and velocity of their cycles.
//! Must not know: sweeps, metrics, how cycles and classes are found, formats.

mod detection;
mod elimination;
mod recognition;
mod state;
mod track;
mod tracker;
mod walk;

pub use detection::{CycleDetection, CycleSource, TrackedCycle};
pub use state::CycleState;
pub use track::SpaceTrack;
pub use walk::{TrackWalk, WalkAnswer};
