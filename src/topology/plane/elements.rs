//! The elements of a skeleton as the plane finds them, by slots.
//!
//! In: nothing.
//! Out: tree edges and dots. The pipeline translates their slots to ids.
//! Must not know: how they are found, ids.

use crate::topology::cloud::Slot;

/// A dot whose persistence is at most this share of its death is rounding, not topology.
pub const DIAGONAL: f64 = 1e-12;

/// An edge of the minimum spanning tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeEdge {
    /// Half its length, squared.
    pub scale: f64,
    /// Its ends, the smaller position first.
    pub ends: [Slot; 2],
}

/// A dot with its critical edge; scales are radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileDot {
    /// The scale at which the cycle is born.
    pub birth: f64,
    /// The scale at which its hole is filled.
    pub death: f64,
    /// The critical edge, the smaller position first.
    pub edge: [Slot; 2],
    /// The triangle that names the death, its corners in order of position.
    pub triangle: [Slot; 3],
}

impl TileDot {
    /// The dot of a critical edge, from squared scales; none if it is on the diagonal.
    #[inline]
    pub fn new(birth_squared: f64, death_squared: f64, edge: [Slot; 2], triangle: [Slot; 3]) -> Option<Self> {
        let (birth, death) = label(birth_squared, death_squared)?;
        Some(Self { birth, death, edge, triangle })
    }

    /// Death minus birth.
    #[inline]
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

/// Birth and death from their squares; none if the dot is on the diagonal.
#[inline]
pub fn label(birth_squared: f64, death_squared: f64) -> Option<(f64, f64)> {
    let (birth, death) = (birth_squared.sqrt(), death_squared.sqrt());
    debug_assert!(!death.is_nan(), "what is closed knows its maximum");
    (death - birth > DIAGONAL * death).then_some((birth, death))
}
