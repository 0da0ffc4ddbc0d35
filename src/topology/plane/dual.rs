//! The total order of the dual graph of a whole mesh.
//!
//! In: a [`Mesh`] and its [`Basins`]. Out: what [`reduce`](super::reduction::reduce) asks for. Invariant: equal scales are decided by the edges' ends, equal weights by
//! the triangles' corners, all by position. Must not know: skeletons.

use std::cell::OnceCell;
use std::cmp::Ordering;

use super::basins::Basins;
use super::mesh::Mesh;
use super::reduction::{Elders, TotalOrder};
use crate::topology::base::pair_key;

/// The dual graph's total order: equal scales are decided by the edges' ends, by position.
pub struct Dual<'a> {
    mesh: &'a Mesh,
    basins: &'a Basins,
    /// Of each site: its place by position. Most clouds have no ties, so it is made for the first.
    places: OnceCell<Vec<u32>>,
}

impl<'a> Dual<'a> {
    /// The order of the links between some basins of a mesh.
    pub fn new(mesh: &'a Mesh, basins: &'a Basins) -> Self {
        Self { mesh, basins, places: OnceCell::new() }
    }
}

impl Elders for Dual<'_> {
    fn weight(&self, node: u32) -> f64 {
        self.basins.weight(node)
    }

    fn break_node_tie(&self, a: u32, b: u32) -> Ordering {
        self.basins.break_tie(self.mesh, a, b)
    }
}

impl TotalOrder for Dual<'_> {
    fn is_open(&self, _: u32) -> bool {
        false
    }

    fn break_link_tie(&self, edge: u32) -> u64 {
        let places = self.places.get_or_init(|| self.mesh.places_by_position());
        let [a, b] = self.mesh.edges()[edge as usize].ends.map(|site| places[site as usize]);
        pair_key([a.min(b), a.max(b)], places.len())
    }
}
