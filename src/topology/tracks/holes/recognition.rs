//! Recognition: which detections of a frame continue which tracks.
//!
//! In: the last known state of each track, and the detections of a frame.
//! Out: for each track, the detection that continues it.
//! Invariants: no detection continues two tracks. The order of detections decides ties only. A detection continues a
//! track only if their persistences are alike.
//! Must not know: events, hysteresis.
//!
//! A track is identified by its hole. First by the triangle of the death. Else by the hole's centre and radius inside a
//! gate, with an optimal assignment in which the more persistent ones weigh more. Both ask for persistences that are
//! much alike, since the deaths of one hole may swap their ranks. The point that is filled last may jump far inside a
//! hole, as between the lobes of a dumb-bell or around an annulus. So the rest is recognized by regions: each contains
//! the other's centre. Then holes that moved far are each other's nearest. Then the elder of two holes that have become
//! one keeps its name, and the larger part of one that has divided. What is left is recognized by its place once more,
//! with any persistence that may continue a track. In the end remembered tracks take selected dots that are left. Never
//! by the critical edge or the birth, which jump. The motion that the holes have in common is found before, so that a
//! camera that moves takes no names away.

use std::collections::HashMap;

use super::detection::Detection;
use super::hole_region::HoleRegion;
use super::last_seen::{LIKE_RADIUS, LastSeen, NEAR, distance, remoteness};
use super::motion::common_motion;
use super::similarity::Motion;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::Hole;
use crate::topology::tracks::assignment::{Pair, assign};

/// The least ratio of persistences for which the same triangle, or a hole near by, is enough.
const MUCH_ALIKE: f64 = 0.5;

/// The gates of holes that moved far: the largest distance in radii, and the least ratios of persistences and of radii.
const FAR: f64 = 2.0;
const FAR_PERSISTENCE: f64 = 0.6;
const FAR_RADIUS: f64 = 0.75;

/// How a track was recognized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecognizedBy {
    /// By the same triangle, or by a hole near by.
    Place,
    /// By its region.
    Region,
}

/// What is recognized in a frame.
#[derive(Clone, Debug)]
pub struct Recognized {
    /// For each track, the place of the detection that continues it.
    pub own: Vec<Option<(usize, RecognizedBy)>>,
    /// The motion that the holes have in common.
    pub motion: Motion,
}

/// The detections that continue tracks.
pub fn recognize<R: HoleRegion>(
    known: &[LastSeen<'_, R>],
    detections: &[Detection],
    is_selected: &[bool],
    mut find_region: impl FnMut(&Detection) -> R,
) -> Recognized {
    let (own, owner) = (vec![None; known.len()], vec![None; detections.len()]);
    let motion = common_motion(known, detections);
    let regions = Regions { found: HashMap::new(), find: &mut find_region };
    let mut search = Search { known, detections, is_selected, motion, own, owner, regions };
    search.by_triangle();
    search.by_place(MUCH_ALIKE);
    search.by_region();
    search.by_far_place();
    search.settle();
    search.by_place(0.0);
    search.by_far_place();
    search.by_memory();
    Recognized { own: search.own, motion }
}

/// The regions of detections, found when they are asked for.
struct Regions<'a, R> {
    found: HashMap<usize, R>,
    find: &'a mut dyn FnMut(&Detection) -> R,
}

/// The state of recognition in one frame.
pub(super) struct Search<'a, R> {
    pub(super) known: &'a [LastSeen<'a, R>],
    pub(super) detections: &'a [Detection],
    is_selected: &'a [bool],
    motion: Motion,
    pub(super) own: Vec<Option<(usize, RecognizedBy)>>,
    /// For each detection, the track that it continues.
    pub(super) owner: Vec<Option<usize>>,
    regions: Regions<'a, R>,
}

