//! What a cloud asks of the places that points have: equality and a digest of it, in any space.
//!
//! In: nothing.
//! Out: [`Site`], and its answers for positions in the plane.
//! Invariants: equal sites have equal coordinates and equal digests. In one cloud all sites have the same dimension.
//! Must not know: how a cloud stores them, distances.

use std::fmt::Debug;
use std::hash::Hash;

use super::position::Position;
use super::refusal::Refusal;

/// The place of a point, in the space of its stream.
pub trait Site: Clone + Debug + Eq + Hash {
    /// Its coordinates.
    fn coordinates(&self) -> impl AsRef<[f64]>;

    /// The hash by which a cloud finds it.
    fn digest(&self) -> u64;

    /// The nearest node of the grid of a step.
    ///
    /// # Errors [`Refusal`], if the node is no site.
    fn on_grid(self, step: f64) -> Result<Self, Refusal>;

    /// Says that no point is here to retract.
    fn not_there(&self) -> Refusal;

    /// The bytes that it takes outside of itself.
    fn heap_size(&self) -> usize {
        0
    }
}

impl Site for Position {
    #[inline]
    fn coordinates(&self) -> impl AsRef<[f64]> {
        self.xy()
    }

    /// Mixes both coordinates. Positions of a grid differ in few bits, so all bits must count.
    #[inline]
    fn digest(&self) -> u64 {
        let [x, y] = self.xy().map(f64::to_bits);
        finish(x.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ y.rotate_left(32).wrapping_mul(0xD6E8_FEB8_6659_FD93))
    }

    fn on_grid(self, step: f64) -> Result<Self, Refusal> {
        Ok(self.snapped(step)?)
    }

    fn not_there(&self) -> Refusal {
        let [x, y] = self.xy();
        Refusal::NotThere { x, y }
    }
}

/// Spreads the bits of a sum over all bits.
#[inline]
pub(super) fn finish(sum: u64) -> u64 {
    let mixed = (sum ^ (sum >> 32)).wrapping_mul(0xFF51_AFD7_ED55_8CCD);
    mixed ^ (mixed >> 29)
}
