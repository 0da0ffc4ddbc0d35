//! Numbers as files of other programs hold them: integers and floats of a fixed size, in either byte order.
//!
//! In: bytes.
//! Out: the nearest double.
//! Must not know: where in a file a number stands.

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// The longest number in bytes.
pub const LONGEST: usize = 8;

impl Number {
    /// The number that has this kind and so many bytes: `i` signed, `u` unsigned, `f` a float.
    pub fn of(kind: char, size: u64) -> Option<Self> {
        Some(match (kind.to_ascii_lowercase(), size) {
            ('i', 1) => Self::I8,
            ('u', 1) => Self::U8,
            ('i', 2) => Self::I16,
            ('u', 2) => Self::U16,
            ('i', 4) => Self::I32,
            ('u', 4) => Self::U32,
            ('i', 8) => Self::I64,
            ('u', 8) => Self::U64,
            ('f', 4) => Self::F32,
            ('f', 8) => Self::F64,
            _ => return None,
        })
    }

    /// In bytes.
    pub const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Reads the number at the beginning of `bytes`, which must be long enough.
    #[inline]
    pub fn read(self, is_big_endian: bool, bytes: &[u8]) -> f64 {
        let mut raw = [0; LONGEST];
        let own = &mut raw[..self.size()];
        own.copy_from_slice(&bytes[..self.size()]);
        if is_big_endian {
            own.reverse();
        }
        let bits = u64::from_le_bytes(raw);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_both_byte_orders() {
        let cases: [(char, u64, &[u8], f64); 11] = [
            ('i', 1, &[0xff], -1.0),
            ('u', 1, &[0xff], 255.0),
            ('I', 2, &(-2i16).to_le_bytes(), -2.0),
            ('u', 2, &65_000u16.to_le_bytes(), 65_000.0),
            ('i', 4, &(-70_000i32).to_le_bytes(), -70_000.0),
            ('U', 4, &4_000_000_000u32.to_le_bytes(), 4e9),
            ('i', 8, &i64::MIN.to_le_bytes(), -9_223_372_036_854_775_808.0),
            ('u', 8, &u64::MAX.to_le_bytes(), 18_446_744_073_709_551_615.0),
            ('f', 4, &1.5f32.to_le_bytes(), 1.5),
            ('F', 8, &(-1e300f64).to_le_bytes(), -1e300),
            ('f', 8, &f64::INFINITY.to_le_bytes(), f64::INFINITY),
        ];
        for (kind, size, bytes, value) in cases {
            let number = Number::of(kind, size).unwrap();
            assert_eq!(number.read(false, bytes), value, "{kind}{size}");
            let reversed: Vec<u8> = bytes.iter().rev().copied().collect();
            assert_eq!(number.read(true, &reversed), value, "{kind}{size}, big endian");
        }
        assert!(Number::F32.read(false, &f32::NAN.to_le_bytes()).is_nan());
        for (kind, size) in [('f', 2), ('f', 16), ('i', 3), ('c', 8), ('i', 0)] {
            assert_eq!(Number::of(kind, size), None);
        }
    }
}
