//! The log of a stream's tracks: its last frames, for any number of consumers to read.
//!
//! In: [`TrackFrame`]s, one per frame. Out: a message for a consumer, from its position.
//! Invariants: frames
//! follow upon each other without a gap. The oldest go when all of them take more than so many bytes; the newest always
//! stays. Cycles that have not changed are shared between frames.
//! Must not know: who reads it, how tracks are found.

use std::collections::VecDeque;
use std::sync::Arc;

use hopes_protocol::{self as wire, TrackState};

use crate::daemon::memory::{Account, Charge};
use crate::daemon::streams::convert::{TrackKind, TrackSpan};

/// What has happened to tracks up to a frame.
#[derive(Debug)]
pub struct TrackFrame<K: TrackKind> {
    /// The frame.
    pub frame: u64,
    /// Its time.
    pub time: Option<f64>,
    /// Since the frame before.
    pub events: Vec<K::Event>,
    /// All that are alive, by id, and their cycles, if a consumer wants them.
    pub living: Vec<Living<K>>,
    /// An estimate of the memory that it takes.
    pub bytes: usize,
    /// Held for its drop.
    _charge: Charge,
}

/// A track that is alive.
#[derive(Debug)]
pub struct Living<K: TrackKind> {
    /// The track.
    pub track: K::Track,
    /// Its cycle, if a consumer wants it.
    pub cycle: Option<Arc<wire::TrackCycle>>,
}

impl<K: TrackKind> TrackFrame<K> {
    /// A frame that takes about so many bytes, which are charged to an account.
    pub fn new(
        (frame, time): (u64, Option<f64>),
        events: Vec<K::Event>,
        living: Vec<Living<K>>,
        bytes: usize,
        account: &Arc<Account>,
    ) -> Self {
        let time = time.filter(|time| time.is_finite());
        Self { frame, time, events, living, bytes, _charge: account.charge(bytes) }
    }

    /// All that are alive.
    fn alive(&self) -> Vec<K::Track> {
        self.living.iter().map(|living| living.track.clone()).collect()
    }

    /// What has happened since the frame before, with all that are alive if these are wanted.
    pub fn changes(&self, stream: u32, with_alive: bool) -> wire::Message {
        let alive = with_alive.then(|| self.alive());
        let span = self.span(stream, self.frame.saturating_sub(1));
        K::message(span, self.events.clone(), alive, Vec::new())
    }

    /// The message that follows the frame `from` in a recording. The first one, from 0, lists the living tracks in
    /// place of events.
    pub fn message(&self, stream: u32, from: u64, with_alive: bool) -> wire::Message {
        let is_first = from == 0;
        let events = if is_first { Vec::new() } else { self.events.clone() };
        let alive = (is_first || with_alive).then(|| self.alive());
        K::message(self.span(stream, from), events, alive, Vec::new())
    }

    fn span(&self, stream: u32, from: u64) -> TrackSpan {
        TrackSpan { stream, from, frame: self.frame, time: self.time }
    }

    fn cycle_of(&self, id: u64) -> Option<&Arc<wire::TrackCycle>> {
        let place = self.living.binary_search_by_key(&id, |living| living.track.id()).ok()?;
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
    Message(Box<wire::Message>),
}

/// The last frames of a stream's tracks.
#[derive(Debug)]
pub struct TrackLog<K: TrackKind> {
    frames: VecDeque<Arc<TrackFrame<K>>>,
    bytes: usize,
}

impl<K: TrackKind> Default for TrackLog<K> {
    fn default() -> Self {
        Self { frames: VecDeque::new(), bytes: 0 }
    }
}

impl<K: TrackKind> TrackLog<K> {
    /// Drops the oldest frames while all take more than `limit` bytes.
    pub fn shrink(&mut self, limit: usize) {
        while self.bytes > limit && self.frames.len() > 1 {
            self.bytes -= self.frames.pop_front().map_or(0, |oldest| oldest.bytes);
        }
    }

    /// The newest frame.
    pub fn newest(&self) -> Option<&Arc<TrackFrame<K>>> {
        self.frames.back()
    }

    /// Appends the newest frame, or replaces it if it is there; drops the oldest while all take more than `limit`
    /// bytes.
    pub fn push(&mut self, frame: Arc<TrackFrame<K>>, limit: usize) {
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
            let span = TrackSpan { frame: at, ..now.span(stream, from) };
            NextTracks::Message(Box::new(K::message(span, events, alive, cycles)))
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
        let events: Vec<K::Event> = run.flat_map(|frame| frame.events.iter().cloned()).collect();
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

    type Frame = TrackFrame<wire::Tracks>;
    type Log = TrackLog<wire::Tracks>;

    fn track(id: u64) -> wire::Track {
        let place = (0.0, 0.0);
        let (age, birth, death, radius, area) = (1, 0.5, 1.5, 1.5, 3.0);
        wire::Track { id, age, birth, death, center: place, radius, area, velocity: place, selected: true }
    }

    /// A frame in which a track of its number is born, and those of all frames before are alive, some with new cycles.
    fn frame(number: u64, before: Option<&Frame>) -> Frame {
        let event =
            wire::TrackEvent { frame: number, time: None, happening: wire::Happening::Born, track: track(number) };
        let cycle = |id| Some(Arc::new(wire::TrackCycle { id, walks: vec![vec![1, 2, number]] }));
        let again = |living: &Living<wire::Tracks>| Living { track: living.track, cycle: living.cycle.clone() };
        let mut living: Vec<Living<wire::Tracks>> =
            before.map_or(Vec::new(), |before| before.living.iter().map(again).collect());
        for living in living.iter_mut().filter(|living| (living.track.id + number).is_multiple_of(3)) {
            living.cycle = cycle(living.track.id);
        }
        living.push(Living { track: track(number), cycle: cycle(number) });
        TrackFrame::new((number, None), vec![event], living, 100, &Arc::default())
    }

    fn ring(numbers: std::ops::RangeInclusive<u64>, limit: usize) -> Log {
        let mut ring = Log::default();
        for number in numbers {
            let next = frame(number, ring.newest().map(|newest| &**newest));
            ring.push(Arc::new(next), limit);
        }
        ring
    }

    fn message_of(next: NextTracks) -> wire::Tracks {
        let NextTracks::Message(message) = next else { panic!("{next:?}") };
        let wire::Message::Tracks(tracks) = *message else { panic!("{message:?}") };
        tracks
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
