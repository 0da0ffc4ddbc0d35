//! The views of one stream that consumers follow.
//!
//! In: requests of cursors, and each frame that is closed. Out: changes published on each view's [`ViewLog`], snapshots
//! for cursors.
//! Invariants: a view is computed once per frame, however many consumers follow it. A new cursor gets a
//! snapshot of the newest frame and, from there on, every change. A view without cursors is kept for a while, so that
//! consumers that come back can resume.
//! Views are bounded, those without cursors to a few. When memory is short, those without cursors and all history go.
//! Must not know: where points come from, connections.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use hopes::topology::{Follower, SimplifiedFollower, Step, TrackOptions};
use hopes_protocol as wire;

use super::any_tracks::AnyTrackFrame;
use super::cursor::{Cursor, Start};
use super::published::PublishedDots;
use super::tracking::Tracking;
use super::view_log::{LogEntry, ViewLog};
use crate::daemon::encoding::{Encoded, encoded};
use crate::daemon::memory::{Charged, Memory};
use crate::daemon::report::report;
use crate::daemon::settings::Limits;
use crate::daemon::streams::consumer::SnapshotPlace;
use crate::daemon::streams::convert;
use crate::daemon::streams::pipeline::AnyPipeline;
use crate::daemon::streams::requests::{Request, Wishes};
use crate::daemon::streams::stream_state::StreamState;

/// How long a view without cursors is kept. A consumer that comes back in that time resumes by diffs.
const KEPT: Duration = Duration::from_secs(60);

/// Views without cursors that are kept at the most: each is computed in every frame.
const MOST_IDLE: usize = 8;

/// An estimate of the bytes that a vertex takes in a snapshot, with its edges, before and after it is encoded; without
/// its coordinates beyond the second.
const SNAPSHOT_BYTES_OF_A_VERTEX: u64 = 100;

/// What a consumer is told for which there is no room.
const NO_MEMORY: &str = "the daemon is at its limit of memory: come back later, or allow more by --max-memory";

/// Follows one view of a pipeline, frame by frame.
#[derive(Debug)]
pub enum ViewFollower {
    /// A part of the skeleton.
    Plain(Follower),
    /// Such a part, simplified.
    Simplified(Box<SimplifiedFollower>),
}

impl ViewFollower {
    /// Follows a view that [`convert::check_view`] has let pass.
    pub fn new(view: wire::View) -> Self {
        let spec = convert::spec(view.cut).unwrap_or_default();
        let simplified = |threshold| Self::Simplified(Box::new(SimplifiedFollower::new(spec, threshold)));
        match view.simplify {
            wire::Simplify::No => Self::Plain(Follower::new(spec)),
            wire::Simplify::AtScale => simplified(None),
            wire::Simplify::Below(threshold) => simplified(Some(threshold)),
        }
    }

    /// What has changed since the last poll, if there is a new frame.
    pub fn poll(&mut self, pipeline: &mut AnyPipeline) -> Option<Step> {
        match self {
            Self::Plain(follower) => pipeline.poll_step(follower),
            Self::Simplified(follower) => pipeline.poll_simplified(follower),
        }
    }

    /// The follower of a plain view.
    pub fn plain(&self) -> Option<&Follower> {
        match self {
            Self::Plain(follower) => Some(follower),
            Self::Simplified(_) => None,
        }
    }
}

/// The newest frame of a view as a whole, encoded.
#[derive(Clone)]
struct Snapshot {
    frame: u64,
    cause: wire::Cause,
    message: Encoded,
}

/// A view that consumers follow.
struct Watched {
    log: Arc<ViewLog>,
    follower: ViewFollower,
    cursors: Vec<Arc<Cursor>>,
    /// Since when it has no cursors.
    idle_since: Option<Instant>,
    /// Snapshots of the newest frame, one for each cause for which one was needed.
    snapshots: Vec<Snapshot>,
}

impl Watched {
    /// A view without cursors, whose first change will be that of the next frame.
    fn new(view: wire::View, pipeline: &mut AnyPipeline) -> Self {
        let mut follower = ViewFollower::new(view);
        let newest = follower.poll(pipeline).map_or(0, |step| step.number);
        let log = Arc::new(ViewLog::new(view, newest));
        Self { log, follower, cursors: Vec::new(), idle_since: None, snapshots: Vec::new() }
    }

