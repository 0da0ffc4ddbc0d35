//! The views of one stream that consumers follow.
//!
//! In: requests of cursors, and each frame that is closed. Out: changes published on each view's [`ViewLog`], snapshots
//! for cursors.
//! Invariants: a view is computed once per frame, however many consumers follow it. A new cursor gets a
//! snapshot of the newest frame and, from there on, every change. A view without cursors is kept for a while, so that
//! consumers that come back can resume.
//! Must not know: where points come from, connections.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use hopes::topology::{Follower, Pipeline, SimplifiedFollower, Step, TrackOptions};
use hopes_protocol as wire;

use super::cursor::{Cursor, Request};
use super::published::PublishedDots;
use super::track_log::TrackFrame;
use super::tracking::Tracking;
use super::view_log::{LogEntry, ViewLog};
use crate::daemon::encoding::encoded;
use crate::daemon::streams::convert;
use crate::daemon::streams::stream_state::StreamState;

/// How long a view without cursors is kept. A consumer that comes back in that time resumes by diffs.
const KEPT: Duration = Duration::from_secs(60);

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
    pub fn poll(&mut self, pipeline: &mut Pipeline) -> Option<Step> {
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
    message: wire::Shared,
}

/// A view that consumers follow.
struct Watched {
    log: Arc<ViewLog>,
    follower: ViewFollower,
    cursors: Vec<Arc<Cursor>>,
    /// Since when it has no cursors.
    idle_since: Option<Instant>,
    /// The newest snapshot, if one was needed.
    snapshot: Option<Snapshot>,
}

impl Watched {
    /// A view without cursors, whose first change will be that of the next frame.
    fn new(view: wire::View, pipeline: &mut Pipeline) -> Self {
        let mut follower = ViewFollower::new(view);
        let newest = follower.poll(pipeline).map_or(0, |step| step.number);
        let log = Arc::new(ViewLog::new(view, newest));
        Self { log, follower, cursors: Vec::new(), idle_since: None, snapshot: None }
    }

    fn add(&mut self, cursor: &Arc<Cursor>) {
        self.idle_since = None;
        self.cursors.push(Arc::clone(cursor));
        cursor.follow(Arc::clone(&self.log));
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

    /// A snapshot of the newest frame, made if there is none for this cause.
    fn snapshot(
        &mut self,
        stream: u32,
        cause: wire::Cause,
        rejected: u64,
        pipeline: &mut Pipeline,
    ) -> Option<Snapshot> {
        if self.snapshot.as_ref().is_none_or(|known| known.cause != cause) {
            let view = self.log.view;
            self.snapshot = ViewFollower::new(view).poll(pipeline).and_then(|step| {
                let message = encoded(convert::snapshot(stream, view, cause, &step, rejected))?;
                Some(Snapshot { frame: step.number, cause, message })
            });
        }
        self.snapshot.clone()
    }
}

/// All views of a stream.
pub struct Views {
    stream: Arc<StreamState>,
    watched: Vec<Watched>,
    /// Cursors in a stream that has no frame yet.
    early: Vec<(Arc<Cursor>, wire::Cause)>,
    /// The newest frame in the view of the last [`Request::SnapshotOnce`].
    once: Option<Arc<wire::Snapshot>>,
    /// Bytes of changes that each log keeps.
    history: usize,
    tracking: Option<Tracking>,
    rejected: u64,
}

impl Views {
    /// No views.
    pub fn new(stream: Arc<StreamState>, history: usize, tracking: Option<TrackOptions>) -> Self {
        let tracking = tracking.map(Tracking::new);
        Self { stream, watched: Vec::new(), early: Vec::new(), once: None, history, tracking, rejected: 0 }
    }

    /// An estimate of the memory that logs take.
    pub fn bytes(&self) -> usize {
        let views: usize = self.watched.iter().map(|watched| watched.log.bytes()).sum();
        views + self.stream.published.tracks().bytes()
    }

