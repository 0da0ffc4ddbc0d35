//! What the filtration knows around one vertex, kept flat: the stars of a tile's vertices, one after the other.
//!
//! In: the surroundings of a vertex in the triangulation. Out: [`Stars`]. An edge is its smaller end's own, a triangle its smallest corner's. Seen
//! from a vertex, its own edges lie in one half of the plane, so they are neighbours around it, and between any two of them that follow each
//! other lies an own triangle: a [`Star`] is a fan. It says which edges are Gabriel and at what scale they enter, or to which side they are attached;
//! which triangles are local maxima, with their circumradius and name; and what lies beyond the first and the last edge. Invariants: every
//! edge and every triangle is told of exactly once; what a star says depends on positions and the triangles around its vertex
//! alone, so it stays right until one of those changes, or, for a maximum with more sites on its circle, one on that circle. Must
//! not know: tiles, reductions.

use crate::topology::cloud::{Located, Position, Slot, half_length_squared};

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

    /// Sets `marks` if something holds.
    #[inline]
    pub fn set(&mut self, marks: Self, when: bool) {
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
    /// Number of its own edges.
    pub spokes: u32,
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
    pub(super) centers: Vec<Center>,
    pub(super) spokes: Vec<Spoke>,
    pub(super) names: Vec<[Slot; 3]>,
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
