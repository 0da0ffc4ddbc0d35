//! The dynamic triangulation: small changes are made vertex by vertex, large ones in bulk. Both give a Delaunay
//! triangulation of the cloud and the skeleton of a recomputation.

mod common;

use std::cmp::Ordering::{Equal, Greater, Less};

use common::by_position::ByPosition;
use common::clouds::{Placement, Point, cases, distinct};
use common::skeleton_of;
use hopes::topology::stages::{Basins, Delaunay, Filtration, Mesh, OUTER_FACE, Update};
use hopes::topology::{Cloud, Position, Skeleton, Window};
use proptest::prelude::*;
use proptest::sample::Index;
use robust::Coord;

/// A cloud and its triangulation, without a pipeline.
struct Stages {
    cloud: Cloud,
    delaunay: Delaunay,
}

impl Stages {
    fn new() -> Self {
        Self { cloud: Cloud::new(Window::All, None), delaunay: Delaunay::default() }
    }

    fn insert(&mut self, points: &[Point]) {
        for &[x, y] in points {
            self.cloud.insert(x, y, None).expect("the point is taken");
        }
    }

    fn retract(&mut self, points: &[Point]) {
        for &[x, y] in points {
            self.cloud.retract(x, y).expect("the point is there");
        }
    }

    /// Commits a frame and updates the triangulation. Returns how, and the number of changed vertices.
    fn follow(&mut self) -> (Update, usize) {
        self.cloud.commit();
        let change = self.cloud.take_change();
        let update = self.delaunay.apply(&self.cloud, &change);
        self.delaunay.check_invariants(&self.cloud);
        (update, change.appeared.len() + change.vanished.len())
    }

    fn positions(&self) -> Vec<Point> {
        self.cloud.vertices().map(|(_, vertex)| vertex.position.xy()).collect()
    }

    fn assert_right(&self) {
        let mesh = self.delaunay.mesh();
        assert_delaunay(&mesh, &self.positions());
        let (basins, links) = Basins::contract(&mesh, Filtration::new(&mesh));
        let skeleton = Skeleton::new(&self.cloud, &mesh, &basins, links);
        ByPosition::of(&skeleton).assert_same(&ByPosition::of(&skeleton_of(&self.positions())));
    }
}

/// The definition: the faces tile the convex hull, and no circle around a triangle contains the vertex across an edge.
fn assert_delaunay(mesh: &Mesh, positions: &[Point]) {
    let sites: Vec<Point> = mesh.positions().iter().map(|p| p.xy()).collect();
    assert_eq!(distinct(&sites), distinct(positions), "the sites are the cloud");
    let (vertices, edges, faces) = (sites.len(), mesh.edges().len(), mesh.face_count());
    assert_eq!(vertices + faces, edges + if vertices == 0 { 1 } else { 2 }, "Euler: one component, no hole");
    for edge in mesh.edges() {
        let [a, b] = edge.ends.map(|site| coord(mesh.position(site)));
        let apexes =
            edge.faces.map(|face| (face != OUTER_FACE).then(|| coord(mesh.position(mesh.opposite(face, edge)))));
        if let [Some(left), Some(right)] = apexes {
            let counter_clockwise = robust::orient2d(a, b, left) > 0.0;
            assert!(counter_clockwise && robust::orient2d(a, b, right) < 0.0, "faces lie on their sides");
            assert!(robust::incircle(a, b, left, right) <= 0.0, "an edge that should be flipped: {edge:?}");
        } else {
            let side = |&[x, y]: &Point| robust::orient2d(a, b, Coord { x, y }).partial_cmp(&0.0).expect("a number");
            let sides: Vec<_> = sites.iter().map(side).filter(|&side| side != Equal).collect();
            let one_sided = sides.iter().all(|&s| s == Less) || sides.iter().all(|&s| s == Greater);
            assert!(one_sided, "an outer edge that is not on the hull: {edge:?}");
        }
    }
}

fn coord(position: Position) -> Coord<f64> {
    Coord { x: position.x(), y: position.y() }
}

/// The kinds of places on which a cloud of some size certainly has a triangulation.
const PLANES: [Placement; 7] = [
    Placement::Uniform,
    Placement::Lattice,
    Placement::RoundedLattice,
    Placement::Circles(25),
    Placement::Far,
    Placement::FarLattice,
    Placement::Tiny,
];

/// A base, and small changes: points to insert, vertices to retract.
type BaseAndChanges = (Vec<Point>, Vec<(Vec<Point>, Vec<Index>)>);

