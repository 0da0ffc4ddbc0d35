//! A track mirror: a consumer's copy of the tracks of a stream. It applies their events.
//!
//! In: [`Tracks`](crate::Tracks) or [`SpaceTracks`](crate::SpaceTracks). Out: the living tracks by id, each in its last
//! reported state, and their cycles.
//!
//! The contract: living tracks are the same whether they were reported by events alone or listed in every frame
//! (SPEC.md, section 9).
//!
//! Invariants: after an error the content is not valid: the mirror reports this and accepts only a message that starts
//! from 0.
//!
//! Must not know: where messages come from, vertices.

use std::collections::BTreeMap;

use thiserror::Error;

use super::track_message::{TrackMessage, TrackState, TrackStep};
use crate::space::SpaceTrack;
use crate::tracks::{Happening, Track, TrackCycle};

/// Why a message does not fit the content of a mirror. Only a message that starts from 0 helps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TrackMirrorError {
    /// The message starts from another frame, or does not lead to a later one.
    #[error("tracks of frame {to} start from frame {from}, but the mirror holds frame {holds}: ask for tracks again")]
    Gap {
        /// The frame that the mirror holds. 0: none.
        holds: u64,
        /// The frame that the message starts from.
        from: u64,
        /// The frame that it leads to.
        to: u64,
    },
    /// The message starts from 0 without a list of living tracks, or with events.
    #[error("tracks of frame {frame} start anew, but are not a list of living tracks alone: ask for tracks again")]
    NoStart {
        /// The frame that the message leads to.
        frame: u64,
    },
    /// An event's frame is outside of the message's frames, or a list is not sorted.
    #[error("tracks of frame {frame} name track {track} out of order: ask for tracks again")]
    Order {
        /// The frame that the message leads to.
        frame: u64,
        /// The first track that is out of order.
        track: u64,
    },
    /// A track that an event or a cycle refers to is not alive.
    #[error("tracks of frame {frame} name track {track}, which is not alive: ask for tracks again")]
    NotAlive {
        /// The frame of the event or cycle.
        frame: u64,
        /// The track.
        track: u64,
    },
    /// A track begins that is alive already.
    #[error("in frame {frame} track {track} begins, which is alive already: ask for tracks again")]
    Alive {
        /// The frame.
        frame: u64,
        /// The track.
        track: u64,
    },
    /// The list of living tracks differs from the result of the events.
    #[error(
        "the living tracks of frame {frame} are not those that events lead to, as track {track} shows: \
         ask for tracks again"
    )]
    Contradiction {
        /// The frame.
        frame: u64,
        /// A track that only one of the two has, or that is selected in only one of them.
        track: u64,
    },
    /// A track's centre and velocity are no coordinates of the space in which the other tracks are.
    #[error(
        "tracks of frame {frame} give track {track} a centre or velocity that is not finite, or of another dimension: \
         ask for tracks again"
    )]
    Coordinates {
        /// The frame that the message leads to.
        frame: u64,
        /// The track.
        track: u64,
    },
    /// An earlier message could not be applied.
    #[error("the mirror of tracks has lost its place and needs a new start: ask for tracks again")]
    Lost,
}

/// A consumer's copy of the tracks of a stream of the plane, unless it is a [`SpaceTrackMirror`].
#[derive(Clone, Debug, PartialEq)]
pub struct TrackMirror<T = Track> {
    frame: u64,
    time: Option<f64>,
    alive: BTreeMap<u64, T>,
    cycles: BTreeMap<u64, Vec<Vec<u64>>>,
    is_lost: bool,
}

/// A consumer's copy of the tracks of a stream in R^d.
pub type SpaceTrackMirror = TrackMirror<SpaceTrack>;

impl<T> Default for TrackMirror<T> {
    fn default() -> Self {
        Self { frame: 0, time: None, alive: BTreeMap::new(), cycles: BTreeMap::new(), is_lost: false }
    }
}

impl TrackMirror {
    /// An empty mirror of the plane. It accepts a message that starts from 0.
    pub fn new() -> Self {
        Self::default()
    }
}

impl<T: TrackState> TrackMirror<T> {
    /// The frame of the last message. 0: none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// The time of that frame.
    pub fn time(&self) -> Option<f64> {
        self.time
    }

    /// Whether the mirror accepts nothing but a message that starts from 0.
    pub fn needs_start(&self) -> bool {
        self.is_lost || self.frame == 0
    }

    /// Tracks that have begun and not ended, by id, each in its last reported state.
    pub fn alive(&self) -> &BTreeMap<u64, T> {
        &self.alive
    }

    /// The walks around the hole of each living track, if the consumer asked for cycles. Empty while the hole is not
    /// seen.
    pub fn cycles(&self) -> &BTreeMap<u64, Vec<Vec<u64>>> {
        &self.cycles
    }

