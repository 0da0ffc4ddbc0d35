//! Cycles over time: persistent dots followed by their holes.

mod assignment;
mod hole_region;
mod recognition;
mod rule;
mod sighting;
mod state;
mod track;
mod tracker;

pub use hole_region::HoleRegion;
pub use rule::{TrackOptions, TrackRule};
pub use sighting::{Sighting, SightingSource, Sightings, in_order, sight};
pub use track::{Changed, EventKind, Track, TrackEvent, TrackId, TrackStep};
pub use tracker::{At, Tracker};
