//! A Delaunay triangulation as flat arrays.
//!
//! In: sites, edges and the faces beside them, from [`super::delaunay`].
//! Out: a [`Mesh`]. Its indices mean nothing outside it.
//! Invariants: face 0 is the outer face. Every edge names its two ends and the faces on its left and right. For a cloud
//! of fewer than three sites, or on one line, face 0 is the only face and the edges are the path along the line.
//! Must not know: the triangulation library, scales.

use crate::topology::base::{in_order, ordinal};
use crate::topology::cloud::{Position, Slot};

/// The outer face of every [`Mesh`].
pub const OUTER_FACE: u32 = 0;

/// An undirected Delaunay edge.
#[derive(Clone, Copy, Debug)]
pub struct MeshEdge {
    /// Its two sites.
    pub ends: [u32; 2],
    /// The face on its left (seen from `ends[0]` to `ends[1]`) and the one on its right.
    pub faces: [u32; 2],
}

/// A triangle: the sum of its corners and one of its edges, which together give the three corners.
///
/// Both can be filled while streaming over the edges; a list of corners cannot.
#[derive(Clone, Copy, Debug, Default)]
struct Face {
    corner_sum: u32,
    edge: u32,
}

/// A Delaunay triangulation as flat arrays.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    positions: Vec<Position>,
    slots: Vec<Slot>,
    edges: Vec<MeshEdge>,
    faces: Vec<Face>,
}

impl Mesh {
    /// Empties the mesh and makes room for this number of sites, edges and faces (including the outer face).
    pub fn reset(&mut self, sites: usize, edges: usize, faces: usize) {
        let Self { positions, slots, edges: old_edges, faces: old_faces } = self;
        positions.clear();
        positions.reserve_exact(sites);
        slots.clear();
        slots.reserve_exact(sites);
        old_edges.clear();
        old_edges.reserve_exact(edges);
        old_faces.clear();
        old_faces.resize(faces.max(1), Face::default());
    }

    /// Adds a site. Sites are numbered in order of addition.
    #[inline]
    pub fn push_site(&mut self, position: Position, slot: Slot) {
        self.positions.push(position);
        self.slots.push(slot);
    }

    /// Adds an edge between two sites, with the faces left and right of it.
    #[inline]
    pub fn push_edge(&mut self, edge: MeshEdge) {
        let index = self.edges.len() as u32;
        for (end, face) in edge.ends.into_iter().zip(edge.faces) {
            // Each corner of a triangle is the origin of exactly one of the three directed edges around it.
            let face = &mut self.faces[face as usize];
            face.corner_sum = face.corner_sum.wrapping_add(end);
            face.edge = index;
        }
        self.edges.push(edge);
    }

    /// Positions of the sites.
    #[inline]
    pub fn positions(&self) -> &[Position] {
        &self.positions
    }

    /// The slot of each site.
    #[inline]
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// All edges.
    #[inline]
    pub fn edges(&self) -> &[MeshEdge] {
        &self.edges
    }

    /// The number of faces, including the outer face.
    #[inline]
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Position of a site.
    #[inline]
    pub fn position(&self, site: u32) -> Position {
        self.positions[site as usize]
    }

    /// The corner of triangle `face` that is not an end of `edge`, which is one of its edges.
    #[inline]
    pub fn opposite(&self, face: u32, edge: &MeshEdge) -> u32 {
        let [a, b] = edge.ends;
        self.faces[face as usize].corner_sum.wrapping_sub(a).wrapping_sub(b)
    }

    /// The three corners of a triangle, by position.
    pub fn corners(&self, face: u32) -> [u32; 3] {
        debug_assert_ne!(face, OUTER_FACE);
        let edge = &self.edges[self.faces[face as usize].edge as usize];
        self.by_position([edge.ends[0], edge.ends[1], self.opposite(face, edge)])
    }

    /// The corner opposite to an edge, `edges()[index]`, on one side (an end of the edge, on the outer face), and
    /// whether the edge is the last of that triangle's three edges.
    #[inline]
    pub fn across(&self, index: u32, edge: &MeshEdge, side: usize) -> (u32, bool) {
        let face = &self.faces[edge.faces[side] as usize];
        let [a, b] = edge.ends;
        let inside = edge.faces[side] != OUTER_FACE;
        (if inside { face.corner_sum.wrapping_sub(a).wrapping_sub(b) } else { a }, inside & (face.edge == index))
    }

    /// Three sites in order of position.
    #[inline]
    pub fn by_position(&self, [mut a, mut b, mut c]: [u32; 3]) -> [u32; 3] {
        // Selections instead of branches: the outcome cannot be predicted.
        let swap = |first: &mut u32, second: &mut u32| {
            let (p, q) = (self.position(*first), self.position(*second));
            let wrong = (q.x() < p.x()) | ((q.x() == p.x()) & (q.y() < p.y()));
            (*first, *second) = if wrong { (*second, *first) } else { (*first, *second) };
        };
        swap(&mut a, &mut b);
        swap(&mut b, &mut c);
        swap(&mut a, &mut b);
        [a, b, c]
    }

    /// The place of each site in the order of positions.
    pub fn places_by_position(&self) -> Vec<u32> {
        let coordinate = |site: u32, axis: usize| ordinal(self.position(site).xy()[axis]);
        let order = in_order(self.positions.len(), |site| coordinate(site, 0), |site| coordinate(site, 1));
        let mut places = vec![0; order.len()];
        for (site, place) in order.into_iter().zip(0..) {
            places[site as usize] = place;
        }
        places
    }

    /// The ends of an edge, the smaller position first.
    #[inline]
    pub fn ordered_ends(&self, edge: u32) -> [Position; 2] {
        let [a, b] = self.edges[edge as usize].ends.map(|site| self.position(site));
        if a < b { [a, b] } else { [b, a] }
    }
}
