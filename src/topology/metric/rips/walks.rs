//! The classes of closed walks at some length of the filtration, as sums of births and of dots.
//!
//! In: a finished sweep that remembers what births became, closed walks of vertices.
//! Out: for each walk the births that its class is the sum of, and the dots that live as long as its parts.
//! Invariants: a class is a sum of births that are alive at the walk's length, and so the sum is unique. The class of a
//! birth is that of its edge, closed by the tree. At a larger length a walk has the same dots, without those that have
//! died.
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

/// The homology class of a walk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Class {
    /// The critical edges that it is the sum of, in order: each stands for the cycle that the tree closes.
    pub births: Vec<Pair>,
    /// The critical edges of the dots that it is the sum of, in order: each stands for the cycle that dies with the
    /// dot. So the class dies with the last of these dots, and not with the last of `births`: the cycle that the tree
    /// closes may be a longer one around two holes.
    pub dots: Vec<Pair>,
}

/// The classes of walks, none where a step of the walk is no edge, in a space whose filtration ends at the length
/// `limit`, at most that of the largest double.
///
/// `sweep` is what has been swept; none without edges. `over` is the length up to which pairs were swept where the
/// sweep has ended before its limit, since nothing is alive from there on.
pub fn classes_of(
    walks: &[ClosedWalk],
    space: &dyn Distances,
    limit: f64,
    sweep: Option<&Sweep<'_>>,
    over: Option<f64>,
) -> Vec<Option<Class>> {
    let answer = |walk: &ClosedWalk| {
        let is_zero = over.is_some_and(|over| walk.length >= over);
        walk.is_there(space, limit)
            .then(|| sweep.filter(|_| !is_zero).map_or_else(Class::default, |sweep| class(walk, sweep)))
    };
    walks.iter().map(answer).collect()
}

fn class(walk: &ClosedWalk, sweep: &Sweep<'_>) -> Class {
    let (halving, classes) = (sweep.halving(), sweep.classes());
    let mut total = classes.zero();
    walk.steps().for_each(|(u, v)| halving.add(u, v, &mut total));
    let is_dead = |birth: u32| sweep.deaths()[birth as usize].is_some_and(|death| death.length <= walk.length);
    classes.settle_as_of(is_dead, &mut total);
    let pair = |birth: u32| sweep.births()[birth as usize];
    let births = births(&total).map(pair).collect();
    Class { births, dots: classes.split_by_death(&mut total).into_iter().map(pair).collect() }
}