fn base_and_changes(placements: &'static [Placement]) -> impl Strategy<Value = BaseAndChanges> {
    proptest::sample::select(placements).prop_flat_map(|placement| {
        let change = (placement.points(0..5), prop::collection::vec(any::<Index>(), 0..5));
        (placement.points(60..160), prop::collection::vec(change, 1..12))
    })
}

/// Updates a base by small changes. Returns how each was done, and its share of the cloud.
fn update_by_changes((base, changes): &BaseAndChanges) -> Vec<(Update, f64)> {
    let mut stages = Stages::new();
    stages.insert(&distinct(base));
    assert_eq!(stages.follow().0, Update::Bulk, "a base is loaded in bulk");
    stages.assert_right();
    let mut updates = Vec::new();
    for (come, go) in changes {
        let there = stages.positions();
        let go: Vec<Point> = go.iter().map(|index| *index.get(&there)).collect();
        stages.insert(come);
        stages.retract(&distinct(&go));
        let (update, changed) = stages.follow();
        stages.assert_right();
        updates.push((update, changed as f64 / stages.positions().len() as f64));
    }
    updates
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn small_changes_are_made_vertex_by_vertex(upkeep in base_and_changes(&PLANES)) {
        for (update, share) in update_by_changes(&upkeep) {
            let want = if share > 0.25 { Update::Bulk } else { Update::Stepwise };
            prop_assert_eq!(update, want, "{} of the cloud changed", share);
        }
    }

    /// A path is updated step by step too, as long as its points are on a line.
    #[test]
    fn a_line_has_no_triangulation(upkeep in base_and_changes(&Placement::LINES)) {
        for (update, share) in update_by_changes(&upkeep) {
            let want = if share > 0.25 { Update::Bulk } else { Update::Stepwise };
            prop_assert_eq!(update, want, "{} of the cloud changed", share);
        }
    }

    /// It is not specified how slivers are updated. Only the result is checked.
    #[test]
    fn slivers_and_mixtures_are_updated_correctly(upkeep in base_and_changes(&[Placement::NearlyCollinear, Placement::Mixture])) {
        update_by_changes(&upkeep);
    }
}

#[test]
fn a_large_change_is_loaded_in_bulk() {
    let mut stages = Stages::new();
    let grid: Vec<Point> = (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10)]).collect();
    stages.insert(&grid);
    stages.follow();
    stages.retract(&grid[..24]);
    assert_eq!(stages.follow(), (Update::Bulk, 24));
    stages.insert(&grid[..20]);
    assert_eq!(stages.follow(), (Update::Stepwise, 20));
    stages.assert_right();
}

/// A spiral of so many points, and a vertex at its centre that sees nearly all of them.
fn spiral(size: i32) -> (Vec<Point>, Point) {
    let at = |i: i32| {
        let share = f64::from(i) / f64::from(size);
        let (sin, cos) = (0.95 * std::f64::consts::TAU * share).sin_cos();
        [(1.0 + 0.3 * share) * cos, (1.0 + 0.3 * share) * sin]
    };
    ((0..size).map(at).collect(), [0.0, 0.0])
}

/// At worst `spade` takes time as the cube of the degree.
#[test]
fn a_removal_that_would_take_longer_than_a_rebuild_is_one() {
    for (size, want) in [(30, Update::Stepwise), (400, Update::Bulk), (3000, Update::Bulk)] {
        let (points, centre) = spiral(size);
        let mut stages = Stages::new();
        stages.insert(&points);
        stages.follow();
        stages.insert(&[centre]);
        assert_eq!(stages.follow(), (Update::Stepwise, 1), "an insertion takes linear time");
        stages.retract(&[centre]);
        assert_eq!(stages.follow(), (want, 1), "the centre of {size} points goes");
        // Without its centre, all triangles of a spiral meet at its inner end, one after the other.
        for end in &points[..3] {
            stages.retract(&[*end]);
            assert_eq!(stages.follow(), (want, 1), "the inner end of {size} points goes");
        }
        stages.retract(&[points[size as usize / 2]]);
        assert_eq!(stages.follow(), (Update::Stepwise, 1), "a point amid {size} goes");
        stages.assert_right();
    }
}

/// Each removal alone would be a step.
#[test]
fn removals_that_take_longer_than_a_rebuild_together_are_one() {
    let (mut points, mut centres) = (Vec::new(), Vec::new());
    for place in 0..12 {
        let (around, centre) = spiral(50);
        let shifted = |[x, y]: Point| [x + 4.0 * f64::from(place), y];
        points.extend(around.into_iter().map(shifted));
        centres.push(shifted(centre));
    }
    let mut stages = Stages::new();
    stages.insert(&points);
    stages.insert(&centres);
    stages.follow();
    stages.retract(&centres[..1]);
    assert_eq!(stages.follow(), (Update::Stepwise, 1));
    stages.retract(&centres[1..]);
    assert_eq!(stages.follow(), (Update::Bulk, 11));
    stages.assert_right();
}

