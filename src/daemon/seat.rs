//! One consumer's place before one stream: which frame it has, and what it is to be sent next.
//!
//! In: what its group has published, answers of the engine. Out: messages, one at a time, when the peer's writer is ready for one. Invariants: every diff starts from the frame that was sent
//! before; a consumer that is too far behind gets one merged diff or a snapshot, and is told which frames it was not sent singly; nothing is kept here for a slow
//! one but the number of its frame. Must not know: sockets, the core's pipeline.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;

use super::board::{Entry, Following, Group, Ranked};
use super::convert::{self, encoded};
use super::streams::Stream;
use super::tracks::{Known, Next};

/// What the engine is asked by consumers.
#[derive(Debug)]
pub enum Control {
    /// Somebody sits down, and may have been here before.
    Join(Arc<Seat>, wire::View, Option<wire::Resume>),
    /// A seat wants to see something else.
    ChangeView(Arc<Seat>, wire::ChangeView),
    /// A seat wants to see tracks, or others.
    WantTracks(Arc<Seat>, wire::TracksWanted),
    /// A seat is too far behind for anything but a snapshot.
    Snapshot(Arc<Seat>),
    /// Somebody leaves.
    Leave(Arc<Seat>),
    /// Somebody who takes no place wants to see the newest frame once.
    SnapshotOnce(wire::View, Sender<Arc<wire::Snapshot>>),
}

/// A consumer's place before a stream.
#[derive(Debug)]
pub struct Seat {
    /// The stream.
    pub stream: Arc<Stream>,
    /// Tells the peer's writer that there may be something to send.
    bell: Sender<()>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// What is looked at; none before the engine has given a place.
    group: Option<Arc<Group>>,
    dots: wire::DotsWanted,
    /// The frame that the consumer has, or will have when the head is sent; 0 for none.
    at: u64,
    /// What has to be sent before anything else.
    head: VecDeque<wire::Shared>,
    /// Whether the engine was asked for a snapshot.
    is_waiting: bool,
    /// Nothing more is to be sent after the head.
    is_closed: bool,
    sent_dots: Option<Arc<Ranked>>,
    tracks: wire::TracksWanted,
    known_tracks: Known,
    /// When something was sent last.
    last: Instant,
}

impl Seat {
    /// A place before a stream; nothing is sent before the engine was told of it.
    pub fn new(stream: Arc<Stream>, dots: wire::DotsWanted, tracks: wire::TracksWanted, bell: Sender<()>) -> Self {
        let opened = wire::StreamOpened {
            stream: stream.number,
            name: stream.name.clone(),
            epoch: stream.epoch,
            window: convert::wire_window(stream.options.window),
            resolution: stream.options.resolution,
            frame: stream.stats.frame(),
        };
        let state = State {
            group: None,
            dots,
            at: 0,
            head: encoded(opened).into_iter().collect(),
            is_waiting: true,
            is_closed: false,
            sent_dots: None,
            tracks,
            known_tracks: Known::default(),
            last: Instant::now(),
        };
        Self { stream, bell, state: Mutex::new(state) }
    }

    /// Tells the writer to look here. A bell that is full rings already.
    pub fn ring_bell(&self) {
        let _ = self.bell.try_send(());
    }

    /// How many dots are wanted.
    pub fn dots_wanted(&self) -> usize {
        self.lock().dots_wanted()
    }

    /// What is wanted of tracks.
    pub fn tracks_wanted(&self) -> wire::TracksWanted {
        self.lock().tracks
    }

    /// Wants to see tracks, from nothing.
    pub fn want_tracks(&self, tracks: wire::TracksWanted) {
        let mut state = self.lock();
        (state.tracks, state.known_tracks) = (tracks, Known::default());
    }

    /// Looks at a group from now on; waits for a snapshot.
    pub fn sit_down(&self, group: Arc<Group>) {
        let mut state = self.lock();
        state.group = Some(group);
        state.is_waiting = true;
    }

    /// Wants other dots.
    pub fn want_dots(&self, dots: wire::DotsWanted) {
        let mut state = self.lock();
        (state.dots, state.sent_dots) = (dots, None);
    }

    /// Goes on from a frame that the consumer has.
    pub fn resume(&self, frame: u64) {
        let mut state = self.lock();
        state.head.extend(encoded(wire::Resumed { stream: self.stream.number, frame }));
        (state.at, state.is_waiting) = (frame, false);
        drop(state);
        self.ring_bell();
    }

    /// Goes on from a snapshot.
    pub fn give_snapshot(&self, frame: u64, snapshot: wire::Shared, cause: wire::Cause) {
        let mut state = self.lock();
        if !state.is_waiting || state.is_closed {
            return;
        }
        if cause == wire::Cause::Lagged {
            let lagged = self.lagged(state.at, frame);
            state.head.extend(lagged.and_then(encoded));
        }
        state.head.push_back(snapshot);
        (state.at, state.is_waiting) = (frame, false);
        drop(state);
        self.ring_bell();
    }

    /// Whether nothing but a snapshot leads on to the newest frame; it waits for one then.
    pub fn needs_snapshot(&self) -> bool {
        let mut state = self.lock();
        state.is_waiting |= matches!(state.following(0), Some((_, Following::Unknown)));
        state.is_waiting && !state.is_closed
    }

