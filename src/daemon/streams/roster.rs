//! The streams of a daemon by name.
//!
//! In: streams as they begin and end. Out: the stream of a name; all streams.
//!
//! Invariants: a name is one stream at a time.
//!
//! Must not know: engines, connections, watchers.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::stream::Stream;
use crate::daemon::locks::{Level, Lock};

/// Streams by name.
#[derive(Debug)]
pub struct Roster(Lock<BTreeMap<String, Arc<Stream>>>);

impl Default for Roster {
    fn default() -> Self {
        Self(Lock::new(Level::Roster, BTreeMap::new()))
    }
}

impl Roster {
    /// Adds a stream, in place of one of its name.
    pub fn insert(&self, stream: &Arc<Stream>) {
        self.0.lock().insert(stream.state.name.clone(), Arc::clone(stream));
    }

    /// Removes a stream: its name is free.
    pub fn remove(&self, stream: &Arc<Stream>) {
        let mut streams = self.0.lock();
        if streams.get(&stream.state.name).is_some_and(|current| Arc::ptr_eq(current, stream)) {
            streams.remove(&stream.state.name);
        }
    }

    /// The stream of a name.
    pub fn get(&self, name: &str) -> Option<Arc<Stream>> {
        self.0.lock().get(name).cloned()
    }

    /// All streams, by name.
    pub fn all(&self) -> Vec<Arc<Stream>> {
        self.0.lock().values().cloned().collect()
    }

    /// The number of streams.
    pub fn len(&self) -> usize {
        self.0.lock().len()
    }
}
