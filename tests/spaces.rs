//! Skeletons of any space: R^d for some d, and distances without coordinates. What is derived from a skeleton does not
//! depend on where it came from.

mod common;

use std::collections::BTreeSet;
use std::num::NonZeroU32;

use common::clouds::{cases, clouds};
use common::skeleton_of;
use hopes::topology::{
    Cycles, Diff, Dot, Edge, Filtration, Killer, Positions, ShortestCycles, Skeleton, Snapshot, VertexId, Vertices,
    View, ViewSpec, simplify,
};
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// A space of a few vertices: their ids and coordinates, and the half-lengths of all pairs.
#[derive(Clone, Debug)]
struct Space {
    vertices: Vertices,
    half_lengths: Vec<f64>,
    /// Which pairs that are not in the tree have a dot: how long it lives, perhaps for ever.
    lives: Vec<Option<f64>>,
}

/// Few different values, so that many are equal.
fn spaces(dimension: usize) -> impl Strategy<Value = Space> {
    (2..9_usize).prop_flat_map(move |count| {
        let ids = prop::collection::btree_set(0..40_u64, count);
        let coordinate = prop_oneof![(-3..4).prop_map(f64::from), -3.0..3.0];
        let coordinates = prop::collection::vec(coordinate, dimension * count);
        let half_length = prop_oneof![(1..5).prop_map(f64::from), 0.5..4.0, Just(f64::INFINITY)];
        let life = prop_oneof![0.1..3.0, (1..4).prop_map(f64::from), Just(f64::INFINITY)];
        let pairs = count * (count - 1) / 2;
        let half_lengths = prop::collection::vec(half_length, pairs);
        let lives = prop::collection::vec(prop::option::of(life), pairs);
        (ids, coordinates, half_lengths, lives).prop_map(move |(ids, coordinates, half_lengths, lives)| {
            let place = |index: usize| &coordinates[index * dimension..(index + 1) * dimension];
            let vertices = ids.into_iter().enumerate().map(|(index, id)| (VertexId(id), place(index))).collect();
            Space { vertices, half_lengths, lives }
        })
    })
}

impl Space {
    /// A minimum spanning forest by Kruskal's algorithm, and dots at some of the other edges of finite length.
    fn skeleton(&self) -> Skeleton {
        let count = self.vertices.len() as u32;
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let mut edges: Vec<(f64, Edge, Option<f64>)> =
            pairs.zip(&self.half_lengths).zip(&self.lives).map(|((edge, &half), &life)| (half, edge, life)).collect();
        edges.retain(|(half, ..)| half.is_finite());
        edges.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut component: Vec<u32> = (0..count).collect();
        let (mut tree, mut dots) = (Vec::new(), Vec::new());
        for (birth, edge, life) in edges {
            let [a, b] = edge.map(|end| component[end as usize]);
            if a != b {
                component.iter_mut().filter(|of| **of == b).for_each(|of| *of = a);
                tree.push((edge, birth));
            } else if let Some(life) = life {
                let killer = if life.is_finite() { Killer::Edge(edge) } else { Killer::None };
                dots.push(Dot { birth, death: birth + life, edge, killer });
            }
        }
        tree.reverse();
        Skeleton::with_lengths(self.vertices.clone(), tree, dots)
    }
}

fn any_space() -> impl Strategy<Value = Space> {
    select(vec![0, 1, 2, 3, 5]).prop_flat_map(spaces)
}

/// Two spaces of one dimension.
fn two_spaces() -> impl Strategy<Value = (Space, Space, Space)> {
    select(vec![0, 1, 3]).prop_flat_map(|dimension| (spaces(dimension), spaces(dimension), spaces(dimension)))
}

fn specs() -> impl Strategy<Value = ViewSpec> {
    let rank = || (1..4_u32).prop_map(|rank| NonZeroU32::new(rank).unwrap());
    prop_oneof![
        Just(ViewSpec::Full),
        (0.0..6.0).prop_map(|alpha| ViewSpec::Reduced { alpha }),
        (rank(), rank()).prop_map(|(k, l)| ViewSpec::Derived { k, l }),
    ]
}

fn snapshot(space: &Space, spec: ViewSpec) -> Snapshot {
    let skeleton = space.skeleton();
    Snapshot::new(&skeleton, &View::new(&skeleton, spec))
}

