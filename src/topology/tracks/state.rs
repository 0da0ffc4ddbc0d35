//! What a tracker knows of one track, announced or not.
//!
//! In: sightings of its dot. Out: what has changed, and what to look for in the next frame. Invariant: a track is selected or not as was last told; a run of frames on the other
//! side turns that. Must not know: other tracks.

use std::num::NonZeroU32;

use super::hole_region::HoleRegion;
use super::recognition::{LastSeen, Recognized, back};
use super::sighting::Sighting;
use super::track::{Changed, EventKind, Track, TrackId};

/// A dot that is not selected goes on being a track's with this share of the persistence that it had when it last was.
const LEAST_SHARE: f64 = 0.5;

/// The newest step's share in a velocity.
const NEWEST_SHARE: f64 = 0.5;

/// A track, announced or not.
#[derive(Clone, Debug)]
pub struct TrackState<R> {
    pub key: u64,
    pub is_announced: bool,
    pub track: Track,
    /// As it was last told of.
    pub told: Track,
    pub first_seen: u64,
    pub last_seen: u64,
    /// As it was last seen.
    pub sighting: Sighting,
    /// What its hole took up when that was looked at last.
    pub region: R,
    /// Where its hole was then.
    pub shaped_at: [f64; 2],
    /// In which frame; 0 for never.
    pub shaped: u64,
    /// A dot of less persistence is no continuation, unless it is selected.
    pub least: f64,
    /// Frames on end in which it was not there.
    pub missed: u32,
    /// Frames on end in which its dot was on the other side of the selection than was told.
    pub swayed: u32,
    /// The life in whose hole it began, if that was seen at once.
    pub parent: Option<u64>,
}

impl<R: HoleRegion> TrackState<R> {
    /// Of a dot that no track is known to be at.
    pub fn new(key: u64, frame: u64, sighting: Sighting, parent: Option<u64>) -> Self {
        let track = Track {
            id: TrackId(0),
            age: 1,
            birth: sighting.critical.birth,
            death: sighting.critical.death,
            hole: sighting.hole,
            area: 0.0,
            velocity: [0.0; 2],
            is_selected: true,
        };
        Self {
            key,
            is_announced: false,
            track,
            told: track,
            first_seen: frame,
            last_seen: frame,
            least: LEAST_SHARE * sighting.persistence(),
            sighting,
            region: R::default(),
            shaped_at: track.hole.center,
            shaped: 0,
            missed: 0,
            swayed: 0,
            parent,
        }
    }

    /// Whether it has been announced and was seen in the newest frame.
    pub fn is_there(&self) -> bool {
        self.is_announced && self.missed == 0
    }

    /// How far it has moved since its region was looked at.
    pub fn shift(&self) -> [f64; 2] {
        back(self.track.hole.center, self.shaped_at)
    }

    /// What of it is looked for in a frame.
    pub fn last_seen(&self, frame: u64) -> LastSeen<'_, R> {
        let Track { hole, velocity, .. } = self.track;
        let frames = (frame - self.last_seen) as f64;
        let expected = [0, 1].map(|axis| hole.center[axis] + velocity[axis] * frames);
        let (triangle, region, shift, least) = (self.sighting.triangle, &self.region, self.shift(), self.least);
        LastSeen { triangle, hole, expected, region, shift, least }
    }

    /// Its dot is there.
    pub fn see(&mut self, frame: u64, sighting: &Sighting, by: Recognized, is_selected: bool) {
        let frames = (frame - self.last_seen) as f64;
        for axis in 0..2 {
            let moved = sighting.hole.center[axis] - self.track.hole.center[axis];
            if by == Recognized::Place {
                self.track.velocity[axis] += NEWEST_SHARE * (moved / frames - self.track.velocity[axis]);
            } else {
                // A hole that is found by its region has jumped inside it, which is no movement of the region.
                self.shaped_at[axis] += moved;
            }
        }
        self.track.age = frame - self.first_seen + 1;
        self.track.hole = sighting.hole;
        (self.track.birth, self.track.death) = (sighting.critical.birth, sighting.critical.death);
        self.sighting = sighting.clone();
        (self.last_seen, self.missed) = (frame, 0);
        if is_selected {
            self.least = LEAST_SHARE * sighting.persistence();
        }
        if !self.is_announced {
            self.track.is_selected = is_selected;
        }
        self.swayed = if is_selected == self.track.is_selected { 0 } else { self.swayed.saturating_add(1) };
    }

    /// Looks at its region, unless that was done in this frame.
    pub fn shape(&mut self, frame: u64, find_region: &mut impl FnMut(&Sighting) -> R) {
        if self.shaped < frame {
            self.region = find_region(&self.sighting);
            self.track.area = self.region.area();
            (self.shaped, self.shaped_at) = (frame, self.track.hole.center);
        }
    }

    /// What has changed since it was told of.
    pub fn update(&self, delta: f64) -> Option<Changed> {
        let (now, told) = (&self.track, &self.told);
        let is_more = |a: f64, b: f64| (a - b).abs() > delta;
        let [[x, y], [old_x, old_y]] = [now.hole.center, told.hole.center];
        let center = (x - old_x).hypot(y - old_y) > delta;
        let changed = Changed { center, birth: is_more(now.birth, told.birth), death: is_more(now.death, told.death) };
        changed.any().then_some(changed)
    }

    /// Whether it has gone out of the selection or come back for good.
    pub fn selection_change(&self, confirm: NonZeroU32, miss: NonZeroU32) -> Option<EventKind> {
        match self.track.is_selected {
            true => (self.swayed >= miss.get()).then_some(EventKind::Unselected),
            false => (self.swayed >= confirm.get()).then_some(EventKind::Reselected),
        }
    }

    /// Takes note of what is told of it; whether it takes this id, since it begins.
    pub fn record(&mut self, happening: EventKind, id: TrackId) -> bool {
        match happening {
            EventKind::Born | EventKind::Split { .. } => (self.is_announced, self.track.id) = (true, id),
            EventKind::Unselected => (self.track.is_selected, self.swayed) = (false, 0),
            EventKind::Reselected => (self.track.is_selected, self.swayed) = (true, 0),
            EventKind::Updated(_) | EventKind::Merged { .. } | EventKind::Died => {}
        }
        self.told = self.track;
        matches!(happening, EventKind::Born | EventKind::Split { .. })
    }
}
