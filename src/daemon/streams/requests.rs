//! Requests of consumers that wait for an engine.
//!
//! In: requests, at any time. Out: what each cursor wants by now, to the engine, peer by peer in turn.
//!
//! Invariants:
//! * A sender never waits. A cursor has one place in line, whatever it requests: a newer request replaces an older one
//!   that is not served, and one to leave replaces all. So the line is bounded by the number of cursors.
//! * Peers take turns, so many requests of one do not delay those of another. A peer whose request took long waits as
//!   long as that before its next one: at most half of an engine's time goes to any peer.
//! * A closed line takes nothing more.
//!
//! Must not know: how requests are served.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Bound;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::Sender;
use hopes_protocol as wire;

use crate::daemon::locks::{Guard, Level, Lock};
use crate::daemon::memory::Charged;

/// Snapshots without a cursor that wait for an engine at the most.
const MOST_ONCE: usize = 64;

/// The peer in whose turn snapshots without a cursor are made: the page's visitors together.
const VISITORS: u64 = 0;

/// What makes requests: a cursor.
pub trait Requester {
    /// The number of its peer, from 1.
    fn peer(&self) -> u64;
}

/// What a cursor wants of the engine.
#[derive(Debug)]
pub struct Wishes<C> {
    /// The cursor.
    pub cursor: Arc<C>,
    /// Follow a view, from the frame that the consumer has if it can be resumed.
    pub join: Option<(wire::View, Option<wire::Resume>)>,
    /// Follow another view.
    pub view: Option<wire::ChangeView>,
    /// Send tracks, or other tracks.
    pub tracks: Option<wire::TracksWanted>,
    /// Send a snapshot: the log does not lead on from the consumer's frame.
    pub snapshot: bool,
    /// Follow nothing more.
    pub leave: bool,
}

/// What an engine has to do next for consumers.
#[derive(Debug)]
pub enum Request<C> {
    /// What a cursor wants.
    Cursor(Wishes<C>),
    /// Send the newest frame once, without a cursor.
    SnapshotOnce(wire::View, Sender<Arc<Charged<wire::Message>>>),
    /// Tell that the engine is at work.
    Probe(Sender<()>),
}

impl<C> Wishes<C> {
    fn none(cursor: &Arc<C>) -> Self {
        Self { cursor: Arc::clone(cursor), join: None, view: None, tracks: None, snapshot: false, leave: false }
    }
}

/// The line of requests to one engine.
#[derive(Debug)]
pub struct Requests<C> {
    state: Lock<State<C>>,
    /// Wakes the engine.
    wake: Sender<()>,
}

#[derive(Debug)]
struct State<C> {
    /// The requests of each peer, in the order in which its cursors came.
    waiting: BTreeMap<u64, VecDeque<Request<C>>>,
    probes: Vec<Sender<()>>,
    /// Peers whose last request took long, and until when they wait.
    resting: BTreeMap<u64, Instant>,
    /// The peer that was served last.
    last: u64,
    is_closed: bool,
}

/// What the engine gets when it asks for the next request.
#[derive(Debug)]
pub enum Next<C> {
    /// A request, and the peer that made it.
    Request(u64, Request<C>),
    /// Nothing before this time, when a peer has waited long enough.
    NotBefore(Instant),
    /// Nothing.
    Nothing,
}

impl<C: Requester> Requests<C> {
    /// An empty line, which wakes its engine.
    pub fn new(wake: Sender<()>) -> Self {
        Self { state: Lock::new(Level::Requests, State::new()), wake }
    }

    /// Requests that a cursor follows a view. False if the engine has ended.
    pub fn join(&self, cursor: &Arc<C>, view: wire::View, resume: Option<wire::Resume>) -> bool {
        self.put(cursor, |wishes| wishes.join = Some((view, resume)))
    }

    /// Requests another view for a cursor.
    pub fn change_view(&self, cursor: &Arc<C>, change: wire::ChangeView) {
        self.put(cursor, |wishes| wishes.view = Some(change));
    }

    /// Requests tracks, or other tracks, for a cursor.
    pub fn want_tracks(&self, cursor: &Arc<C>, tracks: wire::TracksWanted) {
        self.put(cursor, |wishes| wishes.tracks = Some(tracks));
    }

    /// Requests a snapshot for a cursor.
    pub fn want_snapshot(&self, cursor: &Arc<C>) {
        self.put(cursor, |wishes| wishes.snapshot = true);
    }

