//! The alpha filtration of a Delaunay triangulation, and its gradient flow.
//!
//! In: a [`Mesh`]. Out: the scale at which each simplex enters, which edges are Gabriel, to where each triangle flows, and the local maxima
//! where flows end. A triangle with an obtuse or right angle enters at the very scale of the edge opposite to it (the
//! edge is "attached"), so the two cancel: the triangle flows across that edge. Flows end in triangles that hold their own
//! circumcentre, the local maxima of the filtration, or in the outer face; so a dot is born at a Gabriel edge and dies at a
//! local maximum, and nothing else is left to reduce. Invariants: Gabriel or attached is decided by exact signs; a scale is the
//! minimum over the faces beside an edge, so no edge enters after a triangle of its own. Must not know: dots, skeletons.
//!
//! Scales: H. Edelsbrunner and J. Harer, "Computational Topology", section III.4; radii, not squared, at the interface.

use std::cmp::Ordering;

use super::geometry::{Circle, Cocircular, acuteness, circumcircle, half_length_squared, quick_cocircular};
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
use super::reduction::Link;

/// A triangle that holds its own circumcentre: a local maximum of the filtration.
#[derive(Clone, Copy, Debug)]
pub struct Maximum {
    /// The face.
    pub face: u32,
    /// Its corners, by position.
    pub triangle: [u32; 3],
    /// Its circumradius, squared.
    pub radius_squared: f64,
}

/// A triangle that may share its circle with the triangle that it flows to.
#[derive(Clone, Copy, Debug)]
pub struct Suspect {
    /// The triangle.
    pub face: u32,
    /// Whether it does for sure.
    pub certain: bool,
}

/// The alpha filtration of a mesh, as far as it is worth storing.
#[derive(Clone, Debug)]
pub struct Filtration {
    flow: Vec<u32>,
    gabriel: Vec<Link>,
    maxima: Vec<Maximum>,
    suspects: Vec<Suspect>,
}

impl Filtration {
    /// Classifies every edge and triangle of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let edges = mesh.edges();
        let mut filtration = Self {
            flow: (0..mesh.face_count() as u32).collect(),
            gabriel: Vec::with_capacity(edges.len() / 4 * 3),
            maxima: Vec::with_capacity(mesh.face_count() / 2),
            suspects: Vec::new(),
        };
        for (index, edge) in edges.iter().enumerate() {
            filtration.classify(mesh, index as u32, edge);
            for face in edge.faces {
                // With the last of its edges all angles of a triangle are known, and its corners are at hand.
                if mesh.last_edge(face) == index as u32 && face != OUTER_FACE && filtration.is_maximum(face) {
                    filtration.push_maximum(mesh, face, edge);
                }
            }
        }
        filtration
    }

    #[inline]
    fn classify(&mut self, mesh: &Mesh, index: u32, edge: &MeshEdge) {
        let [left, right] = edge.faces;
        let attached = [left, right].map(|face| is_attached_to(mesh, face, edge));
        let (from, into) = match attached {
            [false, false] => return self.push_gabriel(mesh, index, edge),
            [true, false] => (left, right),
            [false, true] => (right, left),
            // Both angles are right and the edge is a diameter: either triangle may be called the maximum.
            [true, true] => (left.max(right), left.min(right)),
        };
        self.flow[from as usize] = into;
        if into == OUTER_FACE {
            return;
        }
        let right_angles = attached == [true, true];
        let [a, b] = edge.ends.map(|site| mesh.position(site));
        let [p, q] = [from, into].map(|face| mesh.position(mesh.opposite(face, edge)));
        match if right_angles { Cocircular::Yes } else { quick_cocircular(a, b, p, q) } {
            Cocircular::No => {}
            look => self.suspects.push(Suspect { face: from, certain: look == Cocircular::Yes }),
        }
    }

    #[inline]
    fn push_gabriel(&mut self, mesh: &Mesh, index: u32, edge: &MeshEdge) {
        let [a, b] = edge.ends.map(|site| mesh.position(site));
        self.gabriel.push(Link { scale: half_length_squared(a, b), ends: edge.faces, edge: index });
    }

    #[inline]
    fn push_maximum(&mut self, mesh: &Mesh, face: u32, edge: &MeshEdge) {
        let triangle = mesh.by_position([edge.ends[0], edge.ends[1], mesh.opposite(face, edge)]);
        let radius_squared = circumcircle(triangle.map(|site| mesh.position(site))).radius_squared;
        self.maxima.push(Maximum { face, triangle, radius_squared });
    }

    /// Of each face: the face across its attached edge, or itself at a local maximum (and for the outer face).
    pub fn flow(&self) -> &[u32] {
        &self.flow
    }

    /// The Gabriel edges, in order, as links between the faces beside them; their scales are squared.
    pub fn gabriel(&self) -> &[Link] {
        &self.gabriel
    }

    /// The same, given away.
    pub fn into_gabriel(self) -> Vec<Link> {
        self.gabriel
    }

    /// The local maxima, but for the outer face.
    pub fn maxima(&self) -> &[Maximum] {
        &self.maxima
    }

    /// Triangles that may lie on one circle with the triangle that they flow to; all others surely do not.
    pub fn suspects(&self) -> &[Suspect] {
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
        let at = &mesh.edges()[edge as usize];
        let beside = at.faces.map(|face| self.face_scale(mesh, face)).into_iter().fold(f64::INFINITY, f64::min);
        let [a, b] = at.ends.map(|site| mesh.position(site));
        if self.is_gabriel(edge) { half_length_squared(a, b).sqrt().min(beside) } else { beside }
    }

    /// Whether no site lies in the closed disc that has the edge as its diameter.
    pub fn is_gabriel(&self, edge: u32) -> bool {
        self.gabriel.binary_search_by_key(&edge, |link| link.edge).is_ok()
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
