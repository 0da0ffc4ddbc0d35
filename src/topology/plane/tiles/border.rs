//! The border of a tile: what it leaves to the tile above.
//!
//! In: nodes, links and open triangles of a reduction.
//! Out: a [`Border`], which can be compared with the one before.
//! Must not know: how tiles are reduced.

use super::faces::FaceKey;
use super::resolved::copy;
use super::star::LocalMaximum;
use crate::topology::cloud::Slot;
use crate::topology::plane::reduction::Link;

/// A Gabriel edge by its slots, the smaller position first. Its scale is squared.
pub type TileLink = Link<[Slot; 2]>;

/// The reduced graph of a tile: what has to be decided outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Border {
    /// The largest maximum of each component that has links outside.
    pub nodes: Vec<LocalMaximum>,
    /// The node of the outer face, if the tile has one.
    pub outer: Option<u32>,
    /// Triangles with edges in other leaves, and their nodes.
    pub open: Vec<(FaceKey, u32)>,
    /// Merges that are not decided yet, in order.
    pub links: Vec<TileLink>,
}

impl Border {
    /// Copies another border into this one's memory.
    pub fn copy_from(&mut self, other: &Self) {
        copy(&mut self.nodes, &other.nodes);
        self.outer = other.outer;
        copy(&mut self.open, &other.open);
        copy(&mut self.links, &other.links);
    }

    /// Empties it.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.outer = None;
        self.open.clear();
        self.links.clear();
    }
}
