//! The decoder: finds the banner and the frames in a stream of bytes (SPEC.md, sections 2 and 3).
//!
//! In: bytes, cut anywhere. Out: a [`Banner`] and [`Frame`]s.
//!
//! Invariants: a length is compared with the limit before any byte of the body is waited for. Memory grows with the
//! bytes that have arrived, never with the length that is announced. After any error except [`FrameError::Incomplete`]
//! nothing more can be read.
//!
//! Must not know: what bodies mean.

use crate::banner::Banner;
use crate::codec::BodyError;
use crate::frame::{CRC, FrameError, HEADER, MAGIC};
use crate::message::Message;

/// The buffer is not shrunk below this number of bytes.
const KEPT: usize = 1 << 16;

/// A message that has arrived as a whole. Its body is not read yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The protocol version of the frame.
    pub version: u16,
    /// The channel of the message.
    pub channel: u32,
    /// The type of the message.
    pub kind: u16,
    /// The encoded fields.
    pub body: Vec<u8>,
}

impl Frame {
    /// Reads the body.
    ///
    /// # Errors
    /// [`BodyError`].
    pub fn message(&self) -> Result<Message, BodyError> {
        Message::decode(self.version, self.kind, &self.body)
    }
}

/// Finds the banner and the frames in a stream of bytes.
#[derive(Debug)]
pub struct Decoder {
    buffer: Vec<u8>,
    /// The number of bytes at the beginning of the buffer that are decoded.
    taken: usize,
    largest: u32,
    /// The version that both sides agreed on, once it is known.
    version: Option<u16>,
    /// The number of all bytes that are decoded.
    offset: u64,
}

impl Decoder {
    /// A decoder that accepts bodies of at most `largest` bytes.
    ///
    /// It accepts every version that this crate announces until [`set_version`](Self::set_version) is called.
    pub fn new(largest: u32) -> Self {
        Self { buffer: Vec::new(), taken: 0, largest, version: None, offset: 0 }
    }

    /// Sets the version that both sides agreed on.
    pub fn set_version(&mut self, version: u16) {
        self.version = Some(version);
    }

    /// Appends received bytes.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.taken > 0 {
            self.buffer.drain(..self.taken);
            self.taken = 0;
        }
        self.buffer.extend_from_slice(bytes);
        // The memory of one large frame must not be kept for ever.
        if self.buffer.len() < self.buffer.capacity() / 4 {
            self.buffer.shrink_to(KEPT);
        }
    }

    /// Whether a part of a frame has arrived.
    pub fn is_within_frame(&self) -> bool {
        self.taken < self.buffer.len()
    }

    /// The memory that is held for bytes that are not decoded yet.
    pub fn capacity(&self) -> usize {
        self.buffer.capacity()
    }

    /// The offset of the next frame in the stream of bytes.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// The banner, or none while bytes are missing. Call this until the banner is there, before the first frame.
    ///
    /// # Errors
    /// [`FrameError::Malformed`].
    pub fn banner(&mut self) -> Result<Option<Banner>, FrameError> {
        match Banner::decode(&self.buffer[self.taken..]) {
            Err(FrameError::Incomplete { .. }) => Ok(None),
            Ok(banner) => {
                self.take(Banner::LENGTH);
                Ok(Some(banner))
            }
            Err(error) => Err(error),
        }
    }

    /// The next frame, or none while bytes are missing.
    ///
    /// # Errors
    /// Any [`FrameError`] except [`Incomplete`](FrameError::Incomplete). Nothing more can be read after it.
    pub fn frame(&mut self) -> Result<Option<Frame>, FrameError> {
        match decode(&self.buffer[self.taken..], self.version, self.largest) {
            Err(FrameError::Incomplete { .. }) => Ok(None),
            Ok((frame, length)) => {
                self.take(length);
                Ok(Some(frame))
            }
            Err(error) => Err(error),
        }
    }

    fn take(&mut self, length: usize) {
        self.taken += length;
        self.offset += length as u64;
        if self.taken == self.buffer.len() {
            self.buffer.clear();
            self.taken = 0;
        }
    }
}

/// The frame at the beginning of `bytes`, and its length.
fn decode(bytes: &[u8], agreed: Option<u16>, largest: u32) -> Result<(Frame, usize), FrameError> {
    let Some((header, rest)) = bytes.split_first_chunk::<HEADER>() else {
        return Err(FrameError::Incomplete { missing: HEADER - bytes.len() });
    };
    let short = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
    let long = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    if header[..4] != MAGIC {
        return Err(FrameError::Malformed("it does not begin with hopF"));
    }
    if long(16) != crc32c::crc32c(&header[..16]) {
        return Err(FrameError::Malformed("the header's checksum does not fit"));
    }
    let (found, kind, channel, length) = (short(4), short(6), long(8), long(12));
    let Banner { lowest, highest } = agreed.map_or(Banner::OURS, |agreed| Banner { lowest: agreed, highest: agreed });
    if !(lowest..=highest).contains(&found) {
        return Err(FrameError::UnsupportedVersion { found, agreed: highest });
    }
    if length > largest {
        return Err(FrameError::TooLarge { length, largest });
    }
    let needed = length as usize + CRC;
    let Some((body, crc)) = rest.get(..needed).and_then(|rest| rest.split_last_chunk::<CRC>()) else {
        return Err(FrameError::Incomplete { missing: needed - rest.len() });
    };
    if u32::from_le_bytes(*crc) != crc32c::crc32c(body) {
        return Err(FrameError::Malformed("the body's checksum does not fit"));
    }
    Ok((Frame { version: found, channel, kind, body: body.to_vec() }, HEADER + needed))
}
