//! What a tile leaves to the one above it.
//!
//! In: nodes, links and open triangles of a reduction. Out: a [`Border`] that can be compared with the one before. Must not know: how
//! tiles are reduced.

use super::faces::FaceKey;
use super::resolved::copy;
use super::star::Summit;
use crate::topology::cloud::Slot;
use crate::topology::plane::reduction::Link;

/// A Gabriel edge, by its slots, the smaller position first; its scale is squared.
pub type TileLink = Link<[Slot; 2]>;

/// What a tile leaves to be decided outside: its reduced graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Border {
    /// The largest maximum of each component that has links outside.
    pub nodes: Vec<Summit>,
    /// The node of the outer face, if the tile has seen it.
    pub outer: Option<u32>,
    /// Triangles with edges elsewhere, and the nodes they belong to.
    pub open: Vec<(FaceKey, u32)>,
    /// Merges that are not decided yet, in order.
    pub links: Vec<TileLink>,
}

impl Border {
    /// Becomes a copy of another one, in its own memory.
    pub fn copy_from(&mut self, other: &Self) {
        copy(&mut self.nodes, &other.nodes);
        self.outer = other.outer;
        copy(&mut self.open, &other.open);
        copy(&mut self.links, &other.links);
    }

    /// Leaves nothing.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.outer = None;
        self.open.clear();
        self.links.clear();
    }
}
