//! A cloud that lies on one line: its sites in order along it.
//!
//! In: sites, then changes of the cloud. Out: the neighbours of a position, and the [`Mesh`] of a path. Invariant: a line is left, and said to be, as soon
//! as a site lies beside it. Must not know: the triangulation library.

use std::collections::BTreeMap;
use std::ops::Bound;

use super::geometry::are_collinear;
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
use crate::topology::cloud::{Cloud, CloudChange, Located, Position, Slot};

/// Sites on one line, in order along it.
#[derive(Clone, Debug, Default)]
pub struct Line(BTreeMap<Position, Slot>);

impl Line {
    /// A line of sites that lie on one.
    pub fn new(sites: impl Iterator<Item = Located<Slot>>) -> Self {
        Self(sites.collect())
    }

    /// Number of sites.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The neighbours of a position, whether there is a site or not.
    pub fn neighbours(&self, position: Position) -> [Option<Located<Slot>>; 2] {
        let left = self.0.range(..position).next_back();
        let right = self.0.range((Bound::Excluded(position), Bound::Unbounded)).next();
        [left, right].map(|neighbour| neighbour.map(|(&position, &slot)| (position, slot)))
    }

    /// Follows a change of the cloud, and names each site that has new neighbours. False when the sites do not lie on one line any more.
    pub fn step(&mut self, cloud: &Cloud, change: &CloudChange, mut has_new_neighbours: impl FnMut(Slot)) -> bool {
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
            changed.for_each(|(_, neighbour)| has_new_neighbours(neighbour));
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

    /// Panics when the line contradicts itself or the cloud. For tests.
    pub fn check_invariants(&self, cloud: &Cloud) {
        assert!(lies_on_a_line(self.0.keys().copied()));
        assert!(cloud.vertices().all(|(slot, vertex)| self.0[&vertex.position] == slot));
    }
}

/// Whether positions lie on one line: so do fewer than three.
pub fn lies_on_a_line(mut positions: impl Iterator<Item = Position>) -> bool {
    let (Some(first), Some(second)) = (positions.next(), positions.next()) else { return true };
    positions.all(|position| are_collinear(first, second, position))
}
