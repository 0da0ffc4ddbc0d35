//! What all cursors of one peer share.
//!
//! In: wishes to wake the peer's writer. Out: its number, the account of what is held for it, its only place for a
//! snapshot.
//!
//! Invariants: one snapshot at most waits for a peer's writer, so that a peer that does not read holds one and not one
//! for each of its channels.
//!
//! Must not know: connections, what is sent.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crossbeam_channel::Sender;

use crate::daemon::memory::Account;

/// A peer that consumes frames.
#[derive(Debug)]
pub struct Consumer {
    /// The peer's number, from 1.
    pub peer: u64,
    /// What is held for it alone.
    pub account: Arc<Account>,
    /// Bytes of shared messages that wait for it: they may be held for others too.
    shared: AtomicU64,
    /// Frames that it did not get one by one.
    pub lagged: AtomicU64,
    wake: Sender<()>,
    has_snapshot: AtomicBool,
}

/// A shared message waits for a peer, until this is dropped.
#[derive(Debug)]
pub struct Share {
    consumer: Arc<Consumer>,
    bytes: u64,
}

/// The place of a peer's snapshot, until this is dropped.
#[derive(Debug)]
pub struct SnapshotPlace(Arc<Consumer>);

impl Consumer {
    /// A peer whose writer is woken through a channel.
    pub fn new(peer: u64, account: Arc<Account>, wake: Sender<()>) -> Self {
        let zero = || AtomicU64::new(0);
        Self { peer, account, shared: zero(), lagged: zero(), wake, has_snapshot: AtomicBool::new(false) }
    }

    /// Wakes the peer's writer.
    pub fn wake(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    /// Bytes held for the peer, alone or together with others.
    pub fn held(&self) -> u64 {
        self.account.held() + self.shared.load(Ordering::Relaxed)
    }

    /// A shared message of so many bytes waits for the peer.
    pub fn share(self: &Arc<Self>, bytes: usize) -> Share {
        let bytes = bytes as u64;
        self.shared.fetch_add(bytes, Ordering::Relaxed);
        Share { consumer: Arc::clone(self), bytes }
    }

    /// The place for a snapshot, if it is free.
    pub fn snapshot_place(self: &Arc<Self>) -> Option<SnapshotPlace> {
        let was_taken = self.has_snapshot.swap(true, Ordering::AcqRel);
        (!was_taken).then(|| SnapshotPlace(Arc::clone(self)))
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.consumer.shared.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Drop for SnapshotPlace {
    fn drop(&mut self) {
        self.0.has_snapshot.store(false, Ordering::Release);
        // Another cursor of the peer may wait for the place.
        self.0.wake();
    }
}
