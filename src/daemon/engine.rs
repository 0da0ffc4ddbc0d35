//! The engine thread: one stream's pipeline, driven by what comes in and by what consumers ask.
//!
//! In: items of the [`Inbox`](super::inbox::Inbox), ticks, and [`Control`]s of seats. Out: answers to producers, each view's changes on its board, diffs on the tap. Invariants: nothing is computed while nobody
//! looks; a frame is computed once, when it is closed, for everybody; every frame of a view starts from the one before; what is refused is counted in the frame that it was
//! meant for; consumers are never waited for, only the tap is. Must not know: parsing, sockets.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender, never, select, tick};
use hopes::topology::{Contradiction, Follower, Pipeline, VertexId, ViewSpec, Window};
use hopes_protocol as wire;

use super::answer::{Answer, Problem};
use super::inbox::{Batch, Input, Item, Origin};
use super::input_errors::InputErrors;
use super::seat::Control;
use super::streams::{ENDED, Hub, Stream, lock};
use super::tracks::TrackFrame;
use super::views::{Eye, Views};
use super::{DaemonError, StreamSettings, convert};

/// What holds a vertex takes about so many bytes: triangulation, tiles, views (measured at a million points).
const BYTES_OF_A_VERTEX: u64 = 900;

/// What holds a point of the window takes about so many bytes.
const BYTES_OF_A_POINT: u64 = 40;

/// What is told of a frame there.
#[derive(Debug)]
pub struct OutputFrame {
    /// What has changed in the view.
    pub diff: wire::Diff,
    /// What has happened to tracks, if they are followed.
    pub tracks: Option<Arc<TrackFrame>>,
}

/// Where a stream's frames go besides its consumers; whoever reads there is waited for.
#[derive(Debug)]
pub struct Tap {
    /// What it shows.
    pub view: wire::View,
    /// Takes frames.
    pub frames: Sender<OutputFrame>,
    /// Whether the stream ends when nobody takes them any more.
    pub is_vital: bool,
}

/// What feeds a stream besides its producers, and where its frames go besides its consumers.
#[derive(Debug, Default)]
pub struct Sources {
    /// Counts what stdin said that could not be used.
    pub input_errors: InputErrors,
    /// Where all frames go.
    pub tap: Option<Tap>,
}

