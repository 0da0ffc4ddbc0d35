//! The banner: what either side says first, so that any two versions understand each other this far.
//!
//! In and out: 20 bytes whose layout never changes (SPEC.md, section 2). Must not know: frames.

use thiserror::Error;

use crate::frame::FrameError;

/// The protocol version of this crate.
pub const VERSION: u16 = 2;

const MAGIC: [u8; 8] = *b"HOPES\r\n\x1a";

/// Which versions a side speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Banner {
    /// The lowest.
    pub lowest: u16,
    /// The highest.
    pub highest: u16,
}

/// Two sides have no version in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the other side speaks protocol versions {} to {}, this one {} to {}: update the older of the two",
    theirs.lowest, theirs.highest, ours.lowest, ours.highest
)]
pub struct NoCommonVersion {
    /// What this side speaks.
    pub ours: Banner,
    /// What the other side speaks.
    pub theirs: Banner,
}

impl Banner {
    /// What this crate speaks.
    pub const OURS: Self = Self { lowest: 1, highest: VERSION };

    /// Its length in bytes.
    pub const LENGTH: usize = 20;

    /// The banner's bytes.
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
    /// [`FrameError::Incomplete`] while bytes are missing, if those that are there are a banner's; [`FrameError::Malformed`] else.
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

    /// The highest version that both speak.
    ///
    /// # Errors
    /// [`NoCommonVersion`] says what either side speaks.
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
    fn without_one_both_are_named() {
        let error = Banner { lowest: 1, highest: 2 }.agree(Banner { lowest: 3, highest: 4 }).unwrap_err();
        assert!(error.to_string().starts_with("the other side speaks protocol versions 3 to 4, this one 1 to 2"));
    }

    #[test]
    fn a_banner_may_come_in_pieces_and_must_be_whole() {
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
