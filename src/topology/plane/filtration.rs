//! The alpha filtration of a Delaunay triangulation, and its gradient flow.
//!
//! In: a [`Mesh`]. Out: the Gabriel edges and their scales, to where each triangle flows, and the local maxima where flows end, with
//! theirs. A triangle with an obtuse or right angle enters at the very scale of the edge opposite to it (the
//! edge is "attached"), so the two cancel: the triangle flows across that edge. Flows end in triangles that hold their own
//! circumcentre, the local maxima of the filtration, or in the outer face; so a dot is born at a Gabriel edge and dies at a
//! local maximum, and nothing else is left to reduce. Invariants: Gabriel or attached is decided by exact signs. Must not know: dots, skeletons.
//!
//! Scales: H. Edelsbrunner and J. Harer, "Computational Topology", section III.4; radii, here squared.

use std::cmp::Ordering;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::geometry::{Cocircular, acuteness, circumradius_squared, quick_acuteness, quick_cocircular};
use super::mesh::{Mesh, MeshEdge, OUTER_FACE};
use super::reduction::Link;
use crate::topology::base::in_parts;
use crate::topology::cloud::half_length_squared;

/// A triangle that holds its own circumcentre: a local maximum of the filtration. So is the outer face.
#[derive(Clone, Copy, Debug)]
pub struct Maximum {
    /// The face.
    pub face: u32,
    /// Its corners, by position (all 0 for the outer face).
    pub triangle: [u32; 3],
    /// Its circumradius, squared; +infinity for the outer face.
    pub radius_squared: f64,
}

/// A triangle that may share its circle with the triangle that it flows to.
#[derive(Clone, Copy, Debug)]
pub struct Suspect {
    /// The triangle.
    pub face: u32,
    /// Its corner that is not one of the other triangle's.
    pub far: u32,
    /// Whether it does for sure.
    pub certain: bool,
}

/// The alpha filtration of a mesh, as far as it is worth storing.
#[derive(Clone, Debug)]
pub struct Filtration {
    /// Of each face: the face across its attached edge, or itself at a local maximum.
    pub flow: Vec<u32>,
    /// The Gabriel edges, in order, as links between the faces beside them; their scales are squared.
    pub gabriel: Vec<Link>,
    /// The local maxima, the outer face first.
    pub maxima: Vec<Maximum>,
    /// Triangles that may lie on one circle with the triangle that they flow to; all others surely do not.
    pub suspects: Vec<Suspect>,
}

/// What was found at some of the edges, in order.
#[derive(Default)]
struct Found {
    gabriel: Vec<Link>,
    /// All local maxima among the triangles whose last edge is one of these, and some triangles that flow across an edge that others have yet to look at.
    maxima: Vec<Maximum>,
    suspects: Vec<Suspect>,
}

/// How many edges are looked at together.
const BLOCK: usize = 64;

/// One side of an edge.
#[derive(Clone, Copy, Default)]
struct Side {
    /// The corner opposite to the edge.
    opposite: u32,
    /// Whether the edge is the last of the triangle's three.
    closes: bool,
    /// How the angle there compares with a right one, where that is sure. On the outer face it never is: there the edge looks at
    /// itself.
    angle: Option<Ordering>,
}

impl Filtration {
    /// Classifies every edge and triangle of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        // A triangle has at most one angle that is not acute, so no two threads write to one place.
        let flow: Vec<AtomicU32> = (0..mesh.face_count() as u32).map(AtomicU32::new).collect();
        let mut parts = in_parts(mesh.edges().len(), |part| Found::at(mesh, &flow, part)).into_iter();
        let Found { mut gabriel, mut maxima, mut suspects } = parts.next().unwrap_or_default();
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

impl Found {
    /// Classifies some edges, and the triangles of which they are the last.
    fn at(mesh: &Mesh, flow: &[AtomicU32], part: Range<usize>) -> Self {
        // What is found elsewhere is appended to what is found in the first part.
        let count = if part.start == 0 { mesh.edges().len() } else { part.len() };
        let mut found = Self {
            gabriel: Vec::with_capacity(count / 4 * 3),
            maxima: Vec::with_capacity(count / 3 + 1),
            suspects: Vec::new(),
        };
        if part.start == 0 {
            found.maxima.push(Maximum { face: OUTER_FACE, triangle: [0; 3], radius_squared: f64::INFINITY });
        }
        let mut sides = [[Side::default(); 2]; BLOCK];
        let firsts = part.clone().step_by(BLOCK);
        for (first, block) in firsts.zip(mesh.edges()[part].chunks(BLOCK)) {
            look_across(mesh, first as u32, block, &mut sides);
            for ((index, edge), sides) in (first as u32..).zip(block).zip(&sides) {
                found.classify(mesh, flow, index, edge, sides);
            }
        }
        found
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
            // With the last of its edges all angles of a triangle are known, and its corners are at hand.
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
        // With two right angles the edge is a diameter: either triangle may be called the maximum.
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

/// Looks across a block of edges.
///
/// What lies across is all over the memory. Fetched for many edges before any of it is decided on, it is waited for once, not
/// once an edge.
#[inline]
fn look_across(mesh: &Mesh, first: u32, block: &[MeshEdge], sides: &mut [[Side; 2]; BLOCK]) {
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

/// Whether the corner on one side of an edge lies in the closed disc with the edge as diameter.
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