/// A stream at work.
pub struct Engine {
    hub: Arc<Hub>,
    stream: Arc<Stream>,
    settings: StreamSettings,
    is_checking: bool,
    pipeline: Pipeline,
    input_errors: InputErrors,
    views: Views,
    tap: Option<(Tap, Eye)>,
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
    pub fn new(
        hub: Arc<Hub>,
        stream: Arc<Stream>,
        settings: StreamSettings,
        is_checking: bool,
        sources: Sources,
    ) -> Self {
        let views = Views::new(Arc::clone(&stream), hub.limits.history, hub.tracking);
        Self {
            pipeline: Pipeline::new(settings.options),
            input_errors: sources.input_errors,
            tap: sources.tap.map(|tap| {
                let eye = Eye::new(tap.view);
                (tap, eye)
            }),
            hub,
            stream,
            settings,
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

    /// Works until nothing more can come, a producer ends the stream, or the tap's reader is gone.
    pub fn run(mut self, bell: &Receiver<()>, requests: &Receiver<Control>) -> Result<(), DaemonError> {
        let ticks = self.settings.frame_every.map_or_else(never, tick);
        let worked = self.work(bell, requests, &ticks);
        self.stream.inbox.close();
        self.input_errors.sum_up();
        worked?;
        requests.try_iter().for_each(|control| self.serve(control));
        let reason = if self.is_over { "a producer has ended the stream" } else { ENDED };
        self.views.close(&mut self.pipeline, reason);
        for channel in lock(&self.stream.producers).drain(..).filter_map(|channel| channel.upgrade()) {
            channel.close(self.pipeline.committed());
        }
        tracing::debug!("stream {:?} ended at frame {}", self.stream.name, self.pipeline.committed());
        Ok(())
    }

    fn work(
        &mut self,
        bell: &Receiver<()>,
        requests: &Receiver<Control>,
        ticks: &Receiver<Instant>,
    ) -> Result<(), DaemonError> {
        while !self.is_over {
            // Whoever asks is not kept waiting by those who feed.
            while let Ok(control) = requests.try_recv() {
                self.serve(control);
            }
            if ticks.try_recv().is_ok() {
                self.close_frame(None)?;
            }
            match self.stream.inbox.pop() {
                Some(item) => self.take(item)?,
                None if self.stream.inbox.is_finished() => return self.close_last_frame(),
                None => select! {
                    recv(bell) -> _ => {}
                    recv(requests) -> control => if let Ok(control) = control { self.serve(control) },
                    recv(ticks) -> _ => self.close_frame(None)?,
                },
            }
        }
        Ok(())
    }

    /// What came after the last commit is a frame too; so is nothing at all, for those who only read the tap.
    fn close_last_frame(&mut self) -> Result<(), DaemonError> {
        let is_first = self.pipeline.committed() == 0 && self.tap.is_some();
        if self.pending || is_first { self.close_frame(None) } else { Ok(()) }
    }

    fn serve(&mut self, control: Control) {
        self.views.serve(control, &mut self.pipeline);
        self.tell();
    }

    fn take(&mut self, item: Item) -> Result<(), DaemonError> {
        let Item { input, origin } = item;
        match input {
            Input::Points(batch) => self.insert(&batch, &origin)?,
            Input::Retract(batch) => self.retract(&batch, &origin)?,
            Input::Commit(time) => {
                if let Some(Err(refusal)) = time.map(|time| self.pipeline.feed_time(time)) {
                    self.rejected += 1;
                    if matches!(origin, Origin::Stdin) {
                        self.input_errors.add(&refusal)?;
                    }
                }
                self.close_frame(time.filter(|time| time.is_finite()))?;
                if let Origin::Peer { channel, sequence, .. } = &origin {
                    channel.answer(wire::Committed { sequence: *sequence, frame: self.pipeline.committed() });
                }
            }
            Input::Close { end } => {
                // What stdin has said last is a frame, as it always was.
                if matches!(origin, Origin::Stdin) && self.pending {
                    self.close_frame(None)?;
                }
                if end {
                    self.close_last_frame()?;
                    // Whoever is told that it is over must not find it open still, nor in the way of another.
                    self.stream.inbox.close();
                    self.hub.forget(&self.stream);
                    self.is_over = true;
                }
                if let Origin::Peer { channel, .. } = &origin {
                    lock(&self.stream.producers).retain(|other| !std::ptr::eq(other.as_ptr(), Arc::as_ptr(channel)));
                    channel.close(self.pipeline.committed());
                }
            }
            Input::Unreadable(error) => {
                (self.pending, self.rejected) = (true, self.rejected + 1);
                self.input_errors.add(&error)?;
            }
            Input::Failed(reason) => return Err(DaemonError::Source(reason)),
        }
        Ok(())
    }

    fn insert(&mut self, batch: &Batch, origin: &Origin) -> Result<(), DaemonError> {
        let mut answer = Answer::new(batch);
        let no_room = self.no_room();
        let mut begun = Instant::now();
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            self.pending = true;
            let time = batch.times.get(index).copied();
            let placed = match &no_room {
                Some(full) => Err(full.clone()),
                None => self.insert_one(x, y, time),
            };
            self.note(&mut answer, batch, index, placed)?;
            if self.settings.frame_points.is_some_and(|limit| self.points >= limit) {
                self.worked += begun.elapsed();
                self.close_frame(None)?;
                begun = Instant::now();
            }
        }
        self.worked += begun.elapsed();
        self.tell();
        self.stream.stats.accepted.fetch_add(answer.accepted(), Ordering::Relaxed);
        self.stream.stats.refused.fetch_add(answer.refused(), Ordering::Relaxed);
        answer.send(origin);
        Ok(())
    }

    fn insert_one(&mut self, x: f64, y: f64, time: Option<f64>) -> Result<VertexId, Problem> {
        let limit = self.hub.limits.points;
        // In a window of so many points the oldest leaves when one comes.
        let makes_room = matches!(self.settings.options.window, Window::Points(length) if length.get() <= limit);
        if self.pipeline.point_count() >= limit && !makes_room {
            return Err(Problem::StreamFull { what: "points", limit });
        }
        let vertex = self.pipeline.feed_point(x, y, time).map_err(Problem::Refused)?;
        self.points += 1;
        self.newest_time = time.into_iter().chain(self.newest_time).reduce(f64::max);
        Ok(vertex)
    }

    fn retract(&mut self, batch: &Batch, origin: &Origin) -> Result<(), DaemonError> {
        self.pending = true;
        let mut answer = Answer::new(batch);
        for (index, &(x, y)) in batch.positions.iter().enumerate() {
            let retracted = self.pipeline.feed_retraction(x, y).map(|()| VertexId(0)).map_err(Problem::Refused);
            self.note(&mut answer, batch, index, retracted)?;
        }
        self.tell();
        self.stream.stats.refused.fetch_add(answer.refused(), Ordering::Relaxed);
        answer.send(origin);
        Ok(())
    }

    /// Counts what became of a point.
    fn note(
        &mut self,
        answer: &mut Answer,
        batch: &Batch,
        index: usize,
        placed: Result<VertexId, Problem>,
    ) -> Result<(), DaemonError> {
        match placed {
            Ok(vertex) => answer.accept(batch, index, vertex),
            Err(problem) => {
                self.rejected += 1;
                if let Some(line) = batch.lines.get(index) {
                    let (x, y) = batch.positions[index];
                    self.input_errors.add(&format_args!("line {line}, point ({x}, {y}): {problem}"))?;
                }
                answer.refuse(index, &problem);
            }
        }
        Ok(())
    }

    /// Why no batch can be taken now, if that is so.
    fn no_room(&self) -> Option<Problem> {
        let limits = &self.hub.limits;
        if self.pipeline.vertex_count() as u64 >= limits.vertices {
            return Some(Problem::StreamFull { what: "distinct positions", limit: limits.vertices });
        }
        if limits.memory == 0 {
            return None;
        }
        let held = self.hub.memory();
        (held >= limits.memory).then_some(Problem::DaemonFull { held, limit: limits.memory })
    }

    /// Closes the frame in hand, and tells everybody who looks.
    fn close_frame(&mut self, time: Option<f64>) -> Result<(), DaemonError> {
        let begun = Instant::now();
        let number = self.pipeline.commit(time.or(self.newest_time));
        let worked = std::mem::take(&mut self.worked) + begun.elapsed();
        let rejected = std::mem::take(&mut self.rejected);
        (self.points, self.pending) = (0, false);
        self.stream.stats.set_frame(number);
        let begun = Instant::now();
        let tracks = self.views.track(&mut self.pipeline, self.tap.is_some());
        let worked = worked + begun.elapsed() + self.views.publish(&mut self.pipeline, rejected);
        tracing::trace!("stream {:?}: frame {number} took {worked:?}", self.stream.name);
        self.feed_tap(rejected, tracks);
        if self.is_checking {
            self.check()?;
        }
        self.tell();
        Ok(())
    }

    /// Waits while the reader of the tap is behind.
    fn feed_tap(&mut self, rejected: u64, tracks: Option<Arc<TrackFrame>>) {
        let Some((tap, eye)) = &mut self.tap else { return };
        let Some(step) = eye.look(&mut self.pipeline) else { return };
        let diff = convert::diff(self.stream.number, tap.view, &step, rejected);
        if tap.frames.send(OutputFrame { diff, tracks }).is_err() {
            // Its reader has gone: for the writer to say why.
            (self.is_over, self.tap) = (tap.is_vital, None);
        }
    }

    fn check(&mut self) -> Result<(), Contradiction> {
        let tapped = self.tap.iter().filter_map(|(_, eye)| eye.follower());
        let mut followers: Vec<&Follower> = tapped.chain(self.views.followers()).collect();
        let whole = Follower::new(ViewSpec::Full);
        if followers.is_empty() {
            followers.push(&whole);
        }
        followers.into_iter().try_for_each(|follower| self.pipeline.check(follower))
    }

    /// Keeps the stream's numbers up to date.
    fn tell(&self) {
        let (stats, pipeline) = (&self.stream.stats, &self.pipeline);
        let (points, vertices) = (pipeline.point_count(), pipeline.vertex_count() as u64);
        stats.points.store(points, Ordering::Relaxed);
        stats.vertices.store(vertices, Ordering::Relaxed);
        stats.computed.store(pipeline.computed(), Ordering::Relaxed);
        let held = vertices * BYTES_OF_A_VERTEX + points * BYTES_OF_A_POINT + self.views.bytes() as u64;
        stats.memory.store(held, Ordering::Relaxed);
    }
}
