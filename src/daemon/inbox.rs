//! What waits for a stream's engine: a bounded queue with a policy for the case that it is full.
//!
//! In: [`Item`]s from stdin and from peers' readers. Out: the same, in order, to the engine. Invariants: at most so many points wait (one item may be larger), and what is no point counts
//! too; commits are never dropped, whoever sends one waits; and the order of what one source sends is kept; whoever sends is told of every item that was dropped; a closed inbox takes
//! nothing more, and what is in it stays to be worked on. Must not know: what the engine does.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use crossbeam_channel::{Receiver, Sender, bounded};
use hopes_protocol::Policy;

use super::peer::{Debt, ProducerChannel};

/// Points on their way in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Where.
    pub positions: Vec<(f64, f64)>,
    /// When: nothing, or one for each point.
    pub times: Vec<f64>,
    /// The producer's own numbers: nothing, or one for each point.
    pub tags: Vec<u64>,
    /// Lines of the input that points stand on: nothing, or one for each point.
    pub lines: Vec<u64>,
}

/// One thing that a source says.
#[derive(Clone, Debug)]
pub enum Input {
    /// Points to insert.
    Points(Batch),
    /// Points to take back.
    Retract(Batch),
    /// The end of a frame, with the time it shall carry.
    Commit(Option<f64>),
    /// The producer has no more to say; with `end`, nobody has.
    Close {
        /// Whether the stream ends.
        end: bool,
    },
    /// Something that could not be read, with where and why.
    Unreadable(String),
    /// The source has failed and says no more.
    Failed(String),
}

/// An item takes the room of so many points besides its own: a queue of commits must not grow for ever.
const ROOM_OF_AN_ITEM: usize = 16;

impl Input {
    fn room(&self) -> usize {
        self.points() + ROOM_OF_AN_ITEM
    }

    fn points(&self) -> usize {
        match self {
            Self::Points(batch) | Self::Retract(batch) => batch.positions.len(),
            _ => 0,
        }
    }

    fn may_be_dropped(&self) -> bool {
        matches!(self, Self::Points(_) | Self::Retract(_))
    }
}

/// Who said it.
#[derive(Debug)]
pub enum Origin {
    /// The process' own input.
    Stdin,
    /// A producer.
    Peer {
        /// Where answers go.
        channel: Arc<ProducerChannel>,
        /// The producer's number for the message.
        sequence: u64,
        /// The answer is owed, if there is one, as long as this item lives.
        #[expect(dead_code, reason = "what counts is when it goes")]
        debt: Option<Debt>,
    },
}

/// Something said, and by whom.
#[derive(Debug)]
pub struct Item {
    /// What.
    pub input: Input,
    /// By whom.
    pub origin: Origin,
}

/// What happens to a producer that is faster than the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overload {
    /// It waits.
    #[default]
    Block,
    /// Something of what was sent is dropped.
    Drop(Policy),
}

/// The stream takes nothing more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended;

#[derive(Debug, Default)]
struct State {
    items: VecDeque<Item>,
    points: usize,
    /// Room that is taken, in points.
    taken: usize,
    is_closed: bool,
}

/// The queue.
#[derive(Debug)]
pub struct Inbox {
    state: Mutex<State>,
    room: Condvar,
    /// Holds one ring at the most: the engine looks for itself how much there is.
    bell: Sender<()>,
    capacity: usize,
    overload: Overload,
    dropped: AtomicU64,
}

impl Inbox {
    /// An empty queue for so many points, and the bell that tells of new items.
    pub fn new(capacity: usize, overload: Overload) -> (Self, Receiver<()>) {
        let (bell, rings) = bounded(1);
        let (state, room) = (Mutex::default(), Condvar::new());
        (Self { state, room, bell, capacity, overload, dropped: AtomicU64::new(0) }, rings)
    }

    /// Puts an item at the end. When the queue is full this waits, or drops something and tells whose it was.
    ///
    /// # Errors
    /// [`Ended`]: the item was not taken.
    pub fn push(&self, item: Item) -> Result<(), Ended> {
        let mut state = self.lock();
        while !state.is_closed && !state.items.is_empty() && state.taken + item.input.room() > self.capacity {
            let oldest = match self.overload {
                Overload::Drop(Policy::DropNewest) if item.input.may_be_dropped() => {
                    drop(state);
                    self.tell_dropped(&item, Policy::DropNewest);
                    return Ok(());
                }
                Overload::Drop(Policy::DropOldest) => state.take_oldest(),
                _ => None,
            };
            match oldest {
                Some(oldest) => self.tell_dropped(&oldest, Policy::DropOldest),
                None => state = self.room.wait(state).unwrap_or_else(PoisonError::into_inner),
            }
        }
        if state.is_closed {
            return Err(Ended);
        }
        state.put(item);
        drop(state);
        // A bell that is full rings already.
        let _ = self.bell.try_send(());
        Ok(())
    }

    /// The next item, if there is one.
    pub fn pop(&self) -> Option<Item> {
        let item = self.lock().take(0)?;
        self.room.notify_all();
        Some(item)
    }