    /// The followers of plain views.
    pub fn followers(&self) -> impl Iterator<Item = &Follower> {
        self.watched.iter().filter_map(|watched| watched.follower.plain())
    }

    /// Serves a request of a consumer.
    pub fn serve(&mut self, request: Request, pipeline: &mut Pipeline) {
        match request {
            Request::Join(cursor, view, resume) => self.join(&cursor, view, resume, pipeline),
            Request::ChangeView(cursor, change) => {
                self.remove(&cursor);
                cursor.want_dots(change.dots);
                self.follow(&cursor, change.view, pipeline);
                self.send_snapshot(&cursor, wire::Cause::ViewChanged, pipeline);
            }
            Request::WantTracks(cursor, tracks) => {
                cursor.want_tracks(tracks);
                cursor.wake();
            }
            Request::Snapshot(cursor) => self.send_snapshot(&cursor, wire::Cause::Lagged, pipeline),
            Request::Leave(cursor) => {
                self.remove(&cursor);
                self.stream.stats.consumers.fetch_sub(1, Ordering::Relaxed);
            }
            Request::SnapshotOnce(view, answer) => {
                if let Some(snapshot) = self.snapshot_once(view, pipeline) {
                    // There is room for one. A requester that has given up needs no answer.
                    let _ = answer.try_send(snapshot);
                }
                return;
            }
        }
        self.publish_tracks(pipeline, false);
        self.publish_dots(pipeline);
    }

    /// Publishes what has happened to tracks up to the newest frame, if a consumer or the output wants it and it is not
    /// published yet.
    pub fn publish_tracks(&mut self, pipeline: &mut Pipeline, has_output: bool) -> Option<Arc<TrackFrame>> {
        let tracking = self.tracking.as_mut().filter(|_| pipeline.committed() > 0)?;
        let cursors = self.watched.iter().flat_map(|watched| &watched.cursors);
        let wanted = cursors.map(|cursor| cursor.tracks_wanted()).max().unwrap_or_default();
        if wanted == wire::TracksWanted::No && !has_output {
            return None;
        }
        let with_cycles = wanted == wire::TracksWanted::Cycles;
        let polled = tracking.poll(pipeline, with_cycles);
        let mut log = self.stream.published.tracks();
        let newest = log.newest().cloned();
        let frame = polled.or_else(|| {
            let lacks_cycles = newest.filter(|newest| with_cycles && !newest.has_cycles());
            lacks_cycles.map(|newest| tracking.with_cycles(pipeline, &newest))
        });
        let frame = Arc::new(frame?);
        log.push(Arc::clone(&frame), self.history);
        drop(log);
        self.wake_all();
        Some(frame)
    }

    /// Publishes the newest frame in all views. Returns the time that computing them took, without publishing.
    pub fn publish(&mut self, pipeline: &mut Pipeline, rejected: u64) -> Duration {
        (self.rejected, self.once) = (rejected, None);
        let mut took = Duration::ZERO;
        self.watched.retain(|watched| watched.idle_since.is_none_or(|since| since.elapsed() < KEPT));
        for watched in &mut self.watched {
            watched.snapshot = None;
            let begun = Instant::now();
            let step = watched.follower.poll(pipeline);
            took += begun.elapsed();
            let Some(step) = step else { continue };
            if let Some(entry) = entry(self.stream.number, watched.log.view, step, rejected) {
                watched.log.publish(entry, self.history);
            }
        }
        self.publish_dots(pipeline);
        for (cursor, cause) in std::mem::take(&mut self.early) {
            self.send_snapshot(&cursor, cause, pipeline);
        }
        self.wake_all();
        took
    }

    /// Closes all cursors after the stream's last frame.
    pub fn close(&mut self, pipeline: &mut Pipeline, reason: &str) {
        let cursors: Vec<Arc<Cursor>> = self.watched.iter().flat_map(|watched| watched.cursors.clone()).collect();
        for cursor in cursors {
            if cursor.needs_snapshot() {
                self.send_snapshot(&cursor, wire::Cause::Lagged, pipeline);
            }
            cursor.close(pipeline.committed(), reason);
        }
    }

