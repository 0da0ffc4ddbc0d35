//! The daemon: threads and channels around one stream's engine.
//!
//! In: [`Input`]s from a source, options. Out: frames as lines on a sink. Three threads, joined by bounded channels, so that a slow
//! reader of the sink slows the producer and memory stays bounded:
//!
//! ```text
//! reader ──(inputs)──▶ engine ──(frame lines)──▶ writer
//!                        ▲ signals, ticks
//! ```
//!
//! Invariants: no frame is dropped: when somebody has to wait, it is the producer. On a signal the frame in hand is closed and
//! written before the end. Must not know: how inputs are parsed, geometry.

mod complaints;
mod engine;
mod frame_line;
mod signals;
mod writer;

use std::io::Write;
use std::num::NonZeroUsize;
use std::thread;
use std::time::Duration;

use crossbeam_channel::{Sender, bounded, never, tick};
use hopes::topology::{Contradiction, Options, ViewSpec};
use thiserror::Error;

pub use complaints::{Complaints, StrictStop};
use engine::Engine;

/// One thing that a source says.
#[derive(Clone, Debug)]
pub enum Input {
    /// Points to insert.
    Points(Vec<Point>),
    /// Points to take back.
    Retract(Vec<Point>),
    /// The end of a frame, with the time it shall carry.
    Commit(Option<f64>),
    /// Something that could not be read, with where and why.
    Unreadable(String),
    /// The source has failed and says no more.
    Failed(String),
}

/// A point on its way in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where.
    pub position: [f64; 2],
    /// When, if known.
    pub time: Option<f64>,
    /// The line of the input that it stands on.
    pub line: u64,
}

/// What the stream does.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Which points stay.
    pub options: Options,
    /// What consumers see.
    pub view: ViewSpec,
    /// Close a frame by itself after so many points.
    pub frame_points: Option<u64>,
    /// Close a frame by itself every so often.
    pub frame_every: Option<Duration>,
    /// Stop at the first thing that cannot be used.
    pub strict: bool,
    /// Recompute every frame from scratch, and stop where it differs.
    pub check: bool,
    /// So many threads reduce tiles; as many as there are processors, if none is given.
    pub threads: Option<NonZeroUsize>,
}

/// Why the daemon stopped before its input ended.
#[derive(Debug, Error)]
pub enum DaemonError {
    /// Under `strict`.
    #[error(transparent)]
    Refused(#[from] StrictStop),
    /// Under `check`.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// Threads could not be started.
    #[error("cannot start the threads that reduce tiles: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The source failed.
    #[error("cannot read the input: {0}")]
    Source(String),
    /// The sink failed; a closed pipe is one of these.
    #[error("cannot write frames")]
    Sink(#[source] std::io::Error),
    /// The system gave no signal handler or no thread.
    #[error("cannot start")]
    Start(#[source] std::io::Error),
    /// A thread panicked, which is a bug.
    #[error("the {0} thread stopped by itself: please report this")]
    Thread(&'static str),
}

/// Inputs under way; a batch has at most [`BATCH`] points, so this bounds what waits for the engine to some megabytes.
const INPUTS: usize = 16;

/// Points that are handed on together at the most.
pub const BATCH: usize = 4096;

/// Frames under way to the sink: one being written, one ready.
const FRAMES: usize = 2;

/// Hands inputs on; false once nobody listens any more.
pub struct Feed(Sender<Input>);

impl Feed {
    /// Waits while the engine is busy.
    pub fn send(&self, input: Input) -> bool {
        self.0.send(input).is_ok()
    }
}

/// Runs a stream from a source to a sink, until the source ends, a signal comes or something fails.
///
/// The reader thread is not waited for: it may be blocked in a read that never returns, and owns nothing that has to be finished.
pub fn run(
    settings: Settings,
    source: impl FnOnce(Feed) + Send + 'static,
    sink: impl Write + Send + 'static,
) -> Result<(), DaemonError> {
    if let Some(threads) = settings.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
    }
    let signals = signals::channel().map_err(DaemonError::Start)?;
    let (input_sender, inputs) = bounded(INPUTS);
    let (line_sender, lines) = bounded(FRAMES);
    let named = |name: &str| thread::Builder::new().name(name.to_owned());
    named("reader").spawn(move || source(Feed(input_sender))).map_err(DaemonError::Start)?;
    let writer = named("writer").spawn(move || writer::run(&lines, sink)).map_err(DaemonError::Start)?;
    let ticks = settings.frame_every.map_or_else(never, tick);
    let engine = named("engine")
        .spawn(move || Engine::new(settings, line_sender).run(&inputs, &ticks, &signals))
        .map_err(DaemonError::Start)?;
    // The engine ends first, and by dropping its sender ends the writer once all is written.
    let ended = engine.join().map_err(|_| DaemonError::Thread("engine"))?;
    let written = writer.join().map_err(|_| DaemonError::Thread("writer"))?;
    written.map_err(DaemonError::Sink).and(ended)
}
