//! The persistence diagram, stored so that its widest gaps are found quickly however many dots there are.
//!
//! In: dots that are added or removed.
//! Out: [`Selection`]s, as [`gaps`](crate::topology::skeleton::gaps) gives them.
//! Invariants: a selection equals that of the whole diagram. Every dot of at least the persistence `least` is sorted.
//! All dots die, as those of the plane do.
//! Must not know: edges other than critical ones, views.
//!
//! The most persistent dots are sorted. All others are counted in buckets of equal width. No gap between counted dots
//! is wider than the longest run of empty buckets and the two buckets around it. As long as the wanted gaps are wider,
//! they are all between sorted dots. If they are not, more dots have to be sorted, which takes time in proportion to
//! all dots. That is rare where few dots stand out.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::num::NonZeroU32;

use crate::topology::base::ordinal;
use crate::topology::skeleton::gaps::{
    Gap, Selection, TOLERANCE, diagonal_strips, lowest, ranked, selection_of, strips_between,
};
use crate::topology::skeleton::{Critical, EdgeId};

/// The number of dots that are sorted at first.
const SORTED_AT_FIRST: usize = 512;

/// If this many times as many dots as chosen are sorted, the choice is made again.
const GROWTH: usize = 8;

/// A bucket is at most this fraction (1/8) of the narrowest wanted gap, within the limit of [`BUCKETS`].
const FINENESS: f64 = 8.0;

/// The largest number of buckets.
const BUCKETS: f64 = 4_096.0;

/// The order of dots: the most persistent first, equal ones in order of their edges.
type Rank = (Reverse<u64>, EdgeId);

/// A dot in its own representation, before it is named by ids.
pub trait Persistent: Copy {
    /// Death minus birth.
    fn persistence(&self) -> f64;
}

/// A dot by ids, and in its own representation.
pub type NamedDot<D> = (Critical, D);

/// A persistence diagram that changes.
#[derive(Clone, Debug)]
pub struct Diagram<D> {
    sorted: BTreeMap<Rank, NamedDot<D>>,
    /// The smallest persistence of sorted dots; 0 if all dots are sorted.
    least: f64,
    buckets: Vec<u32>,
    /// The number of buckets in a unit of persistence.
    scale: f64,
    counted: usize,
    /// The number of dots that are sorted at first.
    at_first: usize,
    /// The number of dots chosen to be sorted last time.
    chosen: usize,
}

fn rank(dot: &Critical) -> Rank {
    (Reverse(ordinal(persistence(dot))), dot.edge)
}

fn persistence(dot: &Critical) -> f64 {
    dot.death - dot.birth
}

impl<D: Persistent> Diagram<D> {
    /// The diagram of all these dots.
    pub fn new(all: impl Iterator<Item = NamedDot<D>>) -> Self {
        Self::with_sorted(all, SORTED_AT_FIRST)
    }

    fn with_sorted(all: impl Iterator<Item = NamedDot<D>>, at_first: usize) -> Self {
        let sorted = BTreeMap::new();
        let mut diagram =
            Self { sorted, least: 0.0, buckets: Vec::new(), scale: 0.0, counted: 0, at_first, chosen: at_first };
        diagram.choose(at_first, 2, 0.0, all);
        diagram
    }

    /// Follows dots that were removed and added. `name` gives the ids of one.
    pub fn follow(&mut self, removed: &[D], added: &[D], name: impl Fn(&D) -> Critical) {
        for dot in removed {
            if self.is_sorted(dot.persistence()) {
                self.sorted.remove(&rank(&name(dot)));
            } else {
                self.count(dot.persistence(), false);
            }
        }
        for dot in added {
            if self.is_sorted(dot.persistence()) {
                let named = name(dot);
                self.sorted.insert(rank(&named), (named, *dot));
            } else {
                self.count(dot.persistence(), true);
            }
        }
    }

    /// Whether all dots of at least this persistence are sorted.
    pub fn is_sorted(&self, persistence: f64) -> bool {
        persistence >= self.least
    }

    fn count(&mut self, persistence: f64, comes: bool) {
        let bucket = self.bucket(persistence);
        if comes {
            self.buckets[bucket] += 1;
            self.counted += 1;
        } else {
            self.buckets[bucket] -= 1;
            self.counted -= 1;
        }
    }

    fn bucket(&self, persistence: f64) -> usize {
        ((persistence * self.scale) as usize).min(self.buckets.len() - 1)
    }

    /// The sorted dots of at least this persistence, in order.
    pub fn down_to(&self, least: f64) -> impl Iterator<Item = &Critical> {
        self.sorted.values().map(|(dot, _)| dot).take_while(move |dot| persistence(dot) >= least)
    }

