//! Tracks: persistent cycles over time. In the plane they are identified by their holes, in other spaces by the
//! homology classes of their cycles.
//!
//! In: the most persistent dots of each frame (detections) with their holes, and regions of holes on request; or with
//! their cycles, and the classes of cycles of the frame before.
//! Out: tracks and their events.
//! Must not know: triangulations, sweeps, how holes, regions and classes are found, formats.

mod assignment;
mod cycles;
mod detection;
mod holes;
mod life;
mod rule;
mod track;
mod tracker;

pub use cycles::{CycleDetection, CycleSource, CycleState, SpaceTrack, TrackWalk, TrackedCycle, WalkAnswer};
pub use detection::{DetectionSource, Detections, detect, in_order};
pub use holes::{Detection, HoleRegion, HoleState};
pub use rule::{Remember, TrackOptions, TrackRule};
pub use track::{Changed, EventKind, FrameStamp, Track, TrackEvent, TrackId, TrackStep};
pub use tracker::Tracker;

/// Follows the persistent cycles of one stream in R^d.
pub type SpaceTracker = Tracker<CycleState>;

/// An event of a track in R^d.
pub type SpaceTrackEvent = TrackEvent<SpaceTrack>;

/// The events of all tracks in R^d up to a frame.
pub type SpaceTrackStep = TrackStep<SpaceTrack>;
