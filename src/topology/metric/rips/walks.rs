//! The classes of closed walks at some length of the filtration, as sums of births.
//!
//! In: a finished sweep that remembers what births became, closed walks of vertices.
//! Out: for each walk the births that its class is the sum of.
//! Invariants: a class is a sum of births that are alive at the walk's length, and so the sum is unique. The class of a
//! birth is that of its edge, closed by the tree.
//! Must not know: how the sweep found births and deaths.

use super::classes::births;
use super::pair::Pair;
use super::sweep::Sweep;
use crate::topology::metric::space::Distances;

/// A closed walk along edges of a space, whose class is asked for. The last vertex is joined to the first.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedWalk {
    /// Its vertices.
    pub vertices: Vec<u32>,
    /// The length of the filtration at which it is asked for.
    pub length: f64,
}

impl ClosedWalk {
    /// Its steps from one vertex to another.
    fn steps(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(&u, &v)| (u, v)).filter(|(u, v)| u != v)
    }

    /// Whether all its steps are edges up to its length, and up to the last one of the filtration.
    fn is_there(&self, space: &dyn Distances, limit: f64) -> bool {
        self.steps().all(|(u, v)| space.length(u, v) <= self.length.min(limit))
    }
}

/// The critical edges that a walk's class is the sum of, in order; none where a step of the walk is no edge.
pub type Class = Option<Vec<Pair>>;

/// The classes of walks in a space whose filtration ends at the length `limit`, at most that of the largest double.
///
/// `sweep` is what has been swept; none without edges. `over` is the length up to which pairs were swept where the
/// sweep has ended before its limit, since nothing is alive from there on.
pub fn classes_of(
    walks: &[ClosedWalk],
    space: &dyn Distances,
    limit: f64,
    sweep: Option<&Sweep<'_>>,
    over: Option<f64>,
) -> Vec<Class> {
    let answer = |walk: &ClosedWalk| {
        let is_zero = over.is_some_and(|over| walk.length >= over);
        walk.is_there(space, limit)
            .then(|| sweep.filter(|_| !is_zero).map_or_else(Vec::new, |sweep| class(walk, sweep)))
    };
    walks.iter().map(answer).collect()
}

fn class(walk: &ClosedWalk, sweep: &Sweep<'_>) -> Vec<Pair> {
    let (halving, classes) = (sweep.halving(), sweep.classes());
    let mut total = classes.zero();
    walk.steps().for_each(|(u, v)| halving.add(u, v, &mut total));
    let is_dead = |birth: u32| sweep.deaths()[birth as usize].is_some_and(|death| death.length <= walk.length);
    classes.settle_as_of(is_dead, &mut total);
    births(&total).map(|birth| sweep.births()[birth as usize]).collect()
}
