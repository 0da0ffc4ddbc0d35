//! Recognition in R^d: which detections of a frame continue which tracks.
//!
//! In: the last known state of each track, what its cycle is the sum of in the frame, and the detections of the frame.
//! Out: [`Recognized`].
//! Invariants: no detection continues two tracks. The order of detections decides ties only. A detection continues a
//! track only if their persistences are alike, so that noise takes over no track.
//! Must not know: events, hysteresis.
//!
//! A track is identified by the homology class of its cycle, and a class by when it dies: with the last of the dots
//! that it is the sum of. The classes of all tracks are turned into pairs of a track and a dot by elimination. What is
//! left, because a cycle is not there any more or bounds something, is recognized by vertices that its cycle has in
//! common with that of a dot, and then by centre and radius inside a gate. Never by the critical edge, which jumps.

use std::cmp::Ordering;
use std::collections::{BTreeSet, HashMap, HashSet};

use super::detection::{CycleDetection, CycleSource, TrackedCycle};
use super::elimination::{Pairs, eliminate};
use super::walk::WalkAnswer;
use crate::topology::cloud::VertexId;
use crate::topology::skeleton::EdgeId;
use crate::topology::tracks::assignment::{Pair, assign};
use crate::topology::tracks::detection::Detected;

/// The largest ratio of the persistences of one track in two frames.
const LIKE_PERSISTENCE: f64 = 4.0;

/// The same of one that was missing for long.
const REMEMBERED_PERSISTENCE: f64 = 2.0;

/// The least share of the vertices of two cycles that both have.
const OVERLAP: f64 = 0.25;

/// The gate: the largest distance between centres of one track, as a share of the larger radius.
const NEAR: f64 = 0.5;

/// The gate: the largest ratio of two radii of one track.
const LIKE_RADIUS: f64 = 2.0;

/// The last known state of a track.
#[derive(Clone, Debug)]
pub struct LastSeen<'a> {
    /// Its dot.
    pub detection: &'a CycleDetection,
    /// The centre of its cycle.
    pub center: &'a [f64],
    /// The predicted centre.
    pub expected: Vec<f64>,
    /// The radius of its cycle.
    pub radius: f64,
    /// A dot of less persistence does not continue it, unless the dot is selected.
    pub least: f64,
    /// Whether it has been missing for long, and is remembered.
    pub is_remembered: bool,
}

/// What is recognized.
#[derive(Debug)]
pub struct Recognized {
    /// For each track, the place of the detection that continues it.
    pub own: Vec<Option<usize>>,
    /// For each track without one, the track whose class is the same, up to those of tracks before.
    pub absorbed_by: Vec<Option<usize>>,
    /// For each track, whether its cycle dies with the dot that continues it.
    pub is_own: Vec<bool>,
    /// For each detection, the most persistent track whose cycle is a sum of it and of others.
    pub part_of: Vec<Option<usize>>,
    /// The cycles of detections, as far as they were found.
    pub cycles: HashMap<usize, TrackedCycle>,
}

/// The detections of a frame that continue tracks. The answers are those for the tracks, in order.
pub fn recognize(
    known: &[LastSeen<'_>],
    answers: &[WalkAnswer],
    detections: &[CycleDetection],
    is_selected: &[bool],
    source: &impl CycleSource,
) -> Recognized {
    let found = Recognized {
        own: vec![None; known.len()],
        absorbed_by: vec![None; known.len()],
        is_own: vec![false; known.len()],
        part_of: vec![None; detections.len()],
        cycles: HashMap::new(),
    };
    let is_taken = vec![false; detections.len()];
    let mut search = Search { known, answers, detections, is_selected, found, is_taken };
    search.by_class();
    let common = search.pairs_in_common(source);
    search.assign(&common);
    let near = search.pairs_near(source);
    search.assign(&near);
    let returned = search.pairs_from_memory(source);
    search.assign(&returned);
    search.found
}

struct Search<'a> {
    known: &'a [LastSeen<'a>],
    answers: &'a [WalkAnswer],
    detections: &'a [CycleDetection],
    is_selected: &'a [bool],
    found: Recognized,
    is_taken: Vec<bool>,
}

