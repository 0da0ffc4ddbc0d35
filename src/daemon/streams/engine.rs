//! The engine of a stream: a thread that drives the stream's pipeline.
//!
//! In: items of the [`Queue`](super::queue::Queue), ticks, and [`Request`]s of consumers. Out: replies to producers,
//! each view's changes on its log, frames for the output.
//! Invariants:
//! * Nothing is computed while nobody follows the stream. A frame is computed once, when it is closed, for everybody.
//! * Points of a producer join the stream at the producer's commit, unless the stream closes its frames by itself. In
//!   a time window all points wait for the end of their frame, which dates those without a time.
//! * Every frame of a view starts from the one before. What is refused is counted in the frame that it was meant for.
//! * The engine never waits for a consumer. It takes no further points while the output is not read, and serves
//!   consumers meanwhile.
//! * Points and frames have their share whatever consumers request: see [`RequestShare`].
//!
//! Must not know: parsing, sockets, connections.

mod commits;
mod feeding;
mod request_share;
mod stage_clock;
mod uncommitted;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, after, never, select, tick};
use hopes::topology::spaces::SpaceError;
use hopes::topology::{Contradiction, Follower, TrackOptions, ViewSpec};

use self::request_share::RequestShare;
use self::stage_clock::StageClock;
use self::uncommitted::Uncommitted;
use super::convert;
use super::error::EngineError;
use super::output::{Output, OutputFrame, Sent};
use super::pipeline::AnyPipeline;
use super::publishing::any_tracks::AnyTrackFrame;
use super::publishing::cursor::Cursor;
use super::publishing::views::{ViewFollower, Views};
use super::requests::{Next, Request};
use super::roster::Roster;
use super::stream::{ENDED, Stream};
use crate::daemon::input_errors::InputErrors;
use crate::daemon::locks::before_waiting;
use crate::daemon::log_limits::LogLimits;
use crate::daemon::memory::{Charge, Memory};
use crate::daemon::settings::{Limits, StreamSettings};

/// The process' own input and output, for the stream that has them.
#[derive(Debug, Default)]
pub struct Standard {
    /// Counts what could not be used of the input.
    pub input_errors: InputErrors,
    /// Where all frames go.
    pub output: Option<Output>,
}

/// What an engine is made of.
#[derive(Debug)]
pub struct EngineSettings {
    /// What the stream does.
    pub stream: StreamSettings,
    /// The daemon's limits.
    pub limits: Limits,
    /// What is tracked, if anything.
    pub tracking: Option<TrackOptions>,
    /// Whether every frame is recomputed and compared.
    pub is_checking: bool,
    /// The process' input and output, if this stream has them.
    pub standard: Standard,
}

/// A stream at work.
pub struct Engine {
    roster: Arc<Roster>,
    stream: Arc<Stream>,
    settings: StreamSettings,
    limits: Limits,
    is_checking: bool,
    pipeline: AnyPipeline,
    clock: Arc<StageClock>,
    input_errors: InputErrors,
    /// For what producers can cause.
    logs: LogLimits,
    views: Views,
    output: Option<(Output, ViewFollower)>,
    /// The first frame that the output did not take before the engine had to end.
    unread: Option<u64>,
    wakes: Receiver<()>,
    share: RequestShare,
    memory: Arc<Memory>,
    /// What points and their triangulation take.
    held: Charge,
    /// Refused since the last frame.
    rejected: u64,
    /// Points taken since the last frame.
    points: u64,
    /// Points refused since then because they are outside the time window. A frame that closes after so many points
    /// closes after as many of these too: only a commit can move the window to them.
    outside: u64,
    /// What is not committed.
    uncommitted: Uncommitted,
    /// Whether anything came since the last frame.
    pending: bool,
    newest_time: Option<f64>,
    /// Time that the frame in hand has taken so far.
    worked: Duration,
    /// A producer has ended the stream.
    is_over: bool,
}

