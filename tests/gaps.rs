//! Gaps, DS_k and VS_{k,l} against their definitions, on diagrams with many equal values and equal widths.
//!
//! A diagram is made of rectangles far apart: a rectangle with sides w <= h has the one dot (h / 2, diagonal / 2).

mod common;

use std::num::NonZeroU32;

use common::clouds::{Placement, Point, cases, clouds};
use common::skeleton_of;
use hopes::topology::{Dot, Gap, Skeleton, View, ViewSpec, diagonal_gaps, select, vertical_gaps};
use proptest::prelude::*;
use proptest::sample::select as one_of;

/// A distance at which dots between rectangles are on the diagonal, and coordinates are still exact.
const APART: f64 = 1e8;

/// Values, and widths, are equal within this share of the largest death.
const TOLERANCE: f64 = 1e-12;

fn rank(rank: u32) -> NonZeroU32 {
    NonZeroU32::new(rank).expect("ranks start from 1")
}

fn rectangles(sides: &[[f64; 2]]) -> Vec<Point> {
    let corners = |(place, &[w, h]): (usize, &[f64; 2])| {
        let x = place as f64 * APART;
        [[x, 0.0], [x + w, 0.0], [x, h], [x + w, h]]
    };
    sides.iter().enumerate().flat_map(corners).collect()
}

/// Sides with an integer diagonal. Births and persistences are multiples of a half, so many widths are equal.
const PYTHAGOREAN: [[f64; 2]; 10] = [
    [3.0, 4.0],
    [6.0, 8.0],
    [9.0, 12.0],
    [5.0, 12.0],
    [8.0, 15.0],
    [12.0, 16.0],
    [15.0, 20.0],
    [20.0, 21.0],
    [7.0, 24.0],
    [12.0, 35.0],
];

/// Rectangles that tie exactly, nearly (well inside the tolerance) or not at all. Some have a persistence close to 0.
fn diagrams() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let close = one_of(vec![1.0, 1.0, 1.0 + 2e-15, 1.0 - 3e-15]);
    let pythagorean = (one_of(&PYTHAGOREAN[..]), close).prop_map(|([w, h], times)| [w, h * times]);
    let any = [1..16_i32, 1..16_i32].prop_map(|[w, h]| [f64::from(w), f64::from(h)]);
    // Widths along x are exact, heights may be tiny. The persistence is h^2 / 4, the tolerance at least 1e-12.
    let flat = (3..60_i32).prop_map(|millionths| [1.0, f64::from(millionths) * 1e-6]);
    prop::collection::vec(prop_oneof![5 => pythagorean, 3 => any, 1 => flat], 0..12)
}

/// Values in ascending order as lines of the diagram: the lowest and the highest of values that count as equal.
fn lines(mut values: Vec<f64>, tolerance: f64) -> Vec<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let mut lines: Vec<[f64; 2]> = Vec::new();
    for value in values {
        match lines.last_mut() {
            Some([_, high]) if value - *high <= tolerance => *high = value,
            _ => lines.push([value, value]),
        }
    }
    lines
}

/// The definition, step by step: the next gap is the lowest of the widest gaps that are left.
fn ranked(mut gaps: Vec<Gap>, tolerance: f64) -> Vec<Gap> {
    let mut ranked = Vec::new();
    while !gaps.is_empty() {
        let widest = gaps.iter().map(Gap::width).fold(0.0, f64::max);
        let is_widest = |gap: &Gap| gap.width() == widest || widest - gap.width() <= tolerance;
        let lowest = gaps.iter().position(is_widest).expect("one of them is the widest");
        ranked.push(gaps.remove(lowest));
    }
    ranked
}

/// Whether widths are either equal or clearly different. Equality within a tolerance is not transitive, so the order in
/// a chain of close widths is not defined.
fn are_clear(gaps: &[Gap], tolerance: f64) -> bool {
    let mut widths: Vec<f64> = gaps.iter().map(Gap::width).collect();
    widths.sort_by(f64::total_cmp);
    widths.windows(2).map(|w| w[1] - w[0]).all(|step| !(0.05 * tolerance..=1.5 * tolerance).contains(&step))
}

/// Gaps and their selection by the definitions.
struct ByDefinition {
    tolerance: f64,
    diagonal: Vec<Gap>,
    vertical: Vec<Gap>,
    ds: Option<f64>,
    vs: f64,
    /// Indices of dots.
    ds_dots: Vec<usize>,
    vs_dots: Vec<usize>,
}

