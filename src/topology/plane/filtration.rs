//! The alpha filtration of a Delaunay triangulation and its gradient flow.
//!
//! In: a [`Mesh`].
//! Out: the Gabriel edges with their scales, the triangle that each triangle flows to, and the local maxima at which
//! flows end.
//! Invariants: exact signs decide whether an edge is Gabriel or attached. A triangle with an obtuse or right angle
//! enters at the same scale as the edge opposite to that angle (the edge is "attached" to it), so the two cancel and
//! the triangle flows across the edge. Flows end in triangles that contain their own circumcentre (the local maxima of
//! the filtration) or in the outer face. Therefore a dot is born at a Gabriel edge and dies at a local maximum, and
//! only these are left to reduce.
//! Must not know: dots, skeletons.
//!
//! Scales are those of H. Edelsbrunner and J. Harer, "Computational Topology", section III.4: radii, here squared.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::geometry::{Cocircular, acuteness, circumradius_squared, quick_acuteness, quick_cocircular};
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
use super::reduction::Link;
use crate::topology::base::in_parts;
use crate::topology::cloud::half_length_squared;

/// A local maximum of the filtration: a triangle that contains its own circumcentre, or the outer face.
#[derive(Clone, Copy, Debug)]
pub struct Maximum {
    /// The face.
    pub face: u32,
    /// Its corners by position; all 0 for the outer face.
    pub triangle: [u32; 3],
    /// Its circumradius, squared; +infinity for the outer face.
    pub radius_squared: f64,
}

/// A triangle that may lie on one circle with the triangle that it flows to.
#[derive(Clone, Copy, Debug)]
pub struct Suspect {
    /// The triangle.
    pub face: u32,
    /// Its corner that is not a corner of the other triangle.
    pub far: u32,
    /// Whether it certainly does.
    pub certain: bool,
}

/// The alpha filtration of a mesh, without what cancels.
#[derive(Clone, Debug)]
pub struct Filtration {
    /// For each face: the face across its attached edge, or itself at a local maximum.
    pub flow: Vec<u32>,
    /// The Gabriel edges, in order, as links between the faces beside them. Their scales are squared.
    pub gabriel: Vec<Link>,
    /// The local maxima, the outer face first.
    pub maxima: Vec<Maximum>,
    /// Triangles that may lie on one circle with the triangle that they flow to; all others certainly do not.
    pub suspects: Vec<Suspect>,
}

/// The results for some of the edges, in order.
#[derive(Default)]
struct Classified {
    gabriel: Vec<Link>,
    /// All local maxima among the triangles whose last edge is one of these. Also some triangles that flow across an
    /// edge which another part has yet to classify.
    maxima: Vec<Maximum>,
    suspects: Vec<Suspect>,
}

/// The number of edges whose surroundings are read together.
const BLOCK: usize = 64;

/// One side of an edge.
#[derive(Clone, Copy, Default)]
struct Side {
    /// The corner opposite to the edge.
    opposite: u32,
    /// Whether the edge is the last of the triangle's three edges.
    closes: bool,
    /// How the angle there compares with a right angle, where rounding cannot have decided it. Always none on the outer
    /// face, where `opposite` is an end of the edge.
    angle: Option<Ordering>,
}

impl Filtration {
    /// Classifies every edge and triangle of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        // A triangle has at most one angle that is not acute, so no two threads write to the same place.
        let flow: Vec<AtomicU32> = (0..mesh.face_count() as u32).map(AtomicU32::new).collect();
        let mut parts = in_parts(mesh.edges().len(), |part| Classified::at(mesh, &flow, part)).into_iter();
        let Classified { mut gabriel, mut maxima, mut suspects } = parts.next().unwrap_or_default();
        let has_parts = parts.len() > 0;
        for mut part in parts {
            gabriel.append(&mut part.gabriel);
            maxima.append(&mut part.maxima);
            suspects.append(&mut part.suspects);
        }
        if has_parts {
            maxima.retain(|maximum| flow[maximum.face as usize].load(Relaxed) == maximum.face);
        }
        let flow = flow.into_iter().map(AtomicU32::into_inner).collect();
        Self { flow, gabriel, maxima, suspects }
    }
}

