//! The dual graph, contracted along the gradient flow: basins and the Gabriel edges between them.
//!
//! In: a [`Mesh`] and its [`Filtration`]. Out: one basin for each local maximum (basin 0 is that of the outer face), with
//! its weight (the circumradius there) and the triangle that names it. Invariants: weights and naming triangles depend on
//! the cloud alone: where sites lie on one circle, the face they bound may be cut into triangles in several ways, so its
//! maximum is taken from one fixed way, the fan around its smallest vertex. Must not know: dots, skeletons, ids.

use std::cmp::Ordering;

use super::filtration::Filtration;
use super::geometry::{acuteness, are_cocircular, circumradius_squared, orientation};
use super::mesh::{Mesh, OUTER_FACE};
use super::position::Position;

/// The basin that everything outside flows to.
pub const OUTER_BASIN: u32 = 0;

/// The basins of a filtration.
#[derive(Clone, Debug)]
pub struct Basins {
    /// Of each basin: circumradius at its maximum, squared; +infinity for the outer basin.
    weights: Vec<f64>,
    /// Of each basin: the sites of the triangle that holds its own circumcentre, by position (all 0 for the outer basin).
    triangles: Vec<[u32; 3]>,
    /// Of each face: the basin that it flows to.
    of_face: Vec<u32>,
}

const UNKNOWN: u32 = u32::MAX;

impl Basins {
    /// Follows the flow of every face to its end.
    pub fn new(mesh: &Mesh, filtration: &Filtration) -> Self {
        let maxima = filtration.maxima();
        let mut result = Self {
            weights: std::iter::once(f64::INFINITY)
                .chain(maxima.iter().map(|maximum| maximum.radius_squared))
                .collect(),
            triangles: std::iter::once([0; 3]).chain(maxima.iter().map(|maximum| maximum.triangle)).collect(),
            of_face: vec![UNKNOWN; mesh.face_count()],
        };
        result.of_face[OUTER_FACE as usize] = OUTER_BASIN;
        for (index, maximum) in maxima.iter().enumerate() {
            result.of_face[maximum.face as usize] = index as u32 + 1;
        }
        result.follow(filtration.flow());
        result.settle_cocircular(mesh, filtration);
        result
    }

    /// Gives every face the basin at the end of its flow.
    fn follow(&mut self, flow: &[u32]) {
        let mut path = Vec::new();
        for face in 0..flow.len() as u32 {
            let mut at = face;
            while self.of_face[at as usize] == UNKNOWN {
                path.push(at);
                at = flow[at as usize];
            }
            let basin = self.of_face[at as usize];
            for face in path.drain(..) {
                self.of_face[face as usize] = basin;
            }
        }
    }

    /// Names the maxima of faces with more than three sites on their circle, of which a mesh shows only one of several
    /// triangulations, by a triangle that does not depend on it.
    fn settle_cocircular(&mut self, mesh: &Mesh, filtration: &Filtration) {
        let flow = filtration.flow();
        // (into, from), so that the tributaries of a face lie side by side.
        let mut tributaries: Vec<(u32, u32)> = (filtration.suspects().iter())
            .filter(|suspect| suspect.certain || on_one_circle(mesh, suspect.face, flow[suspect.face as usize]))
            .map(|suspect| (flow[suspect.face as usize], suspect.face))
            .collect();
        tributaries.sort_unstable();
        let mut sites = Vec::new();
        for group in tributaries.chunk_by(|a, b| a.0 == b.0) {
            let maximum = group[0].0;
            if filtration.is_maximum(maximum) {
                collect_sites(mesh, &tributaries, maximum, &mut sites);
                let triangle = central_triangle(mesh, &mut sites);
                let basin = self.of_face[maximum as usize] as usize;
                self.weights[basin] = circumradius_squared(triangle.map(|site| mesh.position(site)));
                self.triangles[basin] = triangle;
            }
        }
    }

    /// Number of basins, that of the outer face among them.
    pub fn count(&self) -> usize {
        self.weights.len()
    }

    /// Circumradius at a basin's maximum, squared; +infinity for the outer basin.
    #[inline]
    pub fn weight(&self, basin: u32) -> f64 {
        self.weights[basin as usize]
    }

    /// The sites of the triangle that names a basin, by position; not for the outer basin.
    #[inline]
    pub fn triangle(&self, basin: u32) -> [u32; 3] {
        self.triangles[basin as usize]
    }

    /// The basin that a face flows to.
    #[inline]
    pub fn of_face(&self, face: u32) -> u32 {
        self.of_face[face as usize]
    }

    /// The elder rule's order of basins of equal weight: by their triangles' corners.
    pub fn break_tie(&self, mesh: &Mesh, a: u32, b: u32) -> Ordering {
        let corners = |basin: u32| self.triangle(basin).map(|site| mesh.position(site));
        corners(a).cmp(&corners(b))
    }
}

/// Exact: whether two neighbouring triangles have one circumcircle.
fn on_one_circle(mesh: &Mesh, from: u32, into: u32) -> bool {
    let corners = mesh.corners(into);
    let Some(far) = mesh.corners(from).into_iter().find(|site| !corners.contains(site)) else { return false };
    let [a, b, c] = corners.map(|site| mesh.position(site));
    are_cocircular(a, b, c, mesh.position(far))
}

/// All sites of the cocircular face around `maximum`.
fn collect_sites(mesh: &Mesh, tributaries: &[(u32, u32)], maximum: u32, sites: &mut Vec<u32>) {
    sites.clear();
    sites.extend(mesh.corners(maximum));
    let mut pending = vec![maximum];
    while let Some(face) = pending.pop() {
        let first = tributaries.partition_point(|&(into, _)| into < face);
        for &(_, from) in tributaries[first..].iter().take_while(|&&(into, _)| into == face) {
            // Faces around a circle form a tree, so each brings one site more.
            sites.extend(mesh.corners(from).into_iter().filter(|site| !mesh.corners(face).contains(site)));
            pending.push(from);
        }
    }
}

/// Of the fan of triangles around the smallest of the sites on a circle: the one that holds the centre (the later one by
/// position, if the centre is on the border of two).
fn central_triangle(mesh: &Mesh, sites: &mut [u32]) -> [u32; 3] {
    let at = |site: u32| mesh.position(site);
    let smallest = (0..sites.len()).min_by_key(|&index| at(sites[index])).unwrap_or(0);
    sites.swap(0, smallest);
    let (&mut apex, around) = sites.split_first_mut().expect("a triangle has corners");
    // The apex is the smallest, so all others lie within half a turn around it.
    around.sort_unstable_by(|&a, &b| orientation(at(apex), at(b), at(a)));
    let fan = around.windows(2).map(|pair| mesh.by_position([apex, pair[0], pair[1]]));
    fan.filter(|triangle| !is_obtuse(triangle.map(at)))
        .max_by_key(|triangle| triangle.map(at))
        .expect("a maximum holds the centre of its circle, and a fan leaves no gap")
}

fn is_obtuse([a, b, c]: [Position; 3]) -> bool {
    [(a, b, c), (b, c, a), (c, a, b)].into_iter().any(|(p, apex, q)| acuteness(p, apex, q) == Ordering::Less)
}
