//! Recognition: which detections of a frame continue which tracks.
//!
//! In: the last known state of each track, and the detections of a frame.
//! Out: for each track, the detection that continues it.
//! Invariant: the order of detections decides ties only.
//! Must not know: events, hysteresis.
//!
//! A track is identified by its hole. First by the triangle of the death. Else by the hole's centre and radius inside a
//! gate, with an optimal assignment. The point that is filled last may jump far inside a hole, as between the lobes of
//! a dumb-bell or around an annulus. So the rest is recognized by regions: each contains the other's centre. Never by
//! the critical edge or the birth, which jump.

use std::collections::HashMap;

use super::detection::Detection;
use super::hole_region::HoleRegion;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::Hole;
use crate::topology::tracks::assignment::{Pair, assign};
use crate::topology::tracks::detection::Detected;

/// The gate: the largest distance between centres of one hole, as a share of the larger radius.
const NEAR: f64 = 0.5;

/// The gate: the largest ratio of two radii of one hole.
const ALIKE: f64 = 2.0;

/// The last known state of a track.
#[derive(Clone, Copy, Debug)]
pub struct LastSeen<'a, R> {
    /// The triangle that names its death.
    pub triangle: [VertexId; 3],
    /// Its hole when it was last seen.
    pub hole: Hole,
    /// The predicted centre of its hole.
    pub expected: [f64; 2],
    /// Its region when that was last found. Unknown before the track is announced; then only the region of the
    /// detection is tested.
    pub region: &'a R,
    /// The movement of the centre since the region was found.
    pub shift: [f64; 2],
    /// A dot of less persistence does not continue it, unless the dot is selected.
    pub least: f64,
}

/// How a track was recognized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecognizedBy {
    /// By the same triangle, or by a hole near by.
    Place,
    /// By its region.
    Region,
}

/// For each track, the place of the detection that continues it.
pub fn recognize<R: HoleRegion>(
    known: &[LastSeen<'_, R>],
    detections: &[Detection],
    is_selected: &[bool],
    find_region: impl FnMut(&Detection) -> R,
) -> Vec<Option<(usize, RecognizedBy)>> {
    let (own, is_taken) = (vec![None; known.len()], vec![false; detections.len()]);
    let mut search = Search { known, detections, is_selected, own, is_taken };
    search.by_triangle();
    let near = search.pairs_near();
    search.assign(&near, RecognizedBy::Place);
    let inside = search.pairs_inside(find_region);
    search.assign(&inside, RecognizedBy::Region);
    search.own
}

struct Search<'a, R> {
    known: &'a [LastSeen<'a, R>],
    detections: &'a [Detection],
    is_selected: &'a [bool],
    own: Vec<Option<(usize, RecognizedBy)>>,
    is_taken: Vec<bool>,
}

impl<R: HoleRegion> Search<'_, R> {
    fn by_triangle(&mut self) {
        let places: HashMap<[VertexId; 3], usize> =
            self.detections.iter().enumerate().map(|(place, detection)| (detection.triangle, place)).collect();
        for (track, known) in self.known.iter().enumerate() {
            let Some(&place) = places.get(&known.triangle) else { continue };
            if self.goes_on(known, place) {
                self.give(track, place, RecognizedBy::Place);
            }
        }
    }

    /// Whether a detection is persistent enough to continue a track.
    fn goes_on(&self, known: &LastSeen<'_, R>, place: usize) -> bool {
        self.is_selected[place] || self.detections[place].persistence() >= known.least
    }

    fn give(&mut self, track: usize, detection: usize, by: RecognizedBy) {
        self.own[track] = Some((detection, by));
        self.is_taken[detection] = true;
    }

    fn assign(&mut self, pairs: &[Pair], by: RecognizedBy) {
        for (track, detection) in assign(pairs) {
            self.give(track, detection, by);
        }
    }

    /// Pairs of unmatched tracks and detections inside the gate, around the last or the predicted centre.
    fn pairs_near(&self) -> Vec<Pair> {
        let mut free: Vec<usize> = (0..self.detections.len()).filter(|&place| !self.is_taken[place]).collect();
        let x = |place: usize| self.detections[place].hole.center[0];
        free.sort_by(|&a, &b| x(a).total_cmp(&x(b)));
        let mut pairs = Vec::new();
        for (track, known) in self.known.iter().enumerate().filter(|&(track, _)| self.own[track].is_none()) {
            // No gate is wider.
            let reach = NEAR * ALIKE * known.hole.radius;
            let [was, is] = [known.hole.center, known.expected].map(|center| center[0]);
            let first = free.partition_point(|&place| x(place) < was.min(is) - reach);
            let near = free[first..].iter().take_while(|&&place| x(place) <= was.max(is) + reach);
            for &place in near {
                let Detection { hole, .. } = self.detections[place];
                let places = [known.expected, known.hole.center];
                let cost = places
                    .map(|center| remoteness(Hole { center, ..known.hole }, hole))
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                if cost <= 1.0 && self.goes_on(known, place) {
                    pairs.push(Pair { row: track, column: place, cost });
                }
            }
        }
        pairs
    }

    /// Pairs of unmatched tracks and detections whose regions contain each other's centres.
    fn pairs_inside(&self, mut find_region: impl FnMut(&Detection) -> R) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let mut regions: HashMap<usize, R> = HashMap::new();
        for (track, known) in self.known.iter().enumerate().filter(|&(track, _)| self.own[track].is_none()) {
            for (place, detection) in self.detections.iter().enumerate().filter(|&(place, _)| !self.is_taken[place]) {
                let hole = detection.hole;
                let is_possible = are_alike(known.hole.radius, hole.radius)
                    && self.goes_on(known, place)
                    && (known.region.is_unknown() || held(known.region, known.shift, hole.center))
                    && regions.entry(place).or_insert_with(|| find_region(detection)).contains(known.hole.center);
                if is_possible {
                    // All of these are possible; the nearest is the most likely.
                    let apart = distance(known.hole.center, hole.center) / (known.hole.radius + hole.radius);
                    pairs.push(Pair { row: track, column: place, cost: apart / (1.0 + apart) });
                }
            }
        }
        pairs
    }
}

/// The distance between two holes: 0 if they are equal, more than 1 outside the gate.
fn remoteness(a: Hole, b: Hole) -> f64 {
    let apart = distance(a.center, b.center) / (NEAR * a.radius.max(b.radius));
    let unlike = (b.radius / a.radius).ln().abs() / ALIKE.ln();
    if apart <= 1.0 && unlike <= 1.0 { (apart + unlike) / 2.0 } else { f64::INFINITY }
}

fn are_alike(a: f64, b: f64) -> bool {
    a <= ALIKE * b && b <= ALIKE * a
}

/// Whether a region that was found some frames ago contains a point now. The movement of the centre since then may be
/// that of the region, or only that of the centre inside it; either is accepted.
pub fn held(region: &impl HoleRegion, shift: [f64; 2], point: [f64; 2]) -> bool {
    region.contains(point) || region.contains(back(point, shift))
}

/// A point before a shift.
pub fn back(point: [f64; 2], shift: [f64; 2]) -> [f64; 2] {
    [point[0] - shift[0], point[1] - shift[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
