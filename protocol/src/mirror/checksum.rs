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
        (id, &[x, y][..]).into()
    }
}

/// A vertex with any number of coordinates.
impl From<(u64, &[f64])> for Element {
    fn from((id, coordinates): (u64, &[f64])) -> Self {
        Self(hash([1, id].into_iter().chain(coordinates.iter().map(|number| number.to_bits()))))
    }
}

impl From<Edge> for Element {
    fn from((a, b): Edge) -> Self {
        Self(hash([2, a, b]))
    }
}

impl From<Critical> for Element {
    fn from((a, b, birth, death): Critical) -> Self {
        Self(hash([3, a, b, birth.to_bits(), death.to_bits()]))
    }
}

/// The finaliser of SplitMix64, folded over words.
fn hash(words: impl IntoIterator<Item = u64>) -> u64 {
    words.into_iter().fold(0, |hash, word| {
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

    #[test]
    fn a_vertex_with_two_coordinates_has_the_hash_of_one_of_the_plane() {
        let sum = |vertices: &[(u64, &[f64])]| {
            let mut checksum = Checksum::default();
            vertices.iter().for_each(|&vertex| checksum.add(vertex));
            checksum.0
        };
        assert_eq!(sum(&[(1, &[1.0, 0.5])]), 0xc517_8fb7_f54c_40d9);
        let others: [&[f64]; 5] = [&[1.0], &[0.5, 1.0], &[1.0, 0.5, 0.0], &[1.0, 0.5, -0.0], &[]];
        let sums = others.map(|coordinates| sum(&[(1, coordinates)]));
        for (at, one) in sums.iter().enumerate() {
            assert!(!sums[..at].contains(one) && *one != 0xc517_8fb7_f54c_40d9, "{:?}", others[at]);
        }
    }
}
