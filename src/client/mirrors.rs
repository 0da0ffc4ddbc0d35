//! What a consumer holds: a proved mirror of every stream that it follows.
//!
//! In: a daemon's messages about streams, live or recorded.
//! Out: whether a message was a frame, or why it cannot be believed.
//! Invariants: a frame that was taken is proved by its checksum. A mirror outlives its connection, so that the
//! stream can be resumed. The number of mirrors is bounded.
//! Must not know: where messages come from, how they are shown.

use std::collections::BTreeMap;

use hopes_protocol::{
    AnyMirror, Message, MirrorError, Resume, SpaceTrackMirror, StreamOpened, TrackMirror, TrackMirrorError, Window,
    is_name,
};
use thiserror::Error;

use crate::daemon::DEFAULT_STREAM;

/// At most so many streams are followed at once: a peer that announces more must not take all memory.
const STREAMS: usize = 1 << 14;

/// A stream that is followed.
#[derive(Debug)]
pub struct Stream {
    /// Its name.
    pub name: String,
    /// Which of the streams of that name.
    pub epoch: u64,
    /// What is known of it.
    pub mirror: AnyMirror,
    /// What is known of its tracks, if it is of the plane.
    tracks: TrackMirror,
    /// The same, if it is in a space.
    space_tracks: SpaceTrackMirror,
}

impl Stream {
    fn take_tracks(
        &mut self,
        take: impl FnOnce(&mut Self) -> Result<(), TrackMirrorError>,
    ) -> Result<(), MirrorsError> {
        take(self).map_err(|source| MirrorsError::Tracks { name: self.name.clone(), source })
    }
}

/// The mirrors of all streams that are followed, by number.
#[derive(Debug, Default)]
pub struct Mirrors(BTreeMap<u32, Stream>);

/// What a message was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// A frame that was proved.
    Frame,
    /// Something else about a stream.
    Other,
}

/// Why a message cannot be believed.
#[derive(Debug, Error)]
pub enum MirrorsError {
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

impl Mirrors {
    /// Takes a message in.
    ///
    /// # Errors
    /// [`MirrorsError`].
    pub fn take(&mut self, message: &Message) -> Result<Taken, MirrorsError> {
        match message {
            Message::StreamOpened(opened) => self.open(opened)?,
            frame if frame.frame().is_some() => {
                let stream = self.subject(frame)?;
                let named = |source| MirrorsError::Mirror { name: stream.name.clone(), source };
                return stream.mirror.apply(frame).map(|_| Taken::Frame).map_err(named);
            }
            Message::Tracks(tracks) => self.subject(message)?.take_tracks(|stream| stream.tracks.apply(tracks))?,
            Message::SpaceTracks(tracks) => {
                self.subject(message)?.take_tracks(|stream| stream.space_tracks.apply(tracks))?;
            }
            other => {
                self.subject(other)?;
            }
        }
        Ok(Taken::Other)
    }

    /// Takes a recorded message in: a stream that shows itself without having been announced is the default one.
    ///
    /// # Errors
    /// [`MirrorsError`].
    pub fn take_recorded(&mut self, message: &Message) -> Result<Taken, MirrorsError> {
        if let (Some(stream), Some(_)) = (message.stream(), message.frame())
            && !self.0.contains_key(&stream)
        {
            let (name, window) = (DEFAULT_STREAM.to_owned(), Window::All);
            self.open(&StreamOpened { stream, name, epoch: 0, window, resolution: None, frame: 0 })?;
        }
        self.take(message)
    }

    /// Forgets a stream that has ended, after that message was written.
    pub fn forget_closed(&mut self, message: &Message) {
        if let Message::StreamClosed(closed) = message {
            self.0.remove(&closed.stream);
        }
    }

    /// A stream by its number.
    pub fn get(&self, number: u32) -> Option<&Stream> {
        self.0.get(&number)
    }

    /// The name of the stream that a message is about; empty if it was not announced.
    pub fn name_of(&self, message: &Message) -> &str {
        let stream = message.stream().and_then(|number| self.get(number));
        stream.map_or("", |stream| stream.name.as_str())
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

    fn open(&mut self, opened: &StreamOpened) -> Result<(), MirrorsError> {
        let &StreamOpened { stream, ref name, epoch, .. } = opened;
        if !is_name(name) {
            return Err(MirrorsError::BadName(name.clone()));
        }
        // It may be known from an earlier connection or subscription, under whatever number.
        let known: Vec<u32> =
            self.0.iter().filter(|(_, known)| known.name == *name).map(|(number, _)| *number).collect();
        let known: Vec<Stream> = known.iter().filter_map(|number| self.0.remove(number)).collect();
        let mirror = known.into_iter().find(|known| known.epoch == epoch).map(|known| known.mirror);
        if self.0.len() >= STREAMS {
            return Err(MirrorsError::TooMany);
        }
        let (mirror, tracks, space_tracks) = (mirror.unwrap_or_default(), TrackMirror::new(), Default::default());
        self.0.insert(stream, Stream { name: name.clone(), epoch, mirror, tracks, space_tracks });
        Ok(())
    }

    /// The stream that a message is about.
    fn subject(&mut self, message: &Message) -> Result<&mut Stream, MirrorsError> {
        let number = message.stream().ok_or(MirrorsError::OutOfPlace { kind: message.kind() })?;
        self.0.get_mut(&number).ok_or(MirrorsError::NotOpened { stream: number })
    }
}

#[cfg(test)]
mod tests {
    use hopes_protocol::{Cause, Cut, FrameInfo, Simplify, Snapshot, View};

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
        let mut mirrors = Mirrors::default();
        mirrors.take(&opened(1, "a", 7)).unwrap();
        assert_eq!(mirrors.resume("a"), None, "there is nothing to resume from");
        assert_eq!(mirrors.take(&empty(1, 3)).unwrap(), Taken::Frame);
        assert_eq!(mirrors.resume("a"), Some(Resume { epoch: 7, frame: 3 }));
        mirrors.take(&opened(5, "a", 7)).unwrap();
        assert_eq!(mirrors.resume("a"), Some(Resume { epoch: 7, frame: 3 }));
        assert!(mirrors.get(1).is_none());
        mirrors.take(&opened(5, "a", 8)).unwrap();
        assert_eq!(mirrors.resume("a"), None, "another stream of that name");
    }

    #[test]
    fn streams_that_were_not_announced_are_refused() {
        let mut mirrors = Mirrors::default();
        assert!(matches!(mirrors.take(&empty(1, 1)), Err(MirrorsError::NotOpened { stream: 1 })));
        assert_eq!(mirrors.take_recorded(&empty(1, 1)).unwrap(), Taken::Frame);
        assert_eq!(mirrors.get(1).unwrap().name, DEFAULT_STREAM, "in a recording it has a name of its own");
        assert!(matches!(mirrors.take(&opened(1, "a\u{7}", 1)), Err(MirrorsError::BadName(_))));
        let ping = Message::Ping(hopes_protocol::Ping { token: 1 });
        assert!(matches!(mirrors.take(&ping), Err(MirrorsError::OutOfPlace { kind: 3 })));
    }
}