fn by_definition(dots: &[Dot], k: usize, l: usize) -> ByDefinition {
    let tolerance = TOLERANCE * dots.iter().map(|dot| dot.death).fold(0.0, f64::max);
    // The diagonal counts as the lowest value.
    let persistences = lines([0.0].into_iter().chain(dots.iter().map(Dot::persistence)).collect(), tolerance);
    let strips = |lines: &[[f64; 2]]| lines.windows(2).map(|w| Gap { low: w[0][1], high: w[1][0] }).collect::<Vec<_>>();
    let diagonal = ranked(strips(&persistences), tolerance);
    let lowest = diagonal.iter().take(k).min_by(|a, b| a.low.total_cmp(&b.low));
    let ds = lowest.map(|gap| gap.high);
    let ds_dots: Vec<usize> = (0..dots.len()).filter(|&i| ds.is_some_and(|ds| dots[i].persistence() >= ds)).collect();

    let births = lines(ds_dots.iter().map(|&i| dots[i].birth).collect(), tolerance);
    let mut vertical = strips(&births);
    vertical.extend(births.last().map(|&[_, high]| Gap { low: high, high: f64::INFINITY }));
    let vertical = ranked(vertical, tolerance);
    let vs = vertical.iter().take(l).map(|gap| gap.low).fold(f64::INFINITY, f64::min);
    let vs_dots = ds_dots.iter().copied().filter(|&i| dots[i].birth <= vs).collect();
    ByDefinition { tolerance, diagonal, vertical, ds, vs, ds_dots, vs_dots }
}

/// (|gap_rank| - |gap_{rank + 1}|) / share. A missing gap has no width. A rank that is too large means the last gap.
fn margin(gaps: &[Gap], rank: usize, share: f64) -> Option<f64> {
    let rank = rank.min(gaps.len());
    let chosen = gaps.get(rank.checked_sub(1)?)?.width();
    Some((chosen - gaps.get(rank).map_or(0.0, Gap::width)) / share)
}

/// Returns whether the definition applies.
fn check_by_definition(skeleton: &Skeleton, k: u32, l: u32) -> bool {
    let want = by_definition(skeleton.dots(), k as usize, l as usize);
    if !are_clear(&want.diagonal, want.tolerance) || !are_clear(&want.vertical, want.tolerance) {
        return false;
    }
    assert_eq!(diagonal_gaps(skeleton), want.diagonal);
    assert_eq!(vertical_gaps(skeleton, rank(k)), want.vertical);

    let ours = select(skeleton, rank(k), rank(l));
    let first = |gaps: &[Gap], count: u32| gaps[..gaps.len().min(count as usize)].to_vec();
    assert_eq!(ours.diagonal, first(&want.diagonal, k));
    assert_eq!(ours.vertical, first(&want.vertical, l));
    assert_eq!((ours.ds, ours.vs), (want.ds, want.vs));
    assert_eq!((0..ours.ds_count).collect::<Vec<_>>(), want.ds_dots, "DS is a prefix of the dots");
    assert_eq!(ours.vs_dots.iter().map(|&i| i as usize).collect::<Vec<_>>(), want.vs_dots);
    assert_eq!(ours.margins.diagonal, margin(&want.diagonal, k as usize, 8.0));
    assert_eq!(ours.margins.vertical, margin(&want.vertical, l as usize, 4.0));
    assert_derived_view(skeleton, k, l, &want);
    true
}

/// HoPeS_{k,l}: tree edges not longer than 2 vs, and those dots of VS that are alive beyond it.
fn assert_derived_view(skeleton: &Skeleton, k: u32, l: u32, want: &ByDefinition) {
    let view = View::new(skeleton, ViewSpec::Derived { k: rank(k), l: rank(l) });
    let short = |&edge: &[u32; 2]| skeleton.length(edge) <= 2.0 * want.vs * (1.0 + TOLERANCE);
    assert_eq!(view.tree, skeleton.tree().iter().copied().filter(short).collect::<Vec<_>>());
    let alive = want.vs_dots.iter().copied().filter(|&i| skeleton.dots()[i].death > want.vs);
    assert_eq!(view.critical, alive.map(|i| i as u32).collect::<Vec<_>>());
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn gaps_follow_their_definitions(sides in diagrams(), k in 1..14_u32, l in 1..14_u32) {
        let skeleton = skeleton_of(&rectangles(&sides));
        prop_assert_eq!(skeleton.dots().len(), sides.len(), "a dot for every rectangle");
        prop_assume!(check_by_definition(&skeleton, k, l));
    }
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn gaps_of_any_cloud_follow_their_definitions(cloud in clouds(0..150), k in 1..40_u32, l in 1..40_u32) {
        prop_assume!(check_by_definition(&skeleton_of(&cloud), k, l));
    }
}