impl Engine {
    /// An engine of a stream that is on the roster.
    ///
    /// # Errors
    /// The dimension that the stream is to have does not suit its metric.
    pub fn new(
        roster: Arc<Roster>,
        memory: Arc<Memory>,
        stream: Arc<Stream>,
        wakes: Receiver<()>,
        settings: EngineSettings,
    ) -> Result<Self, SpaceError> {
        let EngineSettings { stream: of_stream, limits, tracking, is_checking, standard } = settings;
        let views = Views::new(Arc::clone(&stream.state), Arc::clone(&memory), &limits, tracking);
        let uncommitted = Uncommitted::new(Arc::clone(&stream.state.accounts.points));
        let (mut pipeline, clock) = (AnyPipeline::new(of_stream.options)?, Arc::new(StageClock::default()));
        let of_pipeline = Arc::clone(&clock);
        pipeline.set_stage_listener(move |stage| of_pipeline.begin(stage));
        Ok(Self {
            pipeline,
            clock,
            input_errors: standard.input_errors,
            logs: LogLimits::default(),
            output: standard.output.map(|output| {
                let follower = ViewFollower::new(output.view);
                (output, follower)
            }),
            unread: None,
            wakes,
            share: RequestShare::default(),
            held: stream.state.accounts.points.charge(0),
            memory,
            roster,
            stream,
            settings: of_stream,
            limits,
            is_checking,
            views,
            uncommitted,
            rejected: 0,
            points: 0,
            outside: 0,
            pending: false,
            newest_time: None,
            worked: Duration::ZERO,
            is_over: false,
        })
    }

    /// Works until nothing more can come, a producer ends the stream, or the output's reader has gone.
    ///
    /// # Errors
    /// [`EngineError`].
    pub fn run(mut self) -> Result<(), EngineError> {
        let worked = self.work();
        self.stream.queue.close();
        self.input_errors.sum_up();
        worked?;
        self.tell_left_out();
        self.stream.requests.close().into_iter().for_each(|request| self.serve(request));
        let reason = if self.is_over { "a producer has ended the stream" } else { ENDED };
        self.views.close(&mut self.pipeline, reason);
        for producer in self.stream.take_producers() {
            producer.close(self.pipeline.committed());
        }
        tracing::debug!("stream {:?} ended at frame {}", self.stream.state.name, self.pipeline.committed());
        self.unread.map_or(Ok(()), |frame| Err(EngineError::OutputNotRead { frame }))
    }

    fn work(&mut self) -> Result<(), EngineError> {
        let ticks = self.settings.frame_every.map_or_else(never, tick);
        while !self.is_over {
            let resting = self.serve_requests(true);
            if ticks.try_recv().is_ok() {
                self.close_by_itself()?;
            }
            match self.stream.queue.pop() {
                Some(item) => {
                    let begun = Instant::now();
                    self.take(item)?;
                    self.share.earn(begun.elapsed());
                }
                None if self.stream.queue.is_finished() => return self.close_last_frame(),
                None => {
                    before_waiting("points");
                    let rested = resting.map_or_else(never, |until| after(until.duration_since(Instant::now())));
                    select! {
                        recv(self.wakes) -> _ => {}
                        recv(rested) -> _ => {}
                        recv(ticks) -> _ => self.close_by_itself()?,
                    }
                }
            }
        }
        Ok(())
    }

    /// What came after the last commit is a frame too, if its source has ended by itself. An output gets at least one
    /// frame then. A stream that is stopped closes no frame that nobody has closed, but for one that time would close.
    fn close_last_frame(&mut self) -> Result<(), EngineError> {
        let is_stopped = self.stream.end_by().is_some();
        if is_stopped && self.settings.frame_every.is_none() {
            return Ok(());
        }
        let is_first = self.pipeline.committed() == 0 && self.output.is_some();
        if self.pending || is_first { self.close_by_itself() } else { Ok(()) }
    }

    /// Tells of points that are in no frame.
    fn tell_left_out(&self) {
        // In a time window, all points of the frame in hand wait.
        let joined = if self.is_timed() { 0 } else { self.points };
        let (points, name) = (joined + self.uncommitted.point_count(), &self.stream.state.name);
        if points > 0 {
            tracing::info!("stream {name:?}: {points} points after the last frame are left out: nothing closed it");
        }
    }

    /// Serves consumers, within the share of time that they have while points wait that could be taken. Returns when to
    /// come back for those that have to rest.
    fn serve_requests(&mut self, takes_points: bool) -> Option<Instant> {
        if self.stream.takes_relief() {
            self.views.relieve();
        }
        loop {
            if !takes_points || self.stream.queue.is_empty() {
                self.share.reset();
            } else if self.share.is_spent() {
                return None;
            }
            match self.stream.requests.next() {
                Next::Request(peer, request) => {
                    let begun = Instant::now();
                    self.serve(request);
                    let took = begun.elapsed();
                    self.share.spend(took);
                    self.stream.requests.note_cost(peer, took);
                }
                Next::NotBefore(until) => return Some(until),
                Next::Nothing => return None,
            }
        }
    }

