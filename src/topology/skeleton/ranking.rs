//! The most persistent dots of a frame, with their holes, by ids.
//!
//! In: a skeleton, whole or in tiles, and how many dots are wanted. Out: a [`Ranking`]. Invariants: the most persistent first, equal ones by their critical edges; the first ones of a
//! longer ranking are the shorter ranking. Must not know: views, formats.

use std::cmp::Ordering;

use super::hopes::Hole;
use super::named::Critical;

/// A dot of the persistence diagram, with its hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankedDot {
    /// The critical edge and its label.
    pub critical: Critical,
    /// Where it is filled.
    pub hole: Hole,
}

/// The most persistent dots of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ranking {
    /// Number of the frame.
    pub number: u64,
    /// How many dots there are in all.
    pub total: usize,
    /// The most persistent first.
    pub dots: Vec<RankedDot>,
}

impl Ranking {
    /// The first ones of some dots, given their persistence, name and hole. Only those that may be among the first are given a name, and only these a hole.
    pub(crate) fn new<D>(
        number: u64,
        dots: Vec<D>,
        most: usize,
        persistence: impl Fn(&D) -> f64,
        name: impl Fn(&D) -> Critical,
        hole: impl Fn(&D) -> Hole,
    ) -> Self {
        let (total, first) = first(dots, most, persistence, name);
        let dots = first.into_iter().map(|(dot, critical)| RankedDot { critical, hole: hole(&dot) }).collect();
        Self { number, total, dots }
    }
}

/// The number of all dots, and the first ones in order. Only those that may be among them are given a name.
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
