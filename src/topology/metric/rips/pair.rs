//! A pair of vertices with its length, and the one total order of them.
//!
//! In: nothing.
//! Out: [`Pair`].
//! Invariant: the order is (length, smaller end, larger end). It decides every tie of the filtration.
//! Must not know: which pairs there are.

use std::cmp::Ordering;

/// Two vertices and the length between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The length.
    pub length: f64,
    /// The smaller end.
    pub a: u32,
    /// The larger end.
    pub b: u32,
}

impl Pair {
    /// The pair of `i` and `j`.
    #[inline]
    pub fn new(length: f64, i: u32, j: u32) -> Self {
        Self { length, a: i.min(j), b: i.max(j) }
    }

    /// Both ends.
    pub fn ends(self) -> [u32; 2] {
        [self.a, self.b]
    }

    /// Whether it comes before another pair.
    #[inline]
    pub fn before(&self, other: &Self) -> bool {
        self.length < other.length || self.length == other.length && (self.a, self.b) < (other.a, other.b)
    }

    /// The total order.
    pub fn order(&self, other: &Self) -> Ordering {
        self.length.total_cmp(&other.length).then((self.a, self.b).cmp(&(other.a, other.b)))
    }
}
