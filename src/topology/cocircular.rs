//! Faces with more than three sites on their circle: what names them, whichever way they are cut into triangles.
//!
//! In: sites on one circle, or a triangle of a triangulation to look around from. Out: the triangle that stands for them all, of one fixed
//! way to cut: the fan around the smallest site. Invariants: answers depend on positions alone, and are exact. Must not know: dots, tiles.

use std::cmp::Ordering;

use super::cloud::Slot;
use super::delaunay::{HalfEdge, Plane};
use super::geometry::{Cocircular, acuteness, are_cocircular, is_obtuse, orientation, quick_cocircular};
use super::position::Position;

/// A site and where it is.
pub type Located<S> = (Position, S);

/// Of the fan of triangles around the smallest of the sites on a circle: the one that holds the centre (the later one by
/// position, if the centre is on the border of two). Its corners are in order.
pub fn central_triangle<S: Copy>(sites: &mut [Located<S>]) -> [Located<S>; 3] {
    let smallest = (0..sites.len()).min_by_key(|&index| sites[index].0).unwrap_or(0);
    sites.swap(0, smallest);
    let (&mut apex, around) = sites.split_first_mut().expect("a triangle has corners");
    // The apex is the smallest, so all others lie within half a turn around it.
    around.sort_unstable_by(|a, b| orientation(apex.0, b.0, a.0));
    let fan = around.windows(2).map(|pair| by_position([apex, pair[0], pair[1]]));
    fan.filter(|triangle| !is_obtuse(triangle.map(|site| site.0)))
        .max_by_key(|triangle| triangle.map(|site| site.0))
        .expect("a maximum holds the centre of its circle, and a fan leaves no gap")
}

/// Three sites in order of position.
pub fn by_position<S: Copy>([a, b, c]: [Located<S>; 3]) -> [Located<S>; 3] {
    let in_order = |a: Located<S>, b: Located<S>| if b.0 < a.0 { [b, a] } else { [a, b] };
    let [a, b] = in_order(a, b);
    let [b, c] = in_order(b, c);
    let [a, b] = in_order(a, b);
    [a, b, c]
}

impl Plane<'_> {
    /// The site opposite to a half-edge in the triangle on its left.
    #[inline]
    pub fn apex(self, edge: HalfEdge) -> Located<Slot> {
        self.origin(self.previous(edge))
    }

    /// The site opposite to a half-edge on its right, unless the outer face is there.
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

    /// Whether the triangle on the left of a half-edge flows across it: its angle there is a right or an obtuse one. Where the triangle on the right
    /// has a right angle too, the edge is a diameter, and the one with the smaller apex is called the maximum.
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

    /// Whether the triangles beside a half-edge share their circle.
    #[inline]
    pub fn share_circle(self, edge: HalfEdge) -> bool {
        let Some((far, _)) = self.across(edge) else { return false };
        let [a, b] = self.ends(edge).map(|site| site.0);
        on_one_circle(a, b, self.apex(edge).0, far)
    }

    /// The local maximum on whose circle the triangle on the left of a half-edge lies; none, if flows lead off that circle. Given by a half-edge
    /// that has it on its left.
    pub fn summit_of_circle(self, mut edge: HalfEdge) -> Option<HalfEdge> {
        while let Some(exit) = self.around(edge).into_iter().find(|&edge| self.flows(edge)) {
            if !self.share_circle(exit) {
                return None;
            }
            edge = self.twin(exit);
        }
        Some(edge)
    }

    /// The corners of the triangle on the left of a half-edge.
    #[inline]
    pub fn corners(self, edge: HalfEdge) -> [Located<Slot>; 3] {
        self.around(edge).map(|edge| self.origin(edge))
    }

    /// The half-edges around the triangle on the left of one.
    #[inline]
    pub fn around(self, edge: HalfEdge) -> [HalfEdge; 3] {
        [edge, self.next(edge), self.previous(edge)]
    }

    /// The triangle that names the local maximum on the left of a half-edge, with all the sites that lie on its circle.
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

/// Exact: whether two points on either side of a line through two others lie on one circle with them.
#[inline]
pub fn on_one_circle(a: Position, b: Position, p: Position, q: Position) -> bool {
    match quick_cocircular(a, b, p, q) {
        Cocircular::No => false,
        Cocircular::Yes => true,
        Cocircular::Perhaps => are_cocircular(a, b, p, q),
    }
}
