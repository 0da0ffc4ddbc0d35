//! The persistence diagram, kept so that its widest gaps are at hand however many dots there are.
//!
//! In: dots that come and go. Out: [`Selection`]s, as [`gaps`](crate::topology::skeleton::gaps) gives them. The most persistent dots ("tall") stand in order; all others only
//! count in buckets of one width, which bound the gaps between them: no gap among low dots is wider than the longest run of empty buckets
//! and the two around it. As long as the gaps wanted are wider, they are all among the tall. Where they are not, more dots have to
//! become tall, which takes time in proportion to all of them; that is rare where few dots stand out. Invariants: a selection is the same as
//! from the whole diagram; every dot of at least the persistence `least` is tall. Must not know: edges that are not critical, views.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::num::NonZeroU32;

use crate::topology::base::ordinal;
use crate::topology::skeleton::gaps::{
    Gap, Selection, TOLERANCE, diagonal_strips, lowest, ranked, selection_of, strips_between,
};
use crate::topology::skeleton::{Critical, EdgeId};

/// So many dots are tall at first.
const TALL: usize = 512;

/// When more than so many times as many are, fewer become it again.
const GROWTH: usize = 8;

/// Buckets are so many times narrower than the narrowest gap wanted, if that does not make too many of them.
const FINENESS: f64 = 8.0;

/// At most so many buckets.
const BUCKETS: f64 = 4_096.0;

/// The order of dots: the most persistent first, equal ones by their edges.
type Rank = (Reverse<u64>, EdgeId);

/// A dot as it is held elsewhere, before it is given its name.
pub trait Persistent: Copy {
    /// Death minus birth.
    fn persistence(&self) -> f64;
}

/// A dot by ids, and as it is held elsewhere.
pub type NamedDot<D> = (Critical, D);

/// A persistence diagram that changes.
#[derive(Clone, Debug)]
pub struct Diagram<D> {
    tall: BTreeMap<Rank, NamedDot<D>>,
    /// The smallest persistence of tall dots; 0 when all are.
    least: f64,
    low: Vec<u32>,
    /// Buckets by unit of persistence.
    scale: f64,
    low_count: usize,
    /// So many dots are tall at first.
    at_first: usize,
    /// So many dots became tall when they were last chosen.
    chosen: usize,
}

fn rank(dot: &Critical) -> Rank {
    (Reverse(ordinal(persistence(dot))), dot.edge)
}

fn persistence(dot: &Critical) -> f64 {
    dot.death - dot.birth
}

impl<D: Persistent> Diagram<D> {
    /// A diagram of all these dots.
    pub fn new(all: impl Iterator<Item = NamedDot<D>>) -> Self {
        Self::with_tall(all, TALL)
    }

    fn with_tall(all: impl Iterator<Item = NamedDot<D>>, at_first: usize) -> Self {
        let tall = BTreeMap::new();
        let mut diagram =
            Self { tall, least: 0.0, low: Vec::new(), scale: 0.0, low_count: 0, at_first, chosen: at_first };
        diagram.choose(at_first, 2, 0.0, all);
        diagram
    }

    /// Follows dots that have come and gone; `name` tells of one in full.
    pub fn follow(&mut self, removed: &[D], added: &[D], name: impl Fn(&D) -> Critical) {
        for dot in removed {
            if self.is_tall(dot.persistence()) {
                self.tall.remove(&rank(&name(dot)));
            } else {
                self.count_low(dot.persistence(), false);
            }
        }
        for dot in added {
            if self.is_tall(dot.persistence()) {
                let named = name(dot);
                self.tall.insert(rank(&named), (named, *dot));
            } else {
                self.count_low(dot.persistence(), true);
            }
        }
    }

    /// Whether all dots of at least this persistence stand in order.
    pub fn is_tall(&self, persistence: f64) -> bool {
        persistence >= self.least
    }

    fn count_low(&mut self, persistence: f64, comes: bool) {
        let bucket = self.bucket(persistence);
        if comes {
            self.low[bucket] += 1;
            self.low_count += 1;
        } else {
            self.low[bucket] -= 1;
            self.low_count -= 1;
        }
    }

    fn bucket(&self, persistence: f64) -> usize {
        ((persistence * self.scale) as usize).min(self.low.len() - 1)
    }

    /// Tall dots of at least this persistence, in order.
    pub fn down_to(&self, least: f64) -> impl Iterator<Item = &Critical> {
        self.tall.values().map(|(dot, _)| dot).take_while(move |dot| persistence(dot) >= least)
    }

    /// The most persistent dots down to a persistence, in order: so many at the most, and all that are as persistent as the last of them.
    pub fn first<I: Iterator<Item = NamedDot<D>>>(
        &mut self,
        most: usize,
        least: f64,
        largest_death: f64,
        all: impl Fn() -> I,
    ) -> Vec<NamedDot<D>> {
        let is_short = self.tall.len() < most && self.low_count > 0 && !self.is_tall(least);
        if is_short || self.tall.len() > GROWTH * self.chosen {
            let wanted = all().filter(|(dot, _)| persistence(dot) >= least).count().min(most);
            self.choose(self.at_first.max(wanted.saturating_mul(2)), 2, TOLERANCE * largest_death, all());
        }
        let is_wanted = |dot: &&NamedDot<D>| persistence(&dot.0) >= least;
        let mut wanted: Vec<NamedDot<D>> = self.tall.values().take_while(is_wanted).take(most).copied().collect();
        if let (Some(last), true) = (wanted.last().map(|dot| persistence(&dot.0)), wanted.len() == most) {
            let ties = self.tall.values().skip(most).take_while(|dot| persistence(&dot.0) >= last);
            wanted.extend(ties);
        }
        wanted
    }

