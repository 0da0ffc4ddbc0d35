//! What a consumer holds: a proved mirror for every stream that it follows.
//!
//! In: a daemon's messages about streams, live or recorded. Out: whether one has shown a frame, or why it cannot be believed. Invariants: a frame that was taken is proved by its checksum; a mirror outlives its connection, so that a
//! stream can be resumed. Must not know: where messages come from, how they are shown.

use std::collections::BTreeMap;

use hopes_protocol::{
    Diff, Message, Mirror, MirrorError, Resume, Snapshot, StreamOpened, TrackMirror, TrackMirrorError, Window, is_name,
};
use thiserror::Error;

use crate::daemon::DEFAULT_STREAM;

/// More streams than this nobody follows at once: whoever announces them must not take all memory.
const STREAMS: usize = 1 << 14;

/// A stream that is followed.
#[derive(Debug)]
pub struct Stream {
    /// Its name.
    pub name: String,
    /// Which of the streams of that name.
    pub epoch: u64,
    /// What is known of it.
    pub mirror: Mirror,
    /// What is known of its tracks.
    tracks: TrackMirror,
}

/// All that are followed, by number.
#[derive(Debug, Default)]
pub struct Streams(BTreeMap<u32, Stream>);

/// What a message was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// A frame, proved.
    Frame,
    /// Something else about a stream.
    Other,
}

/// Why a message cannot be believed.
#[derive(Debug, Error)]
pub enum StreamError {
    /// It does not lead on from what is held: there is a gap.
    #[error("stream {name}")]
    Mirror {
        /// Of the stream.
        name: String,
        /// What is wrong.
        source: MirrorError,
    },
    /// What it says of tracks does not lead on from what is held.
    #[error("stream {name}")]
    Tracks {
        /// Of the stream.
        name: String,
        /// What is wrong.
        source: TrackMirrorError,
    },
    /// It is about a stream that was never announced.
    #[error("there is no stream number {stream} in this subscription")]
    NotOpened {
        /// The number.
        stream: u32,
    },
    /// A name that no stream may have.
    #[error("a stream has the name {0:?}, which none may have")]
    BadName(String),
    /// More than can be.
    #[error("there are more than {STREAMS} streams: ask for fewer by a narrower pattern")]
    TooMany,
    /// It is not about a stream.
    #[error("a message of type {kind:#06x} has no place in a subscription")]
    OutOfPlace {
        /// The type.
        kind: u16,
    },
}

impl Streams {
    /// Takes a message in.
    ///
    /// # Errors
    /// [`StreamError`].
    pub fn take(&mut self, message: &Message) -> Result<Taken, StreamError> {
        match message {
            Message::StreamOpened(opened) => self.open(opened)?,
            Message::StreamClosed(closed) => self.known(closed.stream).map(drop)?,
            Message::Snapshot(snapshot) => {
                let stream = self.known(snapshot.stream)?;
                return proved(&stream.name, stream.mirror.apply_snapshot(snapshot));
            }
            Message::Diff(diff) => {
                let stream = self.known(diff.stream)?;
                return proved(&stream.name, stream.mirror.apply_diff(diff));
            }
            Message::Dots(dots) => self.known(dots.stream).map(drop)?,
            Message::Tracks(tracks) => {
                let stream = self.known(tracks.stream)?;
                let name = || stream.name.clone();
                stream.tracks.apply(tracks).map_err(|source| StreamError::Tracks { name: name(), source })?;
            }
            Message::Heartbeat(heartbeat) => self.known(heartbeat.stream).map(drop)?,
            Message::Lagged(lagged) => self.known(lagged.stream).map(drop)?,
            Message::Resumed(resumed) => self.known(resumed.stream).map(drop)?,
            other => return Err(StreamError::OutOfPlace { kind: other.kind() }),
        }
        Ok(Taken::Other)
    }

    /// Takes a recorded message in: a stream that shows itself without having been announced is the default one.
    ///
    /// # Errors
    /// [`StreamError`].
    pub fn take_recorded(&mut self, message: &Message) -> Result<Taken, StreamError> {
        if let Message::Snapshot(Snapshot { stream, .. }) | Message::Diff(Diff { stream, .. }) = message
            && !self.0.contains_key(stream)
        {
            let (name, window) = (DEFAULT_STREAM.to_owned(), Window::All);
            self.open(&StreamOpened { stream: *stream, name, epoch: 0, window, resolution: None, frame: 0 })?;
        }
        self.take(message)
    }

    /// Forgets a stream that has ended, once that was shown.
    pub fn forget_closed(&mut self, message: &Message) {
        if let Message::StreamClosed(closed) = message {
            self.0.remove(&closed.stream);
        }
    }

