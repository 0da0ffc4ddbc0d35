//! Reads stars from the triangulation.
//!
//! In: vertices and the triangulation.
//! Out: their [`Stars`], and the owners of maxima on whose circles their triangles lie.
//! Invariant: the result depends on the triangulation alone.
//! Must not know: tiles, reductions.

use std::cmp::Ordering;

use hashbrown::HashSet;

use super::star::{Center, Marks, OUTSIDE, Spoke, Stars};
use crate::topology::cloud::{Located, Position, Slot, half_length_squared};
use crate::topology::plane::cocircular::{by_position, on_one_circle};
use crate::topology::plane::delaunay::{Delaunay, HalfEdge, HalfEdges};
use crate::topology::plane::geometry::{acuteness, circumradius_squared};

/// A neighbour of a vertex.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position: Position,
    slot: Slot,
    /// The half-edge to it.
    edge: HalfEdge,
    /// Whether the face on the left of that half-edge is the outer one.
    is_outer: bool,
}

/// Reads stars; its memory is reused.
#[derive(Clone, Debug, Default)]
pub struct StarReader {
    /// All neighbours of each vertex, counter-clockwise.
    rings: Vec<Vec<Seen>>,
    /// Vertices whose neighbours are not complete: the ring, its first half-edge and the current one.
    turning: Vec<(u32, HalfEdge, HalfEdge)>,
    /// The owners (smallest corners) of maxima on whose circles triangles of the stars read so far lie.
    pub circle_owners: Vec<Slot>,
    /// Whether these owners are sought.
    pub seeks_owners: bool,
    /// The faces on the ways to them. Many triangles of a large circle share their way, so each face is passed once.
    ways: HashSet<u32>,
}

impl StarReader {
    /// Forgets the owners, and the ways to them. The triangulation may change after this.
    pub fn forget_owners(&mut self) {
        self.circle_owners.clear();
        self.ways.clear();
    }

    /// Collects the neighbours of some vertices. These are scattered over the memory; taking one step for all vertices
    /// at a time lets the cache misses overlap.
    pub fn look_around(&mut self, delaunay: &Delaunay, vertices: &[Located<Slot>]) {
        let Self { rings, turning, .. } = self;
        turning.clear();
        rings.resize_with(rings.len().max(vertices.len()), Vec::new);
        let Some(plane) = delaunay.half_edges() else { return };
        for (ring, &(_, slot)) in (0..).zip(vertices) {
            rings[ring as usize].clear();
            turning.extend(delaunay.edge_out_of(slot).map(|out| (ring, out, out)));
        }
        while !turning.is_empty() {
            turning.retain_mut(|(ring, out, edge)| {
                let (position, slot) = plane.origin(plane.twin(*edge));
                rings[*ring as usize].push(Seen { position, slot, edge: *edge, is_outer: plane.is_outer(*edge) });
                *edge = plane.turn(*edge);
                edge != out
            });
        }
    }

    /// Reads the star of the vertex at `place` in the list given to [`look_around`](Self::look_around), and adds it to
    /// `stars`.
    pub fn read(&mut self, delaunay: &Delaunay, place: usize, (position, slot): Located<Slot>, stars: &mut Stars) {
        let first = stars.spokes.len();
        let [before, after] = if let Some(plane) = delaunay.half_edges() {
            let ring = std::mem::take(&mut self.rings[place]);
            let beyond = self.read_fan(plane, &ring, (position, slot), stars);
            self.rings[place] = ring;
            beyond
        } else {
            let both = delaunay.on_either_side(position);
            let larger = both.into_iter().flatten().filter(|neighbour| position < neighbour.0);
            stars.spokes.extend(larger.map(|(other, to)| spoke(half_length_squared(position, other), to)));
            [OUTSIDE; 2]
        };
        let spokes = (stars.spokes.len() - first) as u32;
        stars.centers.push(Center { position, slot, before, after, spokes });
    }

