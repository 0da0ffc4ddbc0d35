//! The state of one track, announced or not.
//!
//! In: detections that continue it.
//! Out: what has changed, and what to look for in the next frame.
//! Invariant: a track counts as selected or not as was last reported, until a run of frames on the other side reverses
//! it.
//! Must not know: other tracks.

use std::num::NonZeroU32;

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::recognition::{LastSeen, RecognizedBy, back};
use super::track::{Changed, EventKind, Track, TrackId};

/// A dot that is not selected continues a track down to this share of the persistence that the track had when it was
/// last selected.
const LEAST_SHARE: f64 = 0.5;

/// The weight of the newest movement in the velocity.
const NEWEST_SHARE: f64 = 0.5;

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct TrackState<R> {
    pub key: u64,
    pub is_announced: bool,
    pub track: Track,
    /// The track as it was last reported.
    pub reported: Track,
    pub first_seen: u64,
    pub last_seen: u64,
    /// The last detection.
    pub detection: Detection,
    /// The region when it was last found.
    pub region: R,
    /// The centre of the hole at that time.
    pub region_center: [f64; 2],
    /// The frame of that; 0 for never.
    pub region_frame: u64,
    /// A dot of less persistence does not continue the track, unless the dot is selected.
    pub least: f64,
    /// The number of consecutive frames without a detection.
    pub missed: u32,
    /// The number of consecutive frames in which the dot was on the other side of the selection than was reported.
    pub selection_streak: u32,
    /// The key of the track in whose hole it began.
    pub parent: Option<u64>,
}

impl<R: HoleRegion> TrackState<R> {
    /// The state of a new track, from its first detection.
    pub fn new(key: u64, frame: u64, detection: Detection, parent: Option<u64>) -> Self {
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
            key,
            is_announced: false,
            track,
            reported: track,
            first_seen: frame,
            last_seen: frame,
            least: LEAST_SHARE * detection.persistence(),
            detection,
            region: R::default(),
            region_center: track.hole.center,
            region_frame: 0,
            missed: 0,
            selection_streak: 0,
            parent,
        }
    }

    /// Whether it is announced and was detected in the newest frame.
    pub fn is_detected(&self) -> bool {
        self.is_announced && self.missed == 0
    }

    /// The movement of the centre since the region was found.
    pub fn shift(&self) -> [f64; 2] {
        back(self.track.hole.center, self.region_center)
    }

    /// The last known state, for recognition in a frame.
    pub fn last_seen(&self, frame: u64) -> LastSeen<'_, R> {
        let Track { hole, velocity, .. } = self.track;
        let frames = (frame - self.last_seen) as f64;
        let expected = [0, 1].map(|axis| hole.center[axis] + velocity[axis] * frames);
        let (triangle, region, shift, least) = (self.detection.triangle, &self.region, self.shift(), self.least);
        LastSeen { triangle, hole, expected, region, shift, least }
    }

    /// Updates it with the detection that continues it.
    pub fn see(&mut self, frame: u64, detection: &Detection, by: RecognizedBy, is_selected: bool) {
        let frames = (frame - self.last_seen) as f64;
        for axis in 0..2 {
            let moved = detection.hole.center[axis] - self.track.hole.center[axis];
            if by == RecognizedBy::Place {
                self.track.velocity[axis] += NEWEST_SHARE * (moved / frames - self.track.velocity[axis]);
            } else {
                // A centre that is recognized by its region has jumped inside it; the region has not moved.
                self.region_center[axis] += moved;
            }
        }
        self.track.age = frame - self.first_seen + 1;
        self.track.hole = detection.hole;
        (self.track.birth, self.track.death) = (detection.critical.birth, detection.critical.death);
        self.detection = detection.clone();
        (self.last_seen, self.missed) = (frame, 0);
        if is_selected {
            self.least = LEAST_SHARE * detection.persistence();
        }
        if !self.is_announced {
            self.track.is_selected = is_selected;
        }
        self.selection_streak =
            if is_selected == self.track.is_selected { 0 } else { self.selection_streak.saturating_add(1) };
    }

    /// Finds its region, unless that was done in this frame.
    pub fn refresh_region(&mut self, frame: u64, find_region: &mut impl FnMut(&Detection) -> R) {
        if self.region_frame < frame {
            self.region = find_region(&self.detection);
            self.track.area = self.region.area();
            (self.region_frame, self.region_center) = (frame, self.track.hole.center);
        }
    }

    /// What has changed since it was last reported.
    pub fn changed(&self, delta: f64) -> Option<Changed> {
        let (now, reported) = (&self.track, &self.reported);
        let is_more = |a: f64, b: f64| (a - b).abs() > delta;
        let [[x, y], [old_x, old_y]] = [now.hole.center, reported.hole.center];
        let center = (x - old_x).hypot(y - old_y) > delta;
        let changed =
            Changed { center, birth: is_more(now.birth, reported.birth), death: is_more(now.death, reported.death) };
        changed.any().then_some(changed)
    }

    /// Whether it has left the selection or come back, for long enough.
    pub fn selection_change(&self, confirm: NonZeroU32, miss: NonZeroU32) -> Option<EventKind> {
        match self.track.is_selected {
            true => (self.selection_streak >= miss.get()).then_some(EventKind::Unselected),
            false => (self.selection_streak >= confirm.get()).then_some(EventKind::Reselected),
        }
    }

    /// Records an event that is reported. Returns whether the track takes `id` because it begins.
    pub fn record(&mut self, kind: EventKind, id: TrackId) -> bool {
        match kind {
            EventKind::Born | EventKind::Split { .. } => (self.is_announced, self.track.id) = (true, id),
            EventKind::Unselected => (self.track.is_selected, self.selection_streak) = (false, 0),
            EventKind::Reselected => (self.track.is_selected, self.selection_streak) = (true, 0),
            EventKind::Updated(_) | EventKind::Merged { .. } | EventKind::Died => {}
        }
        self.reported = self.track;
        matches!(kind, EventKind::Born | EventKind::Split { .. })
    }
}
