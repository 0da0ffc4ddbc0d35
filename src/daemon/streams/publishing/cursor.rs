//! A consumer's position in a view of one stream: the frame that it has, and what it gets next.
//!
//! In: what the view's log holds, snapshots from the engine. Out: messages, one at a time, when the writer of the
//! connection asks for one.
//!
//! Invariants:
//! * Every diff starts from the frame that was sent before.
//! * A consumer that is too far behind gets one merged diff or a snapshot, after a message that names the frames.
//! * Nothing is kept here for a slow consumer but the number of its frame.
//!
//! Must not know: sockets, the core's pipeline, the engine but by its channel of [`Request`]s.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;

use super::published::PublishedDots;
use super::track_log::{NextTracks, TrackPosition};
use super::view_log::{LogEntry, Since, ViewLog};
use crate::daemon::encoding::encoded;
use crate::daemon::locks::lock;
use crate::daemon::streams::convert;
use crate::daemon::streams::stream_state::StreamState;

/// What consumers request of an engine.
#[derive(Debug)]
pub enum Request {
    /// Follow a view, from the frame that the consumer has if it can be resumed.
    Join(Arc<Cursor>, wire::View, Option<wire::Resume>),
    /// Follow another view.
    ChangeView(Arc<Cursor>, wire::ChangeView),
    /// Send tracks, or other tracks.
    WantTracks(Arc<Cursor>, wire::TracksWanted),
    /// Send a snapshot: the log does not reach back to the consumer's frame.
    Snapshot(Arc<Cursor>),
    /// Follow nothing more.
    Leave(Arc<Cursor>),
    /// Send the newest frame once, without a cursor.
    SnapshotOnce(wire::View, Sender<Arc<wire::Snapshot>>),
}

/// A consumer's position in a stream.
#[derive(Debug)]
pub struct Cursor {
    /// The stream.
    pub stream: Arc<StreamState>,
    requests: Sender<Request>,
    /// Wakes the connection's writer.
    wake: Sender<()>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// The log that is read; none before the engine has answered the first request.
    log: Option<Arc<ViewLog>>,
    dots: wire::DotsWanted,
    /// The frame that the consumer has, or will have when `ahead` is sent; 0 for none.
    at: u64,
    /// What is sent before anything from the log.
    ahead: VecDeque<wire::Shared>,
    /// Whether a snapshot is awaited.
    awaits_snapshot: bool,
    /// Nothing is sent after `ahead`.
    is_closed: bool,
    sent_dots: Option<Arc<PublishedDots>>,
    tracks: wire::TracksWanted,
    track_position: TrackPosition,
    /// When something was sent last.
    last: Instant,
}

impl Cursor {
    /// A cursor that reads nothing before the engine has got its [`Request::Join`].
    pub fn new(
        stream: Arc<StreamState>,
        requests: Sender<Request>,
        dots: wire::DotsWanted,
        tracks: wire::TracksWanted,
        wake: Sender<()>,
    ) -> Self {
        let state = State {
            log: None,
            dots,
            at: 0,
            ahead: encoded(stream.opened()).into_iter().collect(),
            awaits_snapshot: true,
            is_closed: false,
            sent_dots: None,
            tracks,
            track_position: TrackPosition::default(),
            last: Instant::now(),
        };
        Self { stream, requests, wake, state: Mutex::new(state) }
    }

    /// Requests something of the engine; waits while the engine has many requests. An engine that has ended closes the
    /// cursor by itself.
    pub fn request(&self, request: Request) {
        let _ = self.requests.send(request);
    }