    fn serve(&mut self, request: Request<Cursor>) {
        let begun = Instant::now();
        self.views.serve(request, &mut self.pipeline);
        // A frame that nobody followed when it was closed is computed for the first request.
        self.note_times(Duration::ZERO, begun.elapsed());
        self.update_stats();
    }

    /// Closes the frame in hand, and publishes it.
    fn close_frame(&mut self, time: Option<f64>) -> Result<(), EngineError> {
        let begun = Instant::now();
        let number = self.pipeline.commit(time.or(self.newest_time));
        let fed = std::mem::take(&mut self.worked) + begun.elapsed();
        let rejected = std::mem::take(&mut self.rejected);
        (self.points, self.outside, self.pending) = (0, 0, false);
        self.stream.state.stats.set_frame(number);
        let begun = Instant::now();
        let tracks = self.views.publish_tracks(&mut self.pipeline, self.output.is_some());
        self.views.publish(&mut self.pipeline, rejected);
        let published = begun.elapsed();
        if self.is_checking {
            self.check()?;
        }
        self.note_times(fed, published);
        self.update_stats();
        let frame = self.output_frame(rejected, tracks);
        tracing::trace!("stream {:?}: frame {number} took {:?}", self.stream.state.name, fed + begun.elapsed());
        if let Some(frame) = frame {
            self.write_output(frame, number);
        }
        Ok(())
    }

    /// Adds a frame to the histograms, if it was computed.
    fn note_times(&self, fed: Duration, published: Duration) {
        let stages = self.clock.take();
        let computed = stages.triangulation + stages.reduction;
        if computed.is_zero() {
            return;
        }
        // What only the output or the check needed was computed after publishing. Waiting for the output's reader is no
        // work of a frame.
        let publishing = published.saturating_sub(computed);
        let times = &self.stream.state.stats.times;
        times.triangulation.observe(stages.triangulation.as_secs_f64());
        times.reduction.observe(stages.reduction.as_secs_f64());
        times.publishing.observe(publishing.as_secs_f64());
        times.total.observe((fed + computed + publishing).as_secs_f64());
    }

    /// The frame for the output, if there is one.
    fn output_frame(&mut self, rejected: u64, tracks: Option<AnyTrackFrame>) -> Option<OutputFrame> {
        let (output, follower) = self.output.as_mut()?;
        let step = follower.poll(&mut self.pipeline)?;
        let (number, shape) = (self.stream.state.number, self.stream.state.shape());
        let frame = convert::frame_info(output.view, &step, rejected);
        let diff = convert::diff((number, shape), step.from, frame, &step.diff, step.checksum.0);
        Some(OutputFrame { stream: number, number: step.number, diff, tracks })
    }

    /// Hands a frame to the output. While its reader is behind, no points are taken, but consumers are served.
    fn write_output(&mut self, mut frame: OutputFrame, number: u64) {
        let Some((output, _)) = &self.output else { return };
        let (is_vital, output) = (output.is_vital, output.clone());
        loop {
            // No point is taken meanwhile, so no point waits for a consumer.
            let resting = self.serve_requests(false);
            match output.send(frame, &self.wakes, resting, self.stream.end_by()) {
                Sent::Taken => return,
                Sent::NotYet(waiting) => frame = *waiting,
                // The reader has gone; the writer's thread says why.
                Sent::Gone => return (self.is_over, self.output) = (is_vital, None),
                Sent::TooLate => return (self.unread, self.output) = (Some(number), None),
            }
        }
    }

    fn check(&mut self) -> Result<(), Contradiction> {
        let of_output = self.output.iter().filter_map(|(_, follower)| follower.plain());
        let mut followers: Vec<&Follower> = of_output.chain(self.views.followers()).collect();
        let whole = Follower::new(ViewSpec::Full);
        if followers.is_empty() {
            followers.push(&whole);
        }
        followers.into_iter().try_for_each(|follower| self.pipeline.check(follower))
    }

    /// Keeps the stream's numbers up to date.
    fn update_stats(&mut self) {
        let (stats, pipeline) = (&self.stream.state.stats, &self.pipeline);
        let (points, vertices) = (pipeline.point_count(), pipeline.vertex_count() as u64);
        stats.points.store(points, Ordering::Relaxed);
        stats.vertices.store(vertices, Ordering::Relaxed);
        stats.computed.store(pipeline.computed(), Ordering::Relaxed);
        self.held.set(pipeline.bytes() as u64);
    }
}
