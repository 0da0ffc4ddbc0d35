//! Running a daemon: starts its parts, waits for a reason to end, ends them in order.
//!
//! In: settings, the process' own source and sink, a starter of HTTP, the wish to stop. Out: how it ended.
//!
//! Invariants: parts end in the order in which data flows: listeners, readers, engines, writers. What was taken in is
//! finished before the end.
//!
//! Must not know: what any part does.

use std::io;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded, select, unbounded};

use super::connections::listener::Listener;
use super::connections::registry::Registry;
use super::error::DaemonError;
use super::governor::Governor;
use super::http_access::{HttpAccess, StartHttp, StopHttp};
use super::input_errors::InputErrors;
use super::locks::before_waiting;
use super::settings::{DEFAULT_STREAM, Settings};
use super::stop::Stop;
use super::streams::directory::{Directory, EngineEnded};
use super::streams::engine::Standard;
use super::streams::error::EngineError;
use super::streams::input::Input;
use super::streams::output::{Output, OutputFrame};
use super::streams::queue::{Item, Origin};
use super::streams::stream::Stream;

/// Frames under way to the sink: one being written, one ready.
const FRAMES: usize = 2;

/// How long engines may wait for the reader of the output when the daemon ends.
const OUTPUT_PATIENCE: Duration = Duration::from_millis(1500);

/// How long peers may take to read the goodbye.
const GOODBYE: Duration = Duration::from_secs(2);

/// The reason to end of a daemon whose input has ended.
const ENDED: &str = "the input has ended";

/// Hands the inputs of stdin to their stream.
pub struct Feed(Arc<Stream>);

impl Feed {
    /// Waits while the stream's queue is full. False once the stream takes nothing more.
    pub fn send(&self, input: Input) -> bool {
        self.0.queue.push(Item { input, origin: Origin::Stdin }).is_ok()
    }
}

/// Reads the process' input to its end, on a thread of its own.
pub type Source = Box<dyn FnOnce(&Feed) + Send>;

/// Takes the frames of the default stream, on a thread of its own. Its first error ends the daemon.
pub trait Sink: Send {
    /// Writes a frame.
    ///
    /// # Errors
    /// Those of writing.
    fn write(&mut self, frame: OutputFrame) -> io::Result<()>;

    /// Writes the end, after the last frame and with the failure that it comes from, if any.
    ///
    /// # Errors
    /// Those of writing.
    fn finish(&mut self, failure: Option<&str>) -> io::Result<()>;
}

/// The thread that writes frames to the sink.
struct Writer {
    thread: JoinHandle<io::Result<()>>,
    /// Takes how the daemon ends: the failure, if any.
    end: Sender<Option<String>>,
}

/// Serves until it is asked to stop or something fails; without an address to listen at and without HTTP, until the
/// source ends.
///
/// The thread that reads the source is not joined: it may be blocked in a read that never returns, and owns nothing
/// that has to be finished.
///
/// # Errors
/// [`DaemonError`].
pub fn run(
    settings: Settings,
    source: Option<Source>,
    sink: Option<Box<dyn Sink>>,
    http: Option<StartHttp>,
    stop: &Stop,
) -> Result<(), DaemonError> {
    if let Some(threads) = settings.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build_global()?;
    }
    let (ended_sender, ended) = unbounded();
    let directory = Arc::new(Directory::new(&settings, ended_sender));
    let is_listening = !settings.listen.is_empty() || http.is_some();
    let (output, writer) = start_writer(sink, &settings, is_listening)?;
    for (name, stream) in &settings.streams {
        directory.make(name, *stream, Standard::default())?;
    }
    let standard = Standard { input_errors: InputErrors::new(settings.strict), output };
    let default = (source.is_some() || writer.is_some())
        .then(|| directory.make(DEFAULT_STREAM, settings.default_stream, standard))
        .transpose()?;
    let entrances = Entrances::open(&settings, http, &directory)?;
    if let (Some(source), Some(stream)) = (source, &default) {
        start_reader(source, Arc::clone(stream), !is_listening)?;
    }
    let outcome = wait(stop.requests(), &ended, default.filter(|_| !is_listening).as_ref());
    let stopped = (!matches!(outcome, Ok(ENDED))).then(Instant::now);
    let outcome = entrances.close(&directory, outcome, is_listening);
    // Engines that failed while they finished have reported it by now.
    let late = ended.try_iter().find_map(|ended| ended.result.err()).map_or(Ok(()), Err);
    let outcome = outcome.and(late.map_err(DaemonError::from));
    let failure = outcome.as_ref().err().map(ToString::to_string);
    let written = writer.map_or(Ok(()), |writer| join_writer(writer, failure, stopped, stop.requests()));
    written.and(outcome)
}

