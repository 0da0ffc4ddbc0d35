//! The most persistent dots of a frame, with what fills their cycles, by ids.
//!
//! In: dots, with functions that give their persistence, name and filling.
//! Out: a [`Ranking`].
//! Invariants: the most persistent first, equal ones in order of their critical edges. A shorter ranking is a prefix of
//! a longer one.
//! Must not know: views, formats, how holes are found.

use std::cmp::Ordering;

use super::hopes::Hole;
use super::named::{Critical, EdgeId};

/// A dot of the persistence diagram, with what fills its cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedDot {
    /// The critical edge and its label.
    pub critical: Critical,
    /// The last point of its hole to be filled; in the plane.
    pub hole: Option<Hole>,
    /// The edge with which its cycle is filled; in a Rips filtration, and if it ever is.
    pub death_edge: Option<EdgeId>,
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranking {
    /// The number of the frame.
    pub number: u64,
    /// The number of all dots.
    pub total: usize,
    /// The most persistent first.
    pub dots: Vec<RankedDot>,
}

impl Ranking {
    /// The first `most` dots. `name` is called only for dots that may be among them, `filling`
    /// only for those that are.
    pub(crate) fn new<D>(
        number: u64,
        dots: Vec<D>,
        most: usize,
        persistence: impl Fn(&D) -> f64,
        name: impl Fn(&D) -> Critical,
        filling: impl Fn(&D) -> (Option<Hole>, Option<EdgeId>),
    ) -> Self {
        let (total, first) = first(dots, most, persistence, name);
        let ranked = |(dot, critical)| {
            let (hole, death_edge) = filling(&dot);
            RankedDot { critical, hole, death_edge }
        };
        let dots = first.into_iter().map(ranked).collect();
        Self { number, total, dots }
    }
}

/// The number of all dots, and the first ones in order. `name` is called only for dots that may be among them.
fn first<D>(
    mut dots: Vec<D>,
    most: usize,
    persistence: impl Fn(&D) -> f64,
    name: impl Fn(&D) -> Critical,
) -> (usize, Vec<(D, Critical)>) {
    let total = dots.len();
    if most == 0 {
        return (total, Vec::new());
    }
    if most < total {
        let (_, last, _) = dots.select_nth_unstable_by(most - 1, |a, b| persistence(b).total_cmp(&persistence(a)));
        let least = persistence(last);
        dots.retain(|dot| persistence(dot) >= least);
    }
    let with_name = |dot: D| {
        let critical = name(&dot);
        (dot, critical)
    };
    let mut named: Vec<(D, Critical)> = dots.into_iter().map(with_name).collect();
    named.sort_unstable_by(|(_, a), (_, b)| by_persistence(a, b));
    named.truncate(most);
    (total, named)
}

fn by_persistence(a: &Critical, b: &Critical) -> Ordering {
    (b.death - b.birth).total_cmp(&(a.death - a.birth)).then(a.edge.cmp(&b.edge))
}
