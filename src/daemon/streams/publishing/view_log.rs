//! The log of a view: its last frames' changes, for any number of consumers to read.
//!
//! In: each frame's [`LogEntry`], encoded once. Out: entries, shared.
//!
//! Invariants: entries follow upon each other without a gap. The oldest go when all of them take more than so many
//! bytes, so memory depends neither on the number of consumers nor on how slow they are; the newest always stays.
//!
//! Must not know: who reads it.
//!
//! Consumers have no queue of their own. Each has a cursor, the number of its frame, and reads what follows.

use std::collections::VecDeque;
use std::sync::Arc;

use hopes::topology::Diff;
use hopes_protocol as wire;

use crate::daemon::encoding::Encoded;
use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::memory::{Account, Charge};
use crate::daemon::streams::convert::{self, Shape};

/// What turned one frame of a view into the next one.
#[derive(Debug)]
pub struct LogEntry {
    /// The frame before.
    pub from: u64,
    /// The frame after, and its numbers.
    pub info: wire::FrameInfo,
    /// The change itself, to be merged with others.
    pub diff: Diff,
    /// Proves the frame after.
    pub checksum: u64,
    /// The encoded message, which is charged by itself.
    pub message: Encoded,
    bytes: usize,
    /// Held for its drop.
    _charge: Charge,
}

impl LogEntry {
    /// An entry that holds the encoding of its change; both are charged to an account.
    pub fn new(
        from: u64,
        info: wire::FrameInfo,
        diff: Diff,
        checksum: u64,
        message: Encoded,
        account: &Arc<Account>,
    ) -> Self {
        let of_diff = size_of::<Self>() + size_of_diff(&diff);
        let bytes = of_diff + message.bytes();
        Self { from, info, diff, checksum, message, bytes, _charge: account.charge(of_diff) }
    }

    /// One diff for a run of entries; none for no entries.
    pub fn merged(stream: (u32, Shape), run: &[Arc<Self>]) -> Option<wire::Message> {
        let (first, last) = (run.first()?, run.last()?);
        let merged = Diff::merged(run.iter().map(|entry| &entry.diff));
        let rejected = run.iter().map(|entry| entry.info.rejected).sum();
        let frame = wire::FrameInfo { rejected, ..last.info.clone() };
        Some(convert::diff(stream, first.from, frame, &merged, last.checksum))
    }
}

/// The memory that a change takes outside of itself.
fn size_of_diff(diff: &Diff) -> usize {
    let Diff { vertices_added, vertices_removed, tree_added, tree_removed, .. } = diff;
    let Diff { critical_set, critical_removed, critical_before, .. } = diff;
    vertices_added.heap_size()
        + size_of_val(vertices_removed.as_slice())
        + size_of_val(tree_added.as_slice())
        + size_of_val(tree_removed.as_slice())
        + size_of_val(critical_set.as_slice())
        + size_of_val(critical_removed.as_slice())
        + size_of_val(critical_before.as_slice())
}

/// What a log has after a frame.
#[derive(Debug)]
pub enum Since {
    /// Nothing: the frame is the newest.
    Nothing,
    /// The next entry.
    Next(Arc<LogEntry>),
    /// All entries, which are too many to be sent one by one.
    Run(Vec<Arc<LogEntry>>),
    /// The log does not reach back so far.
    Unknown,
}

#[derive(Debug, Default)]
struct State {
    /// Each with the number of message bytes before it.
    entries: VecDeque<(u64, Arc<LogEntry>)>,
    /// Message bytes so far.
    published: u64,
    bytes: usize,
    /// The newest frame; 0 before the first.
    newest: u64,
}

impl State {
    fn push(&mut self, entry: Arc<LogEntry>, limit: usize) {
        debug_assert_eq!(entry.from, self.newest, "entries follow upon each other");
        self.newest = entry.info.number;
        self.bytes += entry.bytes;
        let before = self.published;
        self.published += u64::from(entry.message.length);
        self.entries.push_back((before, entry));
        self.shrink(limit);
    }

    /// Drops the oldest entries while all take more than `limit` bytes.
    fn shrink(&mut self, limit: usize) {
        while self.bytes > limit && self.entries.len() > 1 {
            self.bytes -= self.entries.pop_front().map_or(0, |(_, oldest)| oldest.bytes);
        }
    }

