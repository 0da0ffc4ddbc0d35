//! The checksum of a skeleton. It proves that a mirror holds what was sent (SPEC.md, section 7).
//!
//! In: elements, one by one. Out: 64 bits.
//!
//! Invariants: the checksum is the sum, modulo 2^64, of a hash of each element. So elements are added and removed in
//! any order.
//!
//! Must not know: where elements are stored.

use crate::types::{Critical, Edge, Vertex};

/// A sum of hashes of elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Checksum(pub u64);

impl Checksum {
    /// Adds an element.
    pub fn add(&mut self, element: impl Into<Element>) {
        self.0 = self.0.wrapping_add(element.into().0);
    }

    /// Removes an element.
    pub fn remove(&mut self, element: impl Into<Element>) {
        self.0 = self.0.wrapping_sub(element.into().0);
    }
}

/// The hash of an element.
#[derive(Clone, Copy, Debug)]
pub struct Element(u64);

impl From<Vertex> for Element {
    fn from((id, x, y): Vertex) -> Self {
        Self(hash(&[1, id, x.to_bits(), y.to_bits()]))
    }
}

impl From<Edge> for Element {
    fn from((a, b): Edge) -> Self {
        Self(hash(&[2, a, b]))
    }
}

impl From<Critical> for Element {
    fn from((a, b, birth, death): Critical) -> Self {
        Self(hash(&[3, a, b, birth.to_bits(), death.to_bits()]))
    }
}

/// The finaliser of SplitMix64, folded over words.
fn hash(words: &[u64]) -> u64 {
    words.iter().fold(0, |hash, word| {
        let z = (hash ^ word).wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The engine has the same test with the same values, since both sides follow SPEC.md.
    #[test]
    fn checksums_are_frozen() {
        let mut checksum = Checksum::default();
        checksum.add((1, 1.0, 0.5));
        assert_eq!(checksum.0, 0xc517_8fb7_f54c_40d9);
        checksum.add((2, 2.0, 0.5));
        checksum.add((1, 2));
        checksum.add((1, 2, 1.0, 5.0));
        assert_eq!(checksum.0, 0x27d7_7e13_534e_81a6);
        checksum.remove((2, 2.0, 0.5));
        checksum.remove((1, 2));
        checksum.remove((1, 2, 1.0, 5.0));
        assert_eq!(checksum.0, 0xc517_8fb7_f54c_40d9);
    }
}
