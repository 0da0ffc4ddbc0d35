//! The alpha filtration of a Delaunay triangulation, and its gradient flow.
//!
//! In: a [`Mesh`]. Out: the scale at which each simplex enters, which edges are Gabriel, and to where each triangle flows.
//! A triangle with an obtuse or right angle enters at the very scale of the edge opposite to it (the edge is
//! "attached"), so the two cancel: the triangle flows across that edge. Flows end in triangles that hold their own
//! circumcentre, the local maxima of the filtration, or in the outer face; so a dot is born at a Gabriel edge and dies at a
//! local maximum, and nothing else is left to reduce. Invariants: Gabriel or attached is decided by exact signs; a scale is the
//! minimum over the faces beside an edge, so no edge enters after a triangle of its own. Must not know: dots, skeletons.
//!
//! Scales: H. Edelsbrunner and J. Harer, "Computational Topology", section III.4; radii, not squared, at the interface.

use std::cmp::Ordering;

use super::geometry::{Circle, acuteness, circumcircle, half_length_squared, may_be_cocircular};
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};

/// The alpha filtration of a mesh, as far as it is worth storing.
#[derive(Clone, Debug)]
pub struct Filtration {
    /// Of each face: the face across its attached edge, or itself at a local maximum.
    flow: Vec<u32>,
    /// Gabriel edges, in order.
    gabriel: Vec<u32>,
    /// Triangles that may share their circle with the one that they flow to.
    suspects: Vec<u32>,
}

impl Filtration {
    /// Classifies every edge and triangle of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let mut filtration = Self {
            flow: (0..mesh.face_count() as u32).collect(),
            gabriel: Vec::with_capacity(mesh.edges().len() / 4 * 3),
            suspects: Vec::new(),
        };
        for (index, edge) in mesh.edges().iter().enumerate() {
            filtration.classify(mesh, index as u32, edge);
        }
        filtration
    }

    #[inline]
    fn classify(&mut self, mesh: &Mesh, index: u32, edge: &MeshEdge) {
        let [left, right] = edge.faces;
        let (from, into) = match [left, right].map(|face| is_attached_to(mesh, face, edge)) {
            [false, false] => return self.gabriel.push(index),
            [true, false] => (left, right),
            [false, true] => (right, left),
            // Both angles are right and the edge is a diameter: either triangle may be called the maximum.
            [true, true] => (left.max(right), left.min(right)),
        };
        self.flow[from as usize] = into;
        if into != OUTER_FACE {
            let [a, b] = edge.ends.map(|site| mesh.position(site));
            let [p, q] = [from, into].map(|face| mesh.position(mesh.opposite(face, edge)));
            if may_be_cocircular(a, b, p, q) {
                self.suspects.push(from);
            }
        }
    }

    /// Of each face: the face across its attached edge, or itself at a local maximum (and for the outer face).
    pub fn flow(&self) -> &[u32] {
        &self.flow
    }

    /// The Gabriel edges, in order.
    pub fn gabriel(&self) -> &[u32] {
        &self.gabriel
    }

    /// Triangles that may lie on one circle with the triangle that they flow to; all others surely do not.
    pub fn suspects(&self) -> &[u32] {
        &self.suspects
    }

    /// Whether a face is a local maximum of the filtration: it holds its own circumcentre, or is the outer face.
    #[inline]
    pub fn is_maximum(&self, face: u32) -> bool {
        self.flow[face as usize] == face
    }

    /// Circumcircle of a triangle.
    pub fn circumcircle(&self, mesh: &Mesh, face: u32) -> Circle {
        circumcircle(mesh.corners(face).map(|site| mesh.position(site)))
    }

    /// The scale (a radius) at which a face enters: its circumradius; +infinity for the outer face.
    pub fn face_scale(&self, mesh: &Mesh, face: u32) -> f64 {
        match face {
            OUTER_FACE => f64::INFINITY,
            _ => self.circumcircle(mesh, face).radius(),
        }
    }

    /// The scale (a radius) at which an edge enters.
    pub fn edge_scale(&self, mesh: &Mesh, edge: u32) -> f64 {
        let edge_at = &mesh.edges()[edge as usize];
        let faces = edge_at.faces.map(|face| self.face_scale(mesh, face));
        let beside = faces[0].min(faces[1]);
        let [a, b] = edge_at.ends.map(|site| mesh.position(site));
        if self.is_gabriel(edge) { half_length_squared(a, b).sqrt().min(beside) } else { beside }
    }

    /// Whether no site lies in the closed disc that has the edge as its diameter.
    pub fn is_gabriel(&self, edge: u32) -> bool {
        self.gabriel.binary_search(&edge).is_ok()
    }
}

/// Whether the corner of `face` opposite to `edge` lies in the closed disc with the edge as diameter.
#[inline]
fn is_attached_to(mesh: &Mesh, face: u32, edge: &MeshEdge) -> bool {
    if face == OUTER_FACE {
        return false;
    }
    let [a, b] = edge.ends.map(|site| mesh.position(site));
    acuteness(a, mesh.position(mesh.opposite(face, edge)), b) != Ordering::Greater
}
