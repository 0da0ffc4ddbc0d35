//! The tracks of one stream: what has happened to them, frame by frame, for any number of consumers to take from.
//!
//! In: the stream's pipeline, when somebody wants to know; each consumer's last frame. Out: [`TrackFrame`]s, and [`wire::Tracks`] made of them. Invariants: frames follow upon each
//! other without a gap; older ones go when all of them take more than so many bytes, and the newest one always stays; cycles that have not changed are
//! shared between frames. Must not know: sockets, seats, how tracks are found.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use hopes::topology::{Pipeline, Region, TrackOptions, Tracker};
use hopes_protocol as wire;

use super::convert;

/// What has happened to tracks up to a frame.
#[derive(Debug)]
pub struct TrackFrame {
    /// The frame.
    pub frame: u64,
    /// Its time.
    pub time: Option<f64>,
    /// Since the frame before.
    pub events: Vec<wire::TrackEvent>,
    /// All that are alive, by id, and their cycles, if anybody wants them.
    pub living: Vec<Living>,
    /// An estimate of the memory that it takes.
    bytes: usize,
}

/// A track that is alive.
#[derive(Clone, Debug)]
pub struct Living {
    /// The track.
    pub track: wire::Track,
    /// Its cycle, if anybody wants it.
    pub cycle: Option<Arc<wire::TrackCycle>>,
}

impl TrackFrame {
    /// All that are alive.
    pub fn alive(&self) -> Vec<wire::Track> {
        self.living.iter().map(|living| living.track).collect()
    }

    /// For a recording in which a frame was told before; none of the events of the first is missed, as all that are alive stand there.
    pub fn message(&self, stream: u32, told: u64, with_alive: bool) -> wire::Tracks {
        let is_first = told == 0;
        let events = if is_first { Vec::new() } else { self.events.clone() };
        let alive = (is_first || with_alive).then(|| self.alive());
        wire::Tracks { stream, from: told, frame: self.frame, time: self.time, events, alive, cycles: Vec::new() }
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

/// Follows the tracks of a stream.
#[derive(Debug)]
pub struct Tracking {
    tracker: Tracker,
    cycles: HashMap<u64, Arc<wire::TrackCycle>>,
    /// Whether it was said that there are too many.
    has_warned: bool,
}

impl Tracking {
    /// Has seen nothing yet.
    pub fn new(options: TrackOptions) -> Self {
        Self { tracker: Tracker::new(options), cycles: HashMap::new(), has_warned: false }
    }

    /// What has happened up to the newest frame, if that was not asked before.
    pub fn look(&mut self, pipeline: &mut Pipeline, with_cycles: bool) -> Option<TrackFrame> {
        let step = pipeline.poll_tracks(&mut self.tracker)?;
        if step.left_out > 0 && !self.has_warned {
            tracing::warn!(
                "frame {}: the {} least persistent of the cycles to be tracked are left out: choose fewer with --track",
                step.number,
                step.left_out
            );
        }
        self.has_warned = step.left_out > 0;
        let events: Vec<wire::TrackEvent> = step.events.iter().map(convert::track_event).collect();
        Some(self.frame(pipeline, step.number, step.time, events, with_cycles))
    }

    /// The frame that was looked at last, with cycles.
    pub fn again(&mut self, pipeline: &mut Pipeline, before: &TrackFrame) -> TrackFrame {
        self.frame(pipeline, before.frame, before.time, before.events.clone(), true)
    }

    fn frame(
        &mut self,
        pipeline: &mut Pipeline,
        frame: u64,
        time: Option<f64>,
        events: Vec<wire::TrackEvent>,
        with_cycles: bool,
    ) -> TrackFrame {
        let mut bytes = size_of::<TrackFrame>() + size_of_val(events.as_slice());
        if with_cycles {
            bytes += self.look_at_cycles(pipeline);
        } else {
            self.cycles.clear();
        }
        let living = |track| {
            let track = convert::track(track);
            Living { track, cycle: self.cycles.get(&track.id).cloned() }
        };
        let living: Vec<Living> = self.tracker.alive().map(living).collect();
        bytes += size_of_val(living.as_slice());
        TrackFrame { frame, time: time.filter(|time| time.is_finite()), events, living, bytes }
    }

    /// Finds the cycles of all that are alive; those that are not there in the frame have none. Gives the memory that new ones take.
    fn look_at_cycles(&mut self, pipeline: &mut Pipeline) -> usize {
        let mut bytes = 0;
        let regions: HashMap<u64, Region> =
            pipeline.track_regions(&self.tracker).into_iter().map(|(id, region)| (id.0, region)).collect();
        let cycles = self.tracker.alive().map(|track| {
            let id = track.id.0;
            let now = wire::TrackCycle { id, walks: regions.get(&id).map_or(Vec::new(), walks) };
            let known = self.cycles.get(&id).filter(|known| ***known == now).cloned();
            let cycle = known.unwrap_or_else(|| {
                bytes += 8 * now.walks.iter().map(Vec::len).sum::<usize>();
                Arc::new(now)
            });
            (id, cycle)
        });
        self.cycles = cycles.collect();
        bytes
    }
}

fn walks(region: &Region) -> Vec<Vec<u64>> {
    region.boundary().iter().map(|walk| walk.iter().map(|(vertex, _)| vertex.0).collect()).collect()
}

/// What somebody knows of a stream's tracks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// The frame that he was told of last; 0 for none.
    pub told: u64,
    /// Nothing has happened from there up to this frame.
    pub known: u64,
}

/// What is next for somebody.
#[derive(Debug)]
pub enum Next {
    /// It is not known what was at his frame.
    Unknown,
    /// Nothing is to be said.
    Nothing,
    /// This.
    Tell(wire::Tracks),
}

/// The last frames of a stream's tracks.
#[derive(Debug, Default)]
pub struct TrackRing {
    frames: VecDeque<Arc<TrackFrame>>,
    bytes: usize,
}

impl TrackRing {
    /// An estimate of the memory that it takes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The newest frame.
    pub fn newest(&self) -> Option<&Arc<TrackFrame>> {
        self.frames.back()
    }