    fn add(&mut self, cursor: &Arc<Cursor>, start: Start) {
        self.idle_since = None;
        self.cursors.push(Arc::clone(cursor));
        cursor.follow(Arc::clone(&self.log), start);
    }

    fn remove(&mut self, cursor: &Arc<Cursor>) {
        self.cursors.retain(|other| !Arc::ptr_eq(other, cursor));
        if self.cursors.is_empty() && self.idle_since.is_none() {
            self.idle_since = Some(Instant::now());
        }
    }

    fn wake_all(&self) {
        self.cursors.iter().for_each(|cursor| cursor.wake());
    }

    fn has(&self, cursor: &Arc<Cursor>) -> bool {
        self.cursors.iter().any(|other| Arc::ptr_eq(other, cursor))
    }

    fn known_snapshot(&self, cause: wire::Cause) -> Option<Snapshot> {
        self.snapshots.iter().find(|known| known.cause == cause).cloned()
    }

    /// A snapshot of the newest frame, made if there is none for this cause.
    fn snapshot(
        &mut self,
        stream: &StreamState,
        cause: wire::Cause,
        rejected: u64,
        pipeline: &mut AnyPipeline,
    ) -> Option<Snapshot> {
        let known = self.known_snapshot(cause);
        known.or_else(|| {
            let view = self.log.view;
            let step = ViewFollower::new(view).poll(pipeline)?;
            let frame = convert::frame_info(view, &step, rejected);
            let snapshot = convert::snapshot((stream.number, stream.shape()), cause, frame, &step);
            let message = encoded(snapshot, &stream.accounts.views)?;
            self.snapshots.push(Snapshot { frame: step.number, cause, message });
            self.snapshots.last().cloned()
        })
    }
}

/// All views of a stream.
pub struct Views {
    stream: Arc<StreamState>,
    memory: Arc<Memory>,
    watched: Vec<Watched>,
    /// Cursors in a stream that has no frame yet.
    early: Vec<Arc<Cursor>>,
    /// The newest frame in the view of the last [`Request::SnapshotOnce`].
    once: Option<Arc<Charged<wire::Message>>>,
    /// Views at the most.
    most: usize,
    /// Bytes of changes that each log keeps.
    history: usize,
    tracking: Option<Tracking>,
    rejected: u64,
}

impl Views {
    /// No views. There will be `limits.views` at the most, each with a history of `limits.history` bytes.
    pub fn new(stream: Arc<StreamState>, memory: Arc<Memory>, limits: &Limits, tracking: Option<TrackOptions>) -> Self {
        let tracking =
            tracking.map(|options| Tracking::new(options, stream.space.is_some(), Arc::clone(&stream.accounts.views)));
        let (most, history) = (limits.views.get(), limits.history);
        let (watched, early, once, rejected) = (Vec::new(), Vec::new(), None, 0);
        Self { stream, memory, watched, early, once, most, history, tracking, rejected }
    }

    /// Bytes of changes that each log keeps by now.
    fn history(&self) -> usize {
        if self.memory.is_short() { 0 } else { self.history }
    }

    /// Drops what can be made again: views without cursors, history, snapshots that nobody waits for.
    pub fn relieve(&mut self) {
        self.watched.retain(|watched| watched.idle_since.is_none());
        for watched in &mut self.watched {
            watched.snapshots.clear();
            watched.log.shrink(0);
        }
        self.stream.published.tracks().shrink(0);
        self.once = None;
    }

    /// The followers of plain views.
    pub fn followers(&self) -> impl Iterator<Item = &Follower> {
        self.watched.iter().filter_map(|watched| watched.follower.plain())
    }

    /// Serves a request of a consumer.
    pub fn serve(&mut self, request: Request<Cursor>, pipeline: &mut AnyPipeline) {
        match request {
            Request::Cursor(wishes) => self.serve_cursor(wishes, pipeline),
            Request::SnapshotOnce(view, answer) => {
                if let Some(snapshot) = self.snapshot_once(view, pipeline) {
                    // There is room for one. A requester that has given up needs no answer.
                    let _ = answer.try_send(snapshot);
                }
            }
            Request::Probe(answer) => {
                let _ = answer.try_send(());
            }
        }
    }