    /// Requests that a cursor follows nothing any more.
    pub fn leave(&self, cursor: &Arc<C>) {
        self.put(cursor, |wishes| {
            // A cursor that has not joined has nothing to leave: its place in line is given up.
            *wishes = Wishes { leave: wishes.join.is_none(), ..Wishes::none(&wishes.cursor) };
        });
    }

    /// Requests the newest frame once. False if too many wait for that, or the engine has ended.
    pub fn snapshot_once(&self, view: wire::View, answer: Sender<Arc<Charged<wire::Message>>>) -> bool {
        let mut state = self.lock();
        if state.is_closed {
            return false;
        }
        let line = state.waiting.entry(VISITORS).or_default();
        let is_taken = line.len() < MOST_ONCE;
        if is_taken {
            line.push_back(Request::SnapshotOnce(view, answer));
        }
        drop(state);
        self.wake_engine();
        is_taken
    }

    /// Asks the engine for a sign of life.
    pub fn probe(&self, answer: Sender<()>) {
        let mut state = self.lock();
        if !state.is_closed && state.probes.len() < MOST_ONCE {
            state.probes.push(answer);
        }
        drop(state);
        self.wake_engine();
    }

    /// The next request: of the peer after the one that was served last.
    pub fn next(&self) -> Next<C> {
        let mut state = self.lock();
        if let Some(answer) = state.probes.pop() {
            return Next::Request(VISITORS, Request::Probe(answer));
        }
        state.next(Instant::now())
    }

    /// A peer's request took so long.
    pub fn note_cost(&self, peer: u64, took: Duration) {
        /// What takes less needs no rest.
        const SHORT: Duration = Duration::from_micros(200);
        if took > SHORT {
            self.lock().resting.insert(peer, Instant::now() + took);
        }
    }

    /// Takes nothing more, and gives what waits, whoever rests.
    pub fn close(&self) -> Vec<Request<C>> {
        let mut state = self.lock();
        state.is_closed = true;
        state.probes.clear();
        std::mem::take(&mut state.waiting).into_values().flatten().collect()
    }

    /// Changes what a cursor wants; whether the line is open.
    fn put(&self, cursor: &Arc<C>, change: impl FnOnce(&mut Wishes<C>)) -> bool {
        let mut state = self.lock();
        if state.is_closed {
            return false;
        }
        state.put(cursor, change);
        drop(state);
        self.wake_engine();
        true
    }

    fn wake_engine(&self) {
        // A full channel has a wake-up under way already.
        let _ = self.wake.try_send(());
    }

    fn lock(&self) -> Guard<'_, State<C>> {
        self.state.lock()
    }
}

impl<C: Requester> State<C> {
    fn new() -> Self {
        let (waiting, resting, probes) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        Self { waiting, probes, resting, last: VISITORS, is_closed: false }
    }

    fn put(&mut self, cursor: &Arc<C>, change: impl FnOnce(&mut Wishes<C>)) {
        let peer = cursor.peer();
        let line = self.waiting.entry(peer).or_default();
        let is_of_cursor =
            |request: &Request<C>| matches!(request, Request::Cursor(wishes) if Arc::ptr_eq(&wishes.cursor, cursor));
        let place = line.iter().position(is_of_cursor).unwrap_or_else(|| {
            line.push_back(Request::Cursor(Wishes::none(cursor)));
            line.len() - 1
        });
        let Request::Cursor(wishes) = &mut line[place] else { return };
        change(wishes);
        if wishes.is_empty() {
            line.remove(place);
        }
        if line.is_empty() {
            self.waiting.remove(&peer);
        }
    }

    fn next(&mut self, now: Instant) -> Next<C> {
        self.resting.retain(|_, until| *until > now);
        let after = self.waiting.range((Bound::Excluded(self.last), Bound::Unbounded));
        let mut in_turn = after.chain(self.waiting.range(..=self.last)).map(|(peer, _)| *peer);
        let Some(peer) = in_turn.find(|peer| !self.resting.contains_key(peer)) else {
            let resting = self.resting.iter().filter(|(peer, _)| self.waiting.contains_key(peer));
            return resting.map(|(_, until)| *until).min().map_or(Next::Nothing, Next::NotBefore);
        };
        self.last = peer;
        let Some(line) = self.waiting.get_mut(&peer) else { return Next::Nothing };
        let request = line.pop_front();
        if line.is_empty() {
            self.waiting.remove(&peer);
        }
        request.map_or(Next::Nothing, |request| Next::Request(peer, request))
    }
}

impl<C> Wishes<C> {
    fn is_empty(&self) -> bool {
        let Self { cursor: _, join, view, tracks, snapshot, leave } = self;
        join.is_none() && view.is_none() && tracks.is_none() && !snapshot && !leave
    }
}
