//! The thread that finds edges, and what comes of it.
//!
//! In: files, and how edges are found in them.
//! Out: what is found, through a bounded queue.
//! Invariants: a slow receiver slows the reading; a bounded number of frames is under way.
//! Must not know: how edges are found, where points go.

use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

use crate::daemon::{Batch, Input, Positions, Stop};
use crate::formats::images::finder::{Finder, Found, NothingUsed};

/// Frames that may wait.
pub const WAITING: usize = 2;

/// How long a wait lasts before signals are looked for.
const MOMENT: Duration = Duration::from_millis(50);

/// Starts the thread. It is not waited for: it may be blocked in a read that never returns, and owns nothing that has
/// to be finished.
pub fn start<T: Send + 'static>(
    finder: Finder,
    inputs: Vec<PathBuf>,
    progress: &ProgressBar,
    sender: SyncSender<T>,
    forward: impl Fn(Found, &SyncSender<T>) -> bool + Send + 'static,
    failed: impl Fn(NothingUsed) -> T + Send + 'static,
) -> io::Result<()> {
    let progress = progress.clone();
    let find = move || {
        let found = finder.run(&inputs, &mut |found| forward(found, &sender), &|| progress.inc(1));
        if let Err(error) = found {
            // A receiver that is gone does not need the reason.
            drop(sender.send(failed(error)));
        }
    };
    thread::Builder::new().name("edges".to_owned()).spawn(find).map(drop)
}

/// Sends on what was found, in batches of so many points; whether it was received.
pub fn forward(found: Found, batch: usize, sender: &SyncSender<Input>) -> bool {
    match found {
        Found::Bad(reason) => sender.send(Input::Unreadable(reason)).is_ok(),
        Found::Frame { points, time } => {
            let parts = points.chunks(batch).all(|points| {
                let positions = points.iter().map(|&[x, y]| (x.into(), y.into())).collect();
                sender.send(Input::Points(Batch { positions: Positions::Plane(positions), ..Batch::default() })).is_ok()
            });
            parts && sender.send(Input::Commit(time)).is_ok()
        }
    }
}

/// What comes next; nothing at the end, or when a signal comes first.
pub fn next<T>(results: &Receiver<T>, stop: &mut Stop) -> Option<T> {
    while stop.asked().is_none() {
        match results.recv_timeout(MOMENT) {
            Ok(found) => return Some(found),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
    None
}

/// Waits for a time; whether it came before a signal did.
pub fn wait_for(due: Instant, stop: &mut Stop) -> bool {
    match due.checked_duration_since(Instant::now()) {
        Some(left) if !left.is_zero() => stop.wait(left).is_none(),
        _ => true,
    }
}
