//! What the filtration knows around one vertex, kept flat: the stars of a tile's vertices, one after the other.
//!
//! In: the surroundings of a vertex in the triangulation. Out: [`Stars`]. An edge is its smaller end's own, a triangle its smallest corner's. Seen
//! from a vertex, its own edges lie in one half of the plane, so they are neighbours around it, and between any two of them that follow each
//! other lies an own triangle: a [`Star`] is a fan. It says which edges are Gabriel and at what scale they enter, or to which side they are attached;
//! which triangles are local maxima, with their circumradius and name; and what lies beyond the first and the last edge. Invariants: every
//! edge and every triangle is told of exactly once; what a star says depends on positions and the triangles around its vertex
//! alone, so it stays right until one of those changes, or, for a maximum with more sites on its circle, one on that circle. Must
//! not know: tiles, reductions.

use std::cmp::Ordering;

use crate::topology::cloud::Slot;
use crate::topology::cocircular::{Located, by_position, on_one_circle};
use crate::topology::delaunay::{Delaunay, HalfEdge, Plane};
use crate::topology::geometry::{acuteness, circumradius_squared, half_length_squared};
use crate::topology::position::Position;

/// What is known of an edge, and of the triangle that follows it counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks(u8);

impl Marks {
    /// The triangle on its left flows across it.
    pub const FROM_LEFT: Self = Self(1);
    /// The triangle on its right flows across it.
    pub const FROM_RIGHT: Self = Self(2);
    /// The triangle that follows is a local maximum.
    pub const MAXIMUM: Self = Self(4);
    /// That maximum has more sites on its circle, and a name of its own.
    pub const CIRCLE: Self = Self(8);
    /// The next edge leads to a smaller position than this one.
    pub const NEXT_IS_SMALLER: Self = Self(16);

    /// Whether all of `marks` are set.
    #[inline]
    pub fn has(self, marks: Self) -> bool {
        self.0 & marks.0 == marks.0
    }

    #[inline]
    fn set(&mut self, marks: Self, when: bool) {
        self.0 |= if when { marks.0 } else { 0 };
    }
}

/// An edge to a larger position, and the triangle between it and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spoke {
    /// Half its length, squared.
    pub scale: f64,
    /// Circumradius of the triangle that follows, squared, if that is a local maximum.
    pub weight: f64,
    /// Where it leads.
    pub to: Slot,
    /// What else is known.
    pub marks: Marks,
}

/// A local maximum of the filtration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summit {
    /// Its circumradius, squared; -infinity where none is known.
    pub weight: f64,
    /// The triangle that names it, in order.
    pub triangle: [Slot; 3],
}

impl Summit {
    /// No maximum is known.
    pub const UNKNOWN: Self = Self { weight: f64::NEG_INFINITY, triangle: [0; 3] };
    /// The outer face.
    pub const OUTER: Self = Self { weight: f64::INFINITY, triangle: [0; 3] };
}

/// In place of a third corner: the outer face.
pub const OUTSIDE: Slot = Slot::MAX;

/// A vertex and what is beyond its own edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Center {
    /// Where it is.
    pub position: Position,
    /// Where the cloud keeps it.
    pub slot: Slot,
    /// The third corner of the triangle on the right of the first edge, or [`OUTSIDE`].
    pub before: Slot,
    /// The third corner of the triangle on the left of the last edge, or [`OUTSIDE`].
    pub after: Slot,
    spokes: u32,
}

/// A star, in the memory of a [`Stars`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Star<'a> {
    /// Its vertex.
    pub center: &'a Center,
    /// Its own edges, counter-clockwise.
    pub spokes: &'a [Spoke],
    /// Names of its own maxima that have one of their own, in order.
    pub names: &'a [[Slot; 3]],
}

/// Some stars, in order of position.
#[derive(Clone, Debug, Default)]
pub struct Stars {
    centers: Vec<Center>,
    spokes: Vec<Spoke>,
    names: Vec<[Slot; 3]>,
}

impl Stars {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// How many own edges they have in all.
    pub fn spoke_count(&self) -> usize {
        self.spokes.len()
    }

    /// Adds a copy of a star. It has to be the largest one by position.
    #[inline]
    pub fn push(&mut self, star: Star<'_>) {
        debug_assert!(self.centers.last().is_none_or(|last| last.position < star.center.position));
        self.spokes.extend_from_slice(star.spokes);
        self.names.extend_from_slice(star.names);
        self.centers.push(*star.center);
    }