    /// Sends the stream's end, and nothing after it.
    pub fn close(&self, frame: u64, reason: &str) {
        let mut state = self.lock();
        if state.is_closed {
            return;
        }
        let closed = wire::StreamClosed { stream: self.stream.number, frame, reason: reason.to_owned() };
        // What was published before is still to be sent.
        if let Some((at, following)) = state.following(0) {
            if let Following::Run(run) = following {
                state.at = run.last().map_or(at, |last| last.info.number);
                state.head.extend(run.iter().map(|entry| entry.message.clone()));
            }
            let tracks = self.next_tracks(&mut state);
            state.head.extend(tracks);
            let dots = self.next_dots(&mut state);
            state.head.extend(dots);
        }
        state.head.extend(encoded(closed));
        state.is_closed = true;
        drop(state);
        self.ring_bell();
    }

    /// Sends nothing any more.
    pub fn vacate(&self) {
        let mut state = self.lock();
        state.head.clear();
        state.is_closed = true;
    }

    /// Whether everything was sent that ever will be.
    pub fn is_done(&self) -> bool {
        let state = self.lock();
        state.is_closed && state.head.is_empty()
    }

    /// The next message, if there is one. Who is more than `queue` bytes behind lags.
    pub fn next(self: &Arc<Self>, queue: usize) -> Option<wire::Shared> {
        let mut state = self.lock();
        if let Some(first) = state.head.pop_front() {
            state.last = Instant::now();
            return Some(first);
        }
        let (at, following) = state.following(queue)?;
        if let Some(tracks) = self.next_tracks(&mut state) {
            state.last = Instant::now();
            return Some(tracks);
        }
        match following {
            Following::Nothing => self.next_dots(&mut state),
            Following::Next(entry) => {
                state.at = entry.info.number;
                state.last = Instant::now();
                Some(entry.message.clone())
            }
            Following::Run(run) => {
                // Merging takes its time, and the engine must not wait for it at this lock.
                state.at = run.last().map_or(at, |last| last.info.number);
                drop(state);
                self.catch_up(at, &run)
            }
            Following::Unknown => {
                self.ask_for_snapshot(&mut state, at);
                None
            }
        }
    }

    /// A sign of life, if nothing was sent for so long.
    pub fn heartbeat(&self, after: Duration) -> Option<wire::Shared> {
        let mut state = self.lock();
        if state.is_closed || state.last.elapsed() < after {
            return None;
        }
        state.last = Instant::now();
        encoded(wire::Heartbeat { stream: self.stream.number, frame: self.stream.stats.frame() })
    }

    /// One diff for a whole run, after a word about what is missing; a snapshot, if that is smaller.
    fn catch_up(self: &Arc<Self>, at: u64, run: &[Arc<Entry>]) -> Option<wire::Shared> {
        let last = run.last()?;
        let merged = convert::merged(self.stream.number, at, run);
        let message = encoded(merged)?;
        let mut state = self.lock();
        let is_long = u64::from(message.length) > convert::snapshot_size(&last.info);
        // What has come to the head in the meantime, a snapshot of another view or the end, follows upon the run.
        let goes_on = state.head.is_empty() && !state.is_closed && !state.is_waiting;
        if is_long && goes_on && self.ask_for_snapshot(&mut state, at) {
            return None;
        }
        state.last = Instant::now();
        match self.lagged(at, last.info.number).and_then(encoded) {
            Some(lagged) => {
                state.head.push_front(message);
                Some(lagged)
            }
            None => Some(message),
        }
    }

    /// Whether the engine was asked. It takes this seat's lock, so it must not be waited for here; the next round asks again.
    fn ask_for_snapshot(self: &Arc<Self>, state: &mut State, at: u64) -> bool {
        let is_asked = self.stream.try_ask(Control::Snapshot(Arc::clone(self)));
        if is_asked {
            (state.at, state.is_waiting) = (at, true);
        }
        is_asked
    }

    /// The newest dots, if the consumer has their frame and they are not what it was sent before.
    fn next_dots(&self, state: &mut State) -> Option<wire::Shared> {
        let most = state.dots_wanted();
        let ranked = self.stream.board.dots().filter(|ranked| most > 0 && ranked.frame == state.at)?;
        if state.sent_dots.as_ref().is_some_and(|sent| Arc::ptr_eq(sent, &ranked)) {
            return None;
        }
        let is_known = state.sent_dots.as_ref().is_some_and(|sent| sent.shows(most) == ranked.shows(most));
        let dots = (!is_known).then(|| {
            let (total, dots) = ranked.shows(most);
            wire::Dots { stream: self.stream.number, frame: ranked.frame, total, dots: dots.to_vec() }
        });
        state.sent_dots = Some(ranked);
        dots.and_then(encoded)
    }

    /// What has happened to tracks up to the frame that the consumer has.
    fn next_tracks(&self, state: &mut State) -> Option<wire::Shared> {
        if state.tracks == wire::TracksWanted::No || state.at == 0 {
            return None;
        }
        match self.stream.board.tracks().next(self.stream.number, state.known_tracks, state.at, state.tracks) {
            Next::Unknown => None,
            Next::Nothing => {
                state.known_tracks.known = state.known_tracks.known.max(state.at);
                None
            }
            Next::Tell(tracks) => {
                state.known_tracks = Known { told: state.at, known: state.at };
                encoded(tracks)
            }
        }
    }

    fn lagged(&self, at: u64, to: u64) -> Option<wire::Lagged> {
        let (first, last) = (at + 1, to.saturating_sub(1));
        (first <= last).then(|| {
            self.stream.stats.add_lagged(last - first + 1);
            wire::Lagged { stream: self.stream.number, first, last }
        })
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
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

    /// The frame that the consumer has, and what has been published since; none while nothing can be sent.
    fn following(&self, queue: usize) -> Option<(u64, Following)> {
        let group = self.group.as_ref().filter(|_| !self.is_waiting && !self.is_closed)?;
        Some((self.at, group.ring().following(self.at, queue)))
    }
}
