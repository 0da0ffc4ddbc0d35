//! The tracker: persistent cycles followed from frame to frame, each under an id that is never reused.
//!
//! In: the states of tracks, updated to a frame.
//! Out: a [`TrackStep`]: events and living tracks.
//! Invariants: every track begins once and ends once. Nothing is reported of a track before it begins or after it ends.
//! Must not know: how dots are found or recognized, holes, cycles, formats.
//!
//! A track is announced when its dot was selected in a number of consecutive frames. It ends when its dot was missing
//! in a number of them, or after that when it is not remembered any more. In between it may leave the selection without
//! ending.

use std::fmt::Debug;

use super::life::{Life, Report};
use super::rule::TrackOptions;
use super::track::{EventKind, FrameStamp, TrackEvent, TrackId, TrackStep};

/// The largest number of tracks that are remembered after a frame, besides those that went missing in it.
const MOST_REMEMBERED: usize = 1024;

/// The state of one track, in some space.
pub trait Tracked {
    /// The track as it is reported.
    type Track: Report;
    /// What the tracks of a tracker have in common.
    type Shared: Clone + Debug + Default;
    /// Its life so far.
    fn life(&self) -> &Life<Self::Track>;
    /// The same, to be changed.
    fn life_mut(&mut self) -> &mut Life<Self::Track>;
}

/// Follows the persistent cycles of one stream.
#[derive(Clone, Debug)]
pub struct Tracker<S: Tracked> {
    pub(super) options: TrackOptions,
    /// The frame that it was updated to; 0 for none.
    pub(super) frame: u64,
    /// In order of first detection.
    pub(super) states: Vec<S>,
    /// The key of the next state, announced or not.
    next_key: u64,
    next_id: u64,
    pub(super) shared: S::Shared,
}

impl<S: Tracked> Tracker<S> {
    /// A tracker at no frame yet.
    pub fn new(options: TrackOptions) -> Self {
        Self { options, frame: 0, states: Vec::new(), next_key: 0, next_id: 1, shared: S::Shared::default() }
    }

    /// Its options.
    pub fn options(&self) -> &TrackOptions {
        &self.options
    }

    /// The number of the frame that it was updated to; 0 for none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// All tracks that were announced and have not ended, by id.
    pub fn alive(&self) -> impl Iterator<Item = &S::Track> {
        self.announced().map(|state| &state.life().track)
    }

    /// The states of those of them that were detected in the newest frame, by id.
    pub(super) fn seen_states(&self) -> impl Iterator<Item = (TrackId, &S)> {
        let frame = self.frame;
        let seen = self.announced().filter(move |state| state.life().last_seen == frame);
        seen.map(|state| (state.life().track.status().id, state))
    }

    pub(super) fn announced(&self) -> impl Iterator<Item = &S> {
        self.states.iter().filter(|state| state.life().is_announced)
    }

    /// The number of tracks, announced or not, and the least persistence that continues one of them.
    pub(crate) fn search_bounds(&self) -> (usize, f64) {
        let lives = || self.states.iter().map(Tracked::life).filter(|life| !life.is_remembered);
        (lives().count(), lives().map(|life| life.least).fold(f64::INFINITY, f64::min))
    }

    /// Adds the state of a track that is new, given its key.
    pub(super) fn begin(&mut self, state: impl FnOnce(u64) -> S) {
        self.states.push(state(self.next_key));
        self.next_key += 1;
    }

    /// Drops tracks that end without an event.
    pub(super) fn drop_void(&mut self) {
        self.states.retain(|state| !state.life().is_void());
    }

    /// The events of a frame, in order of track ids. `moved` says how far the centre of a track has moved since that
    /// was last reported, and `heir` the key of the track that the one at a place has become a part of.
    pub(super) fn collect_events(
        &mut self,
        at: FrameStamp,
        moved: impl Fn(&S) -> f64,
        mut heir: impl FnMut(&mut [S], usize) -> Option<u64>,
    ) -> Vec<TrackEvent<S::Track>> {
        let TrackOptions { confirm, miss, remember, delta, .. } = self.options;
        let forgotten = self.forgotten();
        let mut events = Vec::new();
        let mut ended = Vec::new();
        for place in 0..self.states.len() {
            let state = &self.states[place];
            let life = state.life();
            let mut kinds = Vec::new();
            if life.missed >= miss.get() {
                let heir = if life.is_remembered { None } else { heir(&mut self.states, place) };
                let life = self.states[place].life();
                match self.id_of(heir) {
                    None if forgotten.contains(&life.key) || !life.is_recalled(at, remember) => {
                        ended.push(life.key);
                        kinds.push(EventKind::Died);
                    }
                    None if life.track.status().is_selected => kinds.push(EventKind::Unselected),
                    None => {}
                    Some(into) => {
                        ended.push(life.key);
                        kinds.push(EventKind::Merged { into });
                    }
                }
                self.states[place].life_mut().is_remembered = true;
            } else if life.is_detected() {
                kinds.extend(life.changed(moved(state), delta).map(EventKind::Updated));
                kinds.extend(life.selection_change(confirm, miss));
            } else if life.is_due(at.number, confirm) {
                let parent = self.id_of(life.parent);
                kinds.push(parent.map_or(EventKind::Born, |from| EventKind::Split { from }));
            }
            for kind in kinds {
                let id = TrackId(self.next_id);
                let life = self.states[place].life_mut();
                if life.record(kind, id) {
                    self.next_id += 1;
                }
                events.push(TrackEvent { frame: at.number, time: at.time, kind, track: life.track.clone() });
            }
        }
        self.states.retain(|state| !ended.contains(&state.life().key));
        events.sort_by_key(|event| event.track.status().id);
        events
    }

    /// The keys of tracks that are remembered beyond the largest number: the least persistent ones, of equal ones the
    /// youngest.
    fn forgotten(&self) -> Vec<u64> {
        let lives = self.states.iter().map(Tracked::life).filter(|life| life.is_remembered && life.missed > 0);
        let persistence = |life: &Life<S::Track>| {
            let [birth, death] = life.track.label();
            death - birth
        };
        let mut remembered: Vec<(f64, u64)> = lives.map(|life| (persistence(life), life.key)).collect();
        remembered.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        remembered.into_iter().skip(MOST_REMEMBERED).map(|(_, key)| key).collect()
    }

    /// The step to a frame.
    pub(super) fn step(
        &self,
        at: FrameStamp,
        events: Vec<TrackEvent<S::Track>>,
        left_out: usize,
    ) -> TrackStep<S::Track> {
        TrackStep { number: at.number, time: at.time, events, alive: self.alive().cloned().collect(), left_out }
    }

    /// The id of a track that is detected.
    fn id_of(&self, key: Option<u64>) -> Option<TrackId> {
        let lives = self.states.iter().map(Tracked::life);
        lives.filter(|life| life.is_detected()).find(|life| Some(life.key) == key).map(|life| life.track.status().id)
    }
}
