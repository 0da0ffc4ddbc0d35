//! Small clouds against the literal definitions: alpha persistence, the minimum spanning tree, reduced skeletons with
//! their components and cycles, death triangles.

mod common;

use common::by_position::{ByPosition, DotAt};
use common::clouds::{Placement, Point, cases, clouds_on};
use common::naive::{Components, Naive, half_length, pairs, scalar_product};
use common::skeleton_of;
use hopes::topology::{Skeleton, View, ViewSpec};
use proptest::prelude::*;
use proptest::sample::Index;

/// Kinds of places in which lengths either tie exactly or differ by more than rounding.
const PLACEMENTS: [Placement; 8] = [
    Placement::Uniform,
    Placement::Lattice,
    Placement::Circles(5),
    Placement::Circles(25),
    Placement::Oblique,
    Placement::Horizontal,
    Placement::FarLattice,
    Placement::Tiny,
];

/// A small cloud, sometimes on very few positions, so that whole squares of a lattice occur.
fn small_clouds() -> impl Strategy<Value = Vec<Point>> {
    let crowded = prop::collection::vec([0..4_i32, 0..4_i32].prop_map(|p| p.map(f64::from)), 0..13);
    prop_oneof![3 => clouds_on(&PLACEMENTS, 0..13), 2 => crowded]
}

fn close(ours: f64, theirs: f64) -> bool {
    (ours - theirs).abs() <= 1e-9 * theirs
}

/// The triangle contains the centre of an empty circle, and is the one of the fan around the circle's smallest point.
fn assert_names_its_hole(naive: &Naive, dot: &DotAt) {
    let [a, b, c] = dot.triangle;
    let circle = naive.circles.iter().find(|circle| dot.triangle.iter().all(|p| circle.on.contains(p)));
    let circle = circle.unwrap_or_else(|| panic!("{dot:?}: there is a point inside"));
    assert!(close(dot.death, circle.radius), "{dot:?}: dies at the circumradius {}", circle.radius);
    let is_obtuse =
        [(a, [b, c]), (b, [a, c]), (c, [a, b])].into_iter().any(|(apex, side)| scalar_product(apex, side) < 0.0);
    assert!(!is_obtuse, "{dot:?}: holds its circumcentre");
    assert_eq!(a, circle.on[0], "{dot:?}: the fan is around the smallest point of {:?}", circle.on);
    let distance = ((dot.center[0] - a[0]).powi(2) + (dot.center[1] - a[1]).powi(2)).sqrt();
    let rounding = 1e-15 * dot.center[0].abs().max(dot.center[1].abs());
    assert!((distance - dot.death).abs() <= 1e-9 * dot.death + rounding, "{dot:?}: the hole's centre");
}

/// Components and cycles of a view, counted on its own edges.
fn counted(skeleton: &Skeleton, view: &View) -> (usize, usize) {
    let at = |v: u32| skeleton.vertices().xy(v);
    let points: Vec<Point> = (0..skeleton.vertices().len() as u32).map(at).collect();
    let edges: Vec<[Point; 2]> =
        view.tree.iter().copied().chain(view.critical_edges(skeleton)).map(|edge| edge.map(at)).collect();
    let mut components = Components::new(&points);
    let cycles = edges.iter().filter(|&&[a, b]| !components.join(a, b)).count();
    (components.count(), cycles)
}

/// Components of a union of discs: two discs of radius alpha meet if their centres are at most 2 alpha apart.
fn components_of_discs(points: &[Point], alpha: f64) -> usize {
    let mut components = Components::new(points);
    for [a, b] in pairs(points).into_iter().filter(|&pair| half_length(pair) <= alpha * (1.0 + 1e-12)) {
        components.join(a, b);
    }
    components.count()
}

proptest! {
    #![proptest_config(cases(4000))]

    #[test]
    fn the_tree_and_the_dots_are_those_of_the_definition(cloud in small_clouds()) {
        let naive = Naive::new(&cloud);
        let ours = ByPosition::of(&skeleton_of(&cloud));
        prop_assert_eq!(&ours.vertices, &naive.points);
        prop_assert_eq!(&ours.tree, &naive.tree);
        let mut dots = ours.dots;
        dots.retain(|dot| dot.death - dot.birth > 1e-9 * dot.death);
        dots.sort_by(|a, b| a.edge.partial_cmp(&b.edge).expect("no NaN"));
        let [critical, want]: [Vec<[Point; 2]>; 2] =
            [dots.iter().map(|dot| dot.edge).collect(), naive.dots.iter().map(|dot| dot.edge).collect()];
        prop_assert_eq!(critical, want, "critical edges");
        for (our, their) in dots.iter().zip(&naive.dots) {
            prop_assert!(close(our.birth, their.birth) && close(our.death, their.death), "{:?}: {:?}", our, their);
            assert_names_its_hole(&naive, our);
        }
    }

    /// HoPeS(C; alpha): edges, components and cycles, at scales between the dots' own and exactly at them.
    #[test]
    fn reduced_skeletons_are_those_of_the_definition(cloud in small_clouds(), at in any::<Index>(), share in 0.0..1.5) {
        let skeleton = skeleton_of(&cloud);
        let mut scales = vec![0.0, share * skeleton.largest_death()];
        scales.extend(skeleton.dots().iter().flat_map(|dot| [dot.birth, dot.death]));
        scales.extend(skeleton.tree().iter().map(|&edge| skeleton.half_length(edge)));
        let alpha = *at.get(&scales);
        let view = View::new(&skeleton, ViewSpec::Reduced { alpha });

        let short = |&edge: &[u32; 2]| skeleton.length(edge) <= 2.0 * alpha * (1.0 + 1e-12);
        prop_assert_eq!(&view.tree, &skeleton.tree().iter().copied().filter(short).collect::<Vec<_>>());
        let lives = |&index: &u32| {
            let dot = skeleton.dots()[index as usize];
            short(&dot.edge) && dot.death > alpha
        };
        prop_assert_eq!(&view.critical, &(0..skeleton.dots().len() as u32).filter(lives).collect::<Vec<_>>());

        prop_assert_eq!((view.components, view.cycles), counted(&skeleton, &view));
        let points: Vec<Point> = skeleton.vertices().positions().collect();
        prop_assert_eq!(view.components, components_of_discs(&points, alpha), "components of the discs");
    }

    #[test]
    fn components_and_cycles_of_derived_views_are_counted_right(cloud in small_clouds(), k in 1..5_u32, l in 1..5_u32) {
        let skeleton = skeleton_of(&cloud);
        let rank = |rank| std::num::NonZeroU32::new(rank).expect("ranks start from 1");
        for spec in [ViewSpec::Full, ViewSpec::Derived { k: rank(k), l: rank(l) }] {
            let view = View::new(&skeleton, spec);
            prop_assert_eq!((view.components, view.cycles), counted(&skeleton, &view));
        }
    }
}

/// A square lattice: one dot for each square, all with the same birth and death. The tree is a comb.
#[test]
fn a_lattice_has_one_dot_for_each_square() {
    let side = 5;
    let lattice: Vec<Point> = (0..side * side).map(|i| [f64::from(i / side), f64::from(i % side)]).collect();
    let skeleton = skeleton_of(&lattice);
    assert_eq!(skeleton.dots().len(), 16);
    assert!(skeleton.dots().iter().all(|dot| (dot.birth, dot.death) == (0.5, 0.5_f64.sqrt())));
    assert_eq!(Naive::new(&lattice[..12]).dots.len(), 5, "the reference sees the five squares of its twelve points");
}