    /// Applies a message.
    ///
    /// # Errors
    /// [`TrackMirrorError`]: it does not fit the content, or contradicts itself.
    pub fn apply<M: TrackMessage<Track = T>>(&mut self, message: &M) -> Result<(), TrackMirrorError> {
        if message.from() == 0 {
            *self = Self::default();
        } else if self.is_lost {
            return Err(TrackMirrorError::Lost);
        }
        let applied = self.attempt(message);
        self.is_lost = applied.is_err();
        applied
    }

    fn attempt<M: TrackMessage<Track = T>>(&mut self, message: &M) -> Result<(), TrackMirrorError> {
        let (from, frame) = (message.from(), message.frame());
        if from != self.frame || frame <= from {
            return Err(TrackMirrorError::Gap { holds: self.frame, from, to: frame });
        }
        check_order(message)?;
        self.check_coordinates(message)?;
        if from == 0 {
            let alive = message.alive().filter(|_| message.events().next().is_none());
            self.replace(alive.ok_or(TrackMirrorError::NoStart { frame })?);
        } else {
            message.events().try_for_each(|step| self.happen(step))?;
            if let Some(alive) = message.alive() {
                self.compare(frame, alive)?;
                self.replace(alive);
            }
        }
        self.set_cycles(frame, message.cycles())?;
        (self.frame, self.time) = (frame, message.time());
        Ok(())
    }

    /// All tracks lie in one space, that of those that are alive.
    fn check_coordinates<M: TrackMessage<Track = T>>(&self, message: &M) -> Result<(), TrackMirrorError> {
        let listed = message.alive().unwrap_or_default();
        let mut held = self.alive.values().next().and_then(T::dimension);
        for track in message.events().map(|step| step.track).chain(listed) {
            let found = track.dimension();
            if found.is_none() || held.is_some_and(|held| found != Some(held)) {
                return Err(TrackMirrorError::Coordinates { frame: message.frame(), track: track.id() });
            }
            held = found;
        }
        Ok(())
    }

    fn happen(&mut self, step: TrackStep<'_, T>) -> Result<(), TrackMirrorError> {
        let TrackStep { frame, happening, track: state } = step;
        let track = state.id();
        let is_alive = self.alive.contains_key(&track);
        match happening {
            Happening::Born | Happening::Split(_) if is_alive => return Err(TrackMirrorError::Alive { frame, track }),
            Happening::Born | Happening::Split(_) => {}
            _ if !is_alive => return Err(TrackMirrorError::NotAlive { frame, track }),
            Happening::Merged(_) | Happening::Died => self.end(track),
            Happening::Updated(_) | Happening::Unselected | Happening::Reselected => {}
        }
        // The other track goes on, so it must be alive after this one has begun or ended. It also cannot be this one.
        if let Happening::Split(other) | Happening::Merged(other) = happening
            && !self.alive.contains_key(&other)
        {
            return Err(TrackMirrorError::NotAlive { frame, track: other });
        }
        if !matches!(happening, Happening::Merged(_) | Happening::Died) {
            self.alive.insert(track, state.clone());
        }
        Ok(())
    }

    fn end(&mut self, track: u64) {
        self.alive.remove(&track);
        self.cycles.remove(&track);
    }

    /// Events and list must agree on which tracks are alive and which are selected.
    fn compare(&self, frame: u64, alive: &[T]) -> Result<(), TrackMirrorError> {
        let from_events: BTreeMap<u64, bool> =
            self.alive.iter().map(|(&id, track)| (id, track.is_selected())).collect();
        let listed: BTreeMap<u64, bool> = alive.iter().map(|track| (track.id(), track.is_selected())).collect();
        let differs = |id: &&u64| from_events.get(id) != listed.get(id);
        match from_events.keys().chain(listed.keys()).filter(differs).min() {
            Some(&track) => Err(TrackMirrorError::Contradiction { frame, track }),
            None => Ok(()),
        }
    }

    fn replace(&mut self, alive: &[T]) {
        self.alive = alive.iter().map(|track| (track.id(), track.clone())).collect();
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

/// Events are sorted by frame, then by track. Lists are sorted by track, without duplicates.
fn check_order<M: TrackMessage>(message: &M) -> Result<(), TrackMirrorError> {
    let places: Vec<(u64, u64)> = message.events().map(|step| (step.frame, step.track.id())).collect();
    let is_outside = |(frame, _): &&(u64, u64)| *frame <= message.from() || *frame > message.frame();
    let outside = places.iter().find(is_outside).map(|(_, track)| *track);
    let events = places.windows(2).find(|pair| pair[0] > pair[1]).map(|pair| pair[1].1);
    let alive = message.alive().into_iter().flat_map(|alive| alive.windows(2));
    let alive = alive.map(|pair| [pair[0].id(), pair[1].id()]);
    let cycles = message.cycles().windows(2).map(|pair| [pair[0].id, pair[1].id]);
    let listed = alive.chain(cycles).find(|[first, second]| first >= second).map(|[_, second]| second);
    match outside.or(events).or(listed) {
        Some(track) => Err(TrackMirrorError::Order { frame: message.frame(), track }),
        None => Ok(()),
    }
}
