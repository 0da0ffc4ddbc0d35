//! The outer frame: where a message begins and ends, and whether it has arrived whole.
//!
//! In: bytes as they come. Out: [`Frame`]s; headers to be written. Invariants: a length is checked against a cap before a byte of the body is waited for; memory
//! grows with the bytes that have come, never with those that are announced; after any error but [`FrameError::Incomplete`] the stream is lost. Must not know: what bodies
//! mean (SPEC.md, section 3).

use thiserror::Error;

use crate::banner::Banner;
use crate::codec::BodyError;
use crate::message::Message;

/// Length of a frame's header in bytes.
pub const HEADER: usize = 20;

/// The largest body that a client should take if it has no opinion of its own: snapshots of some ten million points.
pub const LARGEST_FRAME: u32 = 1 << 30;

/// A decoder's buffer is not made smaller than this.
const KEPT: usize = 1 << 20;

const MAGIC: [u8; 4] = *b"hopF";
const CRC: usize = 4;

/// Why bytes are no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// They may become one.
    #[error("at least {missing} more bytes are needed")]
    Incomplete {
        /// So many bytes at least.
        missing: usize,
    },
    /// They are not one.
    #[error("this is not a hopes frame: {0}")]
    Malformed(&'static str),
    /// A version that was not agreed on.
    #[error("a frame of protocol version {found}, where version {agreed} was agreed on")]
    UnsupportedVersion {
        /// The frame's.
        found: u16,
        /// The connection's.
        agreed: u16,
    },
    /// It is larger than this side takes.
    #[error("a frame of {length} bytes, where the largest taken has {largest}")]
    TooLarge {
        /// Of its body.
        length: u32,
        /// The cap.
        largest: u32,
    },
}

/// A message as it came: known to be whole, not read yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The version of the protocol that it is of.
    pub version: u16,
    /// The conversation that it belongs to.
    pub channel: u32,
    /// Type of the message.
    pub kind: u16,
    /// Its fields.
    pub body: Vec<u8>,
}

impl Frame {
    /// What it says.
    ///
    /// # Errors
    /// [`BodyError`].
    pub fn message(&self) -> Result<Message, BodyError> {
        Message::decode(self.version, self.kind, &self.body)
    }
}

/// The header of a frame; its body, and the body's CRC-32C, are to follow.
pub fn header(version: u16, kind: u16, channel: u32, length: u32) -> [u8; HEADER] {
    let mut bytes = [0; HEADER];
    bytes[..4].copy_from_slice(&MAGIC);
    bytes[4..6].copy_from_slice(&version.to_le_bytes());
    bytes[6..8].copy_from_slice(&kind.to_le_bytes());
    bytes[8..12].copy_from_slice(&channel.to_le_bytes());
    bytes[12..16].copy_from_slice(&length.to_le_bytes());
    let crc = crc32c::crc32c(&bytes[..16]);
    bytes[16..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// Finds banner and frames in bytes that come in any pieces.
#[derive(Debug)]
pub struct Decoder {
    buffer: Vec<u8>,
    /// Bytes of the buffer that are done with.
    taken: usize,
    largest: u32,
    /// The version that was agreed on, once it was.
    version: Option<u16>,
    /// Bytes that are done with, in all.
    offset: u64,
}

impl Decoder {
    /// Takes frames with a body of up to so many bytes, of every version that this crate speaks until one is set.
    pub fn new(largest: u32) -> Self {
        Self { buffer: Vec::new(), taken: 0, largest, version: None, offset: 0 }
    }

    /// Sets the version that was agreed on.
    pub fn set_version(&mut self, version: u16) {
        self.version = Some(version);
    }

    /// Takes bytes in.
    pub fn push(&mut self, bytes: &[u8]) {
        if self.taken > 0 {
            self.buffer.drain(..self.taken);
            self.taken = 0;
        }
        self.buffer.extend_from_slice(bytes);
        // One large frame must not hold its memory for ever.
        if self.buffer.len() < self.buffer.capacity() / 4 {
            self.buffer.shrink_to(KEPT);
        }
    }

    /// Whether something has come that is not a whole frame yet.
    pub fn is_within_frame(&self) -> bool {
        self.taken < self.buffer.len()
    }

    /// Where in the stream of bytes the next frame begins.
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// The banner, once it is there; to be asked for before the first frame, once.
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

    /// The next frame, once it is there.
    ///
    /// # Errors
    /// Any [`FrameError`] but [`Incomplete`](FrameError::Incomplete). The stream is lost then.
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