    /// Adds the newest frame, in place of itself if it is there; forgets the oldest while all take more than so many bytes.
    pub fn push(&mut self, frame: Arc<TrackFrame>, limit: usize) {
        if self.newest().is_some_and(|newest| newest.frame == frame.frame) {
            self.bytes -= self.frames.pop_back().map_or(0, |newest| newest.bytes);
        }
        self.bytes += frame.bytes;
        self.frames.push_back(frame);
        while self.bytes > limit && self.frames.len() > 1 {
            self.bytes -= self.frames.pop_front().map_or(0, |oldest| oldest.bytes);
        }
    }

    /// What somebody is to be told who has a frame of the view.
    pub fn next(&self, stream: u32, known: Known, at: u64, wanted: wire::TracksWanted) -> Next {
        let with_cycles = wanted == wire::TracksWanted::Cycles;
        let place = |frame: u64| self.frames.binary_search_by_key(&frame, |entry| entry.frame).ok();
        let Some(last) = place(at).filter(|&place| !with_cycles || self.frames[place].has_cycles()) else {
            return Next::Unknown;
        };
        let now = &self.frames[last];
        let tell = |from, events, alive, cycles| {
            Next::Tell(wire::Tracks { stream, from, frame: at, time: now.time, events, alive, cycles })
        };
        let cycles = |is_new: &dyn Fn(u64, &Arc<wire::TrackCycle>) -> bool| {
            let all = now.living.iter().filter(|_| with_cycles).filter_map(|living| living.cycle.as_ref());
            all.filter(|cycle| is_new(cycle.id, cycle)).map(|cycle| wire::TrackCycle::clone(cycle)).collect()
        };
        let Some(first) = place(known.known).filter(|_| known.told > 0) else {
            return tell(0, Vec::new(), Some(now.alive()), cycles(&|_, _| true));
        };
        if first >= last {
            return Next::Nothing;
        }
        let run = self.frames.range(first + 1..=last);
        let events: Vec<wire::TrackEvent> = run.flat_map(|frame| frame.events.iter().copied()).collect();
        if wanted == wire::TracksWanted::Events {
            return if events.is_empty() { Next::Nothing } else { tell(known.told, events, None, Vec::new()) };
        }
        let before = &self.frames[first];
        let is_new = |id, cycle: &Arc<_>| !before.cycle_of(id).is_some_and(|known| Arc::ptr_eq(known, cycle));
        tell(known.told, events, Some(now.alive()), cycles(&is_new))
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
        TrackFrame { frame: number, time: None, events: vec![event], living, bytes: 100 }
    }

    fn ring(numbers: std::ops::RangeInclusive<u64>, limit: usize) -> TrackRing {
        let mut ring = TrackRing::default();
        for number in numbers {
            let next = frame(number, ring.newest().map(|newest| &**newest));
            ring.push(Arc::new(next), limit);
        }
        ring
    }

    fn told(next: Next) -> wire::Tracks {
        match next {
            Next::Tell(tracks) => tracks,
            other => panic!("{other:?}"),
        }
    }

    fn knows(frame: u64) -> Known {
        Known { told: frame, known: frame }
    }

    #[test]
    fn who_comes_is_told_all_and_then_what_happens() {
        let ring = ring(1..=9, 10_000);
        let all = told(ring.next(5, Known::default(), 9, wire::TracksWanted::Events));
        assert_eq!((all.stream, all.from, all.frame, all.events.len(), all.cycles.len()), (5, 0, 9, 0, 0));
        assert_eq!(all.alive.unwrap().len(), 9);
        let some = told(ring.next(5, knows(6), 9, wire::TracksWanted::Events));
        assert_eq!((some.from, some.alive), (6, None));
        assert_eq!(some.events.iter().map(|event| event.frame).collect::<Vec<_>>(), [7, 8, 9]);
        let one = told(ring.next(5, Known { told: 2, known: 7 }, 8, wire::TracksWanted::Alive));
        assert_eq!((one.from, one.events.len(), one.alive.map(|alive| alive.len())), (2, 1, Some(8)));
        assert!(matches!(ring.next(5, knows(9), 9, wire::TracksWanted::Cycles), Next::Nothing));
        assert!(matches!(ring.next(5, knows(9), 10, wire::TracksWanted::Cycles), Next::Unknown));
    }

    #[test]
    fn cycles_are_told_when_they_have_changed() {
        let ring = ring(1..=9, 10_000);
        let ids = |known, at| {
            let tracks = told(ring.next(5, known, at, wire::TracksWanted::Cycles));
            tracks.cycles.iter().map(|cycle| cycle.id).collect::<Vec<_>>()
        };
        assert_eq!(ids(Known::default(), 4), [1, 2, 3, 4]);
        assert_eq!(ids(knows(3), 4), [2, 4]);
        assert_eq!(ids(knows(7), 9), [1, 3, 4, 6, 7, 8, 9]);
    }

    #[test]
    fn what_is_forgotten_is_told_anew() {
        let ring = ring(1..=9, 350);
        assert_eq!((ring.bytes(), ring.frames.len()), (300, 3));
        assert_eq!(told(ring.next(5, knows(6), 9, wire::TracksWanted::Alive)).from, 0);
        assert_eq!(told(ring.next(5, knows(7), 9, wire::TracksWanted::Alive)).from, 7);
    }
}
