//! The engine of a stream: a thread that drives the stream's pipeline.
//!
//! In: items of the [`Queue`](super::queue::Queue), ticks, and [`Request`]s of consumers. Out: replies to producers,
//! each view's changes on its log, frames for the output.
//! Invariants:
//! * Nothing is computed while nobody follows the stream. A frame is computed once, when it is closed, for everybody.
//! * Every frame of a view starts from the one before. What is refused is counted in the frame that it was meant for.
//! * The engine never waits for a consumer. It takes no further points while the output is not read, and serves
//!   consumers meanwhile.
//! * Points and frames have their share whatever consumers request: see [`RequestShare`].
//!
//! Must not know: parsing, sockets, connections.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, after, never, select, tick};
use hopes::topology::{Contradiction, Follower, Pipeline, TrackOptions, VertexId, ViewSpec, Window};

use super::convert;
use super::error::EngineError;
use super::input::{Batch, Input};
use super::output::{Output, OutputFrame, Sent};
use super::publishing::cursor::Cursor;
use super::publishing::track_log::TrackFrame;
use super::publishing::views::{ViewFollower, Views};
use super::queue::{Item, Origin};
use super::reply::{BatchReply, RefusalReason};
use super::request_share::RequestShare;
use super::requests::{Next, Request};
use super::roster::Roster;
use super::stage_clock::StageClock;
use super::stream::{ENDED, Stream};
use crate::daemon::input_errors::InputErrors;
use crate::daemon::locks::before_waiting;
use crate::daemon::memory::{Charge, Memory};
use crate::daemon::settings::{Limits, StreamSettings};

/// An estimate of the bytes that a vertex takes in triangulation, tiles and views, measured at a million points.
const BYTES_OF_A_VERTEX: u64 = 900;

