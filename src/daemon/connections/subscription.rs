//! A channel on which a peer follows streams: a pattern of names, and a cursor in each stream that matches.
//!
//! In: streams as they begin and end, requests of the peer. Out: cursors of the connection, requests to engines.
//!
//! Invariants: a stream has one cursor per subscription; an ended subscription makes no cursor.
//!
//! Must not know: how streams are computed, sockets.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use hopes_protocol as wire;
use wildmatch::WildMatchPattern;

use super::connection::Connection;
use crate::daemon::locks::{Level, Lock};
use crate::daemon::report::report;
use crate::daemon::streams::directory::StreamWatcher;
use crate::daemon::streams::publishing::cursor::Cursor;
use crate::daemon::streams::stream::Stream;
use crate::daemon::streams::stream_state::StreamState;

/// Matches names in which `*` stands for any run of characters. No name has a NUL, so nothing stands for a single one.
pub type Pattern = WildMatchPattern<'*', '\0'>;

/// The first version of the protocol that has spaces.
const SPACES_SINCE: u16 = 4;

/// A subscription.
#[derive(Debug)]
pub struct Subscription {
    channel: u32,
    connection: Arc<Connection>,
    pattern: Pattern,
    /// The view, and the tracks, that are wanted of streams that come later.
    wanted: Lock<(wire::ChangeView, wire::TracksWanted)>,
    is_over: AtomicBool,
}

impl Subscription {
    /// A subscription on a channel of a connection.
    pub fn new(channel: u32, connection: Arc<Connection>, pattern: Pattern, view: wire::ChangeView) -> Self {
        let wanted = Lock::new(Level::Wanted, (view, wire::TracksWanted::default()));
        Self { channel, connection, pattern, wanted, is_over: AtomicBool::new(false) }
    }

    /// Makes no cursor any more, and ends those that it has.
    pub fn end(&self) {
        self.is_over.store(true, Ordering::Release);
        self.connection.end_cursors(self.channel);
    }

    /// The view that is wanted.
    pub fn view(&self) -> wire::View {
        self.wanted.lock().0.view
    }

    /// Follows another view.
    pub fn change_view(&self, change: wire::ChangeView) {
        let cursors = self.connection.cursors.lock();
        self.wanted.lock().0 = change;
        self.of_channel(&cursors).for_each(|cursor| cursor.change_view(change));
    }

    /// Wants tracks, or other tracks.
    pub fn want_tracks(&self, tracks: wire::TracksWanted) {
        let cursors = self.connection.cursors.lock();
        self.wanted.lock().1 = tracks;
        self.of_channel(&cursors).for_each(|cursor| cursor.request_tracks(tracks));
    }

    fn of_channel<'a>(&self, cursors: &'a [(u32, Arc<Cursor>)]) -> impl Iterator<Item = &'a Arc<Cursor>> {
        cursors.iter().filter(|(channel, _)| *channel == self.channel).map(|(_, cursor)| cursor)
    }
}

/// Why a peer that speaks this version cannot follow a stream, if it cannot.
pub fn too_new(stream: &StreamState, version: u16) -> Option<String> {
    stream.space.as_ref().filter(|_| version < SPACES_SINCE).map(|_| {
        format!(
            "stream {:?} is of points in R^d, which needs version {SPACES_SINCE} of the protocol, and this connection \
             speaks {version}: update the client",
            stream.name
        )
    })
}

impl StreamWatcher for Subscription {
    fn matches(&self, name: &str) -> bool {
        self.pattern.matches(name)
    }

    fn stream_opened(&self, stream: &Arc<Stream>, resume: Option<wire::Resume>) {
        let mut cursors = self.connection.cursors.lock();
        if self.is_over.load(Ordering::Acquire) {
            return;
        }
        if let Some(text) = too_new(&stream.state, self.connection.version()) {
            return self.connection.send(self.channel, report(wire::ErrorCode::NeedsVersion, 0, text));
        }
        let (view, tracks) = *self.wanted.lock();
        let cursor = stream.cursor(&self.connection.consumer, view.dots, tracks);
        cursors.push((self.channel, Arc::clone(&cursor)));
        stream.join(&cursor, view.view, resume);
        // The message that the stream is there is sent even if it has no frame.
        cursor.wake();
    }

    fn stream_ended(&self, stream: &Arc<Stream>, reason: &str) {
        let cursors = self.connection.cursors.lock();
        self.of_channel(&cursors)
            .filter(|cursor| Arc::ptr_eq(&cursor.stream, &stream.state))
            .for_each(|cursor| cursor.close(stream.state.stats.frame(), reason));
    }
}