    fn since(&self, frame: u64, queue: usize) -> Since {
        if frame == self.newest {
            return Since::Nothing;
        }
        let place = self.entries.partition_point(|(_, entry)| entry.from < frame);
        match self.entries.get(place) {
            Some((before, entry)) if entry.from == frame => {
                if self.published - before <= queue as u64 {
                    Since::Next(Arc::clone(entry))
                } else {
                    Since::Run(self.entries.range(place..).map(|(_, entry)| Arc::clone(entry)).collect())
                }
            }
            _ => Since::Unknown,
        }
    }
}

/// The log of one view of a stream.
#[derive(Debug)]
pub struct ViewLog {
    /// The view.
    pub view: wire::View,
    state: Lock<State>,
}

impl ViewLog {
    /// The empty log of a view whose newest frame is this, which the log does not describe.
    pub fn new(view: wire::View, newest: u64) -> Self {
        Self { view, state: Lock::new(Level::Published, State { newest, ..State::default() }) }
    }

    /// Drops the oldest entries while all take more than `limit` bytes.
    pub fn shrink(&self, limit: usize) {
        self.lock().shrink(limit);
    }

    /// What follows a frame: one entry, or all of them if they have more than `queue` bytes.
    pub fn since(&self, frame: u64, queue: usize) -> Since {
        self.lock().since(frame, queue)
    }

    /// Whether it reaches back to a frame.
    pub fn reaches(&self, frame: u64) -> bool {
        frame > 0 && !matches!(self.since(frame, 0), Since::Unknown)
    }

    /// Appends the newest entry, and drops the oldest while all take more than `limit` bytes.
    pub fn publish(&self, entry: LogEntry, limit: usize) {
        self.lock().push(Arc::new(entry), limit);
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(newest: u64) -> ViewLog {
        ViewLog::new(wire::View { cut: wire::Cut::Full, simplify: wire::Simplify::No }, newest)
    }

    fn entry(from: u64, length: u32) -> LogEntry {
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
        let account = Arc::default();
        let message = Encoded::new(wire::Shared { kind: 0x0207, length, bytes }, &account);
        LogEntry::new(from, info, Diff::default(), 0, message, &account)
    }

    /// Where the entries after a frame start; none if the log does not reach back so far.
    fn froms(log: &ViewLog, frame: u64) -> Option<Vec<u64>> {
        match log.since(frame, 0) {
            Since::Nothing => Some(Vec::new()),
            Since::Run(run) => Some(run.iter().map(|entry| entry.from).collect()),
            Since::Unknown => None,
            Since::Next(_) => panic!("an entry has more than 0 bytes"),
        }
    }

    #[test]
    fn a_log_gives_what_follows_a_frame() {
        let log = log(3);
        assert_eq!((froms(&log, 3), froms(&log, 2)), (Some(vec![]), None));
        for from in 3..7 {
            log.publish(entry(from, 100), 1 << 20);
        }
        assert_eq!(froms(&log, 3), Some(vec![3, 4, 5, 6]));
        assert_eq!(froms(&log, 6), Some(vec![6]));
        assert_eq!(froms(&log, 7), Some(vec![]));
        assert_eq!((froms(&log, 2), froms(&log, 8)), (None, None));
    }

    #[test]
    fn a_consumer_that_is_not_far_behind_gets_one_entry_after_the_other() {
        let log = log(0);
        (0..10).for_each(|from| log.publish(entry(from, 100), 1 << 20));
        assert!(matches!(log.since(7, 300), Since::Next(entry) if entry.from == 7));
        assert!(matches!(log.since(6, 300), Since::Run(run) if run.len() == 4));
    }

    #[test]
    fn a_log_drops_the_oldest_and_keeps_the_newest() {
        let log = log(0);
        for from in 0..100 {
            log.publish(entry(from, 4000), 20_000);
            assert!(log.lock().bytes <= 20_000);
        }
        assert_eq!(froms(&log, 95), None);
        assert_eq!(froms(&log, 96), Some(vec![96, 97, 98, 99]));
        log.publish(entry(100, 1_000_000), 20_000);
        assert_eq!((froms(&log, 100), froms(&log, 99)), (Some(vec![100]), None));
    }
}
