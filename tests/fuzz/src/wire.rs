//! Bytes of the protocol whose checksums are right, so that mutated inputs pass beyond them.
//!
//! In: any bytes. Out: the same, with the CRC of the banner, of each header and of each whole body set.
//!
//! Must not know: what bodies mean.

use hopes_protocol::{Banner, HEADER};

/// The bytes with the right CRCs.
pub fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let mut at = Banner::LENGTH;
    seal(&mut bytes, 0, 16);
    while let Some(header) = bytes.get(at..at + HEADER) {
        let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]) as usize;
        seal(&mut bytes, at, 16);
        seal(&mut bytes, at + HEADER, length);
        at += HEADER + length + 4;
    }
    bytes
}

/// Sets the CRC behind so many bytes, if all of them are there.
fn seal(bytes: &mut [u8], from: usize, length: usize) {
    if let Some((sealed, crc)) =
        bytes.get_mut(from..from + length + 4).and_then(|part| part.split_at_mut_checked(length))
    {
        crc.copy_from_slice(&crc32c::crc32c(sealed).to_le_bytes());
    }
}