impl Search<'_> {
    fn by_class(&mut self) {
        let order = self.persistent_first();
        let rows = self.rows(&order);
        for (&track, row) in order.iter().zip(&rows) {
            for &place in row.iter().filter(|&&place| place < self.detections.len()) {
                self.found.part_of[place].get_or_insert(track);
            }
        }
        let last: Vec<Option<usize>> = rows.iter().map(|row| self.last_to_die(row)).collect();
        let is_possible = |row: usize, place: usize| place < self.detections.len() && self.goes_on(order[row], place);
        let Pairs { own, absorbed_by } = eliminate(rows, is_possible, |a, b| self.by_death(a, b));
        for (row, &track) in order.iter().enumerate() {
            if let Some(place) = own[row] {
                self.give(track, place);
                self.found.is_own[track] = last[row] == own[row];
            }
            self.found.absorbed_by[track] = absorbed_by[row].map(|row| order[row]);
        }
    }

    /// The tracks that are not only remembered, the most persistent first, equal ones by the positions of their dots.
    fn persistent_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.known.len()).filter(|&track| !self.known[track].is_remembered).collect();
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|track| self.known[track].detection);
            b.persistence().total_cmp(&a.persistence()).then_with(|| a.by_position(b))
        });
        order
    }

    /// The class of each of these tracks as places of detections. Dots that are not detected have numbers beyond.
    fn rows(&self, order: &[usize]) -> Vec<BTreeSet<usize>> {
        let edges = self.detections.iter().map(|detection| detection.critical.edge);
        let mut places: HashMap<EdgeId, usize> = edges.zip(0..).collect();
        let mut place = |edge: &EdgeId| {
            let next = places.len();
            *places.entry(*edge).or_insert(next)
        };
        let of_track = |&track: &usize| self.answers[track].dots.iter().flatten().map(&mut place).collect();
        order.iter().map(of_track).collect()
    }

    /// The detection of a sum that dies last: with it the whole sum does.
    fn last_to_die(&self, row: &BTreeSet<usize>) -> Option<usize> {
        let detected = row.iter().copied().filter(|&place| place < self.detections.len());
        detected.min_by(|&a, &b| self.by_death(a, b))
    }

    /// The last to die comes first; of those that die together the youngest.
    fn by_death(&self, a: usize, b: usize) -> Ordering {
        let [x, y] = [a, b].map(|place| self.detections[place].critical);
        y.death.total_cmp(&x.death).then(y.birth.total_cmp(&x.birth)).then(a.cmp(&b))
    }

    /// Whether a detection is like a track, and persistent enough to continue it.
    fn goes_on(&self, track: usize, place: usize) -> bool {
        let (known, detection) = (&self.known[track], &self.detections[place]);
        let is_enough = self.is_selected[place] || detection.persistence() >= known.least;
        is_enough && unlikeness(known.detection, detection) <= LIKE_PERSISTENCE.ln()
    }

    fn give(&mut self, track: usize, place: usize) {
        self.found.own[track] = Some(place);
        self.is_taken[place] = true;
    }

    fn assign(&mut self, pairs: &[Pair]) {
        for (track, place) in assign(pairs) {
            self.give(track, place);
        }
    }

    /// Tracks without a detection, remembered or not, and free detections that may continue them.
    fn possible_pairs(&self, is_remembered: bool) -> Vec<(usize, usize)> {
        let free: Vec<usize> = (0..self.detections.len()).filter(|&place| !self.is_taken[place]).collect();
        let is_lost =
            |&track: &usize| self.found.own[track].is_none() && self.known[track].is_remembered == is_remembered;
        let lost = (0..self.known.len()).filter(is_lost);
        let pairs = lost.flat_map(|track| free.iter().map(move |&place| (track, place)));
        pairs.filter(|&(track, place)| self.goes_on(track, place)).collect()
    }

    fn cycle(&mut self, place: usize, source: &impl CycleSource) -> &TrackedCycle {
        self.found.cycles.entry(place).or_insert_with(|| source.cycle(&self.detections[place]))
    }

    /// Possible pairs whose cycles have vertices in common.
    fn pairs_in_common(&mut self, source: &impl CycleSource) -> Vec<Pair> {
        let mut pairs = Vec::new();
        let mut walks: HashMap<usize, HashSet<VertexId>> = HashMap::new();
        for (row, column) in self.possible_pairs(false) {
            let walk = walks.entry(row).or_insert_with(|| self.answers[row].vertices.iter().copied().collect());
            let cycle = self.cycle(column, source);
            let common = cycle.vertices.iter().filter(|(id, _)| walk.contains(id)).count();
            let share = common as f64 / (walk.len() + cycle.vertices.len() - common) as f64;
            if share >= OVERLAP {
                pairs.push(Pair { row, column, gain: share });
            }
        }
        pairs
    }

    fn pairs_near(&mut self, source: &impl CycleSource) -> Vec<Pair> {
        let possible = self.possible_pairs(false);
        self.pairs_inside_gate(possible, source)
    }

    /// Remembered tracks and selected detections of much the same persistence.
    fn pairs_from_memory(&mut self, source: &impl CycleSource) -> Vec<Pair> {
        let mut possible = self.possible_pairs(true);
        possible.retain(|&(track, place)| {
            let unlikeness = unlikeness(self.known[track].detection, &self.detections[place]);
            self.is_selected[place] && unlikeness <= REMEMBERED_PERSISTENCE.ln()
        });
        self.pairs_inside_gate(possible, source)
    }

    /// Those of some pairs that are inside the gate, around the last or the predicted centre.
    fn pairs_inside_gate(&mut self, possible: Vec<(usize, usize)>, source: &impl CycleSource) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for (row, column) in possible {
            let known = &self.known[row];
            self.cycle(column, source);
            let cycle = &self.found.cycles[&column];
            let away = |center| source.distance(center, &cycle.center);
            let apart = away(known.center).min(away(&known.expected)) / (NEAR * known.radius.max(cycle.radius));
            let unlike = (cycle.radius / known.radius).ln().abs() / LIKE_RADIUS.ln();
            if apart <= 1.0 && unlike <= 1.0 {
                pairs.push(Pair { row, column, gain: 1.0 - (apart + unlike) / 2.0 });
            }
        }
        pairs
    }
}

