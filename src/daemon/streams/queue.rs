//! The queue of a stream: what waits for its engine, with a policy for the case that it is full.
//!
//! In: [`Item`]s from stdin and from producers. Out: the same, in order, to the engine.
//!
//! Invariants:
//! * At most so many points wait; one item may be larger. Commits take room too, so a flood of them is bounded.
//! * Commits are never dropped: their sender waits. The items of one sender keep their order.
//! * The sender of an item that is dropped gets a reply. A closed queue takes nothing more and keeps what it has.
//!
//! Must not know: what the engine does, what a connection is.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar};

use crossbeam_channel::Sender;
use hopes_protocol::Policy;

use super::input::Input;
use super::reply::{ReplySink, ReplyTo};
use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::memory::{Account, Charge};

/// Where an item comes from, which is where its reply goes.
#[derive(Debug)]
pub enum Origin {
    /// The process' own input, which gets no reply.
    Stdin,
    /// A producer.
    Producer(ReplyTo),
}

impl Origin {
    /// The producer; none is stdin.
    pub fn producer(&self) -> Option<&Arc<dyn ReplySink>> {
        match self {
            Self::Stdin => None,
            Self::Producer(reply_to) => Some(reply_to.sink()),
        }
    }
}

/// An input and its origin.
#[derive(Debug)]
pub struct Item {
    /// The input.
    pub input: Input,
    /// Its origin.
    pub origin: Origin,
}

/// What happens to a producer that is faster than the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overload {
    /// It waits.
    #[default]
    Block,
    /// Points are dropped.
    Drop(Policy),
}

/// The queue is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Closed;

#[derive(Debug)]
struct State {
    items: VecDeque<Item>,
    points: usize,
    /// Room that is taken, in points.
    taken: usize,
    /// Bytes that items take.
    bytes: u64,
    charge: Charge,
    is_closed: bool,
}

/// The queue.
#[derive(Debug)]
pub struct Queue {
    state: Lock<State>,
    has_room: Condvar,
    /// Wakes the engine. One wake-up is enough: the engine then takes all there is.
    wake: Sender<()>,
    capacity: usize,
    overload: Overload,
    dropped: AtomicU64,
}

impl Queue {
    /// An empty queue for so many points, which wakes its engine. What waits is charged to an account.
    pub fn new(capacity: usize, overload: Overload, wake: Sender<()>, account: &Arc<Account>) -> Self {
        let (items, charge) = (VecDeque::new(), account.charge(0));
        let state = State { items, points: 0, taken: 0, bytes: 0, charge, is_closed: false };
        let (state, has_room) = (Lock::new(Level::Queue, state), Condvar::new());
        Self { state, has_room, wake, capacity, overload, dropped: AtomicU64::new(0) }
    }

    /// Appends an item. When the queue is full this waits, or drops points, with a reply to their sender.
    ///
    /// # Errors
    /// [`Closed`]: the item was not taken.
    pub fn push(&self, item: Item) -> Result<(), Closed> {
        // Replies are sent when the lock is given back: they go to other locks and other threads.
        let (taken, dropped, policy) = self.put_or_drop(item);
        dropped.iter().for_each(|item| self.note_dropped(item, policy));
        taken
    }

    /// Whether the item was taken; what was dropped, and which was to be.
    fn put_or_drop(&self, item: Item) -> (Result<(), Closed>, Vec<Item>, Policy) {
        let mut dropped = Vec::new();
        let mut state = self.lock();
        while !state.is_closed && !state.items.is_empty() && state.taken + item.input.room() > self.capacity {
            let oldest = match self.overload {
                Overload::Drop(Policy::DropNewest) if item.input.may_be_dropped() => {
                    return (Ok(()), vec![item], Policy::DropNewest);
                }
                Overload::Drop(Policy::DropOldest) => state.take_oldest(),
                _ => None,
            };
            match oldest {
                Some(oldest) => dropped.push(oldest),
                None => state = state.wait(&self.has_room),
            }
        }
        let is_open = !state.is_closed;
        if is_open {
            state.put(item);
        }
        drop(state);
        self.wake_engine();
        (is_open.then_some(()).ok_or(Closed), dropped, Policy::DropOldest)
    }

    /// The next item, if there is one.
    pub fn pop(&self) -> Option<Item> {
        let item = self.lock().take(0)?;
        self.has_room.notify_all();
        Some(item)
    }

    /// Takes nothing more.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.has_room.notify_all();
        self.wake_engine();
    }

    /// Whether nothing more is taken.
    pub fn is_closed(&self) -> bool {
        self.lock().is_closed
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.lock().items.is_empty()
    }

    /// Whether it is closed and empty.
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

    /// Wakes the engine.
    pub fn wake_engine(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    fn note_dropped(&self, item: &Item, policy: Policy) {
        let points = item.input.points();
        let before = self.dropped.fetch_add(points as u64, Ordering::Relaxed);
        match &item.origin {
            Origin::Producer(reply_to) => reply_to.dropped(points as u32, policy),
            Origin::Stdin if before == 0 => {
                tracing::warn!(
                    "the input is faster than the engine: points are dropped, as --overload asks; status counts them"
                );
            }
            Origin::Stdin => {}
        }
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
    }
}