    /// The most persistent dots down to a persistence, in order: at most `most`, and all that are as persistent as the
    /// last of these.
    pub fn first<I: Iterator<Item = NamedDot<D>>>(
        &mut self,
        most: usize,
        least: f64,
        largest_death: f64,
        all: impl Fn() -> I,
    ) -> Vec<NamedDot<D>> {
        let is_short = self.sorted.len() < most && self.counted > 0 && !self.is_sorted(least);
        if is_short || self.sorted.len() > GROWTH * self.chosen {
            let wanted = all().filter(|(dot, _)| persistence(dot) >= least).count().min(most);
            self.choose(self.at_first.max(wanted.saturating_mul(2)), 2, TOLERANCE * largest_death, all());
        }
        let is_wanted = |dot: &&NamedDot<D>| persistence(&dot.0) >= least;
        let mut wanted: Vec<NamedDot<D>> = self.sorted.values().take_while(is_wanted).take(most).copied().collect();
        if let (Some(last), true) = (wanted.last().map(|dot| persistence(&dot.0)), wanted.len() == most) {
            let ties = self.sorted.values().skip(most).take_while(|dot| persistence(&dot.0) >= last);
            wanted.extend(ties);
        }
        wanted
    }

    /// Selects by the k widest diagonal gaps and the l widest vertical ones. `all` gives every dot, in case more have
    /// to be sorted.
    pub fn select<I: Iterator<Item = NamedDot<D>>>(
        &mut self,
        k: NonZeroU32,
        l: NonZeroU32,
        largest_death: f64,
        all: impl Fn() -> I,
    ) -> Selection {
        let (count, tolerance) = (k.get() as usize + 1, TOLERANCE * largest_death);
        if self.sorted.len() > GROWTH * self.chosen {
            self.choose(self.at_first, count, tolerance, all());
        }
        loop {
            if let Some(gaps) = self.widest(count, tolerance) {
                let ds = lowest(&gaps[..gaps.len().min(count - 1)]).map_or(f64::INFINITY, |gap| gap.high);
                let dots: Vec<Critical> = self.down_to(ds).copied().collect();
                let births = dots.iter().map(|dot| dot.birth);
                return selection_of(gaps, births, k, l, tolerance);
            }
            self.choose(self.chosen * GROWTH, count, tolerance, all());
        }
    }

    /// The widest diagonal gaps, if they are all between sorted dots.
    fn widest(&self, count: usize, tolerance: f64) -> Option<Vec<Gap>> {
        let ascending = || self.sorted.values().rev().map(|(dot, _)| persistence(dot));
        if self.counted == 0 {
            return Some(ranked(diagonal_strips(ascending(), tolerance), count, tolerance));
        }
        // Only between sorted dots: the strip below the lowest of them ends at some counted dot.
        let gaps = ranked(strips_between(ascending(), tolerance), count, tolerance);
        let enough = gaps.len() == count;
        let last = gaps.last().map_or(0.0, Gap::width);
        (enough && last - tolerance > self.widest_below(tolerance)).then_some(gaps)
    }

