//! The widest gaps of a persistence diagram, and the subdiagrams that they select: DS_k, ds_k, VS_{k,l}, vs_{k,l}.
//!
//! In: the dots of a [`Skeleton`].
//! Out: ranked gaps and [`Selection`]s.
//! Invariants: values within 1e-12 of the largest finite death (without one, of the largest birth) count as one; so do
//! widths. Of equal widths, the lower (or left) gap is the wider. A rank beyond the number of gaps means the last gap.
//! Dots that never die are above a diagonal gap of infinite width, which is the widest.
//! Must not know: edges, views.
//!
//! V. Kurlin 2015, Definitions 10 and 12 (with ds_k the upper side of the gap), margins of Propositions 11 and 13.

use std::borrow::Cow;
use std::num::NonZeroU32;

use super::hopes::{Dot, Skeleton};

/// Share of the largest finite death below which two values, or two widths, are equal.
pub const TOLERANCE: f64 = 1e-12;

/// An empty strip of the diagram between two neighbouring values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Its lower (or left) side.
    pub low: f64,
    /// Its upper (or right) side; +infinity for the strip right of all births, and below dots that never die.
    pub high: f64,
}

impl Gap {
    /// Its width.
    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

/// What the k-th diagonal and the l-th vertical gap select.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// The k widest diagonal gaps, the widest first (all of them, if there are fewer).
    pub diagonal: Vec<Gap>,
    /// The l widest vertical gaps of DS_k, the widest first (all of them, if there are fewer).
    pub vertical: Vec<Gap>,
    /// ds_k: the smallest persistence in DS_k; +infinity if these dots never die. None without dots.
    pub ds: Option<f64>,
    /// vs_{k,l}: +infinity without dots.
    pub vs: f64,
    /// The size of DS_k, which is a prefix of the dots.
    pub ds_count: usize,
    /// The places of VS_{k,l} among the dots, in order.
    pub vs_dots: Vec<u32>,
    /// How much noise the choice withstands.
    pub margins: Margins,
}

/// The noise (a bound on the perturbation of every point) that leaves a selection unchanged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// (|dgap_k| - |dgap_{k+1}|) / 8, Proposition 11; a gap that is not there has width 0. +infinity for the gap below
    /// dots that never die. None without dots.
    pub diagonal: Option<f64>,
    /// (|vgap_{k,l}| - |vgap_{k,l+1}|) / 4, Proposition 13; +infinity for l = 1. None without dots.
    pub vertical: Option<f64>,
}

/// All diagonal gaps of a diagram, the widest first.
pub fn diagonal_gaps(skeleton: &Skeleton) -> Vec<Gap> {
    ranked(sorted_strips(skeleton), usize::MAX, tolerance(skeleton))
}

/// All vertical gaps of DS_k, the widest first. The first is the strip right of all births.
pub fn vertical_gaps(skeleton: &Skeleton, k: NonZeroU32) -> Vec<Gap> {
    let (_, dots) = subdiagram(skeleton, k);
    ranked(vertical_strips(dots.iter().map(|dot| dot.birth), tolerance(skeleton)), usize::MAX, tolerance(skeleton))
}

/// Selects by the k widest diagonal gaps and the l widest vertical ones.
pub fn select(skeleton: &Skeleton, k: NonZeroU32, l: NonZeroU32) -> Selection {
    select_dots(skeleton, k, l).0
}

/// The same, with DS_k.
pub fn select_dots(skeleton: &Skeleton, k: NonZeroU32, l: NonZeroU32) -> (Selection, Cow<'_, [Dot]>) {
    let (diagonal, dots) = subdiagram(skeleton, k);
    let births = dots.iter().map(|dot| dot.birth);
    (selection_of(diagonal, births, k, l, tolerance(skeleton)), dots)
}

/// The same from the k + 1 widest diagonal gaps and the births of the dots in DS_k, in order.
pub fn selection_of(
    mut diagonal: Vec<Gap>,
    births: impl ExactSizeIterator<Item = f64> + Clone,
    k: NonZeroU32,
    l: NonZeroU32,
    tolerance: f64,
) -> Selection {
    let mut vertical = ranked(vertical_strips(births.clone(), tolerance), l.get() as usize + 1, tolerance);
    let margins = Margins { diagonal: margin(&diagonal, k, 8.0), vertical: margin(&vertical, l, 4.0) };
    diagonal.truncate(k.get() as usize);
    vertical.truncate(l.get() as usize);
    let vs = vertical.iter().map(|gap| gap.low).fold(f64::INFINITY, f64::min);
    let ds_count = births.len();
    Selection {
        ds: lowest(&diagonal).map(|gap| gap.high),
        vs,
        ds_count,
        vs_dots: births.zip(0..).filter(|&(birth, _)| birth <= vs).map(|(_, index)| index).collect(),
        margins,
        diagonal,
        vertical,
    }
}

