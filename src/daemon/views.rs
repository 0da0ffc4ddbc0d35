//! The views of one stream that somebody looks at.
//!
//! In: what seats ask, and each frame that is closed. Out: changes published on each view's [`Group`], snapshots handed to seats. Invariants: a view is computed once a frame, however many
//! look at it; a seat that comes gets a snapshot of the newest frame and, from there on, every change; a view that nobody looks at any more is kept for a while, for those
//! who come back. Must not know: where points come from.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use hopes::topology::{Follower, Pipeline, SimplifiedFollower, Step, TrackOptions};
use hopes_protocol as wire;

use super::board::{Entry, Group, Ranked};
use super::convert::{self, encoded};
use super::seat::{Control, Seat};
use super::streams::Stream;
use super::tracks::{TrackFrame, Tracking};

/// How long a view is kept that nobody looks at: so long a consumer may be away and still resume by diffs.
const KEPT: Duration = Duration::from_secs(60);

/// Looks at one view, frame by frame.
#[derive(Debug)]
pub enum Eye {
    /// At a part of the skeleton.
    Plain(Follower),
    /// At such a part, simplified.
    Simplified(Box<SimplifiedFollower>),
}

impl Eye {
    /// At a view that was checked.
    pub fn new(view: wire::View) -> Self {
        // Whoever asked for something else was refused: see `convert::check_view`.
        let spec = convert::spec(view.cut).unwrap_or_default();
        let simplified = |threshold| Self::Simplified(Box::new(SimplifiedFollower::new(spec, threshold)));
        match view.simplify {
            wire::Simplify::No => Self::Plain(Follower::new(spec)),
            wire::Simplify::AtScale => simplified(None),
            wire::Simplify::Below(threshold) => simplified(Some(threshold)),
        }
    }

    /// What has changed since it looked last, if there is a new frame.
    pub fn look(&mut self, pipeline: &mut Pipeline) -> Option<Step> {
        match self {
            Self::Plain(follower) => pipeline.poll_step(follower),
            Self::Simplified(follower) => pipeline.poll_simplified(follower),
        }
    }

    /// What follows a plain view.
    pub fn follower(&self) -> Option<&Follower> {
        match self {
            Self::Plain(follower) => Some(follower),
            Self::Simplified(_) => None,
        }
    }
}

/// A view that somebody looks at.
struct Watched {
    group: Arc<Group>,
    eye: Eye,
    /// Since when nobody does.
    idle_since: Option<Instant>,
    /// The newest frame as a whole, if somebody needed it, and why.
    snapshot: Option<(u64, wire::Cause, wire::Shared)>,
}

/// All of them.
pub struct Views {
    stream: Arc<Stream>,
    watched: Vec<Watched>,
    /// Seats before a stream that has no frame yet.
    early: Vec<(Arc<Seat>, wire::Cause)>,
    /// The newest frame in the view in which it was asked for last.
    snapshot_once: Option<Arc<wire::Snapshot>>,
    /// How many bytes of changes each view keeps.
    history: usize,
    tracking: Option<Tracking>,
    rejected: u64,
}

impl Views {
    /// Nobody looks yet.
    pub fn new(stream: Arc<Stream>, history: usize, tracking: Option<TrackOptions>) -> Self {
        let tracking = tracking.map(Tracking::new);
        Self { stream, watched: Vec::new(), early: Vec::new(), snapshot_once: None, history, tracking, rejected: 0 }
    }

    /// An estimate of the memory that is taken.
    pub fn bytes(&self) -> usize {
        let views: usize = self.watched.iter().map(|watched| watched.group.ring().bytes()).sum();
        views + self.stream.board.tracks().bytes()
    }

    /// Those who follow plain views.
    pub fn followers(&self) -> impl Iterator<Item = &Follower> {
        self.watched.iter().filter_map(|watched| watched.eye.follower())
    }

