//! The daemon: streams with an engine each, and those who feed and follow them.
//!
//! In: points from stdin and from producers, options. Out: frames on stdout and to consumers. Threads, joined by bounded queues:
//!
//! ```text
//! stdin ──▶ reader ──┐                                   ┌──(tap)──▶ writer ──▶ stdout
//!                    ├─(inbox)─▶ engine of a stream ─────┤
//! peer ───▶ reader ──┘     ▲                             └─(board)─▶ writer ──▶ peer
//!                          └── what seats ask
//! ```
//!
//! Invariants: when somebody has to wait, it is the producer, for its own stream or for stdout's reader, never for a consumer on a socket; whatever a peer does, others are served on. On a wish to end, what has been taken in is finished, written and sent before the
//! end; threads are named, and joined. Must not know: how inputs are parsed, geometry.

mod address;
mod answer;
mod board;
mod convert;
mod engine;
mod frame_times;
mod http_access;
mod inbox;
mod input_errors;
mod peer;
mod seat;
mod signals;
mod stop;
mod streams;
mod tracks;
mod views;

use std::io;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use crossbeam_channel::{Receiver, bounded, select, unbounded};
use hopes::topology::{Contradiction, Options, TrackOptions};
use hopes_protocol as wire;
use thiserror::Error;

pub use address::Address;
pub use convert::{cut, spec, wire_window};
pub use engine::OutputFrame;
use engine::{Sources, Tap};
pub use frame_times::FrameTimes;
pub use http_access::{HttpAccess, SnapshotError, StartHttp, StopHttp};
pub use inbox::{Batch, Input, Overload};
use inbox::{Item, Origin};
pub use input_errors::{InputErrors, StrictStop};
pub use peer::{ListenError, Socket, Transport, bind_tcp};
use peer::{Listener, Registry};
pub use stop::{Stop, Stopper};
use streams::{Ended, Hub, OpenError, Stream};

/// The stream that stdin feeds and that stdout shows.
pub const DEFAULT_STREAM: &str = "default";

/// What a stream does.
#[derive(Clone, Copy, Debug, Default)]
pub struct StreamSettings {
    /// Which points stay.
    pub options: Options,
    /// Close a frame by itself after so many points.
    pub frame_points: Option<u64>,
    /// Close a frame by itself every so often.
    pub frame_every: Option<Duration>,
}

/// How much of everything there may be.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Peers at one time.
    pub connections: usize,
    /// Channels of a peer.
    pub channels: usize,
    /// Streams at one time.
    pub streams: usize,
    /// Points in the window of a stream.
    pub points: u64,
    /// Distinct positions in a stream.
    pub vertices: u64,
    /// Estimated bytes of all streams; 0 for no limit.
    pub memory: u64,
    /// Points that wait for the engine of a stream.
    pub waiting_points: usize,
    /// Points in one message.
    pub largest_batch: u32,
    /// Bytes in the body of one message of a peer.
    pub largest_frame: u32,
    /// Bytes that a consumer may be behind before frames are merged for it.
    pub consumer_queue: usize,
    /// Bytes of changes that each view keeps, for those who are behind or come back.
    pub history: usize,
    /// How long nothing is sent to a consumer at the most.
    pub heartbeat: Duration,
    /// How long a peer may be silent, or take for a message.
    pub timeout: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 1024,
            channels: 256,
            streams: 256,
            points: 100_000_000,
            vertices: 20_000_000,
            memory: 0,
            waiting_points: 1 << 16,
            largest_batch: 1 << 16,
            largest_frame: 1 << 22,
            consumer_queue: 1 << 20,
            history: 1 << 24,
            heartbeat: Duration::from_secs(5),
            timeout: Duration::from_secs(60),
        }
    }
}

/// What the daemon does.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The stream that stdin feeds.
    pub default_stream: StreamSettings,
    /// What stdout shows of it.
    pub view: wire::View,
    /// What is tracked in every stream, if anything.
    pub tracking: Option<TrackOptions>,
    /// Stop at the first thing on stdin that cannot be used.
    pub strict: bool,
    /// Recompute every frame from scratch, and stop where it differs.
    pub check: bool,
    /// So many threads reduce tiles; as many as there are processors, if none is given.
    pub threads: Option<NonZeroUsize>,
    /// What happens to producers that are faster than their stream.
    pub overload: Overload,
    /// How much of everything there may be.
    pub limits: Limits,
    /// Where peers connect. Without any, the daemon ends with stdin.
    pub listen: Vec<Address>,
    /// Whether peers may come from other machines.
    pub allow_remote: bool,
    /// Streams that are there from the start.
    pub streams: Vec<(String, StreamSettings)>,
}