/// The k + 1 widest diagonal gaps, and DS_k: the dots above the lowest of the first k gaps.
fn subdiagram(skeleton: &Skeleton, k: NonZeroU32) -> (Vec<Gap>, Cow<'_, [Dot]>) {
    let (k, tolerance) = (k.get() as usize, tolerance(skeleton));
    let persistences = skeleton.unsorted_dots().iter().map(Dot::persistence);
    let gaps = widest_unsorted(persistences, k + 1, tolerance)
        .unwrap_or_else(|| ranked(sorted_strips(skeleton), k + 1, tolerance));
    let ds = lowest(&gaps[..k.min(gaps.len())]).map_or(f64::INFINITY, |gap| gap.high);
    (gaps, skeleton.most_persistent(ds))
}

fn tolerance(skeleton: &Skeleton) -> f64 {
    let births = || skeleton.unsorted_dots().iter().map(|dot| dot.birth);
    let death = skeleton.largest_death();
    TOLERANCE * if death > 0.0 { death } else { births().fold(0.0, f64::max) }
}

pub fn lowest(gaps: &[Gap]) -> Option<&Gap> {
    gaps.iter().min_by(|a, b| a.low.total_cmp(&b.low))
}

fn margin(gaps: &[Gap], rank: NonZeroU32, share: f64) -> Option<f64> {
    let last = gaps.len().checked_sub(1)?;
    let chosen = (rank.get() as usize - 1).min(last);
    let next = gaps.get(chosen + 1).map_or(0.0, Gap::width);
    Some((gaps[chosen].width() - next) / share)
}

/// Strips between neighbouring persistences, from the diagonal up.
fn sorted_strips(skeleton: &Skeleton) -> impl Iterator<Item = Gap> {
    diagonal_strips(skeleton.dots().iter().rev().map(Dot::persistence), tolerance(skeleton))
}

/// Strips between ascending persistences, from the diagonal up.
pub fn diagonal_strips(ascending: impl Iterator<Item = f64>, tolerance: f64) -> impl Iterator<Item = Gap> {
    // The diagonal is the lowest line; persistences within the tolerance of 0 lie on it.
    strips_between(std::iter::once(0.0).chain(ascending), tolerance)
}

/// Strips between ascending values only.
pub fn strips_between(ascending: impl Iterator<Item = f64>, tolerance: f64) -> impl Iterator<Item = Gap> {
    let mut lines = lines(ascending, tolerance);
    let mut below = lines.next().map_or(0.0, |(_, high)| high);
    lines.map(move |(low, high)| Gap { low: std::mem::replace(&mut below, high), high: low })
}

/// The average number of persistences in a bucket.
const BUCKET: usize = 16;

/// The `count` widest diagonal gaps of unsorted persistences, where they can be found without sorting: in linear time,
/// with little memory.
///
/// The range of finite values is cut into buckets of equal width, of which only the lowest and the highest value are
/// stored. No gap inside a bucket is wider than the bucket. So if `count` gaps between buckets are wider than a bucket,
/// these are the widest. Infinite values have a bucket of their own.
fn widest_unsorted(
    values: impl ExactSizeIterator<Item = f64> + Clone,
    count: usize,
    tolerance: f64,
) -> Option<Vec<Gap>> {
    let buckets = values.len() / BUCKET + 1;
    let scale = buckets as f64 / values.clone().filter(|value| value.is_finite()).fold(0.0, f64::max);
    let mut spans = vec![(f64::INFINITY, f64::NEG_INFINITY); buckets + 1];
    for value in values {
        // Monotone even where rounded. NaN goes to the first bucket.
        let bucket = if value == f64::INFINITY { buckets } else { ((value * scale) as usize).min(buckets - 1) };
        let (low, high) = &mut spans[bucket];
        (*low, *high) = (low.min(value), high.max(value));
    }
    let ends = spans.into_iter().filter(|(low, high)| low <= high).flat_map(|(low, high)| [low, high]);
    let gaps = ranked(diagonal_strips(ends, tolerance), count, tolerance);
    let inside = (1.0 + TOLERANCE) / scale + tolerance;
    // Gaps are in order except for ties, so the last one may be wider than others by the tolerance.
    let are_between = gaps.len() == count && gaps.last().is_some_and(|gap| gap.width() - tolerance > inside);
    are_between.then_some(gaps)
}

