//! What an engine has published, for any number of consumers to take from: of each view the last frames' changes, of the stream the newest dots.
//!
//! In: each frame's [`Entry`], encoded once. Out: entries, shared. Invariants: entries of a view follow upon each other without a gap; older ones go when all of them take more than so
//! many bytes, so that memory does not depend on how slow consumers are or how many; the newest one always stays. Must not know: sockets, who reads.
//!
//! Consumers have no queue of their own: each knows which frame it has and takes what follows. So a slow one costs nobody anything.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hopes::topology::Diff;
use hopes_protocol as wire;

use super::seat::Seat;
use super::tracks::TrackRing;

/// What turned one frame of a view into the next one.
#[derive(Debug)]
pub struct Entry {
    /// The frame that it starts from.
    pub from: u64,
    /// The frame that it leads to, and what is said of it.
    pub info: wire::FrameInfo,
    /// The change itself, to be merged with others.
    pub diff: Diff,
    /// Proves what it leads to.
    pub checksum: u64,
    /// The message.
    pub message: wire::Shared,
}

impl Entry {
    /// An estimate of the memory that it takes.
    fn bytes(&self) -> usize {
        let Diff { vertices_added, vertices_removed, tree_added, tree_removed, .. } = &self.diff;
        let Diff { critical_set, critical_removed, critical_before, .. } = &self.diff;
        self.message.bytes.len()
            + size_of_val(vertices_added.as_slice())
            + size_of_val(vertices_removed.as_slice())
            + size_of_val(tree_added.as_slice())
            + size_of_val(tree_removed.as_slice())
            + size_of_val(critical_set.as_slice())
            + size_of_val(critical_removed.as_slice())
            + size_of_val(critical_before.as_slice())
            + size_of::<Self>()
    }
}

/// What has been published since a frame.
#[derive(Debug)]
pub enum Following {
    /// Nothing: it is the newest.
    Nothing,
    /// The next entry.
    Next(Arc<Entry>),
    /// More than is to be sent singly: all entries since.
    Run(Vec<Arc<Entry>>),
    /// That is not known any more.
    Unknown,
}

/// The last changes of one view.
#[derive(Debug, Default)]
pub struct Ring {
    /// Each with the number of message bytes before it.
    entries: VecDeque<(u64, Arc<Entry>)>,
    /// Message bytes so far.
    published: u64,
    bytes: usize,
    /// The newest frame; 0 before the first.
    newest: u64,
}

impl Ring {
    /// An estimate of the memory that it takes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Adds the newest entry, and forgets the oldest while all take more than so many bytes.
    fn push(&mut self, entry: Arc<Entry>, limit: usize) {
        debug_assert_eq!(entry.from, self.newest, "entries follow upon each other");
        self.newest = entry.info.number;
        self.bytes += entry.bytes();
        let before = self.published;
        self.published += u64::from(entry.message.length);
        self.entries.push_back((before, entry));
        while self.bytes > limit && self.entries.len() > 1 {
            self.bytes -= self.entries.pop_front().map_or(0, |(_, oldest)| oldest.bytes());
        }
    }

    /// Begins at a frame, whose change is not known.
    fn begin(&mut self, newest: u64) {
        *self = Self { newest, ..Self::default() };
    }

    /// What has been published since a frame: one entry, or all of them if they have more than `queue` bytes.
    pub fn following(&self, frame: u64, queue: usize) -> Following {
        if frame == self.newest {
            return Following::Nothing;
        }
        let place = self.entries.partition_point(|(_, entry)| entry.from < frame);
        match self.entries.get(place) {
            Some((before, entry)) if entry.from == frame => {
                if self.published - before <= queue as u64 {
                    Following::Next(Arc::clone(entry))
                } else {
                    Following::Run(self.entries.range(place..).map(|(_, entry)| Arc::clone(entry)).collect())
                }
            }
            _ => Following::Unknown,
        }
    }
}

/// One view of a stream, and who sits before it.
#[derive(Debug)]
pub struct Group {
    /// What is shown.
    pub view: wire::View,
    ring: Mutex<Ring>,
    seats: Mutex<Vec<Arc<Seat>>>,
}

impl Group {
    /// A view that nobody has seen yet, of a stream whose newest frame is this.
    pub fn new(view: wire::View, newest: u64) -> Self {
        let group = Self { view, ring: Mutex::default(), seats: Mutex::default() };
        group.ring().begin(newest);
        group
    }

