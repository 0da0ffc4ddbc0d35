//! The governor: ends what nobody uses, and keeps the daemon's memory within its limit.
//!
//! In: the directory, the connections, the passing of time. Out: streams that expire; when memory is short, relief.
//!
//! Invariants: history is dropped first, then readers that are far behind, then streams that nobody uses. No batch of a
//! producer is refused for what readers take. Nothing here waits for a stream or a peer.
//!
//! Must not know: what streams hold, how connections work.

use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded};

use super::connections::connection::Connection;
use super::connections::members::Members;
use super::locks::before_waiting;
use super::streams::directory::Directory;
use super::streams::stream::Stream;

/// How often the governor looks.
const STEP: Duration = Duration::from_millis(20);

/// Looks in a row at which memory is short before readers are cut off: engines need time to drop their history.
const PATIENCE: u32 = 5;

/// A reader that holds less is not cut off: it would not help.
const SMALL: u64 = 1 << 16;

/// Streams that nobody has used for so long may be ended for want of memory.
const UNUSED: Duration = Duration::from_secs(10);

/// The governor's thread, which ends when this is dropped.
pub struct Governor {
    /// Dropped before the thread is joined, which ends it.
    ending: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

struct Watch {
    directory: Arc<Directory>,
    members: Arc<Members>,
    /// Looks in a row at which memory was short.
    short: u32,
}

impl Governor {
    /// Starts to govern.
    ///
    /// # Errors
    /// Those of the system, when it gives no thread.
    pub fn start(directory: Arc<Directory>, members: Arc<Members>) -> std::io::Result<Self> {
        let (ending, ends) = bounded(0);
        let mut watch = Watch { directory, members, short: 0 };
        let thread = thread::Builder::new().name("governor".to_owned()).spawn(move || watch.run(&ends))?;
        Ok(Self { ending: Some(ending), thread: Some(thread) })
    }
}

impl Drop for Governor {
    fn drop(&mut self) {
        self.ending = None;
        before_waiting("the governor");
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the governor's thread stopped by itself: please report this");
        }
    }
}

impl Watch {
    fn run(&mut self, ends: &Receiver<()>) {
        while ends.recv_timeout(STEP) == Err(RecvTimeoutError::Timeout) {
            let unused = self.unused_streams();
            self.expire(&unused);
            self.relieve(&unused);
        }
    }

    /// Streams of peers that nobody uses, and for how long, the longest first.
    fn unused_streams(&self) -> Vec<(Duration, Arc<Stream>)> {
        let now = Instant::now();
        let streams = self.directory.streams().into_iter().filter(|stream| !stream.is_permanent);
        let mut unused: Vec<(Duration, Arc<Stream>)> =
            streams.filter_map(|stream| Some((stream.unused_for(now)?, stream))).collect();
        unused.sort_by_key(|(time, stream)| (std::cmp::Reverse(*time), stream.state.number));
        unused
    }

    fn expire(&self, unused: &[(Duration, Arc<Stream>)]) {
        let Some(ttl) = self.directory.limits.stream_ttl else { return };
        for (_, stream) in unused.iter().filter(|(time, _)| *time >= ttl) {
            if !stream.queue.is_closed() {
                tracing::info!("stream {:?} has expired: nobody has fed or followed it", stream.state.name);
                stream.finish(Instant::now());
            }
        }
    }

    fn relieve(&mut self, unused: &[(Duration, Arc<Stream>)]) {
        if !self.directory.memory.is_short() {
            self.short = 0;
            return;
        }
        self.short += 1;
        if self.short == 1 {
            self.directory.streams().iter().for_each(|stream| stream.relieve());
        }
        if self.short <= PATIENCE {
            return;
        }
        // The next look comes after the memory of this one is given back.
        self.short = 0;
        if !self.cut_off_largest_reader() {
            self.end_unused(unused);
        }
    }

    fn cut_off_largest_reader(&self) -> bool {
        let held = |connection: &Arc<Connection>| connection.consumer.held();
        let largest = self.members.connections().into_iter().max_by_key(held);
        let Some(connection) = largest.filter(|connection| held(connection) > SMALL) else { return false };
        if let Some(note) = self.directory.logs.admits("memory", &connection.place) {
            let bytes = held(&connection);
            tracing::warn!("{}: cut off: memory is short, and {bytes} bytes are held for it{note}", connection.label);
        }
        connection.cut_off();
        true
    }

    fn end_unused(&self, unused: &[(Duration, Arc<Stream>)]) {
        let longest = unused.iter().find(|(time, stream)| *time >= UNUSED && !stream.queue.is_closed());
        if let Some((_, stream)) = longest {
            tracing::warn!("stream {:?} ends: memory is short, and nobody uses it", stream.state.name);
            stream.finish(Instant::now());
        }
    }
}