    /// Does what a seat asks.
    pub fn serve(&mut self, control: Control, pipeline: &mut Pipeline) {
        match control {
            Control::Join(seat, view, resume) => self.join(&seat, view, resume, pipeline),
            Control::ChangeView(seat, change) => {
                self.leave(&seat);
                seat.want_dots(change.dots);
                self.sit_down(&seat, change.view, pipeline);
                self.give_snapshot(&seat, wire::Cause::ViewChanged, pipeline);
            }
            Control::WantTracks(seat, tracks) => {
                seat.want_tracks(tracks);
                seat.ring_bell();
            }
            Control::Snapshot(seat) => self.give_snapshot(&seat, wire::Cause::Lagged, pipeline),
            Control::Leave(seat) => {
                self.leave(&seat);
                self.stream.stats.consumers.fetch_sub(1, Ordering::Relaxed);
            }
            Control::SnapshotOnce(view, answer) => {
                if let Some(snapshot) = self.snapshot_once(view, pipeline) {
                    // Whoever does not wait any more needs no answer; there is room for one.
                    let _ = answer.try_send(snapshot);
                }
                return;
            }
        }
        self.track(pipeline, false);
        self.show_dots(pipeline);
    }

    /// What has happened to tracks up to the newest frame, if anybody wants to know and it is not known yet.
    pub fn track(&mut self, pipeline: &mut Pipeline, is_tapped: bool) -> Option<Arc<TrackFrame>> {
        let tracking = self.tracking.as_mut().filter(|_| pipeline.committed() > 0)?;
        let seats = |watched: &Watched| watched.group.seats().iter().map(|seat| seat.tracks_wanted()).max();
        let wanted = self.watched.iter().filter_map(seats).max().unwrap_or_default();
        if wanted == wire::TracksWanted::No && !is_tapped {
            return None;
        }
        let with_cycles = wanted == wire::TracksWanted::Cycles;
        let looked = tracking.look(pipeline, with_cycles);
        let mut ring = self.stream.board.tracks();
        let newest = ring.newest().cloned();
        let looked = looked.or_else(|| {
            newest.filter(|newest| with_cycles && !newest.has_cycles()).map(|newest| tracking.again(pipeline, &newest))
        });
        let looked = Arc::new(looked?);
        ring.push(Arc::clone(&looked), self.history);
        drop(ring);
        self.watched.iter().for_each(|watched| watched.group.ring_bells());
        Some(looked)
    }

    /// Tells of the newest frame, if anybody looks. Gives the time that computing took, telling left out.
    pub fn publish(&mut self, pipeline: &mut Pipeline, rejected: u64) -> Duration {
        (self.rejected, self.snapshot_once) = (rejected, None);
        let mut took = Duration::ZERO;
        self.watched.retain(|watched| watched.idle_since.is_none_or(|since| since.elapsed() < KEPT));
        for watched in &mut self.watched {
            watched.snapshot = None;
            let begun = Instant::now();
            let seen = watched.eye.look(pipeline);
            took += begun.elapsed();
            let Some(step) = seen else { continue };
            if let Some(entry) = entry(self.stream.number, watched.group.view, step, rejected) {
                watched.group.publish(entry, self.history);
            }
        }
        self.show_dots(pipeline);
        for (seat, cause) in std::mem::take(&mut self.early) {
            self.give_snapshot(&seat, cause, pipeline);
        }
        self.watched.iter().for_each(|watched| watched.group.ring_bells());
        took
    }

    /// Tells everybody that the stream has ended, after its last frame.
    pub fn close(&mut self, pipeline: &mut Pipeline, reason: &str) {
        let seats: Vec<Arc<Seat>> = self.watched.iter().flat_map(|watched| watched.group.seats().clone()).collect();
        for seat in seats {
            if seat.needs_snapshot() {
                self.give_snapshot(&seat, wire::Cause::Lagged, pipeline);
            }
            seat.close(pipeline.committed(), reason);
        }
    }

    fn join(&mut self, seat: &Arc<Seat>, view: wire::View, resume: Option<wire::Resume>, pipeline: &mut Pipeline) {
        self.stream.stats.consumers.fetch_add(1, Ordering::Relaxed);
        let group = self.sit_down(seat, view, pipeline);
        match resume {
            None => self.give_snapshot(seat, wire::Cause::Start, pipeline),
            Some(resume) if resume.epoch == self.stream.epoch && group.knows(resume.frame) => {
                seat.resume(resume.frame);
            }
            Some(_) => self.give_snapshot(seat, wire::Cause::CannotResume, pipeline),
        }
    }