    fn serve_cursor(&mut self, wishes: Wishes<Cursor>, pipeline: &mut AnyPipeline) {
        let Wishes { cursor, join, view: change, tracks, snapshot, leave } = wishes;
        if leave {
            self.remove(&cursor);
            self.stream.stats.consumers.fetch_sub(1, Ordering::Relaxed);
            return;
        }
        match (join, change) {
            (Some((view, resume)), None) => self.join(&cursor, view, resume, pipeline),
            (Some((view, resume)), Some(change)) => {
                cursor.want_dots(change.dots);
                self.join(&cursor, change.view, resume.filter(|_| change.view == view), pipeline);
            }
            (None, Some(change)) => self.change_view(&cursor, change, pipeline),
            (None, None) => {}
        }
        if let Some(tracks) = tracks {
            cursor.want_tracks(tracks);
            cursor.wake();
        }
        if snapshot {
            self.send_awaited(&cursor, pipeline);
        }
        self.publish_tracks(pipeline, false);
        self.publish_dots(pipeline);
    }

    /// Publishes what has happened to tracks up to the newest frame, if a consumer or the output wants it and it is not
    /// published yet.
    pub fn publish_tracks(&mut self, pipeline: &mut AnyPipeline, has_output: bool) -> Option<AnyTrackFrame> {
        let history = self.history();
        let tracking = self.tracking.as_mut().filter(|_| pipeline.committed() > 0)?;
        let cursors = self.watched.iter().flat_map(|watched| &watched.cursors);
        let wanted = cursors.map(|cursor| cursor.tracks_wanted()).max().unwrap_or_default();
        if wanted == wire::TracksWanted::No && !has_output {
            return None;
        }
        let with_cycles = wanted == wire::TracksWanted::Cycles;
        let polled = tracking.poll(pipeline, with_cycles);
        let mut log = self.stream.published.tracks();
        let newest = log.newest().filter(|_| with_cycles);
        let frame = polled.or_else(|| tracking.with_cycles(pipeline, newest?))?;
        log.push(&frame, history);
        drop(log);
        self.wake_all();
        Some(frame)
    }

    /// Publishes the newest frame in all views.
    pub fn publish(&mut self, pipeline: &mut AnyPipeline, rejected: u64) {
        (self.rejected, self.once) = (rejected, None);
        let history = self.history();
        self.watched.retain(|watched| watched.idle_since.is_none_or(|since| since.elapsed() < KEPT));
        for watched in &mut self.watched {
            watched.snapshots.clear();
            let Some(step) = watched.follower.poll(pipeline) else { continue };
            if let Some(entry) = entry(&self.stream, watched.log.view, step, rejected) {
                watched.log.publish(entry, history);
            }
        }
        self.publish_dots(pipeline);
        for cursor in std::mem::take(&mut self.early) {
            self.send_awaited(&cursor, pipeline);
        }
        self.wake_all();
    }

    /// Closes all cursors after the stream's last frame.
    pub fn close(&mut self, pipeline: &mut AnyPipeline, reason: &str) {
        let cursors: Vec<Arc<Cursor>> = self.watched.iter().flat_map(|watched| watched.cursors.clone()).collect();
        for cursor in cursors {
            if cursor.needs_snapshot() && pipeline.committed() > 0 {
                self.send_snapshot(&cursor, None, pipeline);
            }
            cursor.close(pipeline.committed(), reason);
        }
    }

    fn join(
        &mut self,
        cursor: &Arc<Cursor>,
        view: wire::View,
        resume: Option<wire::Resume>,
        pipeline: &mut AnyPipeline,
    ) {
        self.stream.stats.consumers.fetch_add(1, Ordering::Relaxed);
        if !self.has_room_for(view, None) {
            return self.refuse(cursor, wire::ErrorCode::TooManyViews, &self.too_many_views());
        }
        // The first follower has the newest frame computed.
        if !self.makes_room_for_snapshot(pipeline) {
            return self.refuse(cursor, wire::ErrorCode::NoMemory, NO_MEMORY);
        }
        let epoch = self.stream.epoch;
        let watched = self.watch(view, pipeline);
        let start = match resume {
            None => Start::Snapshot(wire::Cause::Start),
            Some(resume) if resume.epoch == epoch && watched.log.reaches(resume.frame) => Start::After(resume.frame),
            Some(_) => Start::Snapshot(wire::Cause::CannotResume),
        };
        watched.add(cursor, start);
    }