    /// Adds the own edges of a vertex. Returns the corners before the first and after the last edge.
    fn read_fan(&mut self, plane: HalfEdges<'_>, ring: &[Seen], center: Located<Slot>, stars: &mut Stars) -> [Slot; 2] {
        let step = |place: usize| if place + 1 == ring.len() { 0 } else { place + 1 };
        let back = |place: usize| if place == 0 { ring.len() - 1 } else { place - 1 };
        let is_own = |seen: &Seen| center.0 < seen.position;
        let is_first = |&place: &usize| {
            let before = &ring[back(place)];
            is_own(&ring[place]) && (before.is_outer || !is_own(before))
        };
        let Some(first) = (0..ring.len()).find(is_first) else { return [OUTSIDE; 2] };
        let mut before = ring[back(first)];
        let beyond = if before.is_outer { OUTSIDE } else { before.slot };
        let (mut at, mut place) = (ring[first], step(first));
        let mut spoke = read_edge(center.0, [before, at, ring[place]]);
        loop {
            let after = ring[place];
            if at.is_outer || !is_own(&after) {
                stars.spokes.push(spoke);
                return [beyond, if at.is_outer { OUTSIDE } else { after.slot }];
            }
            let four = [before, at, after, ring[step(place)]];
            let next = read_edge(center.0, [at, after, four[3]]);
            self.read_triangle(plane, center, four, &mut spoke, next.marks, stars);
            stars.spokes.push(spoke);
            (before, at, place, spoke) = (at, after, step(place), next);
        }
    }

    /// Reads the triangle between two own edges, the second and the third of four consecutive ones. `next` are the
    /// marks of the third.
    fn read_triangle(
        &mut self,
        plane: HalfEdges<'_>,
        center: Located<Slot>,
        [before, at, after, beyond]: [Seen; 4],
        spoke: &mut Spoke,
        next: Marks,
        stars: &mut Stars,
    ) {
        spoke.marks.set(Marks::NEXT_IS_SMALLER, after.position < at.position);
        // Whether the site across one of the three edges lies on the triangle's circle.
        let across_first = || !before.is_outer && on_one_circle(center.0, at.position, after.position, before.position);
        let across_second = || !after.is_outer && on_one_circle(center.0, after.position, at.position, beyond.position);
        let opposite = plane.next(at.edge);
        let across_third = || {
            let far = plane.across(opposite);
            far.is_some_and(|far| on_one_circle(at.position, after.position, center.0, far.0))
        };
        let exit = if spoke.marks.has(Marks::FROM_LEFT) {
            Some((at.edge, across_first()))
        } else if next.has(Marks::FROM_RIGHT) {
            Some((plane.previous(at.edge), across_second()))
        } else {
            let is_wide = acuteness(at.position, center.0, after.position) != Ordering::Greater;
            (is_wide && plane.flows(opposite)).then(|| (opposite, across_third()))
        };
        match exit {
            Some((edge, true)) => self.note_circle_owner(plane, plane.twin(edge), center.1),
            Some((_, false)) => {}
            None => {
                spoke.marks.set(Marks::MAXIMUM, true);
                let is_alone = !across_first() && !across_second() && !across_third();
                let name = if is_alone {
                    by_position([center, (at.position, at.slot), (after.position, after.slot)])
                } else {
                    plane.name(at.edge)
                };
                spoke.weight = circumradius_squared(name.map(|corner| corner.0));
                if !is_alone {
                    spoke.marks.set(Marks::CIRCLE, true);
                    stars.names.push(name.map(|corner| corner.1));
                }
            }
        }
    }

    /// Notes the owner of the maximum on the circle of the triangle on the left of `edge`, unless the owner is
    /// `reader`, or was noted before.
    fn note_circle_owner(&mut self, plane: HalfEdges<'_>, edge: HalfEdge, reader: Slot) {
        if !self.seeks_owners {
            return;
        }
        let Some(maximum) = plane.maximum_on_circle(edge, |face| self.ways.insert(face)) else { return };
        let corners = plane.corners(maximum);
        let (_, owner) = corners.into_iter().min_by_key(|corner| corner.0).expect("there are three");
        if owner != reader {
            self.circle_owners.push(owner);
        }
    }
}

/// Reads an own edge, the second of three consecutive ones.
#[inline]
fn read_edge(center: Position, [before, at, after]: [Seen; 3]) -> Spoke {
    let is_wide = |apex: Position| acuteness(center, apex, at.position) != Ordering::Greater;
    let left = !at.is_outer && is_wide(after.position);
    let right = !before.is_outer && is_wide(before.position);
    // With two right angles, the triangle with the larger apex flows.
    let from_left = left && (!right || after.position > before.position);
    let mut spoke = spoke(half_length_squared(center, at.position), at.slot);
    spoke.marks.set(Marks::FROM_LEFT, from_left);
    spoke.marks.set(Marks::FROM_RIGHT, right && !from_left);
    spoke
}

fn spoke(scale: f64, to: Slot) -> Spoke {
    Spoke { scale, weight: f64::NEG_INFINITY, to, marks: Marks::default() }
}
