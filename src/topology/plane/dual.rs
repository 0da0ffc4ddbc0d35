//! The total order of the dual graph of a whole mesh.
//!
//! In: a [`Mesh`] and its [`Basins`].
//! Out: the order that [`reduce`](super::reduction::reduce) takes.
//! Invariant: links of equal scale are ordered by the positions of their edges' ends, nodes of equal weight by the
//! positions of their triangles' corners.
//! Must not know: skeletons.

use std::cell::OnceCell;
use std::cmp::Ordering;

use super::basins::Basins;
use super::mesh::Mesh;
use super::reduction::{Elders, TotalOrder};
use crate::topology::base::pair_key;

/// The order of the nodes and links of a dual graph.
pub struct DualOrder<'a> {
    mesh: &'a Mesh,
    basins: &'a Basins,
    /// The place of each site by position. Most clouds have no ties, so it is computed at the first one.
    places: OnceCell<Vec<u32>>,
}

impl<'a> DualOrder<'a> {
    /// The order of the links between the basins of a mesh.
    pub fn new(mesh: &'a Mesh, basins: &'a Basins) -> Self {
        Self { mesh, basins, places: OnceCell::new() }
    }
}

impl Elders for DualOrder<'_> {
    fn weight(&self, node: u32) -> f64 {
        self.basins.weight(node)
    }

    fn break_node_tie(&self, a: u32, b: u32) -> Ordering {
        self.basins.break_tie(self.mesh, a, b)
    }
}

impl TotalOrder for DualOrder<'_> {
    fn is_open(&self, _: u32) -> bool {
        false
    }

    fn break_link_tie(&self, edge: u32) -> u64 {
        let places = self.places.get_or_init(|| self.mesh.places_by_position());
        let [a, b] = self.mesh.edges()[edge as usize].ends.map(|site| places[site as usize]);
        pair_key([a.min(b), a.max(b)], places.len())
    }
}
