//! Tracks: persistent cycles over time, identified by their holes.
//!
//! In: the most persistent dots of each frame with their holes (detections), and regions of holes on request.
//! Out: tracks and their events.
//! Must not know: triangulations, how holes and regions are found, formats.

mod assignment;
mod detection;
mod hole_region;
mod recognition;
mod rule;
mod state;
mod track;
mod tracker;

pub use detection::{Detection, DetectionSource, Detections, detect, in_order};
pub use hole_region::HoleRegion;
pub use rule::{TrackOptions, TrackRule};
pub use track::{Changed, EventKind, Track, TrackEvent, TrackId, TrackStep};
pub use tracker::{FrameStamp, Tracker};
