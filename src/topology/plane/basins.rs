//! Basins: the dual graph of the mesh, contracted along the gradient flow.
//!
//! In: a [`Mesh`] and its [`Filtration`].
//! Out: one basin for each local maximum, with its weight (the circumradius there) and the triangle that names it; the
//! Gabriel edges as links between basins. Basin 0 is that of the outer face.
//! Invariants: weights and names depend on the cloud alone. Where more than three sites lie on one circle, their face
//! may be cut into triangles in several ways; its maximum is then taken from one fixed way, the fan around its smallest
//! site.
//! Must not know: dots, skeletons, ids.

use std::cmp::Ordering;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::cocircular::central_triangle;
use super::filtration::{Filtration, Maximum, Suspect};
use super::geometry::{are_cocircular, circumradius_squared};
use super::mesh::Mesh;
use super::reduction::Link;
use crate::topology::base::{for_each, in_parts, sort_by_key};

/// The basin of the outer face.
pub const OUTER_BASIN: u32 = 0;

/// The basins of a filtration.
#[derive(Clone, Debug, Default)]
pub struct Basins {
    /// The local maximum of each basin.
    maxima: Vec<Maximum>,
    /// The basin of each face.
    of_face: Vec<u32>,
}

const UNKNOWN: u32 = u32::MAX;

impl Basins {
    /// Follows the flow of every face to its end. Returns the basins, and the Gabriel edges, in order, as links between
    /// them. The links' scales are squared.
    pub fn contract(mesh: &Mesh, filtration: Filtration) -> (Self, Vec<Link>) {
        let Filtration { flow, maxima, gabriel: mut links, suspects } = filtration;
        let of_face = follow(&flow, &maxima);
        let mut basins = Self { maxima, of_face };
        basins.settle_cocircular(mesh, &flow, suspects);
        for_each(&mut links, |link| link.ends = link.ends.map(|face| basins.of_face(face)));
        (basins, links)
    }

    /// Renames the maxima of faces with more than three sites on their circle. The mesh shows one of several
    /// triangulations of such a face; the new name does not depend on it.
    fn settle_cocircular(&mut self, mesh: &Mesh, flow: &[u32], mut suspects: Vec<Suspect>) {
        suspects.retain(|suspect| suspect.certain || is_on_circle(mesh, suspect.far, flow[suspect.face as usize]));
        if suspects.is_empty() {
            return;
        }
        // For each face: a face further along its flow on the same circle, or itself.
        let mut along: Vec<u32> = (0..flow.len() as u32).collect();
        for suspect in &suspects {
            along[suspect.face as usize] = flow[suspect.face as usize];
        }
        // Each triangle of a cocircular face, except for its maximum, adds one corner.
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

    /// The number of basins, including that of the outer face.
    pub fn count(&self) -> usize {
        self.maxima.len()
    }

    /// Circumradius at a basin's maximum, squared; +infinity for the outer basin.
    #[inline]
    pub fn weight(&self, basin: u32) -> f64 {
        self.maxima[basin as usize].radius_squared
    }

    /// The triangle that names a basin, its sites by position; not for the outer basin.
    #[inline]
    pub fn triangle(&self, basin: u32) -> [u32; 3] {
        self.maxima[basin as usize].triangle
    }

    /// The basin that a face flows to.
    #[inline]
    pub fn of_face(&self, face: u32) -> u32 {
        self.of_face[face as usize]
    }

    /// The elder rule's order of basins of equal weight: by the corners of their triangles.
    pub fn break_tie(&self, mesh: &Mesh, a: u32, b: u32) -> Ordering {
        let corners = |basin: u32| self.triangle(basin).map(|site| mesh.position(site));
        corners(a).cmp(&corners(b))
    }
}

/// The basin at the end of each face's flow.
fn follow(flow: &[u32], maxima: &[Maximum]) -> Vec<u32> {
    // Threads may write the same value twice, and no others.
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

/// The last face of a path, which is shortened on the way: all sites of a cloud may lie on one circle, and the path is
/// as long then.
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
