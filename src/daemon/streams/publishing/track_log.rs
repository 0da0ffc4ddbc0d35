//! The log of a stream's tracks: its last frames, for any number of consumers to read.
//!
//! In: [`TrackFrame`]s, one per frame. Out: [`wire::Tracks`] for a consumer, from its position.
//! Invariants: frames
//! follow upon each other without a gap. The oldest go when all of them take more than so many bytes; the newest always
//! stays. Cycles that have not changed are shared between frames.
//! Must not know: who reads it, how tracks are found.

use std::collections::VecDeque;
use std::sync::Arc;

use hopes_protocol as wire;

use crate::daemon::memory::{Account, Charge};

/// What has happened to tracks up to a frame.
#[derive(Debug)]
pub struct TrackFrame {
    /// The frame.
    pub frame: u64,
    /// Its time.
    pub time: Option<f64>,
    /// Since the frame before.
    pub events: Vec<wire::TrackEvent>,
    /// All that are alive, by id, and their cycles, if a consumer wants them.
    pub living: Vec<Living>,
    /// An estimate of the memory that it takes.
    pub bytes: usize,
    /// Held for its drop.
    _charge: Charge,
}

/// A track that is alive.
#[derive(Clone, Debug)]
pub struct Living {
    /// The track.
    pub track: wire::Track,
    /// Its cycle, if a consumer wants it.
    pub cycle: Option<Arc<wire::TrackCycle>>,
}

impl TrackFrame {
    /// A frame that takes about so many bytes, which are charged to an account.
    pub fn new(
        (frame, time): (u64, Option<f64>),
        events: Vec<wire::TrackEvent>,
        living: Vec<Living>,
        bytes: usize,
        account: &Arc<Account>,
    ) -> Self {
        let time = time.filter(|time| time.is_finite());
        Self { frame, time, events, living, bytes, _charge: account.charge(bytes) }
    }

    /// All that are alive.
    fn alive(&self) -> Vec<wire::Track> {
        self.living.iter().map(|living| living.track).collect()
    }

    /// What has happened since the frame before, with all that are alive if these are wanted.
    pub fn changes(&self, stream: u32, with_alive: bool) -> wire::Message {
        let alive = with_alive.then(|| self.alive());
        let (from, frame, time) = (self.frame.saturating_sub(1), self.frame, self.time);
        wire::Tracks { stream, from, frame, time, events: self.events.clone(), alive, cycles: Vec::new() }.into()
    }

    /// The message that follows the frame `from` in a recording. The first one, from 0, lists the living tracks in
    /// place of events.
    pub fn message(&self, stream: u32, from: u64, with_alive: bool) -> wire::Message {
        let is_first = from == 0;
        let events = if is_first { Vec::new() } else { self.events.clone() };
        let alive = (is_first || with_alive).then(|| self.alive());
        wire::Tracks { stream, from, frame: self.frame, time: self.time, events, alive, cycles: Vec::new() }.into()
    }

    fn cycle_of(&self, id: u64) -> Option<&Arc<wire::TrackCycle>> {
        let place = self.living.binary_search_by_key(&id, |living| living.track.id).ok()?;
        self.living[place].cycle.as_ref()
    }

    /// Whether their cycles are known.
    pub fn has_cycles(&self) -> bool {
        self.living.iter().all(|living| living.cycle.is_some())
    }
}

/// A consumer's position in the log.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackPosition {
    /// The frame of the last message; 0 for none.
    pub sent: u64,
    /// Nothing has happened after that frame up to this one.
    pub seen: u64,
}

/// What the log has for a consumer.
#[derive(Debug)]
pub enum NextTracks {
    /// The log does not have the consumer's frame.
    Unknown,
    /// Nothing has happened.
    Nothing,
    /// A message.
    Message(wire::Tracks),
}

/// The last frames of a stream's tracks.
#[derive(Debug, Default)]
pub struct TrackLog {
    frames: VecDeque<Arc<TrackFrame>>,
    bytes: usize,
}

impl TrackLog {
    /// Drops the oldest frames while all take more than `limit` bytes.
    pub fn shrink(&mut self, limit: usize) {
        while self.bytes > limit && self.frames.len() > 1 {
            self.bytes -= self.frames.pop_front().map_or(0, |oldest| oldest.bytes);
        }
    }

    /// The newest frame.
    pub fn newest(&self) -> Option<&Arc<TrackFrame>> {
        self.frames.back()
    }

    /// Appends the newest frame, or replaces it if it is there; drops the oldest while all take more than `limit`
    /// bytes.
    pub fn push(&mut self, frame: Arc<TrackFrame>, limit: usize) {
        if self.newest().is_some_and(|newest| newest.frame == frame.frame) {
            self.bytes -= self.frames.pop_back().map_or(0, |newest| newest.bytes);
        }
        self.bytes += frame.bytes;
        self.frames.push_back(frame);
        self.shrink(limit);
    }