    /// A bound on the gaps between counted dots, and between these and the diagonal or the lowest sorted dot.
    fn widest_below(&self, tolerance: f64) -> f64 {
        let (mut run, mut longest) = (0, 0);
        for &count in &self.buckets {
            run = if count == 0 { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        let lowest_sorted = self.sorted.values().next_back().map_or(self.least, |(dot, _)| persistence(dot));
        (longest as f64 + 2.0) / self.scale * (1.0 + TOLERANCE) + (lowest_sorted - self.least) + tolerance
    }

    /// Sorts about this number of dots and counts the others.
    fn choose(&mut self, chosen: usize, count: usize, tolerance: f64, all: impl Iterator<Item = NamedDot<D>>) {
        let mut dots: Vec<NamedDot<D>> = all.collect();
        self.chosen = chosen;
        self.sorted.clear();
        self.buckets.clear();
        self.counted = 0;
        self.least = 0.0;
        if self.chosen < dots.len() {
            let by_persistence = |a: &NamedDot<D>, b: &NamedDot<D>| persistence(&b.0).total_cmp(&persistence(&a.0));
            let (_, last, _) = dots.select_nth_unstable_by(self.chosen - 1, by_persistence);
            self.least = persistence(&last.0);
        }
        let (sorted, low): (Vec<NamedDot<D>>, Vec<NamedDot<D>>) =
            dots.into_iter().partition(|dot| self.is_sorted(persistence(&dot.0)));
        self.sorted.extend(sorted.into_iter().map(|dot| (rank(&dot.0), dot)));
        let strips = strips_between(self.sorted.values().rev().map(|dot| persistence(&dot.0)), tolerance);
        let width = ranked(strips, count, tolerance).last().map_or(0.0, Gap::width);
        let buckets = (self.least / width * FINENESS).clamp(1.0, BUCKETS).ceil();
        self.scale = buckets / self.least;
        self.buckets.resize(buckets as usize, 0);
        low.iter().for_each(|dot| self.count(persistence(&dot.0), true));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::topology::VertexId;

    /// A dot by its number, persistence and birth.
    fn dot(number: usize, persistence: f64, birth: f64) -> Critical {
        Critical { edge: [VertexId(number as u64), VertexId(u64::MAX)], birth, death: birth + persistence }
    }

    /// A dot's own representation: its number and persistence.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Numbered(usize, f64);

    impl Persistent for Numbered {
        fn persistence(&self) -> f64 {
            self.1
        }
    }

    fn numbered(dot: &Critical) -> Numbered {
        Numbered(dot.edge[0].0 as usize, persistence(dot))
    }

    /// Much noise, some values that stand out, some that are equal.
    fn values() -> impl Strategy<Value = f64> {
        prop_oneof![20 => 1e-9..1e-2, 3 => 0.0..1.0, 3 => (1..6_u32).prop_map(|n| f64::from(n) * 0.125)]
    }

    fn from_scratch(dots: &[Critical], k: NonZeroU32, l: NonZeroU32, tolerance: f64) -> Selection {
        let mut dots = dots.to_vec();
        dots.sort_unstable_by_key(rank);
        let gaps =
            ranked(diagonal_strips(dots.iter().rev().map(persistence), tolerance), k.get() as usize + 1, tolerance);
        let ds = lowest(&gaps[..gaps.len().min(k.get() as usize)]).map_or(f64::INFINITY, |gap| gap.high);
        dots.retain(|dot| persistence(dot) >= ds);
        selection_of(gaps, dots.iter().map(|dot| dot.birth), k, l, tolerance)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

        /// After every change, whatever is sorted.
        #[test]
        fn selections_are_those_of_the_whole_diagram(
            values in prop::collection::vec((values(), prop_oneof![Just(0.25), 0.0..1.0]), 1..400),
            steps in prop::collection::vec(prop::collection::vec(any::<prop::sample::Index>(), 1..20), 1..12),
            at_first in 1..30_usize,
            (k, l) in (1..5_u32, 1..4_u32),
        ) {
            let numbered_dots = values.iter().enumerate();
            let all: Vec<Critical> = numbered_dots.map(|(n, &(p, birth))| dot(n, p.max(1e-9), birth)).collect();
            let [k, l] = [k, l].map(|rank| NonZeroU32::new(rank).expect("from 1"));
            let mut there: Vec<bool> = (0..all.len()).map(|number| number % 3 != 0).collect();
            let now = |there: &[bool]| -> Vec<Critical> {
                all.iter().zip(there).filter(|(_, there)| **there).map(|(dot, _)| *dot).collect()
            };
            let named = |dots: Vec<Critical>| dots.into_iter().map(|dot| (dot, numbered(&dot)));
            let mut diagram = Diagram::with_sorted(named(now(&there)), at_first);
            for step in steps {
                let (mut removed, mut added) = (Vec::new(), Vec::new());
                let turned: BTreeSet<usize> = step.iter().map(|index| index.index(all.len())).collect();
                for number in turned {
                    let list = if there[number] { &mut removed } else { &mut added };
                    list.push(numbered(&all[number]));
                    there[number] = !there[number];
                }
                diagram.follow(&removed, &added, |dot| all[dot.0]);
                let dots = now(&there);
                let largest = dots.iter().map(|dot| dot.death).fold(0.0, f64::max);
                let selection = diagram.select(k, l, largest, || named(dots.clone()));
                prop_assert_eq!(selection, from_scratch(&dots, k, l, TOLERANCE * largest));
                let (most, least) = (step.len() * 3, if at_first % 2 == 0 { 0.0 } else { 0.01 });
                let first = diagram.first(most, least, largest, || named(dots.clone()));
                let mut wanted = dots;
                wanted.sort_unstable_by_key(rank);
                let last = wanted.get(most - 1).map_or(0.0, persistence).max(least);
                wanted.retain(|dot| persistence(dot) >= last);
                prop_assert_eq!(first, named(wanted).collect::<Vec<_>>());
            }
        }
    }
}
