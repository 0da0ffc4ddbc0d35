//! The state of one track in R^d, announced or not.
//!
//! In: detections that continue it, with their cycles.
//! Out: what to look for in the next frame.
//! Invariant: detection and cycle are those of the last frame in which it was seen.
//! Must not know: other tracks, hysteresis.

use std::sync::Arc;

use super::detection::{CycleDetection, TrackedCycle};
use super::recognition::LastSeen;
use super::track::SpaceTrack;
use super::walk::TrackWalk;
use crate::topology::tracks::detection::Detected;
use crate::topology::tracks::life::Life;
use crate::topology::tracks::track::{FrameStamp, TrackId};
use crate::topology::tracks::tracker::Tracked;

/// The weight of the newest movement in the velocity.
const NEWEST_SHARE: f64 = 0.5;

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct CycleState {
    pub life: Life<SpaceTrack>,
    /// The last detection.
    pub detection: CycleDetection,
    /// A short cycle of it.
    pub cycle: TrackedCycle,
    /// Whether the cycle is known to die with the dot.
    pub is_own: bool,
    /// While it is missing: the key of the track that it has become a part of.
    pub heir: Option<u64>,
}

impl Tracked for CycleState {
    type Track = SpaceTrack;
    type Shared = ();

    fn life(&self) -> &Life<SpaceTrack> {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life<SpaceTrack> {
        &mut self.life
    }
}

impl CycleState {
    /// The state of a new track, from its first detection.
    pub fn new(key: u64, at: FrameStamp, detection: CycleDetection, cycle: TrackedCycle, parent: Option<u64>) -> Self {
        let track = SpaceTrack {
            id: TrackId(0),
            age: 1,
            birth: detection.critical.birth,
            death: detection.critical.death,
            center: cycle.center.clone(),
            radius: cycle.radius,
            velocity: vec![0.0; cycle.center.len()],
            is_selected: true,
        };
        Self {
            life: Life::new(key, at, track, detection.persistence(), parent),
            detection,
            cycle,
            is_own: false,
            heir: None,
        }
    }

    /// The last known state, for recognition in a frame.
    pub fn last_seen(&self, frame: u64) -> LastSeen<'_> {
        let SpaceTrack { center, velocity, radius, .. } = &self.life.track;
        let frames = (frame - self.life.last_seen) as f64;
        let expected = center.iter().zip(velocity).map(|(center, velocity)| center + velocity * frames).collect();
        let (least, is_remembered) = (self.life.least, self.life.is_remembered);
        LastSeen { detection: &self.detection, center, expected, radius: *radius, least, is_remembered }
    }

    /// Its cycle, as a question to the next frame. That of a track which is only remembered has no vertices.
    pub fn walk(&self) -> TrackWalk {
        let SpaceTrack { birth, death, .. } = self.life.track;
        let is_there = !self.life.is_remembered;
        let vertices = if is_there { Arc::clone(&self.cycle.vertices) } else { Arc::default() };
        TrackWalk { vertices, birth, death, is_own: self.is_own }
    }

    /// Updates it with the detection that continues it, and a cycle of that.
    pub fn see(
        &mut self,
        at: FrameStamp,
        detection: CycleDetection,
        (cycle, is_own): (TrackedCycle, bool),
        is_selected: bool,
    ) {
        let frames = (at.number - self.life.last_seen) as f64;
        let track = &mut self.life.track;
        for ((velocity, old), new) in track.velocity.iter_mut().zip(&track.center).zip(&cycle.center) {
            *velocity += NEWEST_SHARE * ((new - old) / frames - *velocity);
        }
        (track.birth, track.death) = (detection.critical.birth, detection.critical.death);
        track.center.clone_from(&cycle.center);
        track.radius = cycle.radius;
        self.life.see(at, detection.persistence(), is_selected);
        (self.detection, self.cycle, self.is_own, self.heir) = (detection, cycle, is_own, None);
    }
}
