//! What a tile resolved, and the total order of its lists.
//!
//! In: tree edges and dots.
//! Out: sorted lists, which can be compared in linear time.
//! Must not know: how tiles are reduced.

use std::cmp::Ordering;

use crate::topology::cloud::{Cloud, Position, Slot};
use crate::topology::plane::elements::{TileDot, TreeEdge};

/// What a tile decided for good and its parts had not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Edges of the minimum spanning tree, in order.
    pub tree: Vec<TreeEdge>,
    /// Dots off the diagonal, in order of their critical edges.
    pub dots: Vec<TileDot>,
}

impl Resolved {
    /// Copies another one into this one's memory.
    pub fn copy_from(&mut self, other: &Self) {
        copy(&mut self.tree, &other.tree);
        copy(&mut self.dots, &other.dots);
    }
}

pub(super) fn copy<T: Copy>(into: &mut Vec<T>, from: &[T]) {
    into.clear();
    into.extend_from_slice(from);
}

/// The total order of edges, largest first.
#[derive(Clone, Copy)]
pub struct EdgeOrder<'a> {
    /// Gives the positions of slots.
    pub cloud: &'a Cloud,
}

impl EdgeOrder<'_> {
    /// Compares two edges by their scales, then by their ends (each the smaller position first).
    #[inline]
    pub fn of(self, a: f64, a_ends: [Slot; 2], b: f64, b_ends: [Slot; 2]) -> Ordering {
        // Scales are never NaN or -0.
        if a > b {
            Ordering::Less
        } else if a < b {
            Ordering::Greater
        } else {
            self.of_ends(a_ends, b_ends)
        }
    }

    fn of_ends(self, a: [Slot; 2], b: [Slot; 2]) -> Ordering {
        if a == b { Ordering::Equal } else { self.positions(b).cmp(&self.positions(a)) }
    }

    /// Positions of slots.
    #[inline]
    pub fn positions<const N: usize>(self, slots: [Slot; N]) -> [Position; N] {
        slots.map(|slot| self.cloud.position(slot))
    }
}