    /// Wakes the writer of the connection.
    pub fn wake(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    /// The number of dots that are wanted.
    pub fn dots_wanted(&self) -> usize {
        self.lock().dots_wanted()
    }

    /// What is wanted of tracks.
    pub fn tracks_wanted(&self) -> wire::TracksWanted {
        self.lock().tracks
    }

    /// Wants tracks, from nothing.
    pub fn want_tracks(&self, tracks: wire::TracksWanted) {
        let mut state = self.lock();
        (state.tracks, state.track_position) = (tracks, TrackPosition::default());
    }

    /// Reads a log from now on, after a snapshot.
    pub fn follow(&self, log: Arc<ViewLog>) {
        let mut state = self.lock();
        state.log = Some(log);
        state.awaits_snapshot = true;
    }

    /// Wants other dots.
    pub fn want_dots(&self, dots: wire::DotsWanted) {
        let mut state = self.lock();
        (state.dots, state.sent_dots) = (dots, None);
    }

    /// Goes on from a frame that the consumer has.
    pub fn resume(&self, frame: u64) {
        let mut state = self.lock();
        state.ahead.extend(encoded(wire::Resumed { stream: self.stream.number, frame }));
        (state.at, state.awaits_snapshot) = (frame, false);
        drop(state);
        self.wake();
    }

    /// Goes on from a snapshot, if one is awaited.
    pub fn send_snapshot(&self, frame: u64, snapshot: wire::Shared, cause: wire::Cause) {
        let mut state = self.lock();
        if !state.awaits_snapshot || state.is_closed {
            return;
        }
        if cause == wire::Cause::Lagged {
            let lagged = self.lagged(state.at, frame);
            state.ahead.extend(lagged.and_then(encoded));
        }
        state.ahead.push_back(snapshot);
        (state.at, state.awaits_snapshot) = (frame, false);
        drop(state);
        self.wake();
    }

    /// Whether only a snapshot leads on to the newest frame. If so, one is awaited from now on.
    pub fn needs_snapshot(&self) -> bool {
        let mut state = self.lock();
        state.awaits_snapshot |= matches!(state.since(0), Some((_, Since::Unknown)));
        state.awaits_snapshot && !state.is_closed
    }

    /// Sends what was published, then the stream's end, and nothing after it.
    pub fn close(&self, frame: u64, reason: &str) {
        let mut state = self.lock();
        if state.is_closed {
            return;
        }
        let closed = wire::StreamClosed { stream: self.stream.number, frame, reason: reason.to_owned() };
        if let Some((at, since)) = state.since(0) {
            if let Since::Run(run) = since {
                state.at = run.last().map_or(at, |last| last.info.number);
                state.ahead.extend(run.iter().map(|entry| entry.message.clone()));
            }
            let tracks = self.next_tracks(&mut state);
            state.ahead.extend(tracks);
            let dots = self.next_dots(&mut state);
            state.ahead.extend(dots);
        }
        state.ahead.extend(encoded(closed));
        state.is_closed = true;
        drop(state);
        self.wake();
    }

    /// Sends nothing any more.
    pub fn cancel(&self) {
        let mut state = self.lock();
        state.ahead.clear();
        state.is_closed = true;
    }

    /// Whether everything was sent that ever will be.
    pub fn is_done(&self) -> bool {
        let state = self.lock();
        state.is_closed && state.ahead.is_empty()
    }

    /// The next message, if there is one. A consumer that is more than `queue` bytes behind lags.
    pub fn next(self: &Arc<Self>, queue: usize) -> Option<wire::Shared> {
        let mut state = self.lock();
        if let Some(first) = state.ahead.pop_front() {
            state.last = Instant::now();
            return Some(first);
        }
        let (at, since) = state.since(queue)?;
        if let Some(tracks) = self.next_tracks(&mut state) {
            state.last = Instant::now();
            return Some(tracks);
        }
        match since {
            Since::Nothing => self.next_dots(&mut state),
            Since::Next(entry) => {
                state.at = entry.info.number;
                state.last = Instant::now();
                Some(entry.message.clone())
            }
            Since::Run(run) => {
                // Merging takes time, and the engine must not wait for this lock meanwhile.
                state.at = run.last().map_or(at, |last| last.info.number);
                drop(state);
                self.catch_up(at, &run)
            }
            Since::Unknown => {
                self.request_snapshot(&mut state, at);
                None
            }
        }
    }

    /// A heartbeat, if nothing was sent for so long.
    pub fn heartbeat(&self, after: Duration) -> Option<wire::Shared> {
        let mut state = self.lock();
        if state.is_closed || state.last.elapsed() < after {
            return None;
        }
        state.last = Instant::now();
        encoded(wire::Heartbeat { stream: self.stream.number, frame: self.stream.stats.frame() })
    }

    /// One diff for a whole run, after a message that names the merged frames. A snapshot, if that is smaller.
    fn catch_up(self: &Arc<Self>, at: u64, run: &[Arc<LogEntry>]) -> Option<wire::Shared> {
        let last = run.last()?;
        let message = LogEntry::merged(self.stream.number, run).and_then(encoded)?;
        let mut state = self.lock();
        let is_long = u64::from(message.length) > convert::snapshot_size(&last.info);
        // What was put ahead in the meantime, a snapshot of another view or the end, follows upon the run.
        let goes_on = state.ahead.is_empty() && !state.is_closed && !state.awaits_snapshot;
        if is_long && goes_on && self.request_snapshot(&mut state, at) {
            return None;
        }
        state.last = Instant::now();
        match self.lagged(at, last.info.number).and_then(encoded) {
            Some(lagged) => {
                state.ahead.push_front(message);
                Some(lagged)
            }
            None => Some(message),
        }
    }

    /// Whether the request was taken. The engine takes this cursor's lock, so the request must not wait; the next round
    /// tries again.
    fn request_snapshot(self: &Arc<Self>, state: &mut State, at: u64) -> bool {
        let is_requested = self.requests.try_send(Request::Snapshot(Arc::clone(self))).is_ok();
        if is_requested {
            (state.at, state.awaits_snapshot) = (at, true);
        }
        is_requested
    }

    /// The newest dots, if the consumer has their frame and has not got them before.
    fn next_dots(&self, state: &mut State) -> Option<wire::Shared> {
        let most = state.dots_wanted();
        let newest = self.stream.published.dots().filter(|dots| most > 0 && dots.frame == state.at)?;
        if state.sent_dots.as_ref().is_some_and(|sent| Arc::ptr_eq(sent, &newest)) {
            return None;
        }
        let is_known = state.sent_dots.as_ref().is_some_and(|sent| sent.top(most) == newest.top(most));
        let message = (!is_known).then(|| {
            let (total, dots) = newest.top(most);
            wire::Dots { stream: self.stream.number, frame: newest.frame, total, dots: dots.to_vec() }
        });
        state.sent_dots = Some(newest);
        message.and_then(encoded)
    }

    /// The events of tracks up to the frame that the consumer has.
    fn next_tracks(&self, state: &mut State) -> Option<wire::Shared> {
        if state.tracks == wire::TracksWanted::No || state.at == 0 {
            return None;
        }
        let number = self.stream.number;
        match self.stream.published.tracks().next(number, state.track_position, state.at, state.tracks) {
            NextTracks::Unknown => None,
            NextTracks::Nothing => {
                state.track_position.seen = state.track_position.seen.max(state.at);
                None
            }
            NextTracks::Message(tracks) => {
                state.track_position = TrackPosition { sent: state.at, seen: state.at };
                encoded(tracks)
            }
        }
    }

    fn lagged(&self, at: u64, to: u64) -> Option<wire::Lagged> {
        let (first, last) = (at + 1, to.saturating_sub(1));
        (first <= last).then(|| {
            self.stream.stats.lagged.fetch_add(last - first + 1, Ordering::Relaxed);
            wire::Lagged { stream: self.stream.number, first, last }
        })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }
}

impl State {
    fn dots_wanted(&self) -> usize {
        match self.dots {
            wire::DotsWanted::No => 0,
            wire::DotsWanted::Top(most) => most as usize,
            wire::DotsWanted::All => usize::MAX,
        }
    }

    /// The consumer's frame, and what the log has after it; none while nothing may be sent.
    fn since(&self, queue: usize) -> Option<(u64, Since)> {
        let log = self.log.as_ref().filter(|_| !self.awaits_snapshot && !self.is_closed)?;
        Some((self.at, log.since(self.at, queue)))
    }
}