    fn join(&mut self, cursor: &Arc<Cursor>, view: wire::View, resume: Option<wire::Resume>, pipeline: &mut Pipeline) {
        self.stream.stats.consumers.fetch_add(1, Ordering::Relaxed);
        let log = self.follow(cursor, view, pipeline);
        match resume {
            None => self.send_snapshot(cursor, wire::Cause::Start, pipeline),
            Some(resume) if resume.epoch == self.stream.epoch && log.reaches(resume.frame) => {
                cursor.resume(resume.frame);
            }
            Some(_) => self.send_snapshot(cursor, wire::Cause::CannotResume, pipeline),
        }
    }

    /// Puts a cursor on the log of a view, which is made if there is none.
    fn follow(&mut self, cursor: &Arc<Cursor>, view: wire::View, pipeline: &mut Pipeline) -> Arc<ViewLog> {
        let place = self.watched.iter().position(|watched| watched.log.view == view).unwrap_or_else(|| {
            self.watched.push(Watched::new(view, pipeline));
            self.watched.len() - 1
        });
        let watched = &mut self.watched[place];
        watched.add(cursor);
        Arc::clone(&watched.log)
    }

    fn remove(&mut self, cursor: &Arc<Cursor>) {
        self.early.retain(|(other, _)| !Arc::ptr_eq(other, cursor));
        self.watched.iter_mut().for_each(|watched| watched.remove(cursor));
    }

    /// Gives a cursor the newest frame as a whole; if there is none yet, the first one.
    fn send_snapshot(&mut self, cursor: &Arc<Cursor>, cause: wire::Cause, pipeline: &mut Pipeline) {
        let has_cursor = |watched: &&mut Watched| watched.cursors.iter().any(|other| Arc::ptr_eq(other, cursor));
        let Some(watched) = self.watched.iter_mut().find(has_cursor) else { return };
        if pipeline.committed() == 0 {
            self.early.push((Arc::clone(cursor), cause));
            return;
        }
        if let Some(snapshot) = watched.snapshot(self.stream.number, cause, self.rejected, pipeline) {
            cursor.send_snapshot(snapshot.frame, snapshot.message, cause);
        }
    }

    /// The newest frame without a cursor; none if there is none yet. No view is followed for it.
    fn snapshot_once(&mut self, view: wire::View, pipeline: &mut Pipeline) -> Option<Arc<wire::Snapshot>> {
        if let Some(known) = self.once.as_ref().filter(|known| known.frame.view == view) {
            return Some(Arc::clone(known));
        }
        let step = ViewFollower::new(view).poll(pipeline)?;
        let snapshot = convert::snapshot(self.stream.number, view, wire::Cause::Start, &step, self.rejected);
        self.once = Some(Arc::new(snapshot));
        self.once.clone()
    }

    /// Publishes as many dots as any consumer wants.
    fn publish_dots(&mut self, pipeline: &mut Pipeline) {
        let cursors = self.watched.iter().flat_map(|watched| &watched.cursors);
        let most = cursors.map(|cursor| cursor.dots_wanted()).max().unwrap_or(0);
        let published = &self.stream.published;
        if most == 0 || pipeline.committed() == 0 {
            return published.set_dots(None);
        }
        if published.dots().is_some_and(|dots| dots.frame == pipeline.committed() && dots.has_top(most)) {
            return;
        }
        published.set_dots(Some(PublishedDots::new(&pipeline.poll_dots(most))));
        self.wake_all();
    }

    fn wake_all(&self) {
        self.watched.iter().for_each(Watched::wake_all);
    }
}

fn entry(stream: u32, view: wire::View, step: Step, rejected: u64) -> Option<LogEntry> {
    let message = convert::diff(stream, view, &step, rejected);
    let (from, info, checksum) = (message.from, message.frame.clone(), message.checksum);
    let message = encoded(message)?;
    Some(LogEntry { from, info, diff: step.diff, checksum, message })
}