impl<R: HoleRegion> Search<'_, R> {
    fn by_triangle(&mut self) {
        let places: HashMap<[VertexId; 3], usize> =
            self.detections.iter().enumerate().map(|(place, detection)| (detection.triangle, place)).collect();
        for track in 0..self.known.len() {
            let Some(&place) = places.get(&self.known[track].triangle) else { continue };
            if !self.known[track].is_remembered
                && self.goes_on(track, place)
                && self.likeness(track, place) >= MUCH_ALIKE
            {
                self.give(track, place, RecognizedBy::Place);
            }
        }
    }

    /// Free tracks and detections inside the gate, around the last or the predicted centre, also after the common
    /// motion.
    fn by_place(&mut self, least_likeness: f64) {
        let tracks = self.free_tracks();
        let pairs = self.pairs_near(&tracks, |search, row, column| {
            search.likeness(row, column) >= least_likeness && search.goes_on(row, column)
        });
        self.assign(&pairs, RecognizedBy::Place);
    }

    /// Remembered tracks and free detections that are selected, inside the same gate.
    fn by_memory(&mut self) {
        let remembered = |&track: &usize| self.own[track].is_none() && self.known[track].is_remembered;
        let tracks: Vec<usize> = (0..self.known.len()).filter(remembered).collect();
        let pairs = self.pairs_near(&tracks, |search, row, column| {
            search.is_selected[column] && search.likeness(row, column) >= MUCH_ALIKE
        });
        self.assign(&pairs, RecognizedBy::Place);
    }

    /// Some of these tracks and of the free detections inside the gate.
    fn pairs_near(&self, tracks: &[usize], is_possible: impl Fn(&Self, usize, usize) -> bool) -> Vec<Pair> {
        let by_x = self.free_by_x();
        let mut pairs = Vec::new();
        for &row in tracks {
            let known = &self.known[row];
            let centers = self.possible_centers(known);
            // No gate is wider.
            let reach = NEAR * LIKE_RADIUS * known.hole.radius;
            for column in self.between(&by_x, &centers, reach) {
                let detection = &self.detections[column];
                let remote = centers.map(|center| remoteness(Hole { center, ..known.hole }, detection.hole));
                let remoteness = remote.into_iter().fold(f64::INFINITY, f64::min);
                if remoteness <= 1.0 && is_possible(self, row, column) {
                    pairs.push(Pair { row, column, gain: known.gain(detection, remoteness) });
                }
            }
        }
        pairs
    }

    /// Free tracks and detections whose regions contain each other's centres.
    fn by_region(&mut self) {
        let mut pairs = Vec::new();
        let free = self.free_detections();
        for row in self.free_tracks() {
            let known = &self.known[row];
            for &column in &free {
                let detection = &self.detections[column];
                let is_possible = known.has_like_radius(detection)
                    && self.goes_on(row, column)
                    && (known.region.is_unknown() || self.is_in_region(row, column))
                    && self.is_in_region_of(column, row);
                if is_possible {
                    // All of these are possible; the nearest is the most likely.
                    let center = self.motion.apply(known.hole.center);
                    let apart = distance(center, detection.hole.center) / (known.hole.radius + detection.hole.radius);
                    pairs.push(Pair { row, column, gain: known.gain(detection, apart / (1.0 + apart)) });
                }
            }
        }
        self.assign(&pairs, RecognizedBy::Region);
    }

    /// Free tracks and detections that are each other's nearest.
    fn by_far_place(&mut self) {
        let by_x = self.free_by_x();
        let free_tracks = self.free_tracks();
        let mut nearest_track: HashMap<usize, (f64, usize)> = HashMap::new();
        let mut nearest_detection: Vec<(usize, usize)> = Vec::new();
        for &track in &free_tracks {
            let known = &self.known[track];
            let centers = self.possible_centers(known);
            let reach = FAR * known.hole.radius / FAR_RADIUS;
            let mut nearest: Option<(f64, usize)> = None;
            for place in self.between(&by_x, &centers, reach) {
                let Some(apart) = self.far_apart(track, place, &centers) else { continue };
                nearest = nearest.filter(|&(other, _)| other <= apart).or(Some((apart, place)));
                let known = nearest_track.entry(place).or_insert((apart, track));
                if apart < known.0 {
                    *known = (apart, track);
                }
            }
            nearest_detection.extend(nearest.map(|(_, place)| (track, place)));
        }
        for (track, place) in nearest_detection {
            if nearest_track[&place].1 == track {
                self.give(track, place, RecognizedBy::Place);
            }
        }
    }

    /// How far a detection is from a track that may have moved to it, in radii.
    fn far_apart(&self, track: usize, place: usize, centers: &[[f64; 2]]) -> Option<f64> {
        let (known, detection) = (&self.known[track], &self.detections[place]);
        let more = known.hole.radius.max(detection.hole.radius);
        let is_alike = known.radius_likeness(detection) >= FAR_RADIUS && self.likeness(track, place) >= FAR_PERSISTENCE;
        let apart = centers.iter().map(|&center| distance(center, detection.hole.center)).fold(f64::INFINITY, f64::min);
        (is_alike && self.goes_on(track, place) && apart <= FAR * more).then_some(apart / more)
    }

    /// Where the centre of a track may be expected.
    fn possible_centers(&self, known: &LastSeen<'_, R>) -> [[f64; 2]; 3] {
        [known.expected, known.hole.center, self.motion.apply(known.hole.center)]
    }

    /// Whether the region of a track contains the centre of a detection.
    pub(super) fn is_in_region(&self, track: usize, place: usize) -> bool {
        let (known, center) = (&self.known[track], self.detections[place].hole.center);
        known.holds(center) || known.holds(self.motion.undo(center))
    }

    /// Whether the region of a detection contains the centre of a track.
    pub(super) fn is_in_region_of(&mut self, place: usize, track: usize) -> bool {
        let center = self.known[track].hole.center;
        let Regions { found, find } = &mut self.regions;
        let region = found.entry(place).or_insert_with(|| find(&self.detections[place]));
        region.contains(center) || region.contains(self.motion.apply(center))
    }

    pub(super) fn goes_on(&self, track: usize, place: usize) -> bool {
        self.known[track].goes_on(&self.detections[place], self.is_selected[place])
    }

    pub(super) fn likeness(&self, track: usize, place: usize) -> f64 {
        self.known[track].likeness(&self.detections[place])
    }

    pub(super) fn give(&mut self, track: usize, detection: usize, by: RecognizedBy) {
        self.own[track] = Some((detection, by));
        self.owner[detection] = Some(track);
    }

    fn assign(&mut self, pairs: &[Pair], by: RecognizedBy) {
        for (track, detection) in assign(pairs) {
            self.give(track, detection, by);
        }
    }

    /// Tracks that are not remembered only.
    pub(super) fn free_tracks(&self) -> Vec<usize> {
        let is_free = |&track: &usize| self.own[track].is_none() && !self.known[track].is_remembered;
        (0..self.known.len()).filter(is_free).collect()
    }

    pub(super) fn free_detections(&self) -> Vec<usize> {
        (0..self.detections.len()).filter(|&place| self.owner[place].is_none()).collect()
    }

    /// Free detections by the x of their centres.
    fn free_by_x(&self) -> Vec<usize> {
        let mut free = self.free_detections();
        free.sort_by(|&a, &b| self.x(a).total_cmp(&self.x(b)));
        free
    }

    fn x(&self, place: usize) -> f64 {
        self.detections[place].hole.center[0]
    }

    /// Those of them whose x is at most `reach` from that of some centre, or between two.
    fn between(&self, by_x: &[usize], centers: &[[f64; 2]], reach: f64) -> impl Iterator<Item = usize> {
        let least = centers.iter().map(|center| center[0]).fold(f64::INFINITY, f64::min) - reach;
        let most = centers.iter().map(|center| center[0]).fold(f64::NEG_INFINITY, f64::max) + reach;
        let first = by_x.partition_point(|&place| self.x(place) < least);
        by_x[first..].iter().copied().take_while(move |&place| self.x(place) <= most)
    }
}
