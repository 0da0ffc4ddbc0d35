//! Memory, counted where it is allocated: how much is held, and for whom.
//!
//! In: bytes that somebody allocates for a peer or a stream. Out: sums for each peer, each stream and the daemon.
//!
//! Invariants: what is charged is given back when the [`Charge`] is dropped, wherever that happens. A sum is that of
//! the charges that are alive, its own and those of the accounts below it.
//!
//! Must not know: what is held, what happens at a limit.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes held for somebody.
#[derive(Debug, Default)]
pub struct Account {
    held: AtomicU64,
    /// The account of which this one is a part.
    whole: Option<Arc<Account>>,
}

/// Bytes held until this is dropped.
#[derive(Debug)]
pub struct Charge {
    account: Arc<Account>,
    bytes: u64,
}

impl Account {
    /// An account that is part of another one.
    pub fn part_of(whole: &Arc<Self>) -> Arc<Self> {
        Arc::new(Self { held: AtomicU64::new(0), whole: Some(Arc::clone(whole)) })
    }

    /// Bytes that are held.
    pub fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    /// Holds so many bytes.
    pub fn charge(self: &Arc<Self>, bytes: usize) -> Charge {
        let mut charge = Charge { account: Arc::clone(self), bytes: 0 };
        charge.set(bytes as u64);
        charge
    }

    fn add(&self, bytes: u64) {
        self.held.fetch_add(bytes, Ordering::Relaxed);
        if let Some(whole) = &self.whole {
            whole.add(bytes);
        }
    }

    fn subtract(&self, bytes: u64) {
        self.held.fetch_sub(bytes, Ordering::Relaxed);
        if let Some(whole) = &self.whole {
            whole.subtract(bytes);
        }
    }
}

impl Charge {
    /// So many bytes are held from now on.
    pub fn set(&mut self, bytes: u64) {
        if bytes > self.bytes {
            self.account.add(bytes - self.bytes);
        } else if bytes < self.bytes {
            self.account.subtract(self.bytes - bytes);
        }
        self.bytes = bytes;
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.account.subtract(self.bytes);
    }
}

/// A value and what is charged for it.
#[derive(Debug)]
pub struct Charged<T> {
    value: T,
    /// Held for its drop.
    _charge: Charge,
}

impl<T> Charged<T> {
    /// A value that takes about so many bytes.
    pub fn new(value: T, bytes: usize, account: &Arc<Account>) -> Self {
        Self { value, _charge: account.charge(bytes) }
    }
}

impl<T> Deref for Charged<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

/// The accounts of a daemon.
#[derive(Debug, Default)]
pub struct Memory {
    /// Everything that is held for peers and streams.
    pub whole: Arc<Account>,
    /// Of it, what only peers need: answers, snapshots and merged frames under way, messages that have not come as a
    /// whole.
    pub peers: Arc<Account>,
    /// Of it, points with their triangulations.
    pub points: Arc<Account>,
    /// Bytes that may be held; 0 for no limit.
    pub limit: u64,
}

impl Memory {
    /// Nothing is held.
    pub fn new(limit: u64) -> Self {
        let whole = Arc::<Account>::default();
        let (peers, points) = (Account::part_of(&whole), Account::part_of(&whole));
        Self { whole, peers, points, limit }
    }

    /// Whether more is held than may be.
    pub fn is_short(&self) -> bool {
        self.limit > 0 && self.whole.held() >= self.limit
    }

    /// Whether so many more bytes would be too many.
    pub fn has_no_room_for(&self, bytes: u64) -> bool {
        self.limit > 0 && self.whole.held().saturating_add(bytes) > self.limit
    }

    /// Whether points alone take all that may be held.
    pub fn is_full_of_points(&self) -> bool {
        self.limit > 0 && self.points.held() >= self.limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_charged_is_given_back() {
        let memory = Memory::new(100);
        let (peer, other) = (Account::part_of(&memory.peers), Account::part_of(&memory.peers));
        let held = || [&memory.whole, &memory.peers, &peer, &other].map(|account| account.held());
        let first = peer.charge(30);
        let mut second = other.charge(20);
        assert_eq!(held(), [50, 50, 30, 20]);
        second.set(80);
        assert_eq!(held(), [110, 110, 30, 80]);
        assert!(memory.is_short() && !memory.is_full_of_points());
        second.set(10);
        drop(first);
        assert_eq!(held(), [10, 10, 0, 10]);
        assert!(!memory.has_no_room_for(90) && memory.has_no_room_for(91));
        drop(second);
        assert_eq!(held(), [0; 4]);
    }

    #[test]
    fn without_a_limit_there_is_room() {
        let memory = Memory::new(0);
        let _held = memory.points.charge(usize::MAX);
        assert!(!memory.is_short() && !memory.has_no_room_for(1) && !memory.is_full_of_points());
    }
}
