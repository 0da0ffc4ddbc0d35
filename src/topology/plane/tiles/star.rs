//! Stars: the filtration around single vertices, in flat memory.
//!
//! In: what a [`StarReader`](super::star_reader::StarReader) reads.
//! Out: [`Stars`], in order of position.
//! Invariants: every edge belongs to its smaller end, every triangle to its smallest corner, so each is stored exactly
//! once. A star depends on positions and on the triangles around its vertex alone. It is valid until one of these
//! changes; for a maximum with more sites on its circle, until one of these sites changes.
//! Must not know: tiles, reductions.
//!
//! The own edges of a vertex lie in one half of the plane, so they are consecutive around it, and between consecutive
//! ones lies an own triangle: a [`Star`] is a fan. It stores which edges are Gabriel, with their scales, and to which
//! side the others are attached; which triangles are local maxima, with circumradius and name; and what lies beyond the
//! first and the last edge.

use crate::topology::cloud::{Located, Position, Slot, half_length_squared};

/// Properties of an edge, and of the triangle that follows it counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Marks(u8);

impl Marks {
    /// The triangle on its left flows across it.
    pub const FROM_LEFT: Self = Self(1);
    /// The triangle on its right flows across it.
    pub const FROM_RIGHT: Self = Self(2);
    /// The triangle that follows is a local maximum.
    pub const MAXIMUM: Self = Self(4);
    /// That maximum has more sites on its circle, so its name is stored.
    pub const CIRCLE: Self = Self(8);
    /// The next edge leads to a smaller position than this one.
    pub const NEXT_IS_SMALLER: Self = Self(16);

    /// Whether all of `marks` are set.
    #[inline]
    pub fn has(self, marks: Self) -> bool {
        self.0 & marks.0 == marks.0
    }

    /// Sets `marks` if `when` is true.
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
    /// The squared circumradius of the triangle that follows, if that is a local maximum.
    pub weight: f64,
    /// The end that is not the star's vertex.
    pub to: Slot,
    /// The other properties.
    pub marks: Marks,
}

/// A local maximum of the filtration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalMaximum {
    /// The squared circumradius; -infinity if no maximum is known.
    pub weight: f64,
    /// The triangle that names it, its corners in order of position.
    pub triangle: [Slot; 3],
}

impl LocalMaximum {
    /// The maximum is not known.
    pub const UNKNOWN: Self = Self { weight: f64::NEG_INFINITY, triangle: [0; 3] };
    /// The outer face.
    pub const OUTER: Self = Self { weight: f64::INFINITY, triangle: [0; 3] };
}

/// Stands for the third corner if the outer face is there.
pub const OUTSIDE: Slot = Slot::MAX;

/// A vertex, and what lies beyond its own edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Center {
    /// Its position.
    pub position: Position,
    /// Its slot.
    pub slot: Slot,
    /// The third corner of the triangle on the right of the first edge, or [`OUTSIDE`].
    pub before: Slot,
    /// The third corner of the triangle on the left of the last edge, or [`OUTSIDE`].
    pub after: Slot,
    /// Number of its own edges.
    pub spokes: u32,
}

/// A star, stored in a [`Stars`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Star<'a> {
    /// Its vertex.
    pub center: &'a Center,
    /// Its own edges, counter-clockwise.
    pub spokes: &'a [Spoke],
    /// The stored names of its own maxima, in order.
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
    /// The number of stars.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// The number of own edges in all stars.
    pub fn spoke_count(&self) -> usize {
        self.spokes.len()
    }

    /// Adds a copy of a star. Its position must be the largest so far.
    #[inline]
    pub fn push(&mut self, star: Star<'_>) {
        debug_assert!(self.centers.last().is_none_or(|last| last.position < star.center.position));
        self.spokes.extend_from_slice(star.spokes);
        self.names.extend_from_slice(star.names);
        self.centers.push(*star.center);
    }

    /// All stars, in order.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = Star<'_>> {
        let (mut spokes, mut names) = (&self.spokes[..], &self.names[..]);
        self.centers.iter().map(move |center| {
            let own = take(&mut spokes, center.spokes as usize);
            let named = if names.is_empty() { 0 } else { own.iter().filter(|s| s.marks.has(Marks::CIRCLE)).count() };
            Star { center, spokes: own, names: take(&mut names, named) }
        })
    }

    /// The vertices, in order.
    pub fn vertices(&self) -> impl Iterator<Item = Located<Slot>> + '_ {
        self.centers.iter().map(|center| (center.position, center.slot))
    }

    /// A vertex near a position: the nearest of some vertices before and after it in the order.
    pub fn near(&self, position: Position) -> Option<Slot> {
        const AROUND: usize = 6;
        let place = self.centers.partition_point(|center| center.position < position);
        let some = &self.centers[place.saturating_sub(AROUND)..(place + AROUND).min(self.centers.len())];
        let distance = |center: &Center| half_length_squared(center.position, position);
        let nearer = |best: (f64, Slot), next: (f64, Slot)| if next.0 < best.0 { next } else { best };
        some.iter().map(|center| (distance(center), center.slot)).reduce(nearer).map(|(_, slot)| slot)
    }

    /// Copies other stars into this memory.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        self.centers.extend_from_slice(&other.centers);
        self.spokes.extend_from_slice(&other.spokes);
        self.names.extend_from_slice(&other.names);
    }

    /// Removes all stars.
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
