//! Files and pipes in the bytes of the protocol: points in them, and recordings (protocol/SPEC.md, section 8).
//!
//! In: any [`Read`], or messages.
//! Out: messages with the place where each began; bytes for any [`Write`].
//! Invariants: a file that was cut off gives all whole frames before the cut, and the place of the cut. A damaged
//! one gives an error with its place. Memory grows with the bytes that are there, never with a length that they
//! announce. Only whole frames are written. What ended in good order ends with an end.
//! Must not know: what becomes of the messages.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::time::Duration;

use hopes_protocol::{
    Banner, BodyError, Decoder, Elapsed, FILE_VERSION, FrameError, Goodbye, LARGEST_FRAME, Message, NoCommonVersion,
    SPACE_FILE_VERSION, encode,
};
use thiserror::Error;

/// Why frames cannot be read on.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The source failed.
    #[error("reading failed at byte {offset}")]
    Io {
        /// Where.
        offset: u64,
        /// Why.
        source: io::Error,
    },
    /// Something else stands there.
    #[error("this was not written by hopes: {0}")]
    NotOurs(FrameError),
    /// Frames of another version.
    #[error("written by a hopes that is too new or too old: read it with that")]
    Version(#[from] NoCommonVersion),
    /// No frame begins there.
    #[error("damaged at byte {offset}: all before it is good")]
    Frame {
        /// Where.
        offset: u64,
        /// What is wrong.
        source: FrameError,
    },
    /// A frame that says nothing begins there.
    #[error("damaged at byte {offset}: all before it is good")]
    Body {
        /// Where.
        offset: u64,
        /// What is wrong.
        source: BodyError,
    },
}

/// What comes next.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "one at a time, and never kept")]
pub enum Next {
    /// A message.
    Message {
        /// Where its frame begins.
        offset: u64,
        /// Its channel.
        channel: u32,
        /// The version that it is in.
        version: u16,
        /// What it says.
        message: Message,
    },
    /// The source ends within what begins there.
    CutOff {
        /// Where.
        offset: u64,
    },
    /// The source ends.
    End,
}

/// Messages from a file or a pipe.
#[derive(Debug)]
pub struct Frames<R> {
    source: R,
    decoder: Decoder,
    buffer: Box<[u8]>,
    /// That of the banner, once it was read.
    version: Option<u16>,
    has_ended: bool,
}

impl<R: Read> Frames<R> {
    /// Nothing is read yet.
    pub fn new(source: R) -> Self {
        let (decoder, buffer) = (Decoder::new(LARGEST_FRAME), vec![0; 1 << 16].into());
        Self { source, decoder, buffer, version: None, has_ended: false }
    }

    /// Where the next frame begins.
    pub fn offset(&self) -> u64 {
        self.decoder.offset()
    }

    /// Whether more was read than was returned, so that the next message is unlikely to wait for the source.
    pub fn has_more(&self) -> bool {
        self.decoder.is_within_frame()
    }

    /// The next message.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn next(&mut self) -> Result<Next, RecordingError> {
        loop {
            if let Some(next) = self.ready()? {
                return Ok(next);
            }
            if self.has_ended {
                let is_whole = self.version.is_some() && !self.decoder.is_within_frame();
                return Ok(if is_whole { Next::End } else { Next::CutOff { offset: self.offset() } });
            }
            self.read()?;
        }
    }

    /// The next message, if it was read already.
    fn ready(&mut self) -> Result<Option<Next>, RecordingError> {
        let version = match self.version {
            Some(version) => version,
            None => {
                let Some(banner) = self.decoder.banner().map_err(RecordingError::NotOurs)? else { return Ok(None) };
                let version = Banner::OURS.agree(banner)?;
                self.decoder.set_version(version);
                *self.version.insert(version)
            }
        };
        let offset = self.offset();
        let frame = self.decoder.frame().map_err(|source| RecordingError::Frame { offset, source })?;
        let Some(frame) = frame else { return Ok(None) };
        let message = frame.message().map_err(|source| RecordingError::Body { offset, source })?;
        Ok(Some(Next::Message { offset, channel: frame.channel, version, message }))
    }

    fn read(&mut self) -> Result<(), RecordingError> {
        match self.source.read(&mut self.buffer) {
            Ok(count) => {
                // A source that claims more than it was given room for must not lead to a panic.
                self.decoder.push(&self.buffer[..count.min(self.buffer.len())]);
                self.has_ended = count == 0;
                Ok(())
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(()),
            Err(source) => Err(RecordingError::Io { offset: self.offset(), source }),
        }
    }
}