    /// Its last changes.
    pub fn ring(&self) -> MutexGuard<'_, Ring> {
        self.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether what has changed since a frame is still known.
    pub fn knows(&self, frame: u64) -> bool {
        frame > 0 && !matches!(self.ring().following(frame, 0), Following::Unknown)
    }

    /// Tells of a frame.
    pub fn publish(&self, entry: Entry, limit: usize) {
        self.ring().push(Arc::new(entry), limit);
    }

    /// Who sits here.
    pub fn seats(&self) -> MutexGuard<'_, Vec<Arc<Seat>>> {
        self.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells everybody that something is new.
    pub fn ring_bells(&self) {
        self.seats().iter().for_each(|seat| seat.ring_bell());
    }
}

/// The most persistent dots of a frame.
#[derive(Debug, PartialEq)]
pub struct Ranked {
    /// The frame.
    pub frame: u64,
    /// How many there are in all.
    pub total: u64,
    /// As many as anybody wants.
    pub dots: Vec<wire::Dot>,
}

impl Ranked {
    /// What somebody sees of it who wants so many.
    pub fn shows(&self, most: usize) -> (u64, &[wire::Dot]) {
        (self.total, &self.dots[..most.min(self.dots.len())])
    }
}

/// What a stream shows beside its views.
#[derive(Debug, Default)]
pub struct Board {
    dots: Mutex<Option<Arc<Ranked>>>,
    tracks: Mutex<TrackRing>,
}

impl Board {
    /// The last frames of its tracks, if anybody wants them.
    pub fn tracks(&self) -> MutexGuard<'_, TrackRing> {
        self.tracks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The newest dots, if anybody wants them.
    pub fn dots(&self) -> Option<Arc<Ranked>> {
        self.dots.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Shows others.
    pub fn show_dots(&self, dots: Option<Ranked>) {
        *self.dots.lock().unwrap_or_else(PoisonError::into_inner) = dots.map(Arc::new);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(from: u64, length: u32) -> Arc<Entry> {
        let view = wire::View { cut: wire::Cut::Full, simplify: wire::Simplify::No };
        let info = wire::FrameInfo {
            number: from + 1,
            time: None,
            points: 0,
            vertices: 0,
            rejected: 0,
            view,
            ds: None,
            vs: None,
            components: 0,
            cycles: 0,
        };
        let bytes = vec![0; length as usize].into();
        let message = wire::Shared { kind: 0x0207, length, bytes };
        Arc::new(Entry { from, info, diff: Diff::default(), checksum: 0, message })
    }

    /// The entries since a frame, however many; none if that is not known.
    fn froms(ring: &Ring, frame: u64) -> Option<Vec<u64>> {
        match ring.following(frame, 0) {
            Following::Nothing => Some(Vec::new()),
            Following::Run(run) => Some(run.iter().map(|entry| entry.from).collect()),
            Following::Unknown => None,
            Following::Next(_) => panic!("an entry has more than 0 bytes"),
        }
    }

    #[test]
    fn a_ring_tells_what_follows_a_frame() {
        let mut ring = Ring::default();
        ring.begin(3);
        assert_eq!((froms(&ring, 3), froms(&ring, 2)), (Some(vec![]), None));
        for from in 3..7 {
            ring.push(entry(from, 100), 1 << 20);
        }
        assert_eq!(froms(&ring, 3), Some(vec![3, 4, 5, 6]));
        assert_eq!(froms(&ring, 6), Some(vec![6]));
        assert_eq!(froms(&ring, 7), Some(vec![]));
        assert_eq!((froms(&ring, 2), froms(&ring, 8)), (None, None));
    }

    #[test]
    fn who_is_not_far_behind_gets_one_entry_after_the_other() {
        let mut ring = Ring::default();
        (0..10).for_each(|from| ring.push(entry(from, 100), 1 << 20));
        assert!(matches!(ring.following(7, 300), Following::Next(entry) if entry.from == 7));
        assert!(matches!(ring.following(6, 300), Following::Run(run) if run.len() == 4));
    }

    #[test]
    fn a_ring_forgets_the_oldest_and_keeps_the_newest() {
        let mut ring = Ring::default();
        for from in 0..100 {
            ring.push(entry(from, 4000), 20_000);
            assert!(ring.bytes() <= 20_000);
        }
        assert_eq!(froms(&ring, 95), None);
        assert_eq!(froms(&ring, 96), Some(vec![96, 97, 98, 99]));
        ring.push(entry(100, 1_000_000), 20_000);
        assert_eq!((froms(&ring, 100), froms(&ring, 99)), (Some(vec![100]), None));
    }
}