    /// A view that the cursor has left, and nobody else follows, is not kept: it was left on purpose.
    fn change_view(&mut self, cursor: &Arc<Cursor>, change: wire::ChangeView, pipeline: &mut AnyPipeline) {
        /// The type of the message that asks for it.
        const CHANGE_VIEW: u16 = 0x0202;
        if !self.has_room_for(change.view, Some(cursor)) {
            return cursor.notify(report(wire::ErrorCode::TooManyViews, CHANGE_VIEW, self.too_many_views()));
        }
        self.watched.retain_mut(|watched| {
            let had = watched.has(cursor);
            watched.remove(cursor);
            !had || watched.log.view == change.view || !watched.cursors.is_empty()
        });
        cursor.want_dots(change.dots);
        self.watch(change.view, pipeline).add(cursor, Start::Snapshot(wire::Cause::ViewChanged));
    }

    /// Whether a view can be followed: by a cursor that leaves its own for it, or by another one.
    fn has_room_for(&self, view: wire::View, leaving: Option<&Arc<Cursor>>) -> bool {
        let may_go = |watched: &Watched| {
            watched.cursors.is_empty()
                || leaving.is_some_and(|cursor| watched.cursors.len() == 1 && watched.has(cursor))
        };
        self.watched.len() < self.most || self.watched.iter().any(|watched| watched.log.view == view || may_go(watched))
    }

    fn too_many_views(&self) -> String {
        let (most, name) = (self.most, &self.stream.name);
        format!(
            "stream {name:?} is followed in {most} different views, and in no more: take one of these, or allow more"
        )
    }

    /// Ends a cursor that cannot be served.
    fn refuse(&self, cursor: &Arc<Cursor>, code: wire::ErrorCode, text: &str) {
        /// The type of the message that asks for a cursor.
        const SUBSCRIBE: u16 = 0x0201;
        cursor.notify(report(code, SUBSCRIBE, text));
        cursor.close(self.stream.stats.frame(), text);
    }

    /// A view that is watched; from now on, if it was not. There must be room for it.
    fn watch(&mut self, view: wire::View, pipeline: &mut AnyPipeline) -> &mut Watched {
        let place = self.watched.iter().position(|watched| watched.log.view == view).unwrap_or_else(|| {
            if self.watched.len() >= self.most {
                self.drop_idle(self.idle_count().saturating_sub(1));
            }
            self.watched.push(Watched::new(view, pipeline));
            self.watched.len() - 1
        });
        &mut self.watched[place]
    }

    fn remove(&mut self, cursor: &Arc<Cursor>) {
        self.early.retain(|other| !Arc::ptr_eq(other, cursor));
        self.watched.iter_mut().for_each(|watched| watched.remove(cursor));
        self.drop_idle(if self.memory.is_short() { 0 } else { MOST_IDLE });
    }

    fn idle_count(&self) -> usize {
        self.watched.iter().filter(|watched| watched.idle_since.is_some()).count()
    }

    /// Keeps so many views without cursors, those that had some last.
    fn drop_idle(&mut self, kept: usize) {
        let mut since: Vec<Instant> = self.watched.iter().filter_map(|watched| watched.idle_since).collect();
        since.sort_unstable();
        let Some(place) = since.len().checked_sub(kept + 1) else { return };
        let newest_dropped = since[place];
        self.watched.retain(|watched| watched.idle_since.is_none_or(|since| since > newest_dropped));
    }

    /// Gives a cursor the snapshot that it awaits; if there is no frame yet, the first one. A peer gets one at a time.
    fn send_awaited(&mut self, cursor: &Arc<Cursor>, pipeline: &mut AnyPipeline) {
        if pipeline.committed() == 0 {
            self.early.push(Arc::clone(cursor));
            return;
        }
        match cursor.consumer.snapshot_place() {
            Some(place) => self.send_snapshot(cursor, Some(place), pipeline),
            None => cursor.defer_snapshot(),
        }
    }

