//! The outer frame: its header, and why bytes are not a frame (SPEC.md, section 3).
//!
//! In: version, type, channel and length. Out: a header. Must not know: bodies, connections.

use thiserror::Error;

/// Length of a frame's header in bytes.
pub const HEADER: usize = 20;

/// The default limit of a client for a body in bytes: snapshots of some ten million points.
pub const LARGEST_FRAME: u32 = 1 << 30;

/// The first bytes of a header.
pub(crate) const MAGIC: [u8; 4] = *b"hopF";
/// Length of the CRC-32C behind a body in bytes.
pub(crate) const CRC: usize = 4;

/// Why bytes are not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FrameError {
    /// More bytes are needed.
    #[error("at least {missing} more bytes are needed")]
    Incomplete {
        /// The number of bytes that are needed at least.
        missing: usize,
    },
    /// The bytes are not the beginning of a frame.
    #[error("this is not a hopes frame: {0}")]
    Malformed(&'static str),
    /// The frame has another version than the connection.
    #[error("a frame of protocol version {found}, where version {agreed} was agreed on")]
    UnsupportedVersion {
        /// The version of the frame.
        found: u16,
        /// The version of the connection.
        agreed: u16,
    },
    /// The frame is larger than the limit of this side.
    #[error("a frame of {length} bytes, where the largest taken has {largest}")]
    TooLarge {
        /// The length of its body in bytes.
        length: u32,
        /// The limit.
        largest: u32,
    },
}

/// The header of a frame. Its body and the CRC-32C of the body follow it.
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