/// As the specification of the protocol has it: a sum over all elements of a hash of their words.
fn checksum(snapshot: &Snapshot) -> u64 {
    let hash = |words: Vec<u64>| {
        words.iter().fold(0_u64, |hash, word| {
            let z = (hash ^ word).wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^ (z >> 31)
        })
    };
    let vertex = |(id, at): (VertexId, &[f64])| {
        hash([&[1, id.0], &at.iter().map(|v| v.to_bits()).collect::<Vec<_>>()[..]].concat())
    };
    let vertices = snapshot.vertices.iter().map(vertex);
    let tree = snapshot.tree.iter().map(|[a, b]| hash(vec![2, a.0, b.0]));
    let critical = snapshot.critical.iter().map(|critical| {
        let [a, b] = critical.edge;
        hash(vec![3, a.0, b.0, critical.birth.to_bits(), critical.death.to_bits()])
    });
    vertices.chain(tree).chain(critical).fold(0, u64::wrapping_add)
}

/// The independent cycles and the components of a graph.
fn cycles_and_components(vertices: usize, edges: &[Edge]) -> (usize, usize) {
    let mut component: Vec<usize> = (0..vertices).collect();
    for edge in edges {
        let [a, b] = edge.map(|end| component[end as usize]);
        component.iter_mut().filter(|of| **of == b).for_each(|of| *of = a);
    }
    let components = component.into_iter().collect::<BTreeSet<_>>().len();
    (edges.len() + components - vertices, components)
}

/// A hexagon of side 2 that is not in a plane of two coordinates.
fn hexagon() -> Skeleton {
    let mut vertices = Vertices::default();
    let corners =
        [[0.0, 1.0, -1.0], [1.0, 0.0, -1.0], [1.0, -1.0, 0.0], [0.0, -1.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, 0.0]];
    for (id, corner) in (10..).zip(corners) {
        vertices.push(VertexId(id), &corner.map(|v| v * std::f64::consts::SQRT_2));
    }
    let tree = [[0, 1], [1, 2], [2, 3], [3, 4], [0, 5]].map(|edge| (edge, 1.0)).to_vec();
    let dot = Dot { birth: 1.0, death: 3f64.sqrt(), edge: [5, 4], killer: Killer::Edge([1, 5]) };
    Skeleton::with_lengths(vertices, tree, vec![dot])
}

#[test]
fn a_hexagon_in_space_has_one_cycle() {
    let skeleton = hexagon();
    assert_eq!((skeleton.filtration(), skeleton.vertices().dimension()), (Filtration::Rips, 3));
    assert_eq!((skeleton.half_length([0, 5]), skeleton.length([4, 5]), skeleton.tree_length()), (1.0, 2.0, 10.0));
    assert_eq!(skeleton.half_length([0, 2]), f64::INFINITY, "no edge of the skeleton");
    let [dot] = skeleton.dots() else { panic!("one dot") };
    assert_eq!((dot.edge, skeleton.hole(dot)), ([4, 5], None));
    let view = View::new(&skeleton, ViewSpec::default());
    assert_eq!((view.components, view.cycles, view.scale(), view.length(&skeleton)), (1, 1, 1.0, 12.0));
    // From the smallest corner by position on, which is (-1, 0, 1).
    assert_eq!(Cycles::new(&skeleton).cycle(&skeleton, dot), [4, 5, 0, 1, 2, 3]);
    assert_eq!(ShortestCycles::new(&skeleton).cycle(dot), [4, 5, 0, 1, 2, 3]);
    let triangle = simplify(&skeleton, &view, f64::INFINITY);
    assert_eq!((triangle.positions.len(), triangle.edges.len(), triangle.positions.coordinates(0).len()), (3, 3, 3));
}