    /// All of them, in order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = Star<'_>> {
        let (mut spokes, mut names) = (&self.spokes[..], &self.names[..]);
        self.centers.iter().map(move |center| {
            let own = take(&mut spokes, center.spokes as usize);
            let named = if names.is_empty() { 0 } else { own.iter().filter(|s| s.marks.has(Marks::CIRCLE)).count() };
            Star { center, spokes: own, names: take(&mut names, named) }
        })
    }

    /// Vertices and where they are, in order.
    pub fn vertices(&self) -> impl Iterator<Item = Located<Slot>> + '_ {
        self.centers.iter().map(|center| (center.position, center.slot))
    }

    /// A vertex near a position: the nearest of some that are before and after it in the order.
    pub fn near(&self, position: Position) -> Option<Slot> {
        const AROUND: usize = 6;
        let place = self.centers.partition_point(|center| center.position < position);
        let some = &self.centers[place.saturating_sub(AROUND)..(place + AROUND).min(self.centers.len())];
        let distance = |center: &Center| half_length_squared(center.position, position);
        let nearer = |best: (f64, Slot), next: (f64, Slot)| if next.0 < best.0 { next } else { best };
        some.iter().map(|center| (distance(center), center.slot)).reduce(nearer).map(|(_, slot)| slot)
    }

    /// Becomes a copy of others, in its own memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        self.centers.extend_from_slice(&other.centers);
        self.spokes.extend_from_slice(&other.spokes);
        self.names.extend_from_slice(&other.names);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.centers.clear();
        self.spokes.clear();
        self.names.clear();
    }
}

#[inline]
fn take<'a, T>(rest: &mut &'a [T], count: usize) -> &'a [T] {
    let (taken, left) = rest.split_at(count);
    *rest = left;
    taken
}

/// A neighbour, as it is seen from a vertex.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position: Position,
    slot: Slot,
    /// The edge to it.
    edge: HalfEdge,
    /// Whether the face left of that edge is the outer one.
    is_outer: bool,
}

/// Reads stars, in memory of its own.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    /// Of each vertex looked around from: all its neighbours, counter-clockwise.
    rings: Vec<Vec<Seen>>,
    /// Of each of them that is not done: its ring, the edge that it began with, and the one it is at.
    turning: Vec<(u32, HalfEdge, HalfEdge)>,
    /// Smallest corners of maxima on whose circles triangles of the stars read so far lie.
    pub concerned: Vec<Slot>,
}

impl Reader {
    /// Looks around from some vertices. What is next to each is all over the memory; it is waited for once for all of them, step by step.
    pub fn look_around(&mut self, delaunay: &Delaunay, vertices: &[Located<Slot>]) {
        let Self { rings, turning, .. } = self;
        turning.clear();
        rings.resize_with(rings.len().max(vertices.len()), Vec::new);
        let Some(plane) = delaunay.plane() else { return };
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

    /// Reads the star of the vertex that stood at a place in the list looked around from, to the end of `stars`.
    pub fn read(&mut self, delaunay: &Delaunay, place: usize, (position, slot): Located<Slot>, stars: &mut Stars) {
        let first = stars.spokes.len();
        let [before, after] = if let Some(plane) = delaunay.plane() {
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

    /// Adds the own edges of a vertex. Gives what is before the first and after the last one.
    fn read_fan(&mut self, plane: Plane<'_>, ring: &[Seen], center: Located<Slot>, stars: &mut Stars) -> [Slot; 2] {
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

    /// Reads the triangle between two own edges, the second and the third of four that follow each other; marks of the third are at hand.
    fn read_triangle(
        &mut self,
        plane: Plane<'_>,
        center: Located<Slot>,
        [before, at, after, beyond]: [Seen; 4],
        spoke: &mut Spoke,
        next: Marks,
        stars: &mut Stars,
    ) {
        spoke.marks.set(Marks::NEXT_IS_SMALLER, after.position < at.position);
        // Whether what lies across one of the three edges is on the triangle's circle.
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
            Some((edge, true)) => self.concern(plane, plane.twin(edge), center.1),
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

    /// Notes whose maximum shares the circle of the triangle left of an edge, if it is not that of `reader`.
    pub fn concern(&mut self, plane: Plane<'_>, edge: HalfEdge, reader: Slot) {
        let Some(summit) = plane.summit_of_circle(edge) else { return };
        let corners = plane.corners(summit);
        let (_, owner) = corners.into_iter().min_by_key(|corner| corner.0).expect("there are three");
        if owner != reader {
            self.concerned.push(owner);
        }
    }
}

/// Reads an own edge, the second of three that follow each other.
#[inline]
fn read_edge(center: Position, [before, at, after]: [Seen; 3]) -> Spoke {
    let is_wide = |apex: Position| acuteness(center, apex, at.position) != Ordering::Greater;
    let left = !at.is_outer && is_wide(after.position);
    let right = !before.is_outer && is_wide(before.position);
    // With two right angles, the one with the larger apex flows.
    let from_left = left && (!right || after.position > before.position);
    let mut spoke = spoke(half_length_squared(center, at.position), at.slot);
    spoke.marks.set(Marks::FROM_LEFT, from_left);
    spoke.marks.set(Marks::FROM_RIGHT, right && !from_left);
    spoke
}

fn spoke(scale: f64, to: Slot) -> Spoke {
    Spoke { scale, weight: f64::NEG_INFINITY, to, marks: Marks::default() }
}
