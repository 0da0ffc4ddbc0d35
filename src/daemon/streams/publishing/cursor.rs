//! A consumer's position in a view of one stream: the frame that it has, and what it gets next.
//!
//! In: what the view's log holds, snapshots from the engine. Out: messages, one at a time, when the writer of the
//! connection asks for one.
//!
//! Invariants:
//! * Every diff starts from the frame that was sent before.
//! * A consumer that is too far behind gets one merged diff or a snapshot, after a message that names the frames.
//! * Nothing is kept here for a slow consumer but the number of its frame: its writer asks for a snapshot when it is
//!   ready to send one, and of all cursors of a peer one has a snapshot at a time.
//!
//! Must not know: sockets, the core's pipeline, the engine but by its line of [`Requests`].

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use hopes_protocol as wire;

use super::published::PublishedDots;
use super::track_log::{NextTracks, TrackPosition};
use super::view_log::{LogEntry, Since, ViewLog};
use crate::daemon::encoding::{Encoded, encoded};
use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::streams::consumer::{Consumer, Share, SnapshotPlace};
use crate::daemon::streams::convert;
use crate::daemon::streams::requests::{Requester, Requests};
use crate::daemon::streams::stream_state::StreamState;

/// A consumer's position in a stream.
#[derive(Debug)]
pub struct Cursor {
    /// The stream.
    pub stream: Arc<StreamState>,
    /// The peer.
    pub consumer: Arc<Consumer>,
    requests: Arc<Requests<Self>>,
    state: Lock<State>,
}

impl Requester for Cursor {
    fn peer(&self) -> u64 {
        self.consumer.peer
    }
}

/// What a cursor in another view starts from.
#[derive(Clone, Copy, Debug)]
pub enum Start {
    /// A snapshot, which its writer asks for when it comes to it.
    Snapshot(wire::Cause),
    /// A frame that the consumer has.
    After(u64),
}

#[derive(Debug)]
struct State {
    /// The log that is read; none before the engine has answered the first request.
    log: Option<Arc<ViewLog>>,
    dots: wire::DotsWanted,
    /// The frame that the consumer has, or will have when `ahead` is sent; 0 for none.
    at: u64,
    /// What is sent before anything from the log.
    ahead: VecDeque<Ahead>,
    /// Why a snapshot is awaited, if one is.
    awaited: Option<wire::Cause>,
    /// The engine knows that one is awaited.
    is_requested: bool,
    /// Nothing is sent after `ahead`.
    is_closed: bool,
    /// The dots of the frame `at`, if they were there when it was sent.
    held_dots: Option<Arc<PublishedDots>>,
    sent_dots: Option<Arc<PublishedDots>>,
    tracks: wire::TracksWanted,
    track_position: TrackPosition,
    /// When something was sent last.
    last: Instant,
}

/// A message that is sent before anything from the log.
#[derive(Debug)]
struct Ahead {
    message: Encoded,
    kind: AheadKind,
    /// Held for its drop, by messages that others may hold too.
    _share: Option<Share>,
}

impl Ahead {
    /// A message for this consumer alone.
    fn own(message: Encoded, kind: AheadKind) -> Self {
        Self { message, kind, _share: None }
    }

    /// A message that others may hold too.
    fn shared(message: Encoded, kind: AheadKind, consumer: &Arc<Consumer>) -> Self {
        let share = consumer.share(message.bytes());
        Self { message, kind, _share: Some(share) }
    }
}

#[derive(Debug)]
enum AheadKind {
    /// It is sent whatever view is followed by then.
    Notice,
    /// It belongs to the view that is followed.
    OfView,
    /// As before; the peer's only snapshot that waits.
    Snapshot(#[allow(dead_code, reason = "held for its drop")] SnapshotPlace),
}

impl Cursor {
    /// A cursor that reads nothing before the engine knows of it.
    pub fn new(
        stream: Arc<StreamState>,
        consumer: Arc<Consumer>,
        requests: Arc<Requests<Self>>,
        dots: wire::DotsWanted,
        tracks: wire::TracksWanted,
    ) -> Self {
        let opened = encoded(stream.opened(), &consumer.account);
        let state = State {
            log: None,
            dots,
            at: 0,
            ahead: opened.into_iter().map(|message| Ahead::own(message, AheadKind::Notice)).collect(),
            awaited: None,
            is_requested: false,
            is_closed: false,
            held_dots: None,
            sent_dots: None,
            tracks,
            track_position: TrackPosition::default(),
            last: Instant::now(),
        };
        Self { stream, consumer, requests, state: Lock::new(Level::Cursor, state) }
    }

    /// Requests another view.
    pub fn change_view(self: &Arc<Self>, change: wire::ChangeView) {
        self.requests.change_view(self, change);
    }

