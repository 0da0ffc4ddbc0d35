//! The gradient flow of the alpha filtration, seen from a half-edge of the triangulation.
//!
//! In: a half-edge.
//! Out: the triangle beside it, whether that flows across the half-edge, the local maximum on its circle and that
//! maximum's name.
//! Invariants: answers depend on positions alone, and are exact.
//! Must not know: dots, tiles.

use std::cmp::Ordering;

use super::cocircular::{central_triangle, on_one_circle};
use super::delaunay::{HalfEdge, HalfEdges};
use super::geometry::acuteness;
use crate::topology::cloud::{Located, Slot};

impl HalfEdges<'_> {
    /// The site opposite to a half-edge in the triangle on its left.
    #[inline]
    pub fn apex(self, edge: HalfEdge) -> Located<Slot> {
        self.origin(self.previous(edge))
    }

    /// The site opposite to a half-edge in the triangle on its right; none if the outer face is there.
    #[inline]
    pub fn across(self, edge: HalfEdge) -> Option<Located<Slot>> {
        let twin = self.twin(edge);
        (!self.is_outer(twin)).then(|| self.apex(twin))
    }

    /// The ends of a half-edge.
    #[inline]
    pub fn ends(self, edge: HalfEdge) -> [Located<Slot>; 2] {
        [self.origin(edge), self.origin(self.twin(edge))]
    }

    /// Whether the triangle on the left of a half-edge flows across it: its angle there is right or obtuse. If the
    /// triangle on the right has a right angle too, the edge is a diameter, and the triangle with the smaller apex is
    /// the maximum.
    pub fn flows(self, edge: HalfEdge) -> bool {
        let [a, b] = self.ends(edge).map(|site| site.0);
        let apex = self.apex(edge).0;
        match acuteness(a, apex, b) {
            Ordering::Greater => false,
            Ordering::Less => true,
            Ordering::Equal => {
                self.across(edge).is_none_or(|(far, _)| acuteness(a, far, b) != Ordering::Equal || apex > far)
            }
        }
    }

    /// Whether the triangles on both sides of a half-edge lie on one circle.
    #[inline]
    pub fn share_circle(self, edge: HalfEdge) -> bool {
        let Some((far, _)) = self.across(edge) else { return false };
        let [a, b] = self.ends(edge).map(|site| site.0);
        on_one_circle(a, b, self.apex(edge).0, far)
    }

    /// The local maximum on the circle of the triangle on the left of a half-edge, as a half-edge with the maximum on
    /// its left. None if the flow leaves the circle, or reaches a face that is not new.
    pub fn maximum_on_circle(self, mut edge: HalfEdge, mut is_new: impl FnMut(u32) -> bool) -> Option<HalfEdge> {
        while is_new(self.face_number(edge)) {
            let Some(exit) = self.around(edge).into_iter().find(|&edge| self.flows(edge)) else { return Some(edge) };
            if !self.share_circle(exit) {
                return None;
            }
            edge = self.twin(exit);
        }
        None
    }

    /// The corners of the triangle on the left of a half-edge.
    #[inline]
    pub fn corners(self, edge: HalfEdge) -> [Located<Slot>; 3] {
        self.around(edge).map(|edge| self.origin(edge))
    }

    /// The half-edges around the triangle on the left of a half-edge.
    #[inline]
    pub fn around(self, edge: HalfEdge) -> [HalfEdge; 3] {
        [edge, self.next(edge), self.previous(edge)]
    }

    /// The triangle that names the local maximum on the left of a half-edge. All sites on its circle count.
    pub fn name(self, edge: HalfEdge) -> [Located<Slot>; 3] {
        let mut sites = self.corners(edge).to_vec();
        let mut open = self.around(edge).to_vec();
        while let Some(edge) = open.pop() {
            let twin = self.twin(edge);
            if !self.is_outer(twin) && self.share_circle(edge) && self.flows(twin) {
                sites.push(self.apex(twin));
                open.extend([self.next(twin), self.previous(twin)]);
            }
        }
        central_triangle(&mut sites)
    }
}