    fn send_snapshot(&mut self, cursor: &Arc<Cursor>, place: Option<SnapshotPlace>, pipeline: &mut AnyPipeline) {
        let Some(cause) = cursor.awaited() else { return };
        let Some(of_cursor) = self.watched.iter().position(|watched| watched.has(cursor)) else { return };
        let is_known = self.watched[of_cursor].known_snapshot(cause).is_some();
        if !is_known && !self.makes_room_for_snapshot(pipeline) {
            return self.refuse(cursor, wire::ErrorCode::NoMemory, NO_MEMORY);
        }
        // Views without cursors may have gone to make room.
        let Some(watched) = self.watched.iter_mut().find(|watched| watched.has(cursor)) else { return };
        if let Some(snapshot) = watched.snapshot(&self.stream, cause, self.rejected, pipeline) {
            cursor.send_snapshot(snapshot.frame, snapshot.message, place);
        }
    }

    /// Whether there is room for another snapshot, and for computing its frame, if need be without what can be made
    /// again.
    fn makes_room_for_snapshot(&mut self, pipeline: &AnyPipeline) -> bool {
        let of_coordinates = 2 * size_of::<f64>() as u64 * u64::from(self.stream.shape().dimension().saturating_sub(2));
        let of_snapshot = pipeline.vertex_count() as u64 * (SNAPSHOT_BYTES_OF_A_VERTEX + of_coordinates);
        let needed = of_snapshot + pipeline.bytes_to_compute() as u64;
        if self.memory.has_no_room_for(needed) {
            self.relieve();
        }
        !self.memory.has_no_room_for(needed)
    }

    /// The newest frame without a cursor; none if there is none yet, or no room for it. No view is followed for it.
    fn snapshot_once(&mut self, view: wire::View, pipeline: &mut AnyPipeline) -> Option<Arc<Charged<wire::Message>>> {
        let is_of_view = |known: &wire::Message| known.frame().is_some_and(|frame| frame.view == view);
        if let Some(known) = self.once.as_ref().filter(|known| is_of_view(known)) {
            return Some(Arc::clone(known));
        }
        self.once = None;
        if !self.makes_room_for_snapshot(pipeline) {
            return None;
        }
        let step = ViewFollower::new(view).poll(pipeline)?;
        let (frame, shape) = (convert::frame_info(view, &step, self.rejected), self.stream.shape());
        let bytes = convert::snapshot_size(&frame, shape) as usize;
        let snapshot = convert::snapshot((self.stream.number, shape), wire::Cause::Start, frame, &step);
        self.once = Some(Arc::new(Charged::new(snapshot, bytes, &self.stream.accounts.views)));
        self.once.clone()
    }

    /// Publishes as many dots as any consumer wants.
    fn publish_dots(&mut self, pipeline: &mut AnyPipeline) {
        let cursors = self.watched.iter().flat_map(|watched| &watched.cursors);
        let most = cursors.map(|cursor| cursor.dots_wanted()).max().unwrap_or(0);
        let published = &self.stream.published;
        if most == 0 || pipeline.committed() == 0 {
            return published.set_dots(None);
        }
        if published.dots().is_some_and(|dots| dots.frame == pipeline.committed() && dots.has_top(most)) {
            return;
        }
        let (shape, ranking) = (self.stream.shape(), pipeline.poll_dots(most));
        published.set_dots(Some(PublishedDots::new(shape, &ranking, &self.stream.accounts.views)));
        self.wake_all();
    }

    fn wake_all(&self) {
        self.watched.iter().for_each(Watched::wake_all);
    }
}

fn entry(stream: &StreamState, view: wire::View, step: Step, rejected: u64) -> Option<LogEntry> {
    let (info, from, checksum) = (convert::frame_info(view, &step, rejected), step.from, step.checksum.0);
    let message = convert::diff((stream.number, stream.shape()), from, info.clone(), &step.diff, checksum);
    let account = &stream.accounts.views;
    let message = encoded(message, account)?;
    Some(LogEntry::new(from, info, step.diff, checksum, message, account))
}