    /// Requests tracks, or other tracks.
    pub fn request_tracks(self: &Arc<Self>, tracks: wire::TracksWanted) {
        self.requests.want_tracks(self, tracks);
    }

    /// Follows nothing more, and sends nothing more.
    pub fn leave(self: &Arc<Self>) {
        self.cancel();
        self.requests.leave(self);
    }

    /// Wakes the writer of the connection.
    pub fn wake(&self) {
        self.consumer.wake();
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

    /// Reads a log from now on. What was to be sent of the view before is left out.
    pub fn follow(&self, log: Arc<ViewLog>, start: Start) {
        let mut state = self.lock();
        state.ahead.retain(|ahead| matches!(ahead.kind, AheadKind::Notice));
        // In one step: the writer must not read the log from the frame that the consumer has of another view.
        state.log = Some(log);
        match start {
            Start::Snapshot(cause) => (state.awaited, state.is_requested) = (Some(cause), false),
            Start::After(frame) => {
                (state.at, state.awaited) = (frame, None);
                let resumed = wire::Resumed { stream: self.stream.number, frame };
                self.put(&mut state, resumed, AheadKind::OfView);
            }
        }
        drop(state);
        self.wake();
    }

    /// Wants other dots.
    pub fn want_dots(&self, dots: wire::DotsWanted) {
        let mut state = self.lock();
        (state.dots, state.sent_dots) = (dots, None);
    }

    /// Why a snapshot is awaited, if one is.
    pub fn awaited(&self) -> Option<wire::Cause> {
        let state = self.lock();
        state.awaited.filter(|_| !state.is_closed)
    }

    /// The peer's writer has another snapshot to send: the request is made again when that one is sent.
    pub fn defer_snapshot(&self) {
        self.lock().is_requested = false;
        // If the other one was sent in the meantime, nobody else wakes the writer: giving back the place does.
        drop(self.consumer.snapshot_place());
    }

    /// Goes on from a snapshot, if one is awaited. At the stream's end it has no place of its own: all cursors in a
    /// view share it.
    pub fn send_snapshot(&self, frame: u64, snapshot: Encoded, place: Option<SnapshotPlace>) {
        let mut state = self.lock();
        let Some(cause) = state.awaited.filter(|_| !state.is_closed) else { return };
        if cause == wire::Cause::Lagged
            && let Some(lagged) = self.lagged(state.at, frame)
        {
            self.put(&mut state, lagged, AheadKind::OfView);
        }
        let kind = place.map_or(AheadKind::OfView, AheadKind::Snapshot);
        state.ahead.push_back(Ahead::shared(snapshot, kind, &self.consumer));
        (state.at, state.awaited) = (frame, None);
        drop(state);
        self.wake();
    }

    /// Tells the consumer something in between.
    pub fn notify(&self, message: impl Into<wire::Message>) {
        let mut state = self.lock();
        if !state.is_closed {
            self.put(&mut state, message, AheadKind::Notice);
        }
        drop(state);
        self.wake();
    }

    fn put(&self, state: &mut State, message: impl Into<wire::Message>, kind: AheadKind) {
        if let Some(message) = encoded(message, &self.consumer.account) {
            state.ahead.push_back(Ahead::own(message, kind));
        }
    }

    /// Whether only a snapshot leads on to the newest frame. If so, one is awaited from now on.
    pub fn needs_snapshot(&self) -> bool {
        let mut state = self.lock();
        if matches!(state.since(0), Some((_, Since::Unknown))) {
            state.awaited = Some(wire::Cause::Lagged);
        }
        state.awaited.is_some() && !state.is_closed
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
                let of_view =
                    |entry: &Arc<LogEntry>| Ahead::shared(entry.message.clone(), AheadKind::OfView, &self.consumer);
                state.ahead.extend(run.iter().map(of_view));
            }
            let (tracks, dots) = (self.next_tracks(&mut state), self.next_dots(&mut state));
            let last = tracks.into_iter().chain(dots);
            state.ahead.extend(last.map(|message| Ahead::own(message, AheadKind::OfView)));
        }
        self.put(&mut state, closed, AheadKind::Notice);
        state.is_closed = true;
        drop(state);
        self.wake();
    }