    /// What follows a position, up to the frame `at` that the consumer has of its view.
    pub fn next(&self, stream: u32, position: TrackPosition, at: u64, wanted: wire::TracksWanted) -> NextTracks {
        let with_cycles = wanted == wire::TracksWanted::Cycles;
        let place = |frame: u64| self.frames.binary_search_by_key(&frame, |entry| entry.frame).ok();
        let Some(last) = place(at).filter(|&place| !with_cycles || self.frames[place].has_cycles()) else {
            return NextTracks::Unknown;
        };
        let now = &self.frames[last];
        let message = |from, events, alive, cycles| {
            NextTracks::Message(wire::Tracks { stream, from, frame: at, time: now.time, events, alive, cycles })
        };
        let cycles = |is_new: &dyn Fn(u64, &Arc<wire::TrackCycle>) -> bool| {
            let all = now.living.iter().filter(|_| with_cycles).filter_map(|living| living.cycle.as_ref());
            all.filter(|cycle| is_new(cycle.id, cycle)).map(|cycle| wire::TrackCycle::clone(cycle)).collect()
        };
        let Some(first) = place(position.seen).filter(|_| position.sent > 0) else {
            return message(0, Vec::new(), Some(now.alive()), cycles(&|_, _| true));
        };
        if first >= last {
            return NextTracks::Nothing;
        }
        let run = self.frames.range(first + 1..=last);
        let events: Vec<wire::TrackEvent> = run.flat_map(|frame| frame.events.iter().copied()).collect();
        if wanted == wire::TracksWanted::Events {
            return if events.is_empty() {
                NextTracks::Nothing
            } else {
                message(position.sent, events, None, Vec::new())
            };
        }
        let before = &self.frames[first];
        let is_new = |id, cycle: &Arc<_>| !before.cycle_of(id).is_some_and(|known| Arc::ptr_eq(known, cycle));
        message(position.sent, events, Some(now.alive()), cycles(&is_new))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(id: u64) -> wire::Track {
        let place = (0.0, 0.0);
        let (age, birth, death, radius, area) = (1, 0.5, 1.5, 1.5, 3.0);
        wire::Track { id, age, birth, death, center: place, radius, area, velocity: place, selected: true }
    }

    /// A frame in which a track of its number is born, and those of all frames before are alive, some with new cycles.
    fn frame(number: u64, before: Option<&TrackFrame>) -> TrackFrame {
        let event =
            wire::TrackEvent { frame: number, time: None, happening: wire::Happening::Born, track: track(number) };
        let cycle = |id| Some(Arc::new(wire::TrackCycle { id, walks: vec![vec![1, 2, number]] }));
        let mut living = before.map_or(Vec::new(), |before| before.living.clone());
        for living in living.iter_mut().filter(|living| (living.track.id + number).is_multiple_of(3)) {
            living.cycle = cycle(living.track.id);
        }
        living.push(Living { track: track(number), cycle: cycle(number) });
        TrackFrame::new((number, None), vec![event], living, 100, &Arc::default())
    }

    fn ring(numbers: std::ops::RangeInclusive<u64>, limit: usize) -> TrackLog {
        let mut ring = TrackLog::default();
        for number in numbers {
            let next = frame(number, ring.newest().map(|newest| &**newest));
            ring.push(Arc::new(next), limit);
        }
        ring
    }

    fn message_of(next: NextTracks) -> wire::Tracks {
        match next {
            NextTracks::Message(tracks) => tracks,
            other => panic!("{other:?}"),
        }
    }

    fn at(frame: u64) -> TrackPosition {
        TrackPosition { sent: frame, seen: frame }
    }

    #[test]
    fn a_new_consumer_gets_all_tracks_and_then_events() {
        let ring = ring(1..=9, 10_000);
        let all = message_of(ring.next(5, TrackPosition::default(), 9, wire::TracksWanted::Events));
        assert_eq!((all.stream, all.from, all.frame, all.events.len(), all.cycles.len()), (5, 0, 9, 0, 0));
        assert_eq!(all.alive.unwrap().len(), 9);
        let some = message_of(ring.next(5, at(6), 9, wire::TracksWanted::Events));
        assert_eq!((some.from, some.alive), (6, None));
        assert_eq!(some.events.iter().map(|event| event.frame).collect::<Vec<_>>(), [7, 8, 9]);
        let one = message_of(ring.next(5, TrackPosition { sent: 2, seen: 7 }, 8, wire::TracksWanted::Alive));
        assert_eq!((one.from, one.events.len(), one.alive.map(|alive| alive.len())), (2, 1, Some(8)));
        assert!(matches!(ring.next(5, at(9), 9, wire::TracksWanted::Cycles), NextTracks::Nothing));
        assert!(matches!(ring.next(5, at(9), 10, wire::TracksWanted::Cycles), NextTracks::Unknown));
    }

    #[test]
    fn cycles_are_sent_when_they_have_changed() {
        let ring = ring(1..=9, 10_000);
        let ids = |known, at| {
            let tracks = message_of(ring.next(5, known, at, wire::TracksWanted::Cycles));
            tracks.cycles.iter().map(|cycle| cycle.id).collect::<Vec<_>>()
        };
        assert_eq!(ids(TrackPosition::default(), 4), [1, 2, 3, 4]);
        assert_eq!(ids(at(3), 4), [2, 4]);
        assert_eq!(ids(at(7), 9), [1, 3, 4, 6, 7, 8, 9]);
    }

    #[test]
    fn a_consumer_behind_the_log_gets_all_tracks_again() {
        let ring = ring(1..=9, 350);
        assert_eq!((ring.bytes, ring.frames.len()), (300, 3));
        assert_eq!(message_of(ring.next(5, at(6), 9, wire::TracksWanted::Alive)).from, 0);
        assert_eq!(message_of(ring.next(5, at(7), 9, wire::TracksWanted::Alive)).from, 7);
    }
}