/// How unlike two dots are: the logarithm of the ratio of their persistences. Where one of them is infinite, since the
/// filtration ends before, that of their births.
fn unlikeness(a: &CycleDetection, b: &CycleDetection) -> f64 {
    let ratio = b.persistence() / a.persistence();
    let ratio = if ratio.is_finite() && ratio > 0.0 { ratio } else { b.critical.birth / a.critical.birth };
    ratio.ln().abs()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::topology::cloud::Coordinates;
    use crate::topology::skeleton::Critical;

    fn point(x: f64) -> Coordinates {
        Coordinates::new(&[x]).unwrap()
    }

    fn detection(name: u64, [birth, death]: [f64; 2]) -> CycleDetection {
        let edge = [VertexId(name), VertexId(name + 1)];
        CycleDetection { critical: Critical { edge, birth, death }, ends: [point(0.0), point(1.0)] }
    }

    /// A cycle of some vertices around a place.
    fn cycle(center: f64, ids: std::ops::Range<u64>) -> TrackedCycle {
        let vertices: Arc<[_]> = ids.map(|id| (VertexId(id), point(center))).collect();
        TrackedCycle { vertices, center: vec![center], radius: 1.0 }
    }

    /// A line, where the cycle of a detection is known by the first end of its edge.
    struct Line(HashMap<u64, TrackedCycle>);

    impl CycleSource for Line {
        fn cycle(&self, detection: &CycleDetection) -> TrackedCycle {
            self.0[&detection.critical.edge[0].0].clone()
        }

        fn along(&self, walk: &[VertexId]) -> TrackedCycle {
            panic!("nobody asks for {walk:?}")
        }

        fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
            (a[0] - b[0]).abs()
        }
    }

    /// What continues a track of birth 1 and death 5 around 0, which had the vertices 0 to 8, given its dots.
    fn own(dots: Option<Vec<EdgeId>>, detections: &[(CycleDetection, TrackedCycle)]) -> Option<usize> {
        let last = detection(100, [1.0, 5.0]);
        let known = LastSeen {
            detection: &last,
            center: &[0.0],
            expected: vec![0.0],
            radius: 1.0,
            least: 1.0,
            is_remembered: false,
        };
        let answer = WalkAnswer { vertices: (0..8).map(VertexId).collect(), dots };
        let cycles = detections.iter().map(|(detection, cycle)| (detection.critical.edge[0].0, cycle.clone()));
        let source = Line(cycles.collect());
        let all: Vec<CycleDetection> = detections.iter().map(|(detection, _)| detection.clone()).collect();
        recognize(&[known], &[answer], &all, &vec![true; all.len()], &source).own[0]
    }

    #[test]
    fn a_class_comes_before_common_vertices_and_these_before_places() {
        let of_class = (detection(200, [1.0, 4.0]), cycle(50.0, 40..48));
        let in_common = (detection(300, [1.0, 4.0]), cycle(50.0, 5..13));
        let near = (detection(400, [1.0, 4.0]), cycle(0.2, 40..48));
        let all = [near.clone(), in_common.clone(), of_class.clone()];
        assert_eq!(own(Some(vec![of_class.0.critical.edge]), &all), Some(2));
        for dots in [None, Some(Vec::new())] {
            // Three of thirteen vertices are too few, four of twelve are enough.
            assert_eq!(own(dots.clone(), &all), Some(0));
            let more = (in_common.0.clone(), cycle(50.0, 4..12));
            assert_eq!(own(dots.clone(), &[near.clone(), more]), Some(1));
            let far = (near.0.clone(), cycle(0.6, 40..48));
            assert_eq!(own(dots, &[far, of_class.clone()]), None);
        }
    }

    #[test]
    fn a_dot_of_another_size_continues_no_track() {
        let small = (detection(200, [1.0, 1.9]), cycle(0.0, 0..8));
        assert_eq!(own(Some(vec![small.0.critical.edge]), std::slice::from_ref(&small)), None);
        let like = (detection(200, [1.0, 2.1]), cycle(0.0, 0..8));
        assert_eq!(own(Some(vec![like.0.critical.edge]), &[like]), Some(0));
    }
}
