//! The end in time of a program whose stdout takes nothing any more.
//!
//! In: a signal.
//! Out: the end of the process, if it has not come by itself.
//! Invariants: without a signal nothing happens: who reads slowly is waited for.
//! Must not know: what is written.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread;
use std::time::Duration;

use crate::daemon::Stop;

/// How long the end in good order may take.
const GRACE: Duration = Duration::from_secs(5);

/// From here on a signal ends the process in time, with exit code 1 and the number of frames if it must be hurried.
///
/// # Errors
/// Those of the system, when it gives no signals or no thread.
pub fn end_in_time(frames: Arc<AtomicU64>) -> io::Result<()> {
    let stop = Stop::listen()?;
    let wait = move || {
        let Ok(signal) = stop.requests().recv() else { return };
        thread::sleep(GRACE);
        let frames = frames.load(Relaxed);
        tracing::error!("{signal}: stopped after {frames} frames; the rest is lost: nobody reads the output");
        std::process::exit(1);
    };
    thread::Builder::new().name("patience".to_owned()).spawn(wait).map(drop)
}