    /// Selects by the k widest diagonal gaps and the l widest vertical ones. `all` gives every dot, should more of them have to be tall.
    pub fn select<I: Iterator<Item = NamedDot<D>>>(
        &mut self,
        k: NonZeroU32,
        l: NonZeroU32,
        largest_death: f64,
        all: impl Fn() -> I,
    ) -> Selection {
        let (count, tolerance) = (k.get() as usize + 1, TOLERANCE * largest_death);
        if self.tall.len() > GROWTH * self.chosen {
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

    /// The widest diagonal gaps, if they are all among tall dots.
    fn widest(&self, count: usize, tolerance: f64) -> Option<Vec<Gap>> {
        let ascending = || self.tall.values().rev().map(|(dot, _)| persistence(dot));
        if self.low_count == 0 {
            return Some(ranked(diagonal_strips(ascending(), tolerance), count, tolerance));
        }
        // Between tall dots alone: the strip below the lowest of them ends somewhere among the low ones.
        let gaps = ranked(strips_between(ascending(), tolerance), count, tolerance);
        let enough = gaps.len() == count;
        let last = gaps.last().map_or(0.0, Gap::width);
        (enough && last - tolerance > self.widest_below(tolerance)).then_some(gaps)
    }

    /// A bound on the gaps among low dots, and between them and the diagonal or the lowest tall one.
    fn widest_below(&self, tolerance: f64) -> f64 {
        let (mut run, mut longest) = (0, 0);
        for &count in &self.low {
            run = if count == 0 { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        let lowest_tall = self.tall.values().next_back().map_or(self.least, |(dot, _)| persistence(dot));
        (longest as f64 + 2.0) / self.scale * (1.0 + TOLERANCE) + (lowest_tall - self.least) + tolerance
    }

    /// Makes about so many dots tall.
    fn choose(&mut self, chosen: usize, count: usize, tolerance: f64, all: impl Iterator<Item = NamedDot<D>>) {
        let mut dots: Vec<NamedDot<D>> = all.collect();
        self.chosen = chosen;
        self.tall.clear();
        self.low.clear();
        self.low_count = 0;
        self.least = 0.0;
        if self.chosen < dots.len() {
            let by_persistence = |a: &NamedDot<D>, b: &NamedDot<D>| persistence(&b.0).total_cmp(&persistence(&a.0));
            let (_, last, _) = dots.select_nth_unstable_by(self.chosen - 1, by_persistence);
            self.least = persistence(&last.0);
        }
        let (tall, low): (Vec<NamedDot<D>>, Vec<NamedDot<D>>) =
            dots.into_iter().partition(|dot| self.is_tall(persistence(&dot.0)));
        self.tall.extend(tall.into_iter().map(|dot| (rank(&dot.0), dot)));
        let strips = strips_between(self.tall.values().rev().map(|dot| persistence(&dot.0)), tolerance);
        let width = ranked(strips, count, tolerance).last().map_or(0.0, Gap::width);
        let buckets = (self.least / width * FINENESS).clamp(1.0, BUCKETS).ceil();
        self.scale = buckets / self.least;
        self.low.resize(buckets as usize, 0);
        low.iter().for_each(|dot| self.count_low(persistence(&dot.0), true));
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::topology::VertexId;

    /// A dot by its place among all, its persistence and birth.
    fn dot(number: usize, persistence: f64, birth: f64) -> Critical {
        Critical { edge: [VertexId(number as u64), VertexId(u64::MAX)], birth, death: birth + persistence }
    }

    /// A dot as it is held elsewhere: by its place among all.
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

    /// Much noise, and some that stands out; some all alike.
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

        /// After every change, whatever is tall.
        #[test]
        fn selections_are_those_of_the_whole_diagram(
            values in prop::collection::vec((values(), prop_oneof![Just(0.25), 0.0..1.0]), 1..400),
            steps in prop::collection::vec(prop::collection::vec(any::<prop::sample::Index>(), 1..20), 1..12),
            at_first in 1..30_usize,
            (k, l) in (1..5_u32, 1..4_u32),
        ) {
            let all: Vec<Critical> = values.iter().enumerate().map(|(n, &(p, birth))| dot(n, p.max(1e-9), birth)).collect();
            let [k, l] = [k, l].map(|rank| NonZeroU32::new(rank).expect("from 1"));
            let mut there: Vec<bool> = (0..all.len()).map(|number| number % 3 != 0).collect();
            let now = |there: &[bool]| -> Vec<Critical> {
                all.iter().zip(there).filter(|(_, there)| **there).map(|(dot, _)| *dot).collect()
            };
            let named = |dots: Vec<Critical>| dots.into_iter().map(|dot| (dot, numbered(&dot)));
            let mut diagram = Diagram::with_tall(named(now(&there)), at_first);
            for step in steps {
                let (mut removed, mut added) = (Vec::new(), Vec::new());
                let turned: std::collections::BTreeSet<usize> = step.iter().map(|index| index.index(all.len())).collect();
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
