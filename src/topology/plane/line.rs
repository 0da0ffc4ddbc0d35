//! A cloud on one line: its sites in order along it.
//!
//! In: sites, then changes of the cloud.
//! Out: the neighbours of a position, and the path as a [`Mesh`].
//! Invariant: [`Line::step`] returns false as soon as a site lies beside the line.
//! Must not know: the triangulation library.

use std::collections::BTreeMap;
use std::ops::Bound;

use super::geometry::are_collinear;
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
use crate::topology::cloud::{Cloud, CloudChange, Located, Position, Slot};

/// Sites on one line, in order along it.
#[derive(Clone, Debug, Default)]
pub struct Line(BTreeMap<Position, Slot>);

impl Line {
    /// The line of some collinear sites.
    pub fn new(sites: impl Iterator<Item = Located<Slot>>) -> Self {
        Self(sites.collect())
    }

    /// Number of sites.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The sites on either side of a position, whether there is a site or not.
    pub fn neighbours(&self, position: Position) -> [Option<Located<Slot>>; 2] {
        let left = self.0.range(..position).next_back();
        let right = self.0.range((Bound::Excluded(position), Bound::Unbounded)).next();
        [left, right].map(|neighbour| neighbour.map(|(&position, &slot)| (position, slot)))
    }

    /// Applies a change of the cloud, and reports each site that has new neighbours. Returns false if the sites are not
    /// collinear any more.
    pub fn step(&mut self, cloud: &Cloud, change: &CloudChange, mut on_new_neighbours: impl FnMut(Slot)) -> bool {
        let path = &mut self.0;
        for &slot in &change.vanished {
            path.remove(&cloud.position(slot));
        }
        let stayed = path.first_key_value().zip(path.last_key_value()).map(|((&first, _), (&last, _))| (first, last));
        for &slot in &change.appeared {
            path.insert(cloud.position(slot), slot);
        }
        for &slot in change.vanished.iter().chain(&change.appeared) {
            let changed = self.neighbours(cloud.position(slot)).into_iter().flatten();
            changed.for_each(|(_, neighbour)| on_new_neighbours(neighbour));
        }
        match stayed {
            Some((first, last)) if first < last => {
                change.appeared.iter().all(|&slot| are_collinear(first, last, cloud.position(slot)))
            }
            _ => lies_on_a_line(self.0.keys().copied()),
        }
    }

    /// The path along the line, as flat arrays.
    pub fn read_into(&self, mesh: &mut Mesh) {
        mesh.reset(self.len(), self.len().saturating_sub(1), 1);
        for (&position, &slot) in &self.0 {
            mesh.push_site(position, slot);
        }
        for right in 1..self.len() as u32 {
            mesh.push_edge(MeshEdge { ends: [right - 1, right], faces: [OUTER_FACE; 2] });
        }
    }

    /// Panics when the line is inconsistent or differs from the cloud. For tests.
    pub fn check_invariants(&self, cloud: &Cloud) {
        assert!(lies_on_a_line(self.0.keys().copied()));
        assert!(cloud.vertices().all(|(slot, vertex)| self.0[&vertex.position] == slot));
    }
}

/// Whether positions are collinear, as fewer than three always are.
pub fn lies_on_a_line(mut positions: impl Iterator<Item = Position>) -> bool {
    let (Some(first), Some(second)) = (positions.next(), positions.next()) else { return true };
    positions.all(|position| are_collinear(first, second, position))
}
