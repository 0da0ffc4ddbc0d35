//! Every cloud of `tests/cases` against its exact answer (see `tests/cases/README.md`): dots, tree length, and for
//! every (k, l) the gaps, edges, cycles and components.

mod common;

use std::num::NonZeroU32;

use common::{Answer, Case, cases, skeleton_of};
use hopes::topology::{Skeleton, View, ViewSpec};

/// The tolerance for births and deaths, relative to the largest death.
const CLOSE: f64 = 1e-9;

/// Rounded coordinates: ties differ by an ulp. Dots and trees are compared, skeletons are not.
const ROUNDED_TIES: [&str; 3] = ["lattice_20x20_step0.1", "lattice_tri_sqrt3", "regular_60gon_float"];

#[test]
fn all_cases_are_there() {
    assert_eq!(cases().count(), 51);
}

#[test]
fn dots_are_exact() {
    for case in cases() {
        let skeleton = skeleton_of(&case.points);
        let ours = skeleton.dots().iter().map(|dot| [dot.birth, dot.death]).collect();
        let theirs = case.answer.dots.iter().chain(&case.answer.near_dots).copied().collect();
        assert_same_dots(&case, ours, theirs);
    }
}

fn assert_same_dots(case: &Case, mut ours: Vec<[f64; 2]>, mut theirs: Vec<[f64; 2]>) {
    let largest = theirs.iter().map(|dot| dot[1]).fold(0.0, f64::max);
    // Births that differ only by rounding count as one value. Among them the deaths decide the order.
    theirs.retain(|dot| dot[1] - dot[0] > 1e-12 * dot[1]);
    for dots in [&mut ours, &mut theirs] {
        dots.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut first = 0;
        while first < dots.len() {
            let run = dots[first..].windows(2).take_while(|w| w[1][0] - w[0][0] <= CLOSE * largest).count() + 1;
            dots[first..first + run].sort_by(|a, b| a[1].total_cmp(&b[1]));
            first += run;
        }
    }
    assert_eq!(ours.len(), theirs.len(), "{}: number of dots", case.name);
    for (our, their) in ours.iter().zip(&theirs) {
        for side in 0..2 {
            let close = (our[side] - their[side]).abs() <= CLOSE * their[side];
            assert!(close, "{}: {our:?} should be {their:?}", case.name);
        }
    }
}

#[test]
fn trees_have_the_exact_length() {
    for case in cases() {
        let skeleton = skeleton_of(&case.points);
        let want = case.answer.mst_length;
        assert_eq!(skeleton.vertices().len(), case.answer.n_distinct, "{}", case.name);
        assert_eq!(skeleton.tree().len(), case.answer.n_distinct.saturating_sub(1), "{}", case.name);
        assert!((skeleton.tree_length() - want).abs() <= CLOSE * want, "{}", case.name);
        let longest = skeleton.tree().iter().map(|&edge| skeleton.length(edge)).fold(0.0, f64::max);
        assert!((longest - case.answer.mst_longest).abs() <= CLOSE * longest, "{}", case.name);
    }
}

#[test]
fn derived_skeletons_are_exact() {
    for case in cases().filter(|case| !ROUNDED_TIES.contains(&case.name.as_str())) {
        let skeleton = skeleton_of(&case.points);
        for (ranks, want) in &case.answer.skeletons {
            let (k, l) = ranks.split_once(',').unwrap();
            let [k, l] = [k, l].map(|rank| rank.parse::<NonZeroU32>().unwrap());
            let view = View::new(&skeleton, ViewSpec::Derived { k, l });
            assert_view(&format!("{} at {ranks}", case.name), &case.answer, &skeleton, &view, want);
        }
    }
}

fn assert_view(what: &str, answer: &Answer, skeleton: &Skeleton, view: &View, want: &common::DerivedAnswer) {
    let largest = answer.dots.iter().map(|dot| dot[1]).fold(0.0, f64::max);
    let selection = view.selection.as_ref().expect("a derived view says what its gaps selected");
    let close = |a: f64, b: f64| (a - b).abs() <= CLOSE * largest;
    match want.ds {
        Some(ds) => assert!(close(selection.ds.unwrap(), ds), "{what}: ds {:?} {ds}", selection.ds),
        None => assert_eq!(selection.ds, None, "{what}"),
    }
    match want.vs.as_f64() {
        Some(vs) => assert!(close(selection.vs, vs), "{what}: vs {} {vs}", selection.vs),
        None => assert_eq!(selection.vs, f64::INFINITY, "{what}"),
    }
    let counts = (selection.ds_count, selection.vs_dots.len(), view.tree.len(), view.critical.len());
    assert_eq!(counts, (want.n_ds, want.n_vs, want.mst_kept, want.critical), "{what}: DS, VS, tree, critical");
    assert_eq!((view.cycles, view.components), (want.h1, want.components), "{what}: cycles, components");
    assert_eq!(view.tree.len() + view.critical.len(), want.edges, "{what}: edges");
    let length: f64 = view.tree.iter().copied().chain(view.critical_edges(skeleton)).map(|e| skeleton.length(e)).sum();
    assert!((length - want.length).abs() <= CLOSE * want.length, "{what}: length");
}

/// Critical edges are unique if no two edges and no two triangles tie.
#[test]
fn critical_edges_are_exact_without_ties() {
    let tie_free =
        ["A_n300_e0.08", "B_n400_e0.08", "P_n300_e0.12", "circle_n500_e0.15", "theta_n500_e0.1", "uniform_5000"];
    for case in cases().filter(|case| tie_free.contains(&case.name.as_str())) {
        let skeleton = skeleton_of(&case.points);
        let mut ours: Vec<[u32; 2]> =
            skeleton.dots().iter().filter(|dot| dot.persistence() > 1e-9 * dot.death).map(|dot| dot.edge).collect();
        let ends = |edge: &(u32, u32, f64, f64)| [edge.0.min(edge.1), edge.0.max(edge.1)];
        let mut theirs: Vec<[u32; 2]> = case.answer.critical_edges.iter().map(ends).collect();
        ours.sort_unstable();
        theirs.sort_unstable();
        assert_eq!(ours, theirs, "{}", case.name);
    }
}
