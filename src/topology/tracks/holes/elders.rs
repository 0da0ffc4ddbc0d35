//! Elders: which track goes on where holes become one, and which part of a hole keeps its name.
//!
//! In: what was recognized in a frame.
//! Out: the same, with the more persistent track on what two have become, and the more persistent part with the track
//! of the whole.
//! Invariant: a track changes its detection only for one of at least half and at most twice its persistence.
//! Must not know: events, hysteresis.

use super::hole_region::HoleRegion;
use super::last_seen::distance;
use super::recognition::{RecognizedBy, Search};
use crate::topology::tracks::detection::Detected;

/// The least ratio of the persistences of a track and a detection that it changes to.
const ALIKE: f64 = 0.5;

/// The largest distance of a track's centre from that of a detection in whose region it is, in radii.
const NEAR: f64 = 4.0;

impl<R: HoleRegion> Search<'_, R> {
    /// Settles who is the elder.
    pub(super) fn settle(&mut self) {
        self.settle_mergers();
        self.settle_splits();
    }

    /// A track without a detection takes that of a less persistent one, if the region of it holds its centre.
    fn settle_mergers(&mut self) {
        let mut lost = self.free_tracks();
        lost.sort_by(|&a, &b| self.known[b].persistence.total_cmp(&self.known[a].persistence));
        for track in lost {
            let younger = (0..self.detections.len()).find(|&place| self.is_elder(track, place));
            if let Some(place) = younger {
                let other = self.owner[place].take();
                other.into_iter().for_each(|other| self.own[other] = None);
                self.give(track, place, RecognizedBy::Region);
            }
        }
    }

    /// Whether a track is more persistent than the one that a detection continues, and has become one with it.
    fn is_elder(&mut self, track: usize, place: usize) -> bool {
        let (known, detection) = (&self.known[track], &self.detections[place]);
        let is_less = |other: usize| self.known[other].persistence < known.persistence;
        self.owner[place].is_some_and(is_less)
            && self.may_change(track, place)
            && distance(known.hole.center, detection.hole.center) <= NEAR * detection.hole.radius
            && self.is_in_region_of(place, track)
    }

    /// A free detection in the region of a track takes the place of a less persistent one.
    fn settle_splits(&mut self) {
        for place in self.free_detections() {
            let persistence = self.detections[place].persistence();
            let is_part = |&track: &usize| {
                let is_less = |(own, _): (usize, _)| self.detections[own].persistence() < persistence;
                self.own[track].is_some_and(is_less)
                    && self.may_change(track, place)
                    && self.goes_on(track, place)
                    && self.is_in_region(track, place)
            };
            let Some(track) = (0..self.known.len()).find(is_part) else { continue };
            if let Some((own, _)) = self.own[track] {
                self.owner[own] = None;
            }
            self.give(track, place, RecognizedBy::Region);
        }
    }

    fn may_change(&self, track: usize, place: usize) -> bool {
        self.likeness(track, place) >= ALIKE && self.known[track].has_like_radius(&self.detections[place])
    }
}