/// Consumers of any language compute these.
#[test]
fn checksums_of_other_spaces_are_frozen() {
    let frozen = |coordinates: &[f64]| {
        let vertices: Vertices = [(VertexId(7), coordinates)].into_iter().collect();
        Snapshot { vertices, ..Snapshot::default() }.checksum().to_string()
    };
    assert_eq!(frozen(&[]), "7716da39cba275b2");
    assert_eq!(frozen(&[0.5]), "b1a161a5feaf0ba4");
    assert_eq!(frozen(&[0.5, -1.0, 2.0]), "11fa394d331f1a80");
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn a_skeleton_of_the_plane_is_the_same_from_its_lengths(points in clouds(0..60_usize), spec in specs(), backwards: bool) {
        let plane = skeleton_of(&points);
        let mut tree: Vec<(Edge, f64)> = plane.tree().iter().map(|&edge| (edge, plane.half_length(edge))).collect();
        let mut dots = plane.dots().to_vec();
        if backwards {
            tree.reverse();
            tree.iter_mut().for_each(|(edge, _)| edge.reverse());
            dots.iter_mut().for_each(|dot| dot.edge.reverse());
        }
        let rips = Skeleton::with_lengths(plane.vertices().clone(), tree, dots);
        prop_assert_eq!((plane.filtration(), rips.filtration()), (Filtration::Alpha, Filtration::Rips));
        prop_assert_eq!(rips.tree(), plane.tree());
        prop_assert_eq!(rips.dots(), plane.dots());
        let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.max(b);
        let edges = plane.tree().iter().copied().chain(plane.dots().iter().map(|dot| dot.edge));
        for edge in edges {
            prop_assert!(is_near(plane.length(edge), rips.length(edge)), "{:?}", edge);
        }
        prop_assert!(is_near(plane.tree_length(), rips.tree_length()));
        let [view, ours] = [&plane, &rips].map(|skeleton| View::new(skeleton, spec));
        prop_assert!(is_near(view.length(&plane), ours.length(&rips)));
        prop_assert_eq!(&ours, &view);
        let [old, new] = [&plane, &rips].map(|skeleton| Snapshot::new(skeleton, &view));
        prop_assert_eq!(old.checksum(), new.checksum());
        prop_assert!(old.diff(&new).is_empty());
        prop_assert_eq!(Snapshot::default().diff(&old), Snapshot::default().diff(&new));
        let [of_plane, of_rips] = [&plane, &rips].map(Cycles::new);
        let shortest = [&plane, &rips].map(ShortestCycles::new);
        for dot in plane.dots() {
            prop_assert_eq!(of_plane.cycle(&plane, dot), of_rips.cycle(&rips, dot));
            prop_assert_eq!(shortest[0].cycle(dot), shortest[1].cycle(dot));
        }
        let simple = [&plane, &rips].map(|skeleton| simplify(skeleton, &view, view.scale()));
        for simple in &simple {
            let counts = cycles_and_components(simple.positions.len(), &simple.edges);
            prop_assert_eq!(counts, (view.cycles, view.components));
        }
    }

    #[test]
    fn views_keep_what_their_scales_say(space in any_space(), spec in specs()) {
        let skeleton = space.skeleton();
        let view = View::new(&skeleton, spec);
        let edges: Vec<Edge> = view.tree.iter().copied().chain(view.critical_edges(&skeleton)).collect();
        prop_assert_eq!(cycles_and_components(space.vertices.len(), &edges), (view.cycles, view.components));
        let limit = view.scale() * (1.0 + 1e-12);
        prop_assert!(edges.iter().all(|&edge| skeleton.half_length(edge) <= limit));
        let short = skeleton.tree().iter().filter(|&&edge| skeleton.half_length(edge) <= limit);
        prop_assert_eq!(short.count(), view.tree.len());
        prop_assert!(!view.scale().is_nan());
        if let Some(selection) = &view.selection {
            prop_assert!(selection.ds.is_none_or(|ds| !ds.is_nan()));
            let margins = [selection.margins.diagonal, selection.margins.vertical];
            // Of widths that count as equal the next one may be the larger by rounding.
            let rounding = 1e-12 * skeleton.dots().iter().map(|dot| dot.birth).fold(skeleton.largest_death(), f64::max);
            prop_assert!(margins.iter().flatten().all(|margin| *margin >= -rounding), "{:?}", margins);
            let never_dies = skeleton.dots().iter().filter(|dot| dot.death.is_infinite()).count();
            if matches!(spec, ViewSpec::Derived { k: NonZeroU32::MIN, .. }) && never_dies > 0 {
                prop_assert_eq!((selection.ds, selection.ds_count), (Some(f64::INFINITY), never_dies));
            }
        }
    }

    #[test]
    fn diffs_lead_from_one_space_to_the_next((a, b, c) in two_spaces(), spec in specs()) {
        let [a, b, c] = [a, b, c].map(|space| snapshot(&space, spec));
        let steps = [a.diff(&b), b.diff(&c)];
        prop_assert_eq!(a.apply(&steps[0]), Ok(b.clone()));
        prop_assert_eq!(b.apply(&steps[1]), Ok(c.clone()));
        prop_assert_eq!(Snapshot::default().apply(&Snapshot::default().diff(&a)), Ok(a.clone()));
        prop_assert_eq!(a.apply(&Diff::merged(&steps)), Ok(c.clone()));
        prop_assert!(c.diff(&c).is_empty());
        for snapshot in [&a, &b, &c] {
            prop_assert_eq!(snapshot.checksum().0, checksum(snapshot));
        }
        prop_assert!(a == b || a.checksum() != b.checksum());
    }

    #[test]
    fn simplified_views_keep_cycles_and_components(space in any_space(), spec in specs(), threshold in 0.0..6.0_f64) {
        let skeleton = space.skeleton();
        let view = View::new(&skeleton, spec);
        let simple = simplify(&skeleton, &view, threshold);
        let counts = cycles_and_components(simple.positions.len(), &simple.edges);
        prop_assert_eq!(counts, (view.cycles, view.components));
        let edges = view.tree.iter().copied().chain(view.critical_edges(&skeleton));
        let mut images: Vec<Edge> = edges.map(|edge| edge.map(|vertex| simple.image[vertex as usize])).collect();
        images.retain(|[a, b]| a != b);
        images.iter_mut().for_each(|edge| edge.sort_unstable());
        images.sort_unstable();
        prop_assert_eq!(&images, &simple.edges);
        if let Positions::Labels(labels) = &simple.positions {
            // A label stays at a vertex that was merged into it.
            prop_assert!((0..).zip(labels).all(|(place, &label)| simple.image[label as usize] == place));
        }
        let snapshot = Snapshot::of_simplified(&skeleton, &simple);
        prop_assert_eq!(snapshot.vertices.len(), simple.positions.len());
        prop_assert!(snapshot.vertices.ids().is_sorted_by(|a, b| a < b));
        prop_assert!(snapshot.vertices.dimension() == space.vertices.dimension());
        let empty = Snapshot::default();
        prop_assert_eq!(empty.apply(&empty.diff(&snapshot)), Ok(snapshot));
    }

    #[test]
    fn cycles_close_critical_edges(space in any_space()) {
        let skeleton = space.skeleton();
        let (cycles, shortest) = (Cycles::new(&skeleton), ShortestCycles::new(&skeleton));
        for dot in skeleton.dots() {
            let both = [cycles.cycle(&skeleton, dot), shortest.cycle(dot)];
            let half_lengths = both.each_ref().map(|cycle| {
                let next = cycle.iter().cycle().skip(1);
                let edges: Vec<Edge> = cycle.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]).collect();
                assert!(cycle.len() >= 3 && edges.contains(&dot.edge), "{cycle:?} of {dot:?}");
                let first = &skeleton.vertices();
                assert!(cycle.iter().all(|&other| first.compare(cycle[0], other).is_le()), "{cycle:?}");
                edges.iter().map(|&edge| skeleton.half_length(edge)).sum::<f64>()
            });
            prop_assert!(half_lengths[1] <= half_lengths[0] * (1.0 + 1e-12));
        }
    }

    /// Where positions differ, numbers do not matter.
    #[test]
    fn simplification_depends_on_positions(space in spaces(3), swaps in prop::collection::vec(any::<[Index; 2]>(), 8)) {
        let skeleton = space.skeleton();
        let count = space.vertices.len();
        let mut order: Vec<usize> = (0..count).collect();
        swaps.iter().for_each(|[a, b]| order.swap(a.index(count), b.index(count)));
        let new_place = |old: u32| order.iter().position(|&place| place == old as usize).unwrap() as u32;
        let coordinates = order.iter().map(|&old| space.vertices.coordinates(old as u32));
        let vertices: Vertices = space.vertices.ids().iter().copied().zip(coordinates).collect();
        let distinct: BTreeSet<Vec<u64>> = space.vertices.iter().map(|(_, at)| at.iter().map(|v| v.to_bits()).collect()).collect();
        prop_assume!(distinct.len() == count);
        let tree = skeleton.tree().iter().map(|&edge| (edge.map(new_place), skeleton.half_length(edge))).collect();
        let dots = skeleton.dots().iter().map(|dot| Dot { edge: dot.edge.map(new_place), ..*dot }).collect();
        let moved = Skeleton::with_lengths(vertices, tree, dots);
        let [ours, theirs] = [&skeleton, &moved].map(|skeleton| simplify(skeleton, &View::new(skeleton, ViewSpec::Full), 2.0));
        prop_assert_eq!((ours.positions, ours.edges), (theirs.positions, theirs.edges));
    }
}
