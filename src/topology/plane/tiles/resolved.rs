//! What a tile has found for good, and the total order in which it lists it.
//!
//! In: tree edges and dots. Out: lists that can be compared in step. Must not know: how tiles are reduced.

use std::cmp::Ordering;

use crate::topology::cloud::{Cloud, Position, Slot};
use crate::topology::plane::elements::{TileDot, TreeEdge};

/// What is known for good inside a tile, and was not inside its parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Edges of the minimum spanning tree, in order.
    pub tree: Vec<TreeEdge>,
    /// Dots off the diagonal, in order of their critical edges.
    pub dots: Vec<TileDot>,
}

impl Resolved {
    /// Becomes a copy of another one, in its own memory.
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
    /// Knows where slots are.
    pub cloud: &'a Cloud,
}

impl EdgeOrder<'_> {
    /// Compares two edges by their scales and, if these are equal, by their ends (each the smaller position first).
    #[inline]
    pub fn of(self, a: f64, a_ends: [Slot; 2], b: f64, b_ends: [Slot; 2]) -> Ordering {
        // Scales are numbers, and 0 has one sign.
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
