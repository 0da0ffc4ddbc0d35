//! The streams of a daemon by name, and the memory that they hold.
//!
//! In: streams as they begin and end. Out: the stream of a name; all streams.
//!
//! Invariants: a name is one stream at a time.
//!
//! Must not know: engines, connections, watchers.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use super::stream::Stream;
use crate::daemon::locks::lock;

/// Streams by name.
#[derive(Debug, Default)]
pub struct Roster(Mutex<BTreeMap<String, Arc<Stream>>>);

impl Roster {
    /// Adds a stream, in place of one of its name.
    pub fn insert(&self, stream: &Arc<Stream>) {
        lock(&self.0).insert(stream.state.name.clone(), Arc::clone(stream));
    }

    /// Removes a stream: its name is free.
    pub fn remove(&self, stream: &Arc<Stream>) {
        let mut streams = lock(&self.0);
        if streams.get(&stream.state.name).is_some_and(|current| Arc::ptr_eq(current, stream)) {
            streams.remove(&stream.state.name);
        }
    }

    /// The stream of a name.
    pub fn get(&self, name: &str) -> Option<Arc<Stream>> {
        lock(&self.0).get(name).cloned()
    }

    /// All streams, by name.
    pub fn all(&self) -> Vec<Arc<Stream>> {
        lock(&self.0).values().cloned().collect()
    }

    /// The number of streams.
    pub fn len(&self) -> usize {
        lock(&self.0).len()
    }

    /// Estimate of bytes held for all streams.
    pub fn memory(&self) -> u64 {
        lock(&self.0).values().map(|stream| stream.state.stats.memory.load(Ordering::Relaxed)).sum()
    }
}
