//! Files and pipes in the bytes of the protocol: points in them, and recordings (protocol/SPEC.md, section 8).
//!
//! In: any [`Read`], or messages.
//! Out: messages with the place where each began; bytes for any [`Write`].
//! Invariants: a file that was cut off gives all whole frames before the cut, and the place of the cut. A damaged
//! one gives an error with its place. Memory grows with the bytes that are there, never with a length that they
//! announce. Only whole frames are written.
//! Must not know: what becomes of the messages.

use std::io::{self, Read, Write};
use std::time::Duration;

use hopes_protocol::{
    Banner, BodyError, Decoder, Elapsed, FILE_VERSION, FrameError, LARGEST_FRAME, Message, NoCommonVersion, encode,
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
    /// Whether the banner was read.
    has_begun: bool,
    has_ended: bool,
}

impl<R: Read> Frames<R> {
    /// Nothing is read yet.
    pub fn new(source: R) -> Self {
        let (decoder, buffer) = (Decoder::new(LARGEST_FRAME), vec![0; 1 << 16].into());
        Self { source, decoder, buffer, has_begun: false, has_ended: false }
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
                let is_whole = self.has_begun && !self.decoder.is_within_frame();
                return Ok(if is_whole { Next::End } else { Next::CutOff { offset: self.offset() } });
            }
            self.read()?;
        }
    }

    /// The next message, if it was read already.
    fn ready(&mut self) -> Result<Option<Next>, RecordingError> {
        if !self.has_begun {
            let Some(banner) = self.decoder.banner().map_err(RecordingError::NotOurs)? else { return Ok(None) };
            self.decoder.set_version(Banner::OURS.agree(banner)?);
            self.has_begun = true;
        }
        let offset = self.offset();
        let frame = self.decoder.frame().map_err(|source| RecordingError::Frame { offset, source })?;
        let Some(frame) = frame else { return Ok(None) };
        let message = frame.message().map_err(|source| RecordingError::Body { offset, source })?;
        Ok(Some(Next::Message { offset, channel: frame.channel, message }))
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

/// A recording that is being written.
#[derive(Debug)]
pub struct Recording<W> {
    sink: W,
    bytes: u64,
}

impl<W: Write> Recording<W> {
    /// Begins with the banner.
    pub fn new(mut sink: W) -> io::Result<Self> {
        let banner = Banner { lowest: FILE_VERSION, highest: FILE_VERSION }.encode();
        sink.write_all(&banner)?;
        sink.flush()?;
        Ok(Self { sink, bytes: banner.len() as u64 })
    }

    /// Writes a message that came so long after the recording began, as a whole.
    pub fn write(&mut self, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        let nanoseconds = u64::try_from(elapsed.as_nanos()).unwrap_or(u64::MAX);
        let mut bytes = encode(FILE_VERSION, 0, &Elapsed { nanoseconds }.into()).map_err(io::Error::other)?;
        bytes.extend(encode(FILE_VERSION, channel, message).map_err(io::Error::other)?);
        self.sink.write_all(&bytes)?;
        self.sink.flush()?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// How much was written.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}