impl Classified {
    /// Classifies some edges, and the triangles whose last edge is one of these.
    fn at(mesh: &Mesh, flow: &[AtomicU32], part: Range<usize>) -> Self {
        // The results of the other parts are appended to those of the first.
        let count = if part.start == 0 { mesh.edges().len() } else { part.len() };
        let mut classified = Self {
            gabriel: Vec::with_capacity(count / 4 * 3),
            maxima: Vec::with_capacity(count / 3 + 1),
            suspects: Vec::new(),
        };
        if part.start == 0 {
            classified.maxima.push(Maximum { face: OUTER_FACE, triangle: [0; 3], radius_squared: f64::INFINITY });
        }
        let mut sides = [[Side::default(); 2]; BLOCK];
        let firsts = part.clone().step_by(BLOCK);
        for (first, block) in firsts.zip(mesh.edges()[part].chunks(BLOCK)) {
            read_sides(mesh, first as u32, block, &mut sides);
            for ((index, edge), sides) in (first as u32..).zip(block).zip(&sides) {
                classified.classify(mesh, flow, index, edge, sides);
            }
        }
        classified
    }

    #[inline]
    fn classify(&mut self, mesh: &Mesh, flow: &[AtomicU32], index: u32, edge: &MeshEdge, sides: &[Side; 2]) {
        let attached = [0, 1].map(|side| is_attached_to(mesh, edge, side, &sides[side]));
        if attached == [false, false] {
            let [a, b] = edge.ends.map(|site| mesh.position(site));
            self.gabriel.push(Link { scale: half_length_squared(a, b), ends: edge.faces, edge: index });
        } else {
            self.attach(mesh, flow, edge, sides, attached);
        }
        for (face, side) in edge.faces.into_iter().zip(sides) {
            // At the last of its edges all angles of a triangle are known, and its corners are at hand.
            if side.closes && flow[face as usize].load(Relaxed) == face {
                let triangle = mesh.by_position([edge.ends[0], edge.ends[1], side.opposite]);
                let radius_squared = circumradius_squared(triangle.map(|site| mesh.position(site)));
                self.maxima.push(Maximum { face, triangle, radius_squared });
            }
        }
    }

    fn attach(&mut self, mesh: &Mesh, flow: &[AtomicU32], edge: &MeshEdge, sides: &[Side; 2], attached: [bool; 2]) {
        let [left, right] = edge.faces;
        let right_angles = attached == [true, true];
        // With two right angles the edge is a diameter; either triangle may be called the maximum.
        let from_left = if right_angles { left > right } else { attached[0] };
        let (from, into) = if from_left { (left, right) } else { (right, left) };
        flow[from as usize].store(into, Relaxed);
        if into == OUTER_FACE {
            return;
        }
        let [a, b] = edge.ends.map(|site| mesh.position(site));
        let far = sides[usize::from(!from_left)].opposite;
        let [p, q] = [0, 1].map(|side| mesh.position(sides[side].opposite));
        match if right_angles { Cocircular::Yes } else { quick_cocircular(a, b, p, q) } {
            Cocircular::No => {}
            look => self.suspects.push(Suspect { face: from, far, certain: look == Cocircular::Yes }),
        }
    }
}

/// Reads what lies beside the edges of a block.
///
/// Neighbours are scattered over the memory. Reading those of a whole block before any decision lets the cache misses
/// overlap.
#[inline]
fn read_sides(mesh: &Mesh, first: u32, block: &[MeshEdge], sides: &mut [[Side; 2]; BLOCK]) {
    for ((index, edge), sides) in (first..).zip(block).zip(sides.iter_mut()) {
        for (side, look) in sides.iter_mut().enumerate() {
            (look.opposite, look.closes) = mesh.across(index, edge, side);
        }
    }
    for (edge, sides) in block.iter().zip(sides) {
        let [a, b] = edge.ends.map(|site| mesh.position(site));
        for look in sides {
            look.angle = quick_acuteness(a, mesh.position(look.opposite), b);
        }
    }
}

/// Whether the corner on one side of an edge lies in the closed disc that has the edge as diameter.
#[inline]
fn is_attached_to(mesh: &Mesh, edge: &MeshEdge, side: usize, look: &Side) -> bool {
    let angle = look.angle.unwrap_or_else(|| match edge.faces[side] {
        OUTER_FACE => Ordering::Greater,
        _ => {
            let [a, b] = edge.ends.map(|site| mesh.position(site));
            acuteness(a, mesh.position(look.opposite), b)
        }
    });
    angle != Ordering::Greater
}