impl State {
    fn put(&mut self, item: Item) {
        self.points += item.input.points();
        self.taken += item.input.room();
        self.bytes += item.input.bytes() as u64;
        self.items.push_back(item);
        self.charge.set(self.bytes);
    }

    fn take(&mut self, place: usize) -> Option<Item> {
        let item = self.items.remove(place)?;
        self.points -= item.input.points();
        self.taken -= item.input.room();
        self.bytes -= item.input.bytes() as u64;
        self.charge.set(self.bytes);
        Some(item)
    }

    fn take_oldest(&mut self) -> Option<Item> {
        let place = self.items.iter().position(|item| item.input.may_be_dropped())?;
        self.take(place)
    }
}

#[cfg(test)]
mod tests {
    use crossbeam_channel::{Receiver, bounded};

    use super::*;
    use crate::daemon::streams::input::{Batch, Positions, ROOM_OF_AN_ITEM};

    fn queue(capacity: usize, overload: Overload) -> (Queue, Receiver<()>) {
        let (wake, wakes) = bounded(1);
        (Queue::new(capacity, overload, wake, &Arc::default()), wakes)
    }

    fn points(count: usize) -> Item {
        let batch = Batch { positions: Positions::Plane(vec![(0.0, 0.0); count]), ..Batch::default() };
        Item { input: Input::Points(batch), origin: Origin::Stdin }
    }

    fn commit() -> Item {
        Item { input: Input::Commit(None), origin: Origin::Stdin }
    }

    fn sizes(queue: &Queue) -> Vec<usize> {
        std::iter::from_fn(|| queue.pop()).map(|item| item.input.points()).collect()
    }

    #[test]
    fn the_oldest_points_are_dropped_and_no_commit() {
        let (queue, _wakes) = queue(10 + 3 * ROOM_OF_AN_ITEM, Overload::Drop(Policy::DropOldest));
        for item in [points(4), commit(), points(5), points(6)] {
            queue.push(item).unwrap();
        }
        assert_eq!((queue.dropped(), queue.waiting()), (9, 6));
        assert_eq!(sizes(&queue), [0, 6]);
    }

    #[test]
    fn the_newest_points_are_dropped_and_no_commit() {
        let (queue, _wakes) = queue(25 + 3 * ROOM_OF_AN_ITEM, Overload::Drop(Policy::DropNewest));
        for item in [points(20), points(30), commit(), points(5)] {
            queue.push(item).unwrap();
        }
        assert_eq!((queue.dropped(), queue.waiting()), (30, 25));
        assert_eq!(sizes(&queue), [20, 0, 5]);
    }

    #[test]
    fn commits_wait_for_room_whatever_the_policy() {
        for overload in [Overload::Block, Overload::Drop(Policy::DropOldest), Overload::Drop(Policy::DropNewest)] {
            let (queue, wakes) = queue(10, overload);
            std::thread::scope(|scope| {
                scope.spawn(|| (0..100).for_each(|_| queue.push(commit()).unwrap()));
                let mut taken = 0;
                while taken < 100 {
                    wakes.recv().unwrap();
                    while queue.pop().is_some() {
                        taken += 1;
                    }
                }
            });
            assert_eq!(queue.dropped(), 0);
        }
    }

    #[test]
    fn a_full_queue_makes_its_source_wait() {
        let (queue, wakes) = queue(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        std::thread::scope(|scope| {
            scope.spawn(|| (0..100).for_each(|_| queue.push(points(3)).unwrap()));
            let mut taken = 0;
            while taken < 100 {
                wakes.recv().unwrap();
                while let Some(item) = queue.pop() {
                    assert!(queue.waiting() + item.input.points() <= 13 + 3 * ROOM_OF_AN_ITEM);
                    taken += 1;
                }
            }
        });
        assert_eq!(queue.dropped(), 0);
    }

    #[test]
    fn one_item_may_be_larger_than_the_queue() {
        let (queue, _wakes) = queue(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        queue.push(points(1000)).unwrap();
        assert_eq!(sizes(&queue), [1000]);
    }

    #[test]
    fn a_closed_queue_takes_nothing_and_keeps_what_it_has() {
        let (queue, _wakes) = queue(10 + 3 * ROOM_OF_AN_ITEM, Overload::Block);
        queue.push(points(3)).unwrap();
        queue.close();
        assert_eq!(queue.push(points(1)), Err(Closed));
        assert!(!queue.is_finished());
        assert_eq!(sizes(&queue), [3]);
        assert!(queue.is_finished());
    }

    #[test]
    fn closing_wakes_senders_that_wait() {
        let (queue, _wakes) = queue(1, Overload::Block);
        queue.push(points(1)).unwrap();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| queue.push(points(1)));
            queue.close();
            assert_eq!(waiting.join().unwrap(), Err(Closed));
        });
    }
}