/// An estimate of the bytes that a point of the window takes.
const BYTES_OF_A_POINT: u64 = 40;

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
    pipeline: Pipeline,
    clock: Arc<StageClock>,
    input_errors: InputErrors,
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
    pub fn new(
        roster: Arc<Roster>,
        memory: Arc<Memory>,
        stream: Arc<Stream>,
        wakes: Receiver<()>,
        settings: EngineSettings,
    ) -> Self {
        let EngineSettings { stream: of_stream, limits, tracking, is_checking, standard } = settings;
        let views = Views::new(Arc::clone(&stream.state), Arc::clone(&memory), &limits, tracking);
        let (mut pipeline, clock) = (Pipeline::new(of_stream.options), Arc::new(StageClock::default()));
        let of_pipeline = Arc::clone(&clock);
        pipeline.set_stage_listener(move |stage| of_pipeline.begin(stage));
        Self {
            pipeline,
            clock,
            input_errors: standard.input_errors,
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
            rejected: 0,
            points: 0,
            pending: false,
            newest_time: None,
            worked: Duration::ZERO,
            is_over: false,
        }
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
            let resting = self.serve_requests();
            if ticks.try_recv().is_ok() {
                self.close_frame(None)?;
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
                        recv(ticks) -> _ => self.close_frame(None)?,
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
            if self.points > 0 {
                let (points, name) = (self.points, &self.stream.state.name);
                tracing::info!("stream {name:?}: {points} points after the last frame are left out: nothing closed it");
            }
            return Ok(());
        }
        let is_first = self.pipeline.committed() == 0 && self.output.is_some();
        if self.pending || is_first { self.close_frame(None) } else { Ok(()) }
    }

    /// Serves consumers, within the share of time that they have while points wait. Returns when to come back for those
    /// that have to rest.
    fn serve_requests(&mut self) -> Option<Instant> {
        if self.stream.takes_relief() {
            self.views.relieve();
        }
        loop {
            if self.stream.queue.is_empty() {
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

    fn take(&mut self, item: Item) -> Result<(), EngineError> {
        let Item { input, origin } = item;
        match input {
            Input::Points(batch) => self.insert(&batch, &origin)?,
            Input::Retract(batch) => self.retract(&batch, &origin)?,
            Input::Commit(time) => self.commit(time, &origin)?,
            Input::Close { end } => self.close_source(end, &origin)?,
            Input::Unreadable(error) => {
                (self.pending, self.rejected) = (true, self.rejected + 1);
                self.input_errors.add(&error)?;
            }
            Input::Failed(reason) => return Err(EngineError::Source(reason)),
        }
        Ok(())
    }

    fn commit(&mut self, time: Option<f64>, origin: &Origin) -> Result<(), EngineError> {
        if let Some(Err(refusal)) = time.map(|time| self.pipeline.feed_time(time)) {
            self.rejected += 1;
            if matches!(origin, Origin::Stdin) {
                self.input_errors.add(&refusal)?;
            }
        }
        self.close_frame(time.filter(|time| time.is_finite()))?;
        if let Origin::Producer(reply_to) = origin {
            reply_to.committed(self.pipeline.committed());
        }
        Ok(())
    }

    fn close_source(&mut self, ends_stream: bool, origin: &Origin) -> Result<(), EngineError> {
        // What stdin has said after its last commit is a frame.
        if matches!(origin, Origin::Stdin) && self.pending {
            self.close_frame(None)?;
        }
        if ends_stream {
            self.close_last_frame()?;
            // A producer may open the name anew as soon as it gets the reply: the name must be free by then.
            self.stream.queue.close();
            self.roster.remove(&self.stream);
            self.is_over = true;
        }
        if let Origin::Producer(reply_to) = origin {
            self.stream.remove_producer(reply_to.sink());
            reply_to.sink().close(self.pipeline.committed());
        }
        Ok(())
    }

    fn insert(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        let mut reply = BatchReply::new(batch);
        let no_room = self.no_room();
        let mut begun = Instant::now();
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            self.pending = true;
            let time = batch.times.get(index).copied();
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None => self.insert_one(x, y, time),
            };
            self.note(&mut reply, batch, index, placed)?;
            if self.settings.frame_points.is_some_and(|limit| self.points >= limit) {
                self.worked += begun.elapsed();
                self.close_frame(None)?;
                begun = Instant::now();
            }
        }
        self.worked += begun.elapsed();
        self.update_stats();
        self.stream.state.stats.accepted.fetch_add(reply.accepted(), Ordering::Relaxed);
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    fn insert_one(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, RefusalReason> {
        let limit = self.limits.points;
        // In a window of so many points the oldest leaves when one comes.
        let makes_room = matches!(self.settings.options.window, Window::Points(length) if length.get() <= limit);
        if self.pipeline.point_count() >= limit && !makes_room {
            return Err(RefusalReason::StreamFull { what: "points", limit });
        }
        let vertex = self.pipeline.feed_point(x, y, time).map_err(RefusalReason::Refused)?;
        self.points += 1;
        self.newest_time = time.into_iter().chain(self.newest_time).reduce(f64::max);
        Ok(vertex)
    }

    fn retract(&mut self, batch: &Batch, origin: &Origin) -> Result<(), EngineError> {
        self.pending = true;
        let mut reply = BatchReply::new(batch);
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            let retracted = self.pipeline.feed_retraction(x, y).map(|()| VertexId(0)).map_err(RefusalReason::Refused);
            self.note(&mut reply, batch, index, retracted)?;
        }
        self.update_stats();
        self.stream.state.stats.refused.fetch_add(reply.refused(), Ordering::Relaxed);
        send(reply, origin);
        Ok(())
    }

    /// Counts what became of a point.
    fn note(
        &mut self,
        reply: &mut BatchReply,
        batch: &Batch,
        index: usize,
        placed: Result<VertexId, RefusalReason>,
    ) -> Result<(), EngineError> {
        match placed {
            Ok(vertex) => reply.accept(batch, index, vertex),
            Err(reason) => {
                self.rejected += 1;
                if let Some(line) = batch.lines.get(index) {
                    let (x, y) = batch.positions[index];
                    self.input_errors.add(&format_args!("line {line}, point ({x}, {y}): {reason}"))?;
                }
                reply.refuse(index, &reason);
            }
        }
        Ok(())
    }

    /// Why no batch can be taken now, if that is so.
    fn no_room(&self) -> Option<RefusalReason> {
        let limits = &self.limits;
        if self.pipeline.vertex_count() as u64 >= limits.vertices {
            return Some(RefusalReason::StreamFull { what: "distinct positions", limit: limits.vertices });
        }
        // What consumers take is dropped before points are refused.
        let (held, limit) = (self.memory.points.held(), self.memory.limit);
        self.memory.is_full_of_points().then_some(RefusalReason::DaemonFull { held, limit })
    }

    /// Closes the frame in hand, and publishes it.
    fn close_frame(&mut self, time: Option<f64>) -> Result<(), EngineError> {
        let begun = Instant::now();
        let number = self.pipeline.commit(time.or(self.newest_time));
        let fed = std::mem::take(&mut self.worked) + begun.elapsed();
        let rejected = std::mem::take(&mut self.rejected);
        (self.points, self.pending) = (0, false);
        self.stream.state.stats.set_frame(number);
        let begun = Instant::now();
        let tracks = self.views.publish_tracks(&mut self.pipeline, self.output.is_some());
        let computed = begun.elapsed() + self.views.publish(&mut self.pipeline, rejected);
        tracing::trace!("stream {:?}: frame {number} took {:?}", self.stream.state.name, fed + computed);
        let published = begun.elapsed();
        if self.is_checking {
            self.check()?;
        }
        self.note_times(fed, published);
        self.update_stats();
        self.write_output(rejected, tracks);
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

    /// Hands a frame to the output. While its reader is behind, no points are taken, but consumers are served.
    fn write_output(&mut self, rejected: u64, tracks: Option<Arc<TrackFrame>>) {
        let Some((output, follower)) = &mut self.output else { return };
        let Some(step) = follower.poll(&mut self.pipeline) else { return };
        let diff = convert::diff(self.stream.state.number, output.view, &step, rejected);
        let (is_vital, output) = (output.is_vital, output.clone());
        let mut frame = OutputFrame { diff, tracks };
        loop {
            let resting = self.serve_requests();
            match output.send(frame, &self.wakes, resting, self.stream.end_by()) {
                Sent::Taken => return,
                Sent::NotYet(waiting) => frame = *waiting,
                // The reader has gone; the writer's thread says why.
                Sent::Gone => return (self.is_over, self.output) = (is_vital, None),
                Sent::TooLate => return (self.unread, self.output) = (Some(step.number), None),
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
        self.held.set(vertices * BYTES_OF_A_VERTEX + points * BYTES_OF_A_POINT);
    }
}

/// Replies to a producer; stdin gets no reply.
fn send(reply: BatchReply, origin: &Origin) {
    if let Origin::Producer(reply_to) = origin {
        reply.send(reply_to);
    }
}
