//! The dual graph, contracted along the gradient flow: basins and the Gabriel edges between them.
//!
//! In: a [`Mesh`] and its [`Filtration`]. Out: one basin for each local maximum (basin 0 is that of the outer face), with
//! its weight (the circumradius there) and the triangle that names it, and the links between them. Invariants: weights and naming triangles depend on
//! the cloud alone: where sites lie on one circle, the face they bound may be cut into triangles in several ways, so its
//! maximum is taken from one fixed way, the fan around its smallest vertex. Must not know: dots, skeletons, ids.

use std::cmp::Ordering;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::cocircular::central_triangle;
use super::filtration::{Filtration, Maximum, Suspect};
use super::geometry::{are_cocircular, circumradius_squared};
use super::mesh::Mesh;
use super::reduction::Link;
use crate::topology::base::{for_each, in_parts, sort_by_key};

/// The basin that everything outside flows to.
pub const OUTER_BASIN: u32 = 0;

/// The basins of a filtration.
#[derive(Clone, Debug, Default)]
pub struct Basins {
    /// Of each basin: where its flows end.
    maxima: Vec<Maximum>,
    /// Of each face: the basin that it flows to.
    of_face: Vec<u32>,
}

const UNKNOWN: u32 = u32::MAX;

impl Basins {
    /// Follows the flow of every face to its end. Gives the basins, and the Gabriel edges, in order, as links between them; the links'
    /// scales are squared.
    pub fn contract(mesh: &Mesh, filtration: Filtration) -> (Self, Vec<Link>) {
        let Filtration { flow, maxima, gabriel: mut links, suspects } = filtration;
        let of_face = follow(&flow, &maxima);
        let mut basins = Self { maxima, of_face };
        basins.settle_cocircular(mesh, &flow, suspects);
        for_each(&mut links, |link| link.ends = link.ends.map(|face| basins.of_face(face)));
        (basins, links)
    }

    /// Names the maxima of faces with more than three sites on their circle, of which a mesh shows only one of several
    /// triangulations, by a triangle that does not depend on it.
    fn settle_cocircular(&mut self, mesh: &Mesh, flow: &[u32], mut suspects: Vec<Suspect>) {
        suspects.retain(|suspect| suspect.certain || is_on_circle(mesh, suspect.far, flow[suspect.face as usize]));
        if suspects.is_empty() {
            return;
        }
        // Of each face: one further along its flow on the same circle, or itself.
        let mut along: Vec<u32> = (0..flow.len() as u32).collect();
        for suspect in &suspects {
            along[suspect.face as usize] = flow[suspect.face as usize];
        }
        // Each triangle of a cocircular face that is not its maximum brings one more corner.
        let mut corners: Vec<(u32, u32)> = (suspects.iter())
            .filter_map(|suspect| {
                let last = last_along(&mut along, suspect.face);
                (flow[last as usize] == last).then(|| (self.of_face[last as usize], suspect.far))
            })
            .collect();
        sort_by_key(&mut corners, |&(basin, _)| basin);
        let mut sites = Vec::new();
        for group in corners.chunk_by(|a, b| a.0 == b.0) {
            let maximum = &mut self.maxima[group[0].0 as usize];
            sites.clear();
            let corners = maximum.triangle.into_iter().chain(group.iter().map(|&(_, far)| far));
            sites.extend(corners.map(|site| (mesh.position(site), site)));
            maximum.triangle = central_triangle(&mut sites).map(|(_, site)| site);
            maximum.radius_squared = circumradius_squared(maximum.triangle.map(|site| mesh.position(site)));
        }
    }

    /// Number of basins, that of the outer face among them.
    pub fn count(&self) -> usize {
        self.maxima.len()
    }

    /// Circumradius at a basin's maximum, squared; +infinity for the outer basin.
    #[inline]
    pub fn weight(&self, basin: u32) -> f64 {
        self.maxima[basin as usize].radius_squared
    }

    /// The sites of the triangle that names a basin, by position; not for the outer basin.
    #[inline]
    pub fn triangle(&self, basin: u32) -> [u32; 3] {
        self.maxima[basin as usize].triangle
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

/// Gives every face the basin at the end of its flow.
fn follow(flow: &[u32], maxima: &[Maximum]) -> Vec<u32> {
    // Two threads may find out the same, and nothing else.
    let of_face: Vec<AtomicU32> = flow.iter().map(|_| AtomicU32::new(UNKNOWN)).collect();
    for (maximum, basin) in maxima.iter().zip(0..) {
        of_face[maximum.face as usize].store(basin, Relaxed);
    }
    in_parts(flow.len(), |faces| {
        let mut path = Vec::new();
        for face in faces {
            let mut at = face;
            let basin = loop {
                match of_face[at].load(Relaxed) {
                    UNKNOWN => path.push(at),
                    basin => break basin,
                }
                at = flow[at] as usize;
            };
            path.drain(..).for_each(|face| of_face[face].store(basin, Relaxed));
        }
    });
    of_face.into_iter().map(AtomicU32::into_inner).collect()
}

/// The end of a way, which is shortened as it is walked: a circle may hold all of a cloud, and then the way is as long.
fn last_along(along: &mut [u32], mut face: u32) -> u32 {
    while along[face as usize] != face {
        along[face as usize] = along[along[face as usize] as usize];
        face = along[face as usize];
    }
    face
}

/// Exact: whether a site lies on the circle through a triangle's corners.
fn is_on_circle(mesh: &Mesh, site: u32, face: u32) -> bool {
    let [a, b, c] = mesh.corners(face).map(|site| mesh.position(site));
    are_cocircular(a, b, c, mesh.position(site))
}