fn diagram(sides: &[[f64; 2]]) -> Skeleton {
    skeleton_of(&rectangles(sides))
}

#[test]
fn without_dots_nothing_is_selected() {
    let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
    for (cloud, edges) in [(&line[..0], 0), (&line[..1], 0), (&line[..2], 1), (&line[..], 2)] {
        let skeleton = skeleton_of(cloud);
        let selection = select(&skeleton, rank(1), rank(1));
        assert_eq!((selection.ds, selection.vs), (None, f64::INFINITY));
        assert_eq!((selection.margins.diagonal, selection.margins.vertical), (None, None));
        let view = View::new(&skeleton, ViewSpec::Derived { k: rank(3), l: rank(2) });
        assert_eq!((view.tree.len(), view.cycles), (edges, 0), "the whole tree");
        assert!(check_by_definition(&skeleton, 1, 1));
    }
}

/// Persistences 1/2, 1, 3/2: three gaps of equal width. The lower one is preferred.
#[test]
fn of_equal_diagonal_gaps_the_lowest_comes_first() {
    let skeleton = diagram(&[[9.0, 12.0], [3.0, 4.0], [6.0, 8.0]]);
    let ds = |k| select(&skeleton, rank(k), rank(1)).ds;
    assert_eq!([ds(1), ds(2), ds(3), ds(4)], [Some(0.5); 4]);
    assert_eq!(diagonal_gaps(&skeleton).iter().map(|gap| gap.low).collect::<Vec<_>>(), [0.0, 0.5, 1.0]);
    assert_eq!(select(&skeleton, rank(1), rank(1)).margins.diagonal, Some(0.0));
}

/// Births 2, 4, 6: the unbounded strip is first, then the leftmost of the equal strips.
#[test]
fn of_equal_vertical_gaps_the_leftmost_comes_first() {
    let skeleton = diagram(&[[9.0, 12.0], [3.0, 4.0], [6.0, 8.0]]);
    let vs = |l| select(&skeleton, rank(1), rank(l)).vs;
    assert_eq!([vs(1), vs(2), vs(3), vs(4)], [6.0, 2.0, 2.0, 2.0]);
    assert_eq!(vertical_gaps(&skeleton, rank(1)).iter().map(|gap| gap.low).collect::<Vec<_>>(), [6.0, 2.0, 4.0]);
    assert_eq!(select(&skeleton, rank(1), rank(1)).margins.vertical, Some(f64::INFINITY));
}

/// Values within 1e-12 of the largest death are on one line. If they are that close to 0, it is the diagonal.
#[test]
fn a_persistence_within_the_tolerance_of_zero_is_on_the_diagonals_line() {
    let skeleton = diagram(&[[20.0, 21.0], [1.0, 6e-6]]);
    let [large, tiny] = skeleton.dots() else { panic!("two dots") };
    assert!(tiny.persistence() > 1e-12 * tiny.death, "it is a dot");
    assert!(tiny.persistence() < 1e-12 * large.death, "on the line of the diagonal");
    assert_eq!(diagonal_gaps(&skeleton), [Gap { low: tiny.persistence(), high: large.persistence() }]);
    assert_eq!(select(&skeleton, rank(2), rank(1)).ds_count, 1);
}

#[test]
fn ranks_beyond_the_gaps_mean_the_last() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let cloud = Placement::Uniform.points(100).new_tree(&mut runner).expect("a cloud").current();
    let skeleton = skeleton_of(&cloud);
    let gaps = diagonal_gaps(&skeleton).len() as u32;
    let all = select(&skeleton, rank(gaps), rank(1));
    assert_eq!(select(&skeleton, rank(gaps + 1), rank(1)), all);
    assert_eq!(select(&skeleton, rank(u32::MAX), rank(1)), all);
    assert_eq!(all.ds_count, skeleton.dots().len(), "all dots are above the lowest of all gaps");
    let strips = vertical_gaps(&skeleton, rank(gaps)).len() as u32;
    let last = select(&skeleton, rank(gaps), rank(strips));
    assert_eq!(select(&skeleton, rank(gaps), rank(u32::MAX)), last);
    assert!(last.vs < all.vs);
}