/// Strips between neighbouring births, and the strip right of them all.
fn vertical_strips(births: impl Iterator<Item = f64>, tolerance: f64) -> Vec<Gap> {
    let mut births: Vec<f64> = births.collect();
    births.sort_unstable_by(f64::total_cmp);
    let mut gaps: Vec<Gap> = Vec::new();
    for (low, high) in lines(births.into_iter(), tolerance) {
        if let Some(left) = gaps.last_mut() {
            left.high = low;
        }
        gaps.push(Gap { low: high, high: f64::INFINITY });
    }
    gaps
}

/// Ascending values as lines: the first and the last value of every run whose steps are within the tolerance.
fn lines(values: impl Iterator<Item = f64>, tolerance: f64) -> impl Iterator<Item = (f64, f64)> {
    let mut values = values.peekable();
    std::iter::from_fn(move || {
        let low = values.next()?;
        let mut high = low;
        // Infinite values are equal, though their difference is no number.
        while let Some(next) = values.next_if(|&next| next == high || next - high <= tolerance) {
            high = next;
        }
        Some((low, high))
    })
}

/// The `count` widest gaps, the widest first; of equal widths the lower gap is the wider. `gaps` are given from low to
/// high.
pub fn ranked(gaps: impl IntoIterator<Item = Gap>, count: usize, tolerance: f64) -> Vec<Gap> {
    let mut gaps = widest(gaps.into_iter(), count, tolerance);
    gaps.sort_by(|a, b| b.width().total_cmp(&a.width()));
    let mut first = 0;
    while first < gaps.len() {
        let widest = gaps[first].width();
        let same = |gap: &&Gap| gap.width() == widest || widest - gap.width() <= tolerance;
        let last = first + gaps[first..].iter().take_while(same).count();
        gaps[first..last].sort_by(|a, b| a.low.total_cmp(&b.low));
        first = last;
    }
    gaps.truncate(count);
    gaps
}

/// The number of gaps that are buffered before narrow ones are dropped.
const BUFFERED: usize = 1024;

/// Gaps in order, without most of those that cannot be among the `count` widest. Linear time.
fn widest(gaps: impl Iterator<Item = Gap>, count: usize, tolerance: f64) -> Vec<Gap> {
    let mut kept: Vec<Gap> = Vec::new();
    let (mut limit, mut full) = (f64::NEG_INFINITY, BUFFERED.max(count.saturating_mul(2)));
    for gap in gaps {
        if gap.width() < limit {
            continue;
        }
        kept.push(gap);
        if kept.len() >= full {
            limit = keep_widest(&mut kept, count, tolerance);
            full = kept.len().saturating_mul(2).max(full);
        }
    }
    keep_widest(&mut kept, count, tolerance);
    kept
}