#[test]
fn a_position_removed_and_inserted_between_two_updates_stays() {
    let mut stages = Stages::new();
    let grid: Vec<Point> = (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10)]).collect();
    stages.insert(&grid);
    stages.follow();
    let last_sites = [grid[0], grid[55], grid[99]];
    stages.retract(&last_sites);
    stages.cloud.commit();
    stages.insert(&last_sites);
    assert_eq!(stages.follow(), (Update::Stepwise, 6), "three vanished, three appeared");
    stages.assert_right();
    stages.retract(&last_sites);
    assert_eq!(stages.follow(), (Update::Stepwise, 3));
    stages.assert_right();
}

/// Clouds on a few lines or in a few clumps, for which bulk loading would take quadratic time, and a batch that is no
/// better.
fn thin_clouds(size: i32) -> impl Iterator<Item = (&'static str, Vec<Point>, Vec<Point>)> {
    let points = move |of: &dyn Fn(f64) -> Point| (0..size).map(f64::from).map(of).collect::<Vec<_>>();
    let half = f64::from(size / 2);
    let clouds = [
        ("a line and one point far off", points(&|i| if i == 7.0 { [-9.0 * half, 1.0] } else { [i, 2.0 * i] })),
        ("two parallel lines", points(&|i| [(i / 2.0).floor(), i % 2.0])),
        ("a cross", points(&|i| if i % 2.0 == 0.0 { [i - half, 0.0] } else { [0.0, i - half] })),
        ("an L", points(&|i| if i % 2.0 == 0.0 { [i, 0.0] } else { [0.0, i] })),
        ("a parabola", points(&|i| [i - half, (i - half) * (i - half) * 0.25])),
        (
            "a line and a lattice",
            points(&|i| if i % 2.0 == 0.0 { [i, 0.0] } else { [i % 41.0 / 64.0, 5.0 + i % 37.0 / 64.0] }),
        ),
    ];
    let far_line: Vec<Point> = (0..size / 8).map(|i| [f64::from(i) * 8.0, 4.0 * half + 0.5]).collect();
    clouds.into_iter().map(move |(name, cloud)| (name, cloud, far_line.clone()))
}

#[test]
fn thin_clouds_are_triangulated_by_definition() {
    for (name, cloud, batch) in thin_clouds(2000) {
        println!("{name}");
        let mut stages = Stages::new();
        stages.insert(&distinct(&cloud));
        stages.follow();
        stages.assert_right();
        stages.insert(&batch);
        stages.follow();
        stages.assert_right();
        stages.retract(&batch[1..]);
        stages.follow();
        stages.assert_right();
    }
}

/// Bulk loading of `spade` leaves a loop in the hull of these, although it turns one way everywhere.
#[test]
fn slivers_have_a_convex_hull() {
    let points = [
        [28.12, 46.3599999999997],
        [48.1, 79.2999999999998],
        [48.47, 79.9099999999998],
        [49.21, 81.13],
        [75.48, 124.4399999999998],
        [76.22, 125.6599999999997],
        [75.48, 124.4399999999999],
        [119.14, 196.42],
    ];
    let mut stages = Stages::new();
    stages.insert(&points);
    stages.follow();
    stages.assert_right();
}

#[test]
fn a_cloud_leaves_a_line_and_returns_to_it() {
    let mut stages = Stages::new();
    let line: Vec<Point> = (0..50).map(|i| [f64::from(i), f64::from(2 * i)]).collect();
    stages.insert(&line);
    stages.follow();
    for off in [[10.0, 21.0], [-3.0, -6.5], [100.0, 0.0]] {
        stages.insert(&[off]);
        assert_eq!(stages.follow().0, Update::Bulk, "a path gives way to a triangulation");
        stages.assert_right();
        stages.insert(&[[70.0, 140.0]]);
        assert_eq!(stages.follow().0, Update::Stepwise);
        stages.assert_right();
        stages.retract(&[[70.0, 140.0]]);
        assert_eq!(stages.follow().0, Update::Stepwise);
        stages.assert_right();
        stages.retract(&[off]);
        assert_eq!(stages.follow().0, Update::Bulk, "a triangulation gives way to a path");
        stages.assert_right();
    }
}