    /// Sends nothing any more.
    fn cancel(&self) {
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
    pub fn next(self: &Arc<Self>, queue: usize) -> Option<Encoded> {
        let mut state = self.lock();
        if let Some(first) = state.ahead.pop_front() {
            state.last = Instant::now();
            self.hold_dots(&mut state);
            return Some(first.message);
        }
        if state.awaited.is_some() && !state.is_requested && !state.is_closed {
            state.is_requested = true;
            drop(state);
            self.requests.want_snapshot(self);
            return None;
        }
        let (at, since) = state.since(queue)?;
        if let Some(tracks) = self.next_tracks(&mut state) {
            state.last = Instant::now();
            return Some(tracks);
        }
        // Before the next frame: a consumer that is always behind would have no dots otherwise.
        if let Some(dots) = self.next_dots(&mut state) {
            state.last = Instant::now();
            return Some(dots);
        }
        match since {
            Since::Nothing => None,
            Since::Next(entry) => {
                state.at = entry.info.number;
                state.last = Instant::now();
                self.hold_dots(&mut state);
                Some(entry.message.clone())
            }
            Since::Run(run) => {
                // Merging takes time, and the engine must not wait for this lock meanwhile.
                state.at = run.last().map_or(at, |last| last.info.number);
                self.hold_dots(&mut state);
                drop(state);
                self.catch_up(at, &run)
            }
            Since::Unknown => {
                (state.awaited, state.is_requested) = (Some(wire::Cause::Lagged), true);
                drop(state);
                self.requests.want_snapshot(self);
                None
            }
        }
    }

    /// A heartbeat, if nothing was sent for so long.
    pub fn heartbeat(&self, after: Duration) -> Option<Encoded> {
        let mut state = self.lock();
        if state.is_closed || state.last.elapsed() < after {
            return None;
        }
        state.last = Instant::now();
        let heartbeat = wire::Heartbeat { stream: self.stream.number, frame: self.stream.stats.frame() };
        encoded(heartbeat, &self.consumer.account)
    }

    /// One diff for a whole run, after a message that names the merged frames. A snapshot, if that is smaller.
    fn catch_up(self: &Arc<Self>, at: u64, run: &[Arc<LogEntry>]) -> Option<Encoded> {
        let last = run.last()?;
        let shape = self.stream.shape();
        let merged = LogEntry::merged((self.stream.number, shape), run)?;
        let message = encoded(merged, &self.consumer.account)?;
        let mut state = self.lock();
        let is_long = u64::from(message.length) > convert::snapshot_size(&last.info, shape);
        // What was put ahead in the meantime, a snapshot of another view or the end, follows upon the run.
        let goes_on = state.ahead.is_empty() && !state.is_closed && state.awaited.is_none();
        if is_long && goes_on {
            (state.at, state.awaited, state.is_requested) = (at, Some(wire::Cause::Lagged), true);
            drop(state);
            self.requests.want_snapshot(self);
            return None;
        }
        state.last = Instant::now();
        match self.lagged(at, last.info.number).and_then(|lagged| encoded(lagged, &self.consumer.account)) {
            Some(lagged) => {
                state.ahead.push_front(Ahead::own(message, AheadKind::OfView));
                Some(lagged)
            }
            None => Some(message),
        }
    }

    /// Keeps the dots of the frame that is sent, if they are there: the engine may replace them before their turn.
    fn hold_dots(&self, state: &mut State) {
        let (at, is_wanted) = (state.at, state.dots_wanted() > 0);
        if state.held_dots.as_ref().is_none_or(|held| held.frame != at) {
            state.held_dots = self.stream.published.dots().filter(|dots| is_wanted && dots.frame == at);
        }
    }

    /// The dots of the frame that the consumer has, if they are known and it was not told before. In place of dots that
    /// it has already, it gets a heartbeat with that frame.
    fn next_dots(&self, state: &mut State) -> Option<Encoded> {
        let most = state.dots_wanted();
        let held = state.held_dots.take().filter(|dots| dots.frame == state.at);
        let known = held.or_else(|| self.stream.published.dots().filter(|dots| dots.frame == state.at));
        let dots = known.filter(|_| most > 0)?;
        let sent = state.sent_dots.replace(Arc::clone(&dots));
        let stream = self.stream.number;
        match sent {
            Some(sent) if Arc::ptr_eq(&sent, &dots) => None,
            Some(sent) if sent.has_same_top(&dots, most) => {
                encoded(wire::Heartbeat { stream, frame: dots.frame }, &self.consumer.account)
            }
            _ => encoded(dots.dots.message(stream, dots.frame, dots.total, most), &self.consumer.account),
        }
    }

    /// The events of tracks up to the frame that the consumer has.
    fn next_tracks(&self, state: &mut State) -> Option<Encoded> {
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
                encoded(*tracks, &self.consumer.account)
            }
        }
    }

    fn lagged(&self, at: u64, to: u64) -> Option<wire::Lagged> {
        let (first, last) = (at + 1, to.saturating_sub(1));
        (first <= last).then(|| {
            self.stream.stats.lagged.fetch_add(last - first + 1, Ordering::Relaxed);
            self.consumer.lagged.fetch_add(last - first + 1, Ordering::Relaxed);
            wire::Lagged { stream: self.stream.number, first, last }
        })
    }

    fn lock(&self) -> Guard<'_, State> {
        self.state.lock()
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
        let log = self.log.as_ref().filter(|_| self.awaited.is_none() && !self.is_closed)?;
        Some((self.at, log.since(self.at, queue)))
    }
}
