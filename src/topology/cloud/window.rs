//! The window of a stream: all points, the last N, the last N frames, or the last T of event time.
//!
//! In: arrivals, frame numbers, event times.
//! Out: the arrivals that leave.
//! Invariants: arrivals leave oldest first, by event time in a time window, else by order of arrival. Nothing is stored
//! for [`Window::All`].
//! Must not know: positions, the states of vertices.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::num::NonZeroU64;

use super::vertex::{Slot, VertexId};

/// How long a point stays in the cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Window {
    /// Until it is retracted.
    #[default]
    All,
    /// While it is among the last N points.
    Points(NonZeroU64),
    /// While its frame is among the last N frames. With 1, every frame replaces the cloud.
    Frames(NonZeroU64),
    /// While its event time is at most this much before the newest one (in the unit of the event times).
    Time(f64),
}

/// One point in the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrival {
    /// Frame number, or event time.
    key: f64,
    /// Order of arrival.
    sequence: u64,
    /// Its vertex.
    pub slot: Slot,
    /// Distinguishes a vertex from a later one in the same slot.
    pub vertex: VertexId,
}

impl Eq for Arrival {}

impl PartialOrd for Arrival {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Arrival {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key.total_cmp(&other.key).then(self.sequence.cmp(&other.sequence))
    }
}

/// The arrivals in a window; the oldest leaves first.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    window: Window,
    order: Order,
    sequence: u64,
}

#[derive(Clone, Debug)]
enum Order {
    /// Keys arrive in order.
    Arrival(VecDeque<Arrival>),
    /// Event times may arrive in any order.
    Time(BinaryHeap<Reverse<Arrival>>),
}

impl Queue {
    pub fn new(window: Window) -> Self {
        let order = match window {
            Window::Time(_) => Order::Time(BinaryHeap::new()),
            _ => Order::Arrival(VecDeque::new()),
        };
        Self { window, order, sequence: 0 }
    }

    /// Adds an arrival; `key` is its frame number or event time.
    pub fn push(&mut self, key: f64, slot: Slot, vertex: VertexId) {
        let arrival = Arrival { key, sequence: self.sequence, slot, vertex };
        self.sequence += 1;
        match &mut self.order {
            Order::Arrival(_) if self.window == Window::All => {}
            Order::Arrival(queue) => queue.push_back(arrival),
            Order::Time(heap) => heap.push(Reverse(arrival)),
        }
    }

    /// Removes the oldest arrival.
    pub fn pop(&mut self) -> Option<Arrival> {
        match &mut self.order {
            Order::Arrival(queue) => queue.pop_front(),
            Order::Time(heap) => heap.pop().map(|Reverse(arrival)| arrival),
        }
    }

    /// Removes the oldest arrival if its frame number or event time is below `limit`.
    pub fn pop_below(&mut self, limit: f64) -> Option<Arrival> {
        let oldest = match &self.order {
            Order::Arrival(queue) => queue.front(),
            Order::Time(heap) => heap.peek().map(|Reverse(arrival)| arrival),
        };
        if oldest?.key < limit { self.pop() } else { None }
    }

    pub fn len(&self) -> usize {
        match &self.order {
            Order::Arrival(queue) => queue.len(),
            Order::Time(heap) => heap.len(),
        }
    }

    /// About how many bytes the arrivals take.
    pub fn bytes(&self) -> usize {
        self.len() * size_of::<Arrival>()
    }

    /// Removes the arrivals for which `keep` is false; `keep` is called from the oldest on.
    pub fn retain(&mut self, mut keep: impl FnMut(&Arrival) -> bool) {
        match &mut self.order {
            Order::Arrival(queue) => queue.retain(keep),
            Order::Time(heap) => {
                let mut arrivals = std::mem::take(heap).into_vec();
                arrivals.sort_unstable_by(|a, b| b.cmp(a));
                arrivals.retain(|Reverse(arrival)| keep(arrival));
                *heap = arrivals.into();
            }
        }
    }
}