/// Drops gaps that cannot be among the `count` widest, in linear time. Returns the width below which no gap can be.
fn keep_widest(gaps: &mut Vec<Gap>, count: usize, tolerance: f64) -> f64 {
    if count >= gaps.len() {
        return f64::NEG_INFINITY;
    }
    let mut widths: Vec<f64> = gaps.iter().map(Gap::width).collect();
    let (_, &mut last, _) = widths.select_nth_unstable_by(count, |a, b| b.total_cmp(a));
    // Gaps as wide as the last one must stay, so that the tie can be decided. An infinite limit keeps infinite widths.
    let limit = last - 2.0 * tolerance;
    gaps.retain(|gap| gap.width() >= limit);
    limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::skeleton::{Killer, View, ViewSpec};
    use proptest::prelude::*;

    fn persistences() -> impl Strategy<Value = Vec<f64>> {
        let value =
            prop_oneof![16 => 1e-9..1e-3, 4 => 0.0..1.0, 2 => (0..9_u32).prop_map(f64::from), 1 => Just(f64::INFINITY)];
        prop::collection::vec(value, 1..300)
    }

    /// A diagram of these births and deaths, with nothing else.
    fn diagram(labels: &[[f64; 2]]) -> Skeleton {
        let vertices = crate::topology::testing::labels(labels.len() as u64 + 1);
        let dot =
            |(place, &[birth, death]): (u32, &[f64; 2])| Dot { birth, death, edge: [0, place], killer: Killer::None };
        Skeleton::with_lengths(vertices, Vec::new(), (1..).zip(labels).map(dot).collect())
    }

    fn ranks(k: u32, l: u32) -> [NonZeroU32; 2] {
        [k, l].map(|rank| NonZeroU32::new(rank).expect("ranks count from 1"))
    }

    const NEVER: f64 = f64::INFINITY;

    #[test]
    fn the_widest_gap_is_below_the_dots_that_never_die() {
        let mixed = diagram(&[[1.0, 1.5], [0.5, NEVER], [2.0, 5.0], [0.7, NEVER], [1.0, 1.25]]);
        assert_eq!(diagonal_gaps(&mixed)[0], Gap { low: 3.0, high: NEVER });
        let [k, l] = ranks(1, 1);
        let first = select(&mixed, k, l);
        assert_eq!((first.ds, first.ds_count, first.vs, &first.vs_dots[..]), (Some(NEVER), 2, 0.7, &[0, 1][..]));
        assert_eq!(first.margins, Margins { diagonal: Some(NEVER), vertical: Some(NEVER) });
        let [k, l] = ranks(2, 2);
        let second = select(&mixed, k, l);
        assert_eq!((second.ds, second.ds_count, second.vs), (Some(3.0), 3, 0.7), "the next ones");
        assert_eq!(second.margins, Margins { diagonal: Some((2.5 - 0.25) / 8.0), vertical: Some((1.3 - 0.2) / 4.0) });
        let view = View::new(&mixed, ViewSpec::Derived { k, l });
        assert_eq!((&view.critical[..], view.scale()), (&[0, 1][..], 0.7));
    }

    #[test]
    fn dots_that_never_die_alone_are_above_one_gap() {
        let all = diagram(&[[1.0, NEVER], [3.0, NEVER]]);
        assert_eq!(diagonal_gaps(&all), [Gap { low: 0.0, high: NEVER }]);
        for k in [1, 2] {
            let [k, l] = ranks(k, 2);
            let both = select(&all, k, l);
            assert_eq!((both.ds, both.ds_count, both.vs), (Some(NEVER), 2, 1.0));
            assert_eq!(both.margins, Margins { diagonal: Some(NEVER), vertical: Some(0.5) });
        }
        let nearly = diagram(&[[1.0, NEVER], [1.0 + 1e-13, NEVER]]);
        let births = vertical_gaps(&nearly, NonZeroU32::MIN);
        assert_eq!(births, [Gap { low: 1.0 + 1e-13, high: NEVER }], "births within 1e-12 of the largest are one");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn widest_unsorted_equals_widest_sorted(mut values in persistences(), count in 1..8_usize) {
            let finite = values.iter().copied().filter(|value| value.is_finite());
            let tolerance = TOLERANCE * finite.fold(0.0, f64::max);
            let at_sight = widest_unsorted(values.iter().copied(), count, tolerance);
            values.sort_unstable_by(f64::total_cmp);
            let sorted = ranked(diagonal_strips(values.into_iter(), tolerance), count, tolerance);
            prop_assert!(sorted.iter().all(|gap| gap.width() > tolerance));
            if let Some(gaps) = at_sight {
                prop_assert_eq!(gaps, sorted);
            }
        }

        #[test]
        fn the_first_gap_selects_what_never_dies(
            mut labels in prop::collection::vec((0.1..1.0, 0.1..1.0).prop_map(|(birth, more)| [birth, birth + more]), 0..40),
            never in prop::collection::vec(0.1..1.0, 1..5),
        ) {
            let finite = select(&diagram(&labels), ranks(1, 1)[0], ranks(1, 1)[1]);
            labels.extend(never.iter().map(|&birth| [birth, NEVER]));
            let all = diagram(&labels);
            let of_rank = |k| select(&all, ranks(k, 1)[0], ranks(k, 1)[1]);
            let first = of_rank(1);
            prop_assert_eq!((first.ds, first.ds_count), (Some(NEVER), never.len()));
            prop_assert!(!first.vs.is_nan() && first.margins.diagonal == Some(NEVER));
            if labels.len() > never.len() {
                let second = of_rank(2);
                prop_assert_eq!((second.ds, second.ds_count), (finite.ds, finite.ds_count + never.len()));
                prop_assert!(second.margins.diagonal.is_some_and(f64::is_finite));
            }
        }
    }

    #[test]
    fn clear_gaps_are_found_without_sorting() {
        let noise = (0..1000).map(|step| f64::from(step) * 1e-5);
        let values: Vec<f64> = noise.chain([0.5, 1.0, 1.75]).collect();
        let highs = |gaps: Vec<Gap>| gaps.iter().map(|gap| gap.high).collect::<Vec<_>>();
        let gaps = widest_unsorted(values.iter().copied(), 3, 1e-12).expect("they are clear");
        assert_eq!(highs(gaps), [1.75, 1.0, 0.5]);
        assert_eq!(widest_unsorted(values.iter().copied(), 4, 1e-12), None);
        assert_eq!(widest_unsorted([].into_iter(), 1, 0.0), None);
        let never = values.iter().copied().chain([NEVER; 3]);
        let gaps = widest_unsorted(never.collect::<Vec<_>>().into_iter(), 4, 1e-12).expect("they are clear");
        assert_eq!(highs(gaps), [NEVER, 1.75, 1.0, 0.5]);
    }
}
