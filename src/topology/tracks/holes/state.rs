//! The state of one track in the plane, announced or not.
//!
//! In: detections that continue it.
//! Out: what to look for in the next frame.
//! Invariant: its region is that of a frame in which it was detected.
//! Must not know: other tracks, hysteresis.

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::last_seen::{LastSeen, back};
use super::recognition::RecognizedBy;
use crate::topology::tracks::detection::Detected;
use crate::topology::tracks::life::{Life, Report, Status};
use crate::topology::tracks::track::{Track, TrackId};
use crate::topology::tracks::tracker::{FrameStamp, Tracked};

/// The weight of the newest movement in the velocity.
const NEWEST_SHARE: f64 = 0.5;

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct HoleState<R> {
    pub life: Life<Track>,
    /// The last detection.
    pub detection: Detection,
    /// The region when it was last found.
    pub region: R,
    /// The centre of the hole at that time.
    pub region_center: [f64; 2],
    /// The frame of that; 0 for never.
    pub region_frame: u64,
}

impl Report for Track {
    fn status(&self) -> Status {
        Status { id: self.id, age: self.age, is_selected: self.is_selected }
    }

    fn set_status(&mut self, status: Status) {
        (self.id, self.age, self.is_selected) = (status.id, status.age, status.is_selected);
    }

    fn label(&self) -> [f64; 2] {
        [self.birth, self.death]
    }
}

impl<R> Tracked for HoleState<R> {
    type Track = Track;

    /// The number of vertices left over for finding regions.
    type Shared = usize;

    fn life(&self) -> &Life<Track> {
        &self.life
    }

    fn life_mut(&mut self) -> &mut Life<Track> {
        &mut self.life
    }
}

impl<R: HoleRegion> HoleState<R> {
    /// The state of a new track, from its first detection.
    pub fn new(key: u64, at: FrameStamp, detection: Detection, parent: Option<u64>) -> Self {
        let track = Track {
            id: TrackId(0),
            age: 1,
            birth: detection.critical.birth,
            death: detection.critical.death,
            hole: detection.hole,
            area: 0.0,
            velocity: [0.0; 2],
            is_selected: true,
        };
        Self {
            life: Life::new(key, at, track, detection.persistence(), parent),
            detection,
            region: R::default(),
            region_center: track.hole.center,
            region_frame: 0,
        }
    }

    /// The movement of the centre since the region was found.
    pub fn shift(&self) -> [f64; 2] {
        back(self.life.track.hole.center, self.region_center)
    }

    /// How far the centre has moved since that was last reported.
    pub fn moved(&self) -> f64 {
        let [[x, y], [old_x, old_y]] = [self.life.track.hole.center, self.life.reported.hole.center];
        (x - old_x).hypot(y - old_y)
    }

    /// The last known state, for recognition in a frame.
    pub fn last_seen(&self, frame: u64) -> LastSeen<'_, R> {
        let Track { hole, velocity, .. } = self.life.track;
        let frames = (frame - self.life.last_seen) as f64;
        let expected = [0, 1].map(|axis| hole.center[axis] + velocity[axis] * frames);
        let persistence = self.life.track.persistence();
        let (triangle, region, shift, least) = (self.detection.triangle, &self.region, self.shift(), self.life.least);
        let is_remembered = self.life.is_remembered;
        LastSeen { triangle, hole, expected, persistence, region, shift, least, is_remembered }
    }

    /// Updates it with the detection that continues it.
    pub fn see(&mut self, at: FrameStamp, detection: &Detection, by: RecognizedBy, is_selected: bool) {
        let frames = (at.number - self.life.last_seen) as f64;
        let track = &mut self.life.track;
        for axis in 0..2 {
            let moved = detection.hole.center[axis] - track.hole.center[axis];
            if by == RecognizedBy::Place {
                track.velocity[axis] += NEWEST_SHARE * (moved / frames - track.velocity[axis]);
            } else {
                // A centre that is recognized by its region has jumped inside it; the region has not moved.
                self.region_center[axis] += moved;
            }
        }
        track.hole = detection.hole;
        (track.birth, track.death) = (detection.critical.birth, detection.critical.death);
        self.life.see(at, detection.persistence(), is_selected);
        self.detection = detection.clone();
    }

    /// Finds its region, unless that was done in this frame.
    pub fn refresh_region(&mut self, frame: u64, find_region: &mut impl FnMut(&Detection) -> R) {
        if self.region_frame < frame {
            self.region = find_region(&self.detection);
            self.life.track.area = self.region.area();
            (self.region_frame, self.region_center) = (frame, self.life.track.hole.center);
        }
    }
}
