//! LZF, the compression of binary PCD files.
//!
//! In: compressed bytes, in any pieces.
//! Out: what was compressed.
//! Invariant: memory is bounded by one piece, what it holds, and the 8 KiB that a reference reaches back.
//! Must not know: what was compressed.

/// How far a reference reaches back.
const REACH: usize = 1 << 13;

/// What the next byte is.
#[derive(Clone, Copy, Debug)]
enum Expected {
    Control,
    /// So many bytes are to be taken as they are.
    Literal(usize),
    /// The rest of a length, with the high part of the distance.
    Length(usize),
    /// The low part of the distance, with its high part and the length.
    Distance(usize, usize),
}

/// Decompresses.
#[derive(Debug)]
pub struct Lzf {
    expected: Expected,
    /// The last bytes that came out, and before that those of the present piece.
    out: Vec<u8>,
    /// Where those begin that were not handed out.
    fresh: usize,
    is_damaged: bool,
}

/// A reference reaches back before the beginning.
struct BadReference;

impl Lzf {
    pub fn new() -> Self {
        Self { expected: Expected::Control, out: Vec::new(), fresh: 0, is_damaged: false }
    }

    /// Decompresses a piece, up to where it is damaged.
    pub fn decompress(&mut self, piece: &[u8]) -> &[u8] {
        self.out.drain(..self.out.len().saturating_sub(REACH));
        self.fresh = self.out.len();
        for &byte in piece {
            if self.is_damaged {
                break;
            }
            match self.after(byte) {
                Ok(expected) => self.expected = expected,
                Err(BadReference) => self.is_damaged = true,
            }
        }
        &self.out[self.fresh..]
    }

    pub fn is_damaged(&self) -> bool {
        self.is_damaged
    }

    /// Whether the data may end here.
    pub fn is_whole(&self) -> bool {
        matches!(self.expected, Expected::Control)
    }

    fn after(&mut self, byte: u8) -> Result<Expected, BadReference> {
        let value = usize::from(byte);
        Ok(match self.expected {
            Expected::Control if value < 32 => Expected::Literal(value + 1),
            Expected::Control if value >> 5 == 7 => Expected::Length((value & 31) << 8),
            Expected::Control => Expected::Distance((value & 31) << 8, (value >> 5) + 2),
            Expected::Literal(left) => {
                self.out.push(byte);
                if left > 1 { Expected::Literal(left - 1) } else { Expected::Control }
            }
            Expected::Length(distance) => Expected::Distance(distance, value + 7 + 2),
            Expected::Distance(high, length) => {
                self.repeat(high + value + 1, length)?;
                Expected::Control
            }
        })
    }

    /// Bytes may repeat themselves.
    fn repeat(&mut self, distance: usize, length: usize) -> Result<(), BadReference> {
        let from = self.out.len().checked_sub(distance).ok_or(BadReference)?;
        for index in from..from + length {
            self.out.push(self.out[index]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_compressed_comes_out_however_it_is_cut() {
        // Three bytes as they are; a reference that overlaps itself; a long one; one byte more.
        let compressed = [2, b'a', b'b', b'c', 0b0110_0000, 2, 0b1110_0000, 10, 0, 0, b'z'];
        let expected = format!("abcabcab{}z", "b".repeat(19));
        for size in 1..=compressed.len() {
            let mut lzf = Lzf::new();
            let mut out = Vec::new();
            for piece in compressed.chunks(size) {
                out.extend_from_slice(lzf.decompress(piece));
            }
            assert_eq!(String::from_utf8(out).unwrap(), expected);
            assert!(lzf.is_whole());
        }
    }

    #[test]
    fn a_reference_before_the_beginning_is_found() {
        let mut lzf = Lzf::new();
        assert_eq!(lzf.decompress(&[0, b'a', 0b0010_0000, 1, 0, b'b']), b"a");
        assert!(lzf.is_damaged() && lzf.decompress(&[0, b'c']).is_empty());
        let mut lzf = Lzf::new();
        assert_eq!(lzf.decompress(&[5, 1, 2]), [1, 2]);
        assert!(!lzf.is_whole());
    }

    #[test]
    fn memory_is_bounded_and_the_far_end_of_the_reach_is_kept() {
        let mut lzf = Lzf::new();
        lzf.decompress(&[0, b'q']);
        for index in 0..REACH - 1 {
            lzf.decompress(&[0, (index % 7) as u8]);
        }
        assert_eq!(lzf.decompress(&[0b0011_1111, 0xff]), [b'q', 0, 1]);
        assert!(lzf.out.len() <= REACH + 3);
    }
}
