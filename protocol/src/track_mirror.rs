//! What a consumer holds of a stream's tracks: it follows what happened to them.
//!
//! In: [`Tracks`]. Out: the living tracks by id, as they were last told of, and their cycles. The contract: living tracks are the same whether they were told by events alone or listed
//! in every frame (SPEC.md, section 9). Invariants: after an error it holds nothing to rely on, says so, and takes nothing but a message that starts anew. Must not
//! know: where messages come from, vertices.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::tracks::{Happening, Track, TrackCycle, TrackEvent, Tracks};

/// Why a message does not lead on from what a mirror holds. It has to be given one that starts from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TrackMirrorError {
    /// It starts from another frame, or does not lead forward.
    #[error("tracks of frame {to} start from frame {from}, but the mirror holds frame {holds}: ask for tracks again")]
    Gap {
        /// The frame that the mirror holds; 0 for none.
        holds: u64,
        /// The frame that the message starts from.
        from: u64,
        /// The frame that it leads to.
        to: u64,
    },
    /// It starts anew and does not say with what, or says what happened before.
    #[error("tracks of frame {frame} start anew, but are not a list of living tracks alone: ask for tracks again")]
    NoStart {
        /// The frame that it leads to.
        frame: u64,
    },
    /// An event is of a frame that is told of before or later, or something is not in its place.
    #[error("tracks of frame {frame} name track {track} out of order: ask for tracks again")]
    Order {
        /// The frame that the message leads to.
        frame: u64,
        /// The track that is in the wrong place.
        track: u64,
    },
    /// Something happens to a track that is not alive, or has a cycle, or is named by another one.
    #[error("tracks of frame {frame} name track {track}, which is not alive: ask for tracks again")]
    NotAlive {
        /// The frame in which it should be.
        frame: u64,
        /// The track.
        track: u64,
    },
    /// A track begins that is alive.
    #[error("in frame {frame} track {track} begins, which is alive already: ask for tracks again")]
    Alive {
        /// The frame.
        frame: u64,
        /// The track.
        track: u64,
    },
    /// The list of living tracks is not what the events lead to.
    #[error(
        "the living tracks of frame {frame} are not those that events lead to, as track {track} shows: \
         ask for tracks again"
    )]
    Contradiction {
        /// The frame.
        frame: u64,
        /// A track that is in one of them, or that is selected in one of them.
        track: u64,
    },
    /// An earlier message did not lead on.
    #[error("the mirror of tracks has lost its place and needs a new start: ask for tracks again")]
    Lost,
}

/// A consumer's copy of the tracks of a stream.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackMirror {
    frame: u64,
    time: Option<f64>,
    alive: BTreeMap<u64, Track>,
    cycles: BTreeMap<u64, Vec<Vec<u64>>>,
    is_lost: bool,
}

impl TrackMirror {
    /// Knows nothing: a message that starts from 0 may come.
    pub fn new() -> Self {
        Self::default()
    }

    /// The frame that was told of last; 0 if there was none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// That frame's time.
    pub fn time(&self) -> Option<f64> {
        self.time
    }

    /// Whether only a message that starts from 0 can help.
    pub fn needs_start(&self) -> bool {
        self.is_lost || self.frame == 0
    }

    /// Tracks that have begun and not ended, by id, each as it was last told of.
    pub fn alive(&self) -> &BTreeMap<u64, Track> {
        &self.alive
    }

    /// The walks around the hole of each living track, if cycles were asked for. A track that is missing for a while has none.
    pub fn cycles(&self) -> &BTreeMap<u64, Vec<Vec<u64>>> {
        &self.cycles
    }

    /// Goes on to the frame that a message leads to.
    ///
    /// # Errors
    /// [`TrackMirrorError`]: it starts from something else, or contradicts itself.
    pub fn apply(&mut self, tracks: &Tracks) -> Result<(), TrackMirrorError> {
        if tracks.from == 0 {
            *self = Self::new();
        } else if self.is_lost {
            return Err(TrackMirrorError::Lost);
        }
        let applied = self.attempt(tracks);
        self.is_lost = applied.is_err();
        applied
    }

