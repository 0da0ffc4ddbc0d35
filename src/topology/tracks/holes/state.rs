//! The state of one track in the plane, announced or not.
//!
//! In: detections that continue it.
//! Out: what to look for in the next frame.
//! Invariant: its region is that of a frame in which it was detected.
//! Must not know: other tracks, hysteresis.

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::last_seen::{LastSeen, back, held};
use super::recognition::RecognizedBy;
use super::similarity::Motion;
use crate::topology::tracks::detection::Detected;
use crate::topology::tracks::life::{Life, Report, Status};
use crate::topology::tracks::track::{FrameStamp, Track, TrackId};
use crate::topology::tracks::tracker::Tracked;

/// The weight of the newest movement in the velocity.
const NEWEST_SHARE: f64 = 0.5;

/// A hole whose persistence has become more than so many times larger has grown much.
const MUCH: f64 = 1.25;

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct HoleState<R> {
    pub life: Life<Track>,
    /// The last detection.
    pub detection: Detection,
    /// The region when it was last found.
    pub region: R,
    /// The persistence at that time.
    region_persistence: f64,
    /// The common motion since that time.
    pub motion: Motion,
    /// The movement of the centre since then besides that. The region may have moved with it.
    pub shift: [f64; 2],
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
            region_persistence: 0.0,
            motion: Motion::IDENTITY,
            shift: [0.0; 2],
            region_frame: 0,
        }
    }

    /// Whether its region contains a point now.
    pub fn holds(&self, point: [f64; 2]) -> bool {
        held(&self.region, &self.motion, self.shift, point)
    }

    /// Whether a point is at most half of the region's size away from it.
    pub fn is_near(&self, point: [f64; 2]) -> bool {
        let points = [point, back(point, self.shift)].map(|point| self.motion.undo(point));
        points.into_iter().any(|point| self.region.is_near(point))
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
        LastSeen {
            triangle: self.detection.triangle,
            hole,
            expected,
            persistence,
            region: &self.region,
            motion: self.motion,
            shift: self.shift,
            least: self.life.least,
            is_remembered: self.life.is_remembered,
        }
    }

    /// Updates it with the detection that continues it, after a common motion.
    pub fn see(&mut self, at: FrameStamp, detection: &Detection, by: RecognizedBy, motion: &Motion, is_selected: bool) {
        self.move_region(motion);
        let frames = (at.number - self.life.last_seen) as f64;
        let track = &mut self.life.track;
        // A centre that is recognized by its region has jumped inside it; the region has not moved.
        if by == RecognizedBy::Place {
            let is = detection.hole.center;
            let (moved, apart) = (back(is, track.hole.center), back(is, motion.apply(track.hole.center)));
            for axis in 0..2 {
                track.velocity[axis] += NEWEST_SHARE * (moved[axis] / frames - track.velocity[axis]);
                self.shift[axis] += apart[axis];
            }
        }
        track.hole = detection.hole;
        (track.birth, track.death) = (detection.critical.birth, detection.critical.death);
        self.life.see(at, detection.persistence(), is_selected);
        self.detection = detection.clone();
    }

    /// Whether its hole has grown much since the region was found: then so has the region.
    pub fn has_grown(&self) -> bool {
        self.life.track.persistence() > MUCH * self.region_persistence
    }

    /// It is missing in a frame, after a common motion.
    pub fn miss(&mut self, motion: &Motion) {
        self.move_region(motion);
        self.life.miss();
    }

    fn move_region(&mut self, motion: &Motion) {
        (self.motion, self.shift) = (motion.after(&self.motion), motion.turned(self.shift));
    }

    /// Finds its region, unless that was done in this frame.
    pub fn refresh_region(&mut self, frame: u64, find_region: &mut impl FnMut(&Detection) -> R) {
        if self.region_frame < frame {
            self.region = find_region(&self.detection);
            self.life.track.area = self.region.area();
            self.region_persistence = self.life.track.persistence();
            (self.region_frame, self.motion, self.shift) = (frame, Motion::IDENTITY, [0.0; 2]);
        }
    }
}