/// Why the daemon stopped before it was asked to.
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
    /// Nobody could connect.
    #[error(transparent)]
    Listen(#[from] ListenError),
    /// A stream that was asked for cannot be.
    #[error("{0}")]
    Stream(String),
    /// The source failed.
    #[error("cannot read the input: {0}")]
    Source(String),
    /// The sink failed; a closed pipe is one of these.
    #[error("cannot write frames")]
    Sink(#[source] std::io::Error),
    /// The system gave no thread.
    #[error("cannot start")]
    Start(#[source] std::io::Error),
    /// A thread panicked, which is a bug.
    #[error("the {0} thread stopped by itself: please report this")]
    Thread(&'static str),
}

impl From<OpenError> for DaemonError {
    fn from(error: OpenError) -> Self {
        Self::Stream(error.text)
    }
}

/// Points of stdin that are handed on together at the most.
pub const BATCH: usize = 4096;

/// Frames under way to the sink: one being written, one ready.
const FRAMES: usize = 2;

/// Hands what stdin says on to its stream.
pub struct Feed(Arc<Stream>);

impl Feed {
    /// Waits while the engine is busy; false once nobody listens any more.
    pub fn send(&self, input: Input) -> bool {
        self.0.inbox.push(Item { input, origin: Origin::Stdin }).is_ok()
    }
}

/// Where stdin's points come from.
pub type Source = Box<dyn FnOnce(&Feed) + Send>;

/// Writes the frames of the default stream, one at a time, on a thread of its own. Its first error ends the daemon.
pub type Sink = Box<dyn FnMut(OutputFrame) -> io::Result<()> + Send>;

/// Serves until it is asked to stop or something fails; without a place to listen at or a http, until the source ends.
///
/// The reader of the source is not waited for: it may be blocked in a read that never returns, and owns nothing that has to be finished.
///
/// # Errors
/// [`DaemonError`].
pub fn run(
    settings: Settings,
    source: Option<Source>,
    sink: Option<Sink>,
    http: Option<StartHttp>,
    stop: &Stop,
) -> Result<(), DaemonError> {
    if let Some(threads) = settings.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
    }
    let (ended_sender, ended) = unbounded();
    let hub = Arc::new(Hub::new(&settings, ended_sender));
    let is_listening = !settings.listen.is_empty() || http.is_some();
    let named = |name: &str| thread::Builder::new().name(name.to_owned());

    let mut sources = Sources { input_errors: InputErrors::new(settings.strict), tap: None };
    let mut writer = None;
    if let Some(sink) = sink {
        let (frames, written) = bounded(FRAMES);
        sources.tap = Some(Tap { view: settings.view, frames, is_vital: !is_listening });
        writer =
            Some(named("writer").spawn(move || written.into_iter().try_for_each(sink)).map_err(DaemonError::Start)?);
    }
    for (name, stream) in &settings.streams {
        hub.make(name, *stream, Sources::default())?;
    }
    let default = (source.is_some() || writer.is_some())
        .then(|| hub.make(DEFAULT_STREAM, settings.default_stream, sources))
        .transpose()?;
    let registry = Arc::new(Registry::new(Arc::clone(&hub)));
    let mut listeners = Vec::new();
    for address in &settings.listen {
        listeners.push(Listener::start(address, settings.allow_remote, Arc::clone(&registry))?);
    }
    let access = HttpAccess::new(Arc::clone(&hub), Arc::clone(&registry));
    let closing = http.map(|http| http(access)).transpose()?;
    if let (Some(source), Some(stream)) = (source, &default) {
        let feed = Feed(Arc::clone(stream));
        let read = move || {
            source(&feed);
            feed.send(Input::Close { end: !is_listening });
        };
        named("reader").spawn(read).map_err(DaemonError::Start)?;
    }

    let outcome = wait(stop.wishes(), &ended, default.filter(|_| !is_listening).as_ref());
    listeners.into_iter().for_each(Listener::stop);
    closing.into_iter().for_each(|close| close());
    registry.stop_reading();
    let streams = hub.finish();
    let outcome = outcome.map(|reason| {
        for (name, frame) in streams.iter().filter(|_| reason != ENDED) {
            match is_listening {
                true => tracing::info!("{reason}: stream {name:?} stopped after frame {frame}"),
                false => tracing::info!("{reason}: stopped after frame {frame}"),
            }
        }
        registry.say_goodbye(reason, &streams);
    });
    if outcome.is_err() {
        registry.say_goodbye("the daemon has failed", &streams);
    }
    // Engines that failed while they finished have said so by now.
    let late = ended.try_iter().find_map(|ended| ended.result.err()).map_or(Ok(()), Err);
    let written = writer.map_or(Ok(Ok(())), thread::JoinHandle::join).map_err(|_| DaemonError::Thread("writer"))?;
    written.map_err(DaemonError::Sink).and(outcome).and(late)
}

/// Why a daemon ends that nobody has stopped.
const ENDED: &str = "the input has ended";

/// Waits for a wish to end, for the end of the stream that all is about, or for a failure that nobody should overlook. Says why it is the end.
fn wait(
    wishes: &Receiver<&'static str>,
    ended: &Receiver<Ended>,
    only: Option<&Arc<Stream>>,
) -> Result<&'static str, DaemonError> {
    loop {
        select! {
            recv(wishes) -> wish => return Ok(wish.unwrap_or("nobody is left to ask for an end")),
            recv(ended) -> ended => {
                // The hub, which is ours, holds the other end.
                let Ok(Ended { stream, result }) = ended else { return Ok(ENDED) };
                let is_only = only.is_some_and(|only| Arc::ptr_eq(only, &stream));
                match result {
                    // One stream's accident is not the others'.
                    Err(DaemonError::Thread(_)) if !is_only => {}
                    Err(error) => return Err(error),
                    Ok(()) if is_only => return Ok(ENDED),
                    Ok(()) => {}
                }
            }
        }
    }
}
