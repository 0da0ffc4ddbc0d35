//! What must not change a skeleton: the order of arrival, and (Proposition 8) isometries and scalings of the plane.

mod common;

use common::by_position::{ByPosition, in_order};
use common::clouds::{Placement, Point, cases, clouds, clouds_on, distinct, shuffled};
use common::skeleton_of;
use hopes::topology::Skeleton;
use proptest::prelude::*;

fn by_position(points: &[Point]) -> ByPosition {
    ByPosition::of(&skeleton_of(points))
}

proptest! {
    #![proptest_config(cases(400))]

    /// Ties included. Only ids may differ.
    #[test]
    fn the_order_of_arrival_does_not_matter((cloud, again) in shuffled(clouds(0..150))) {
        by_position(&again).assert_same(&by_position(&cloud));
    }

    #[test]
    fn duplicates_do_not_matter(cloud in clouds(0..80)) {
        let doubled = [cloud.clone(), cloud.clone()].concat();
        by_position(&doubled).assert_same(&by_position(&distinct(&cloud)));
    }
}

/// A map of the plane.
type Map = fn(Point) -> Point;

/// Isometries that are exact in doubles.
const EXACT: [(&str, Map); 7] = [
    ("reflection in the y axis", |[x, y]| [-x, y]),
    ("reflection in the x axis", |[x, y]| [x, -y]),
    ("exchange of the axes", |[x, y]| [y, x]),
    ("exchange with both reversed", |[x, y]| [-y, -x]),
    ("a quarter turn", |[x, y]| [-y, x]),
    ("half a turn", |[x, y]| [-x, -y]),
    ("three quarters of a turn", |[x, y]| [y, -x]),
];

/// Births and deaths, sorted by birth.
fn dots(skeleton: &Skeleton) -> Vec<[f64; 2]> {
    in_order(skeleton.dots().iter().map(|dot| [dot.birth, dot.death]).collect())
}

fn births(skeleton: &Skeleton) -> Vec<f64> {
    dots(skeleton).iter().map(|[birth, _]| *birth).collect()
}

fn moved(points: &[Point], motion: impl Fn(Point) -> Point) -> Vec<Point> {
    points.iter().copied().map(motion).collect()
}

/// Edges by the moved positions of their ends, both tree edges and critical edges.
fn moved_edges(skeleton: &ByPosition, motion: impl Fn(Point) -> Point) -> [Vec<[Point; 2]>; 2] {
    let moved = |edge: [Point; 2]| in_order(edge.map(|p| motion(p).map(|v| v + 0.0)));
    let tree = skeleton.tree.iter().map(|&edge| moved(edge)).collect();
    let critical = skeleton.dots.iter().map(|dot| moved(dot.edge)).collect();
    [in_order(tree), in_order(critical)]
}

fn assert_close(ours: &[[f64; 2]], theirs: &[[f64; 2]], tolerance: f64, what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}: number of dots");
    for (our, their) in ours.iter().zip(theirs) {
        let close = (0..2).all(|side| (our[side] - their[side]).abs() <= tolerance * their[1]);
        assert!(close, "{what}: {our:?} should be {their:?}");
    }
}

fn assert_same_length(ours: &Skeleton, theirs: &Skeleton, tolerance: f64, what: &str) {
    let (our, their) = (ours.tree_length(), theirs.tree_length());
    assert!((our - their).abs() <= tolerance * their, "{what}: tree length {our} should be {their}");
}

proptest! {
    #![proptest_config(cases(200))]

    /// Lengths are exact to the last bit. A circumradius is computed from the first of its corners, so it has the
    /// promised precision only.
    #[test]
    fn exact_isometries_keep_dots_and_edges(cloud in clouds_on(&Placement::TIE_FREE, 0..120)) {
        let still = skeleton_of(&cloud);
        for (what, motion) in EXACT {
            let image = skeleton_of(&moved(&cloud, motion));
            prop_assert_eq!(births(&image), births(&still), "{}", what);
            assert_close(&dots(&image), &dots(&still), 1e-12, what);
            assert_same_length(&image, &still, 1e-15, what);
            let want = moved_edges(&ByPosition::of(&still), motion);
            prop_assert_eq!(moved_edges(&ByPosition::of(&image), |p| p), want, "{}", what);
        }
    }

    /// With ties another tree of the same length may be first in the order. A radius is right except for its last bits.
    #[test]
    fn exact_isometries_keep_dots_under_ties(cloud in clouds_on(&Placement::INTEGERS, 0..120)) {
        let still = skeleton_of(&cloud);
        for (what, motion) in EXACT {
            let image = skeleton_of(&moved(&cloud, motion));
            assert_close(&dots(&image), &dots(&still), 1e-12, what);
            assert_same_length(&image, &still, 1e-14, what);
        }
    }

    /// Differences of coordinates and the order of positions do not change, so nothing may change.
    #[test]
    fn exact_translations_change_nothing(
        cloud in clouds_on(&Placement::INTEGERS, 0..120),
        by in [-1_000_000..1_000_000_i32, -1_000_000..1_000_000_i32],
    ) {
        let motion = |p: Point| [0, 1].map(|axis| p[axis] + f64::from(by[axis]));
        let (still, image) = (skeleton_of(&cloud), skeleton_of(&moved(&cloud, motion)));
        prop_assert_eq!(dots(&image), dots(&still));
        prop_assert_eq!(image.tree_length(), still.tree_length());
        let want = moved_edges(&ByPosition::of(&still), motion);
        prop_assert_eq!(moved_edges(&ByPosition::of(&image), |p| p), want);
    }

    /// Every operation is exact except for its exponent, so every bit is kept, for every cloud.
    #[test]
    fn scaling_by_powers_of_two_scales_everything(cloud in clouds(0..120), exponent in -50..170_i32) {
        let scale = 2f64.powi(exponent);
        let scaled = moved(&cloud, |p| p.map(|v| v * scale));
        let mut want = by_position(&cloud);
        let enlarge = |p: &mut Point| *p = p.map(|v| v * scale);
        want.vertices.iter_mut().for_each(enlarge);
        want.tree.as_flattened_mut().iter_mut().for_each(enlarge);
        for dot in &mut want.dots {
            dot.birth *= scale;
            dot.death *= scale;
            dot.edge.iter_mut().chain(&mut dot.triangle).for_each(enlarge);
            enlarge(&mut dot.center);
        }
        by_position(&scaled).assert_same(&want);
        let (length, scaled_length) = (skeleton_of(&cloud).tree_length(), skeleton_of(&scaled).tree_length());
        prop_assert_eq!(scaled_length, length * scale);
    }

    #[test]
    fn generic_rotations_keep_dots(cloud in Placement::Uniform.points(0..120), angle in 0.0..std::f64::consts::TAU) {
        let (sin, cos) = angle.sin_cos();
        let motion = |[x, y]: Point| [cos * x - sin * y, sin * x + cos * y];
        let (still, image) = (skeleton_of(&cloud), skeleton_of(&moved(&cloud, motion)));
        assert_close(&dots(&image), &dots(&still), 1e-9, "rotation");
        assert_same_length(&image, &still, 1e-12, "rotation");
    }
}