    /// Seats somebody before a view, which is made if nobody looks at it yet.
    fn sit_down(&mut self, seat: &Arc<Seat>, view: wire::View, pipeline: &mut Pipeline) -> Arc<Group> {
        let place = self.watched.iter().position(|watched| watched.group.view == view).unwrap_or_else(|| {
            let mut eye = Eye::new(view);
            // From here on it is told of every frame; what is there now goes out as a snapshot.
            let newest = eye.look(pipeline).map_or(0, |step| step.number);
            let group = Arc::new(Group::new(view, newest));
            self.watched.push(Watched { group, eye, idle_since: None, snapshot: None });
            self.watched.len() - 1
        });
        let watched = &mut self.watched[place];
        watched.idle_since = None;
        watched.group.seats().push(Arc::clone(seat));
        seat.sit_down(Arc::clone(&watched.group));
        Arc::clone(&watched.group)
    }

    fn leave(&mut self, seat: &Arc<Seat>) {
        self.early.retain(|(other, _)| !Arc::ptr_eq(other, seat));
        for watched in &mut self.watched {
            let mut seats = watched.group.seats();
            seats.retain(|other| !Arc::ptr_eq(other, seat));
            if seats.is_empty() && watched.idle_since.is_none() {
                watched.idle_since = Some(Instant::now());
            }
        }
    }

    /// Hands somebody the newest frame as a whole; later, if there is none yet.
    fn give_snapshot(&mut self, seat: &Arc<Seat>, cause: wire::Cause, pipeline: &mut Pipeline) {
        let is_here = |watched: &&mut Watched| watched.group.seats().iter().any(|other| Arc::ptr_eq(other, seat));
        let Some(watched) = self.watched.iter_mut().find(is_here) else { return };
        if pipeline.committed() == 0 {
            self.early.push((Arc::clone(seat), cause));
            return;
        }
        let known = watched.snapshot.as_ref().filter(|(_, known, _)| *known == cause);
        let made = known.cloned().or_else(|| snapshot(&self.stream, watched, cause, self.rejected, pipeline));
        if let Some((frame, _, message)) = &made {
            seat.give_snapshot(*frame, message.clone(), cause);
        }
        watched.snapshot = made;
    }

    /// The newest frame for somebody who does not follow the stream; none, if there is none yet. No view is watched for it.
    fn snapshot_once(&mut self, view: wire::View, pipeline: &mut Pipeline) -> Option<Arc<wire::Snapshot>> {
        if let Some(known) = self.snapshot_once.as_ref().filter(|known| known.frame.view == view) {
            return Some(Arc::clone(known));
        }
        let step = Eye::new(view).look(pipeline)?;
        let snapshot = convert::snapshot(self.stream.number, view, wire::Cause::Start, &step, self.rejected);
        self.snapshot_once = Some(Arc::new(snapshot));
        self.snapshot_once.clone()
    }

    /// Shows as many dots as anybody wants.
    fn show_dots(&mut self, pipeline: &mut Pipeline) {
        let wanted = |watched: &Watched| watched.group.seats().iter().map(|seat| seat.dots_wanted()).max();
        let most = self.watched.iter().filter_map(wanted).max().unwrap_or(0);
        if most == 0 || pipeline.committed() == 0 {
            return self.stream.board.show_dots(None);
        }
        let shown = self.stream.board.dots();
        let has_all = |ranked: &Ranked| ranked.dots.len() as u64 == ranked.total || ranked.dots.len() >= most;
        if shown.is_some_and(|ranked| ranked.frame == pipeline.committed() && has_all(&ranked)) {
            return;
        }
        self.stream.board.show_dots(Some(convert::ranked(&pipeline.poll_dots(most))));
        self.watched.iter().for_each(|watched| watched.group.ring_bells());
    }
}

fn entry(stream: u32, view: wire::View, step: Step, rejected: u64) -> Option<Entry> {
    let message = convert::diff(stream, view, &step, rejected);
    let (from, info, checksum) = (message.from, message.frame.clone(), message.checksum);
    let message = encoded(message)?;
    Some(Entry { from, info, diff: step.diff, checksum, message })
}

/// The newest frame of a view as a whole.
fn snapshot(
    stream: &Stream,
    watched: &Watched,
    cause: wire::Cause,
    rejected: u64,
    pipeline: &mut Pipeline,
) -> Option<(u64, wire::Cause, wire::Shared)> {
    let view = watched.group.view;
    let step = Eye::new(view).look(pipeline)?;
    let message = convert::snapshot(stream.number, view, cause, &step, rejected);
    Some((step.number, cause, encoded(message)?))
}