    /// A stream by its number.
    pub fn get(&self, number: u32) -> Option<&Stream> {
        self.0.get(&number)
    }

    /// All.
    pub fn iter(&self) -> impl Iterator<Item = &Stream> {
        self.0.values()
    }

    /// Where the stream of that name can be resumed.
    pub fn resume(&self, name: &str) -> Option<Resume> {
        let stream = self.iter().find(|stream| stream.name == name)?;
        let (epoch, frame) = (stream.epoch, stream.mirror.number());
        (frame > 0 && !stream.mirror.needs_snapshot()).then_some(Resume { epoch, frame })
    }

    fn open(&mut self, opened: &StreamOpened) -> Result<(), StreamError> {
        let &StreamOpened { stream, ref name, epoch, .. } = opened;
        if !is_name(name) {
            return Err(StreamError::BadName(name.clone()));
        }
        // It may be known from an earlier connection or subscription, under whatever number.
        let known: Vec<u32> =
            self.0.iter().filter(|(_, known)| known.name == *name).map(|(number, _)| *number).collect();
        let known: Vec<Stream> = known.iter().filter_map(|number| self.0.remove(number)).collect();
        let mirror = known.into_iter().find(|known| known.epoch == epoch).map(|known| known.mirror);
        if self.0.len() >= STREAMS {
            return Err(StreamError::TooMany);
        }
        let tracks = TrackMirror::new();
        self.0.insert(stream, Stream { name: name.clone(), epoch, mirror: mirror.unwrap_or_default(), tracks });
        Ok(())
    }

    fn known(&mut self, number: u32) -> Result<&mut Stream, StreamError> {
        self.0.get_mut(&number).ok_or(StreamError::NotOpened { stream: number })
    }
}

fn proved(name: &str, outcome: Result<(), MirrorError>) -> Result<Taken, StreamError> {
    match outcome {
        Ok(()) => Ok(Taken::Frame),
        Err(source) => Err(StreamError::Mirror { name: name.to_owned(), source }),
    }
}

#[cfg(test)]
mod tests {
    use hopes_protocol::{Cause, Cut, FrameInfo, Simplify, View};

    use super::*;

    fn opened(stream: u32, name: &str, epoch: u64) -> Message {
        StreamOpened { stream, name: name.to_owned(), epoch, window: Window::All, resolution: None, frame: 0 }.into()
    }

    fn empty(stream: u32, number: u64) -> Message {
        let view = View { cut: Cut::Full, simplify: Simplify::No };
        let frame = FrameInfo {
            number,
            time: None,
            points: 0,
            vertices: 0,
            rejected: 0,
            view,
            ds: None,
            vs: None,
            components: 0,
            cycles: 0,
        };
        let (vertices, edges, critical) = (Vec::new(), Vec::new(), Vec::new());
        Snapshot { stream, cause: Cause::Start, frame, vertices, edges, critical, checksum: 0 }.into()
    }

    #[test]
    fn a_stream_is_known_again_by_name_and_epoch() {
        let mut streams = Streams::default();
        streams.take(&opened(1, "a", 7)).unwrap();
        assert_eq!(streams.resume("a"), None, "there is nothing to resume from");
        assert_eq!(streams.take(&empty(1, 3)).unwrap(), Taken::Frame);
        assert_eq!(streams.resume("a"), Some(Resume { epoch: 7, frame: 3 }));
        streams.take(&opened(5, "a", 7)).unwrap();
        assert_eq!(streams.resume("a"), Some(Resume { epoch: 7, frame: 3 }));
        assert!(streams.get(1).is_none());
        streams.take(&opened(5, "a", 8)).unwrap();
        assert_eq!(streams.resume("a"), None, "another stream of that name");
    }

    #[test]
    fn what_was_not_announced_is_not_believed() {
        let mut streams = Streams::default();
        assert!(matches!(streams.take(&empty(1, 1)), Err(StreamError::NotOpened { stream: 1 })));
        assert_eq!(streams.take_recorded(&empty(1, 1)).unwrap(), Taken::Frame);
        assert_eq!(streams.get(1).unwrap().name, DEFAULT_STREAM, "in a recording it has a name of its own");
        assert!(matches!(streams.take(&opened(1, "a\u{7}", 1)), Err(StreamError::BadName(_))));
        let ping = Message::Ping(hopes_protocol::Ping { token: 1 });
        assert!(matches!(streams.take(&ping), Err(StreamError::OutOfPlace { kind: 3 })));
    }
}