    fn attempt(&mut self, tracks: &Tracks) -> Result<(), TrackMirrorError> {
        let &Tracks { from, frame, time, .. } = tracks;
        if from != self.frame || frame <= from {
            return Err(TrackMirrorError::Gap { holds: self.frame, from, to: frame });
        }
        check_order(tracks)?;
        if from == 0 {
            let alive = tracks.alive.as_ref().filter(|_| tracks.events.is_empty());
            self.replace(alive.ok_or(TrackMirrorError::NoStart { frame })?);
        } else {
            tracks.events.iter().try_for_each(|event| self.happen(event))?;
            if let Some(alive) = &tracks.alive {
                self.compare(frame, alive)?;
                self.replace(alive);
            }
        }
        self.set_cycles(frame, &tracks.cycles)?;
        (self.frame, self.time) = (frame, time);
        Ok(())
    }

    fn happen(&mut self, event: &TrackEvent) -> Result<(), TrackMirrorError> {
        let (frame, track) = (event.frame, event.track.id);
        let is_alive = self.alive.contains_key(&track);
        match event.happening {
            Happening::Born | Happening::Split(_) if is_alive => return Err(TrackMirrorError::Alive { frame, track }),
            Happening::Born | Happening::Split(_) => {}
            _ if !is_alive => return Err(TrackMirrorError::NotAlive { frame, track }),
            Happening::Merged(_) | Happening::Died => self.end(track),
            Happening::Updated(_) | Happening::Unselected | Happening::Reselected => {}
        }
        // The other one goes on, so it is there when this one is not: nothing comes from itself.
        if let Happening::Split(other) | Happening::Merged(other) = event.happening
            && !self.alive.contains_key(&other)
        {
            return Err(TrackMirrorError::NotAlive { frame, track: other });
        }
        if !matches!(event.happening, Happening::Merged(_) | Happening::Died) {
            self.alive.insert(track, event.track);
        }
        Ok(())
    }

    fn end(&mut self, track: u64) {
        self.alive.remove(&track);
        self.cycles.remove(&track);
    }

    /// Events and lists must tell the same of who is alive, and of who is selected.
    fn compare(&self, frame: u64, alive: &[Track]) -> Result<(), TrackMirrorError> {
        let told: BTreeMap<u64, bool> = self.alive.iter().map(|(&id, track)| (id, track.selected)).collect();
        let listed: BTreeMap<u64, bool> = alive.iter().map(|track| (track.id, track.selected)).collect();
        let differs = |id: &&u64| told.get(id) != listed.get(id);
        match told.keys().chain(listed.keys()).filter(differs).min() {
            Some(&track) => Err(TrackMirrorError::Contradiction { frame, track }),
            None => Ok(()),
        }
    }

    fn replace(&mut self, alive: &[Track]) {
        self.alive = alive.iter().map(|track| (track.id, *track)).collect();
    }

    fn set_cycles(&mut self, frame: u64, cycles: &[TrackCycle]) -> Result<(), TrackMirrorError> {
        for TrackCycle { id, walks } in cycles {
            if !self.alive.contains_key(id) {
                return Err(TrackMirrorError::NotAlive { frame, track: *id });
            }
            self.cycles.insert(*id, walks.clone());
        }
        Ok(())
    }
}

/// Events stand by frame, then by track, and lists by track, no track twice.
fn check_order(tracks: &Tracks) -> Result<(), TrackMirrorError> {
    let place = |event: &TrackEvent| (event.frame, event.track.id);
    let is_outside = |event: &&TrackEvent| event.frame <= tracks.from || event.frame > tracks.frame;
    let outside = tracks.events.iter().find(is_outside).map(|event| event.track.id);
    let events = tracks.events.windows(2).find(|pair| place(&pair[0]) > place(&pair[1])).map(|pair| pair[1].track.id);
    let alive = tracks.alive.iter().flat_map(|alive| alive.windows(2));
    let alive = alive.map(|pair| [pair[0].id, pair[1].id]);
    let cycles = tracks.cycles.windows(2).map(|pair| [pair[0].id, pair[1].id]);
    let listed = alive.chain(cycles).find(|[first, second]| first >= second).map(|[_, second]| second);
    match outside.or(events).or(listed) {
        Some(track) => Err(TrackMirrorError::Order { frame: tracks.frame, track }),
        None => Ok(()),
    }
}