    /// Takes nothing more.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.room.notify_all();
        let _ = self.bell.try_send(());
    }

    /// Whether nothing more is taken.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    /// Whether nothing is left and nothing will come.
    pub fn is_finished(&self) -> bool {
        let state = self.lock();
        state.is_closed && state.items.is_empty()
    }

    /// Points that wait.
    pub fn waiting(&self) -> usize {
        self.lock().points
    }

    /// Points dropped so far.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    fn tell_dropped(&self, item: &Item, policy: Policy) {
        let points = item.input.points();
        let before = self.dropped.fetch_add(points as u64, Ordering::Relaxed);
        match &item.origin {
            Origin::Peer { channel, sequence, .. } => channel.answer_dropped(*sequence, points as u32, policy),
            Origin::Stdin if before == 0 => {
                tracing::warn!(
                    "the input is faster than the engine: points are dropped, as --overload asks; status counts them"
                );
            }
            Origin::Stdin => {}
        }
    }

    /// Nothing that holds this lock can panic half way: what it guards is always whole.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn put(&mut self, item: Item) {
        self.points += item.input.points();
        self.taken += item.input.room();
        self.items.push_back(item);
    }

    fn take(&mut self, place: usize) -> Option<Item> {
        let item = self.items.remove(place)?;
        self.points -= item.input.points();
        self.taken -= item.input.room();
        Some(item)
    }

    fn take_oldest(&mut self) -> Option<Item> {
        let place = self.items.iter().position(|item| item.input.may_be_dropped())?;
        self.take(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Item {
        let batch = Batch { positions: vec![(0.0, 0.0); count], ..Batch::default() };
        Item { input: Input::Points(batch), origin: Origin::Stdin }
    }

    fn commit() -> Item {
        Item { input: Input::Commit(None), origin: Origin::Stdin }
    }

    fn sizes(inbox: &Inbox) -> Vec<usize> {
        std::iter::from_fn(|| inbox.pop()).map(|item| item.input.points()).collect()
    }

    #[test]
    fn the_oldest_points_are_dropped_and_no_commit() {
        let (inbox, _rings) = Inbox::new(10 + 3 * ROOM_OF_AN_ITEM, Overload::Drop(Policy::DropOldest));
        for item in [points(4), commit(), points(5), points(6)] {
            inbox.push(item).unwrap();
        }
        assert_eq!((inbox.dropped(), inbox.waiting()), (9, 6));
        assert_eq!(sizes(&inbox), [0, 6]);
    }

    #[test]
    fn the_newest_points_are_dropped_and_no_commit() {
        let (inbox, _rings) = Inbox::new(25 + 3 * ROOM_OF_AN_ITEM, Overload::Drop(Policy::DropNewest));
        for item in [points(20), points(30), commit(), points(5)] {
            inbox.push(item).unwrap();
        }
        assert_eq!((inbox.dropped(), inbox.waiting()), (30, 25));
        assert_eq!(sizes(&inbox), [20, 0, 5]);
    }

    #[test]
    fn commits_wait_for_room_whatever_the_policy() {
        for overload in [Overload::Block, Overload::Drop(Policy::DropOldest), Overload::Drop(Policy::DropNewest)] {
            let (inbox, rings) = Inbox::new(10, overload);
            std::thread::scope(|scope| {
                scope.spawn(|| (0..100).for_each(|_| inbox.push(commit()).unwrap()));
                let mut taken = 0;
                while taken < 100 {
                    rings.recv().unwrap();
                    while inbox.pop().is_some() {
                        taken += 1;
                    }
                }
            });
            assert_eq!(inbox.dropped(), 0);
        }
    }

    #[test]
    fn a_full_inbox_makes_its_source_wait() {
        let (inbox, rings) = Inbox::new(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        std::thread::scope(|scope| {
            scope.spawn(|| (0..100).for_each(|_| inbox.push(points(3)).unwrap()));
            let mut taken = 0;
            while taken < 100 {
                rings.recv().unwrap();
                while let Some(item) = inbox.pop() {
                    assert!(inbox.waiting() + item.input.points() <= 13 + 3 * ROOM_OF_AN_ITEM);
                    taken += 1;
                }
            }
        });
        assert_eq!(inbox.dropped(), 0);
    }

    #[test]
    fn one_item_may_be_larger_than_the_inbox() {
        let (inbox, _rings) = Inbox::new(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        inbox.push(points(1000)).unwrap();
        assert_eq!(sizes(&inbox), [1000]);
    }

    #[test]
    fn a_closed_inbox_takes_nothing_and_keeps_what_it_has() {
        let (inbox, _rings) = Inbox::new(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        inbox.push(points(3)).unwrap();
        inbox.close();
        assert_eq!(inbox.push(points(1)), Err(Ended));
        assert!(!inbox.is_finished());
        assert_eq!(sizes(&inbox), [3]);
        assert!(inbox.is_finished());
    }

    #[test]
    fn closing_wakes_whoever_waits() {
        let (inbox, _rings) = Inbox::new(1, Overload::Block);
        inbox.push(points(1)).unwrap();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| inbox.push(points(1)));
            inbox.close();
            assert_eq!(waiting.join().unwrap(), Err(Ended));
        });
    }
}
