//! The banner: the first bytes that either side sends. Any two versions understand them.
//!
//! In and out: 20 bytes. Invariants: their layout never changes (SPEC.md, section 2). Must not know: frames.

use thiserror::Error;

use crate::frame::FrameError;

/// The protocol version that a side announces: the highest one that it serves.
pub const VERSION: u16 = 4;

/// The version of files: the lowest one that has all messages that files have, so that older readers read them.
pub const FILE_VERSION: u16 = 2;

/// The version of files of streams in R^d, whose messages older versions do not have.
pub const SPACE_FILE_VERSION: u16 = 4;

const MAGIC: [u8; 8] = *b"HOPES\r\n\x1a";

/// The range of protocol versions that a side supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Banner {
    /// The lowest version.
    pub lowest: u16,
    /// The highest version.
    pub highest: u16,
}

/// Two sides have no version in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the other side speaks protocol versions {} to {}, this one {} to {}: update the older of the two",
    theirs.lowest, theirs.highest, ours.lowest, ours.highest
)]
pub struct NoCommonVersion {
    /// The versions that this side supports.
    pub ours: Banner,
    /// The versions that the other side supports.
    pub theirs: Banner,
}

impl Banner {
    /// The versions that a side announces.
    pub const OURS: Self = Self { lowest: 1, highest: VERSION };

    /// The length of a banner in bytes.
    pub const LENGTH: usize = 20;

    /// The bytes of the banner.
    pub fn encode(self) -> [u8; Self::LENGTH] {
        let mut bytes = [0; Self::LENGTH];
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..10].copy_from_slice(&self.lowest.to_le_bytes());
        bytes[10..12].copy_from_slice(&self.highest.to_le_bytes());
        let crc = crc32c::crc32c(&bytes[..16]);
        bytes[16..].copy_from_slice(&crc.to_le_bytes());
        bytes
    }

    /// Reads the banner at the beginning of `bytes`.
    ///
    /// # Errors
    /// [`FrameError::Incomplete`]: the bytes are the beginning of a banner, and more are needed.
    /// [`FrameError::Malformed`]: the bytes are no banner.
    pub fn decode(bytes: &[u8]) -> Result<Self, FrameError> {
        let known = bytes.len().min(MAGIC.len());
        if bytes[..known] != MAGIC[..known] {
            return Err(FrameError::Malformed("the first bytes are not those of a hopes connection"));
        }
        let Some((banner, _)) = bytes.split_first_chunk::<{ Self::LENGTH }>() else {
            return Err(FrameError::Incomplete { missing: Self::LENGTH - bytes.len() });
        };
        let word = |at: usize| u16::from_le_bytes([banner[at], banner[at + 1]]);
        let crc = u32::from_le_bytes([banner[16], banner[17], banner[18], banner[19]]);
        if crc != crc32c::crc32c(&banner[..16]) {
            return Err(FrameError::Malformed("the banner's checksum does not fit"));
        }
        Ok(Self { lowest: word(8), highest: word(10) })
    }

    /// The highest version that both sides support.
    ///
    /// # Errors
    /// [`NoCommonVersion`]: there is none. It names the versions of both sides.
    pub fn agree(self, theirs: Self) -> Result<u16, NoCommonVersion> {
        let highest = self.highest.min(theirs.highest);
        if highest >= self.lowest.max(theirs.lowest) {
            Ok(highest)
        } else {
            Err(NoCommonVersion { ours: self, theirs })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_common_version_is_taken() {
        let speaks = |lowest, highest| Banner { lowest, highest };
        assert_eq!(speaks(1, 3).agree(speaks(2, 9)), Ok(3));
        assert_eq!(speaks(2, 9).agree(speaks(1, 3)), Ok(3));
        assert_eq!(speaks(1, 1).agree(speaks(1, 1)), Ok(1));
    }

    #[test]
    fn without_a_common_version_the_error_names_both_ranges() {
        let error = Banner { lowest: 1, highest: 2 }.agree(Banner { lowest: 3, highest: 4 }).unwrap_err();
        assert!(error.to_string().starts_with("the other side speaks protocol versions 3 to 4, this one 1 to 2"));
    }

    #[test]
    fn a_banner_is_incomplete_until_its_last_byte_and_detects_any_flipped_bit() {
        let bytes = Banner { lowest: 1, highest: 513 }.encode();
        for length in 0..Banner::LENGTH {
            let missing = Banner::LENGTH - length;
            assert_eq!(Banner::decode(&bytes[..length]), Err(FrameError::Incomplete { missing }));
        }
        assert_eq!(Banner::decode(&bytes), Ok(Banner { lowest: 1, highest: 513 }));
        for bit in 0..Banner::LENGTH * 8 {
            let mut broken = bytes;
            broken[bit / 8] ^= 1 << (bit % 8);
            assert!(matches!(Banner::decode(&broken), Err(FrameError::Malformed(_))), "bit {bit}");
        }
        assert!(matches!(Banner::decode(b"GET / HTTP/1.1"), Err(FrameError::Malformed(_))));
    }
}