/// Waits for the last frames to be written. It does not wait for ever once the daemon is `stopped`, which may be before
/// or in the meantime: the reader of the output may have stopped too.
fn join_writer(
    Writer { thread: writer, end }: Writer,
    failure: Option<String>,
    mut stopped: Option<Instant>,
    requests: &Receiver<&'static str>,
) -> Result<(), DaemonError> {
    const STEP: Duration = Duration::from_millis(2);
    // It takes one, and is gone if it has failed.
    let _ = end.try_send(failure);
    before_waiting("the reader of the output");
    while !writer.is_finished() {
        if stopped.is_some_and(|stopped| stopped.elapsed() > OUTPUT_PATIENCE) {
            return Err(DaemonError::SinkStuck("the last frames may not be written".to_owned()));
        }
        match requests.recv_timeout(STEP) {
            Ok(_) => stopped = stopped.or_else(|| Some(Instant::now())),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => thread::sleep(STEP),
        }
    }
    writer.join().map_err(|_| DaemonError::Thread("writer"))?.map_err(DaemonError::Sink)
}

fn named(name: &str) -> thread::Builder {
    thread::Builder::new().name(name.to_owned())
}

fn start_writer(
    sink: Option<Box<dyn Sink>>,
    settings: &Settings,
    is_listening: bool,
) -> Result<(Option<Output>, Option<Writer>), DaemonError> {
    let Some(mut sink) = sink else { return Ok((None, None)) };
    let ((frames, written), (end, ended)) = (bounded(FRAMES), bounded::<Option<String>>(1));
    let write = move || {
        written.into_iter().try_for_each(|frame| sink.write(frame))?;
        ended.recv().map_or(Ok(()), |failure| sink.finish(failure.as_deref()))
    };
    let writer = Writer { thread: named("writer").spawn(write).map_err(DaemonError::Start)?, end };
    Ok((Some(Output { view: settings.view, frames, is_vital: !is_listening }), Some(writer)))
}

fn start_reader(source: Source, stream: Arc<Stream>, ends_stream: bool) -> Result<(), DaemonError> {
    let feed = Feed(stream);
    let read = move || {
        source(&feed);
        feed.send(Input::Close { end: ends_stream });
    };
    named("reader").spawn(read).map(drop).map_err(DaemonError::Start)
}

/// The ways into a daemon: its listeners and its HTTP server.
struct Entrances {
    registry: Arc<Registry>,
    listeners: Vec<Listener>,
    http: Option<StopHttp>,
    governor: Governor,
}

impl Entrances {
    fn open(settings: &Settings, http: Option<StartHttp>, directory: &Arc<Directory>) -> Result<Self, DaemonError> {
        let registry = Arc::new(Registry::new(Arc::clone(directory)));
        let mut listeners = Vec::new();
        for address in &settings.listen {
            listeners.push(Listener::start(address, settings.allow_remote, Arc::clone(&registry))?);
        }
        let access = HttpAccess::new(Arc::clone(directory), Arc::clone(&registry));
        let http = http.map(|start| start(access)).transpose()?;
        let governor = Governor::start(Arc::clone(directory), Arc::clone(&registry.members));
        Ok(Self { registry, listeners, http, governor: governor.map_err(DaemonError::Start)? })
    }

    /// Takes in nothing more, lets engines finish, and says goodbye to all peers.
    fn close(
        self,
        directory: &Directory,
        outcome: Result<&'static str, DaemonError>,
        is_listening: bool,
    ) -> Result<(), DaemonError> {
        self.listeners.into_iter().for_each(Listener::stop);
        self.http.into_iter().for_each(|stop| stop());
        self.registry.stop_reading();
        let streams = directory.finish(Instant::now() + OUTPUT_PATIENCE);
        drop(self.governor);
        for (name, frame) in &streams {
            match outcome {
                Ok(ENDED) | Err(_) => {}
                Ok(reason) if is_listening => tracing::info!("{reason}: stream {name:?} stopped after frame {frame}"),
                Ok(reason) => tracing::info!("{reason}: stopped after frame {frame}"),
            }
        }
        self.registry.say_goodbye(
            outcome.as_ref().unwrap_or(&"the daemon has failed"),
            &streams,
            Instant::now() + GOODBYE,
        );
        outcome.map(drop)
    }
}

/// Waits for a request to stop, the end of the only stream, or a failure that ends the daemon. Returns the reason.
fn wait(
    requests: &Receiver<&'static str>,
    ended: &Receiver<EngineEnded>,
    only: Option<&Arc<Stream>>,
) -> Result<&'static str, DaemonError> {
    before_waiting("a reason to end");
    loop {
        select! {
            recv(requests) -> reason => return Ok(reason.unwrap_or("nobody is left to ask for an end")),
            recv(ended) -> ended => {
                // The directory holds the other end.
                let Ok(EngineEnded { stream, result }) = ended else { return Ok(ENDED) };
                let is_only = only.is_some_and(|only| Arc::ptr_eq(only, &stream));
                match result {
                    // A panic ends its own stream only.
                    Err(EngineError::Panicked) if !is_only => {}
                    Err(error) => return Err(error.into()),
                    Ok(()) if is_only => return Ok(ENDED),
                    Ok(()) => {}
                }
            }
        }
    }
}