/// The end of a recording: why it ends, and the last frame of each stream that has not ended before.
pub fn end(reason: &str, streams: &BTreeMap<String, u64>) -> Message {
    let streams = streams.iter().map(|(name, &frame)| (name.clone(), frame)).collect();
    Goodbye { reason: reason.to_owned(), streams }.into()
}

/// Messages that are held, at most, until a frame shows what the recording is of.
const MOST_HELD: usize = 1024;

/// A recording that is being written.
///
/// It is in the version that older readers know, unless it has streams in spaces. What comes before the first frame is
/// held, until that shows which.
#[derive(Debug)]
pub struct Recording<W> {
    sink: W,
    bytes: u64,
    version: Option<u16>,
    /// Messages before the first frame, each with its time and channel.
    held: Vec<(Duration, u32, Message)>,
    /// The last frame of each stream that has not ended.
    streams: BTreeMap<String, u64>,
    has_ended: bool,
}

impl<W: Write> Recording<W> {
    /// Nothing is written yet.
    pub fn new(sink: W) -> Self {
        Self { sink, bytes: 0, version: None, held: Vec::new(), streams: BTreeMap::new(), has_ended: false }
    }

    /// The recording may have streams of the plane and in spaces: it is in a version that has both. Has no effect once
    /// a frame was written.
    pub fn set_mixed(&mut self) {
        self.version.get_or_insert(SPACE_FILE_VERSION);
    }

    /// Writes a message about the stream of that name, which came so long after the recording began, as a whole.
    ///
    /// # Errors
    /// Those of the sink; or the message is of a space, and all before were of the plane.
    pub fn write(&mut self, name: &str, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        let has_version = self.version.is_some();
        let is_of_space = message.since() > FILE_VERSION;
        if !has_version && (is_of_space || message.frame().is_some()) {
            self.settle(if is_of_space { SPACE_FILE_VERSION } else { FILE_VERSION })?;
        }
        match self.version {
            Some(version) => self.put(version, elapsed, channel, message)?,
            None if self.held.len() < MOST_HELD => self.held.push((elapsed, channel, message.clone())),
            None => {
                self.settle(SPACE_FILE_VERSION)?;
                self.put(SPACE_FILE_VERSION, elapsed, channel, message)?;
            }
        }
        self.note(name, message);
        Ok(())
    }

    /// Writes the end, unless it was written.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(&mut self, elapsed: Duration, reason: &str) -> io::Result<()> {
        if self.version.is_none() {
            self.settle(FILE_VERSION)?;
        }
        if self.has_ended { Ok(()) } else { self.write("", elapsed, 0, &end(reason, &self.streams)) }
    }

    /// How much was written.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// All is in this version from now on. Writes what was held.
    fn settle(&mut self, version: u16) -> io::Result<()> {
        self.version = Some(version);
        let held = std::mem::take(&mut self.held);
        held.iter().try_for_each(|(elapsed, channel, message)| self.put(version, *elapsed, *channel, message))
    }

    fn put(&mut self, version: u16, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        if message.since() > version {
            return Err(io::Error::other(
                "this recording began with a stream of the plane, and cannot have one in R^d: record that one to a \
                 file of its own",
            ));
        }
        let nanoseconds = u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX);
        let banner = Banner { lowest: version, highest: version }.encode();
        let mut bytes = if self.bytes == 0 { banner.to_vec() } else { Vec::new() };
        bytes.extend(encode(version, 0, &Elapsed { nanoseconds }.into()).map_err(io::Error::other)?);
        bytes.extend(encode(version, channel, message).map_err(io::Error::other)?);
        self.sink.write_all(&bytes)?;
        self.sink.flush()?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    fn note(&mut self, name: &str, message: &Message) {
        match message {
            Message::StreamClosed(_) => drop(self.streams.remove(name)),
            Message::Goodbye(_) => self.has_ended = true,
            message => {
                let Some(frame) = message.frame() else { return };
                match self.streams.get_mut(name) {
                    Some(last) => *last = frame.number,
                    None => drop(self.streams.insert(name.to_owned(), frame.number)),
                }
            }
        }
    }
}
