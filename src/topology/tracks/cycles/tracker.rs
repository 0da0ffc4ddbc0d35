//! Tracks in R^d, updated to a frame.
//!
//! In: the detections of a frame, most persistent first; what the cycles of the tracks are the sum of in that frame;
//! cycles and distances on request.
//! Out: a [`TrackStep`].
//! Invariant: reports depend on the positions of points alone, not on their order or ids.
//! Must not know: how dots, cycles and classes are found, formats, hysteresis.
//!
//! A track that begins was split from another one if that one's cycle is now the sum of its own dot and the new one, or
//! if the new cycle lies along it. A track that ends was merged into another one if both cycles have become of one
//! class, or if its cycle lies along that of the other. In both cases the scale at which it is filled must be
//! comparable, so that noise on a cycle is no part of it. So it is told that a ring pinches in two, and that two rings
//! that touch become one. It is not told of holes that meet or part over a long side, where neither cycle lies along
//! the other; then the track is born, or dies.

use super::detection::{CycleDetection, CycleSource, TrackedCycle};
use super::recognition::{LastSeen, Recognized, recognize};
use super::state::CycleState;
use super::track::SpaceTrack;
use super::walk::{TrackWalk, WalkAnswer};
use crate::topology::tracks::detection::Detections;
use crate::topology::tracks::track::{FrameStamp, TrackId, TrackStep};
use crate::topology::tracks::tracker::Tracker;

/// A part of a cycle is filled at no less than this share of the scale at which the cycle is.
const SUBSTANTIAL: f64 = 0.25;

/// The share of the vertices of a part that lie along the cycle.
const ALONG: f64 = 0.75;

impl Tracker<CycleState> {
    /// The cycles of the tracks that were detected in the newest frame, by id.
    pub(crate) fn seen(&self) -> impl Iterator<Item = (TrackId, &TrackedCycle)> {
        self.seen_states().map(|(id, state)| (id, &state.cycle))
    }

    /// The cycles of all tracks, announced or not, as questions to the next frame.
    pub(crate) fn walks(&self) -> Vec<TrackWalk> {
        self.states.iter().map(CycleState::walk).collect()
    }

    /// Updates the tracks to a frame. The answers are those to [`walks`](Self::walks), in order.
    pub(crate) fn advance<S: CycleSource>(
        &mut self,
        at: FrameStamp,
        detections: Detections<CycleDetection>,
        answers: &[WalkAnswer],
        source: &S,
    ) -> TrackStep<SpaceTrack> {
        let Detections { all, is_selected, left_out } = detections;
        let known: Vec<LastSeen<'_>> = self.states.iter().map(|state| state.last_seen(at.number)).collect();
        let Recognized { own, absorbed_by, is_own, part_of, mut cycles } =
            recognize(&known, answers, &all, &is_selected, source);
        let mut is_new = is_selected.clone();
        own.iter().flatten().for_each(|&place| is_new[place] = false);
        let mut cycle = |place: usize| cycles.remove(&place).unwrap_or_else(|| source.cycle(&all[place]));
        let newcomers: Vec<(usize, TrackedCycle)> =
            (0..all.len()).filter(|&place| is_new[place]).map(|place| (place, cycle(place))).collect();
        let walks: Vec<TrackedCycle> =
            answers.iter().filter(|_| !newcomers.is_empty()).map(|answer| source.along(&answer.vertices)).collect();
        let parent = |(place, cycle): &(usize, TrackedCycle)| {
            let birth = |track: usize| self.states[track].life.track.birth;
            let lies_in = |track: usize| lies_along(cycle, &walks[track], birth(track), source);
            self.parent(part_of[*place], &all[*place], lies_in)
        };
        let parents: Vec<Option<u64>> = newcomers.iter().map(parent).collect();
        for (track, state) in self.states.iter_mut().enumerate() {
            let Some(place) = own[track] else {
                state.life.miss();
                continue;
            };
            // A cycle that dies with the dot is taken along. Else the dot may have a better one.
            let cycle = if is_own[track] { source.along(&answers[track].vertices) } else { cycle(place) };
            state.see(at, all[place].clone(), (cycle, is_own[track]), is_selected[place]);
        }
        self.find_heirs(&absorbed_by, source);
        self.frame = at.number;
        for ((place, cycle), parent) in newcomers.into_iter().zip(parents) {
            self.begin(|key| CycleState::new(key, at, all[place].clone(), cycle, parent));
        }
        self.drop_void();
        let moved = |state: &CycleState| source.distance(&state.life.track.center, &state.life.reported.center);
        let events = self.collect_events(at, moved, |states, place| states[place].heir);
        self.step(at, events, left_out)
    }

    /// The key of the announced track that a new dot is a part of, before the tracks are updated: that whose class it
    /// is a part of, else the first in whose cycle it lies.
    fn parent(
        &self,
        part_of: Option<usize>,
        detection: &CycleDetection,
        lies_in: impl Fn(usize) -> bool,
    ) -> Option<u64> {
        let is_part = |&track: &usize| {
            let life = &self.states[track].life;
            life.is_announced && detection.critical.death >= SUBSTANTIAL * life.track.death
        };
        let by_class = part_of.filter(is_part);
        let by_place = || (0..self.states.len()).filter(is_part).find(|&track| lies_in(track));
        by_class.or_else(by_place).map(|track| self.states[track].life.key)
    }

    /// Finds the tracks that the missing ones have become parts of.
    fn find_heirs(&mut self, absorbed_by: &[Option<usize>], source: &impl CycleSource) {
        for (place, &absorbed_by) in absorbed_by.iter().enumerate() {
            let state = &self.states[place];
            if !state.life.is_announced || state.life.missed == 0 || state.heir.is_some() {
                continue;
            }
            let is_heir = |other: &&CycleState| {
                other.life.is_detected() && state.life.track.death >= SUBSTANTIAL * other.life.track.death
            };
            let by_class = absorbed_by.map(|heir| &self.states[heir]).filter(is_heir);
            // The other's own cycle may be that of a part still. The one born with its dot goes around the whole.
            let lies_in = |other: &&CycleState| {
                let is_along = |whole: &TrackedCycle| lies_along(&state.cycle, whole, other.life.track.birth, source);
                is_along(&other.cycle) || is_along(&source.cycle(&other.detection))
            };
            let by_place = || self.states.iter().filter(is_heir).find(lies_in);
            let heir = by_class.or_else(by_place).map(|heir| heir.life.key);
            self.states[place].heir = heir;
        }
    }
}

/// Whether a cycle lies along another one, of a track with some birth: most of its vertices are as near to one of the
/// other's as these are to each other.
fn lies_along(cycle: &TrackedCycle, along: &TrackedCycle, birth: f64, source: &impl CycleSource) -> bool {
    if source.distance(&cycle.center, &along.center) > cycle.radius + along.radius {
        return false;
    }
    let points = || along.vertices.iter().map(|(_, point)| point.as_slice());
    let steps = points().zip(points().cycle().skip(1)).map(|(a, b)| source.distance(a, b));
    let reach = steps.fold(2.0 * birth, f64::max);
    let is_near = |point: &[f64]| points().any(|other| source.distance(point, other) <= reach);
    let near = cycle.vertices.iter().filter(|(_, vertex)| is_near(vertex.as_slice())).count();
    near as f64 >= ALONG * cycle.vertices.len() as f64
}
