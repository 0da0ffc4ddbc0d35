//! The hole of a dot at its birth: which triangles it is made of, and the polygon around it.
//!
//! In: a [`Mesh`] and its [`Basins`], then dots of their skeleton. Out: faces of the mesh, or loops of vertices. The hole at birth is
//! the component of the dual graph that the critical edge is about to join to an elder one: all triangles that can be reached
//! from the one that names the death by crossing edges that come before the critical edge in the total order. An attached edge
//! is crossed whatever its scale, since its triangle and the edge cancel: a hole is a union of basins. Invariants: the
//! boundary is made of Gabriel edges no longer than the critical edge, which is one of them; each boundary edge is passed once,
//! with the hole on its left; edges inside the hole, dangling ones among them, are no boundary; the loops depend on the cloud
//! alone, not on how the mesh cuts cocircular faces into triangles. Must not know: views, frames, how dots are found.

use std::collections::BTreeSet;

use hashbrown::HashTable;

use super::basins::Basins;
use super::geometry::half_length_squared;
use super::mesh::{FaceEdges, Mesh, OUTER_FACE};
use super::position::Position;
use super::skeleton::{Dot, Edge};

/// Finds the holes of a mesh' dots. Made in linear time; a hole then costs time in proportion to its triangles, whatever the cloud.
#[derive(Clone, Debug)]
pub struct Holes<'a> {
    mesh: &'a Mesh,
    basins: &'a Basins,
    rank: &'a [u32],
    face_edges: FaceEdges,
    /// Edges between two basins, which all critical edges are, by their ends.
    edges: HashTable<u32>,
}

impl<'a> Holes<'a> {
    /// Prepares for the holes of a mesh; `rank[slot]` is the place in [`Skeleton::vertices`](super::skeleton::Skeleton::vertices) of
    /// the site that the mesh has from that slot.
    pub fn new(mesh: &'a Mesh, basins: &'a Basins, rank: &'a [u32]) -> Self {
        let edges = HashTable::new();
        let mut holes = Self { mesh, basins, rank, face_edges: FaceEdges::new(mesh), edges };
        holes.edges = holes.index_edges();
        holes
    }

    fn index_edges(&self) -> HashTable<u32> {
        let mut table = HashTable::with_capacity(self.mesh.edges().len() / 2);
        for (index, edge) in self.mesh.edges().iter().enumerate() {
            let [left, right] = edge.faces.map(|face| self.basins.of_face(face));
            if left != right {
                let hash = |&edge: &u32| hash_edge(self.ranked_ends(edge));
                table.insert_unique(hash(&(index as u32)), index as u32, hash);
            }
        }
        table
    }

    /// The faces of the mesh that a dot's hole is made of at its birth; none, if the dot is not of this mesh.
    pub fn faces(&self, dot: &Dot) -> Vec<u32> {
        self.flood(dot).map_or(Vec::new(), |flood| flood.found)
    }

    /// The boundary of a dot's hole at its birth, as closed walks along the edges of the alpha complex at that scale; none,
    /// if the dot is not of this mesh.
    ///
    /// A walk is given as places in [`Skeleton::vertices`](super::skeleton::Skeleton::vertices), without its first vertex at the end. The
    /// first walk is the outer one and runs counter-clockwise; the others run clockwise around islands in the hole. A walk begins
    /// at its smallest vertex by position; it passes a vertex more than once where the boundary touches itself. The
    /// critical edge is on the outer walk, or on an island when what it opens to is inside.
    pub fn boundary(&self, dot: &Dot) -> Vec<Vec<u32>> {
        let Some(hole) = self.flood(dot) else { return Vec::new() };
        let mut left: BTreeSet<u32> = hole.found.iter().flat_map(|&face| self.boundary_edges(&hole, face)).collect();
        let mut walks = Vec::new();
        while let Some(edge) = left.pop_first() {
            walks.push(self.walk(&hole, edge, &mut left));
        }
        // Nothing is smaller than the smallest vertex of the outer walk.
        walks.sort_unstable_by_key(|walk| self.step(walk, 0));
        walks.into_iter().map(|walk| walk.into_iter().map(|site| self.rank_of(site)).collect()).collect()
    }

    /// The edges of a face in the hole across which the hole ends.
    fn boundary_edges(&self, hole: &Flood, face: u32) -> impl Iterator<Item = u32> {
        let ends = move |&edge: &u32| !hole.seen.contains(self.across(edge, face));
        self.face_edges.of(face).into_iter().filter(ends)
    }

    /// Walks along the boundary with the hole on the left, until back at `first`. Takes the edges out of `left`.
    fn walk(&self, hole: &Flood, first: u32, left: &mut BTreeSet<u32>) -> Vec<u32> {
        let faces = self.mesh.edges()[first as usize].faces;
        let start = (first, if hole.seen.contains(faces[0]) { faces[0] } else { faces[1] });
        let mut walk = Vec::new();
        let (mut edge, mut face) = start;
        loop {
            left.remove(&edge);
            let [from, to] = self.directed(edge, face);
            walk.push(from);
            (edge, face) = self.turn(hole, edge, face, to);
            if (edge, face) == start {
                break;
            }
        }
        let smallest = (0..walk.len()).min_by_key(|&place| self.step(&walk, place)).unwrap_or(0);
        walk.rotate_left(smallest);
        walk
    }

    /// The next boundary edge around `pivot`, and the face of the hole beside it: crosses the hole's faces there until it ends.
    fn turn(&self, hole: &Flood, mut edge: u32, mut face: u32, pivot: u32) -> (u32, u32) {
        loop {
            let [a, b, c] = self.face_edges.of(face);
            let next = |&other: &u32| other != edge && self.mesh.edges()[other as usize].ends.contains(&pivot);
            edge = [a, b, c].into_iter().find(next).expect("two edges of a triangle meet in each of its corners");
            let across = self.across(edge, face);
            if !hole.seen.contains(across) {
                return (edge, face);
            }
            face = across;
        }
    }

    /// All faces on the critical edge's younger side. Both sides are searched in turn until one of them shows the triangle that
    /// names the death, so the elder side, which may be most of the plane, costs no more than the hole.
    fn flood(&self, dot: &Dot) -> Option<Flood> {
        let critical = self.find_edge(dot.edge)?;
        let barrier = self.order_of(critical);
        let mut sides = self.mesh.edges()[critical as usize].faces.map(Flood::new);
        while sides.iter().any(Flood::is_unfinished) {
            for side in &mut sides {
                let Some(face) = side.next() else { continue };
                self.spread(side, face, barrier);
                if self.is_named_by(face, dot) {
                    while let Some(face) = side.next() {
                        self.spread(side, face, barrier);
                    }
                    return Some(std::mem::take(side));
                }
            }
        }
        None
    }

    /// Finds the neighbours of a face that lie on the same side of the edges from the barrier on.
    fn spread(&self, flood: &mut Flood, face: u32, barrier: Order) {
        for edge in self.face_edges.of(face) {
            let across = self.across(edge, face);
            let same_basin = self.basins.of_face(across) == self.basins.of_face(face);
            if same_basin || is_before(self.order_of(edge), barrier) {
                flood.reach(across);
            }
        }
    }

    /// Whether a face flows to the maximum that is a dot's death.
    fn is_named_by(&self, face: u32, dot: &Dot) -> bool {
        let triangle = self.basins.triangle(self.basins.of_face(face));
        triangle.map(|site| self.rank_of(site)) == dot.triangle
    }

    fn find_edge(&self, ends: Edge) -> Option<u32> {
        self.edges.find(hash_edge(ends), |&edge| self.ranked_ends(edge) == ends).copied()
    }

    fn ranked_ends(&self, edge: u32) -> Edge {
        let [a, b] = self.mesh.edges()[edge as usize].ends.map(|site| self.rank_of(site));
        [a.min(b), a.max(b)]
    }

    fn rank_of(&self, site: u32) -> u32 {
        self.rank[self.mesh.slots()[site as usize] as usize]
    }

    /// What decides the total order between edges of different basins, which are all Gabriel: their scale, then their ends.
    fn order_of(&self, edge: u32) -> Order {
        let [a, b] = self.mesh.ordered_ends(edge);
        (half_length_squared(a, b), [a, b])
    }

    /// The face on the other side of an edge of `face`.
    fn across(&self, edge: u32, face: u32) -> u32 {
        let [left, right] = self.mesh.edges()[edge as usize].faces;
        if left == face { right } else { left }
    }

    /// The ends of an edge, in the direction that has `face` on its left.
    fn directed(&self, edge: u32, face: u32) -> [u32; 2] {
        let edge = &self.mesh.edges()[edge as usize];
        let [a, b] = edge.ends;
        if edge.faces[0] == face { [a, b] } else { [b, a] }
    }

    /// Where the step of a walk at `place` begins and ends.
    fn step(&self, walk: &[u32], place: usize) -> [Position; 2] {
        [walk[place], walk[(place + 1) % walk.len()]].map(|site| self.mesh.position(site))
    }
}

/// A squared scale and the ends, by position.
type Order = (f64, [Position; 2]);

/// Whether an edge is taken before another one: in DEcreasing order.
fn is_before(a: Order, b: Order) -> bool {
    a.0 > b.0 || a.0 == b.0 && a.1 > b.1
}

/// A component of the dual graph, as far as it is known.
#[derive(Debug, Default)]
struct Flood {
    found: Vec<u32>,
    seen: FaceSet,
    /// How many of `found` have been looked at.
    looked_at: usize,
}

impl Flood {
    fn new(face: u32) -> Self {
        let mut flood = Self::default();
        flood.reach(face);
        flood
    }

    /// Notes a face. With the outer face among it, a component is no hole, and need not be searched.
    fn reach(&mut self, face: u32) {
        if face == OUTER_FACE {
            self.looked_at = usize::MAX;
        } else if self.seen.insert(face) {
            self.found.push(face);
        }
    }

    fn is_unfinished(&self) -> bool {
        self.looked_at < self.found.len()
    }

    /// The next face to look at.
    fn next(&mut self) -> Option<u32> {
        let face = *self.found.get(self.looked_at)?;
        self.looked_at += 1;
        Some(face)
    }
}

/// A set of faces.
#[derive(Debug, Default)]
struct FaceSet(HashTable<u32>);

impl FaceSet {
    /// Adds a face; false when it was there.
    fn insert(&mut self, face: u32) -> bool {
        let is_new = !self.contains(face);
        if is_new {
            self.0.insert_unique(mix(face.into()), face, |&face| mix(face.into()));
        }
        is_new
    }

    fn contains(&self, face: u32) -> bool {
        self.0.find(mix(face.into()), |&other| other == face).is_some()
    }
}

fn hash_edge([a, b]: Edge) -> u64 {
    mix(u64::from(a) << 32 | u64::from(b))
}

/// Spreads the bits of small numbers over all 64, as the table needs it.
fn mix(key: u64) -> u64 {
    let mixed = (key ^ (key >> 32)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    mixed ^ (mixed >> 32)
}

#[cfg(test)]
mod tests {
    use std::cmp::Ordering;

    use proptest::prelude::*;

    use super::*;
    use crate::topology::testing::{Points, clouds, clouds_twice, lattice, points_of, ring};
    use crate::topology::{Cloud, Skeleton, Window, delaunay::Delaunay, filtration::Filtration};

    type Walks = Vec<Vec<[f64; 2]>>;

    /// All that holes are made of.
    struct Scene {
        mesh: Mesh,
        basins: Basins,
        rank: Vec<u32>,
        skeleton: Skeleton,
    }

    impl Scene {
        fn new(points: &[[f64; 2]]) -> Self {
            let mut cloud = Cloud::new(Window::All, None);
            for &[x, y] in points {
                cloud.insert(x, y, None).unwrap();
            }
            cloud.commit();
            let change = cloud.take_change();
            let mut delaunay = Delaunay::default();
            delaunay.apply(&cloud, &change);
            let mesh = delaunay.mesh();
            let (basins, links) = Basins::contract(&mesh, Filtration::new(&mesh));
            let skeleton = Skeleton::new(&cloud, &mesh, &basins, links);
            let mut rank = vec![u32::MAX; cloud.slot_count()];
            for (place, (slot, _)) in cloud.vertices().enumerate() {
                rank[slot as usize] = place as u32;
            }
            Self { mesh, basins, rank, skeleton }
        }

        fn holes(&self) -> Holes<'_> {
            Holes::new(&self.mesh, &self.basins, &self.rank)
        }

        fn at(&self, vertex: u32) -> Position {
            self.skeleton.vertices()[vertex as usize].position
        }

        fn walks(&self, dot: &Dot) -> Walks {
            let place = |walk: Vec<u32>| walk.into_iter().map(|vertex| self.at(vertex).xy()).collect();
            self.holes().boundary(dot).into_iter().map(place).collect()
        }
    }

    fn steps<T: Copy>(walk: &[T]) -> impl Iterator<Item = [T; 2]> + '_ {
        walk.iter().zip(walk.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])
    }

    /// Positive when counter-clockwise.
    fn area(walk: &[[f64; 2]]) -> f64 {
        let [x, y] = walk[0];
        steps(walk).map(|[[ax, ay], [bx, by]]| (ax - x) * (by - y) - (bx - x) * (ay - y)).sum::<f64>() / 2.0
    }

    /// How often a walk goes around a point, counter-clockwise.
    fn winding([x, y]: [f64; 2], walk: &[[f64; 2]]) -> i32 {
        let turn = |[[ax, ay], [bx, by]]: [[f64; 2]; 2]| {
            let cross = (ax - x) * (by - y) - (bx - x) * (ay - y);
            i32::from(ay <= y && by > y && cross > 0.0) - i32::from(by <= y && ay > y && cross < 0.0)
        };
        steps(walk).map(turn).sum()
    }

    #[test]
    fn a_square_is_the_boundary_of_its_hole() {
        let square = Scene::new(&[[1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        let [dot] = square.skeleton.dots() else { panic!("one dot") };
        assert_eq!(square.walks(dot), [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]);
        assert_eq!(square.holes().faces(dot).len(), 2);
    }

    #[test]
    fn an_acute_triangle_is_a_hole_and_others_are_none() {
        let acute = Scene::new(&[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]);
        assert_eq!(acute.walks(&acute.skeleton.dots()[0]), [[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]]);
        let right = Scene::new(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]);
        assert_eq!(right.skeleton.dots(), []);
    }

    #[test]
    fn clouds_without_holes_are_no_trouble() {
        for points in [&[][..], &[[1.0, 2.0]], &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]] {
            let scene = Scene::new(points);
            assert_eq!(scene.skeleton.dots(), []);
            assert_eq!(scene.holes().boundary(&foreign([0, 1])), Vec::<Vec<u32>>::new());
        }
    }

    fn foreign(edge: Edge) -> Dot {
        Dot { birth: 0.5, death: 1.0, edge, triangle: [7, 8, 9] }
    }

    #[test]
    fn a_dot_of_another_cloud_has_no_hole_here() {
        let square = Scene::new(&[[1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        let edge = square.skeleton.dots()[0].edge;
        for edge in [edge, [7, 8], [0, 0]] {
            assert_eq!(square.holes().faces(&foreign(edge)), []);
        }
    }

    #[test]
    fn each_square_of_a_lattice_is_a_hole() {
        let scene = Scene::new(&lattice(7, 5));
        let mut corners: Points = Vec::new();
        for dot in scene.skeleton.dots() {
            let [walk] = &scene.walks(dot)[..] else { panic!("one walk") };
            let [x, y] = walk[0];
            assert_eq!(walk[..], [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]]);
            corners.push([x, y]);
        }
        corners.sort_by(|a, b| a.partial_cmp(b).unwrap());
        corners.dedup();
        assert_eq!(corners.len(), 6 * 4);
    }

    #[test]
    fn a_cocircular_polygon_is_one_hole_however_it_is_cut() {
        let points = points_of(include_str!("../../tests/cases/cocirc_r65.csv"));
        let [forth, back] = [false, true].map(|reversed| {
            let mut points = points.clone();
            points.rotate_left(if reversed { 11 } else { 0 });
            let scene = Scene::new(&points);
            scene.walks(&scene.skeleton.dots()[0])
        });
        assert_eq!(forth, back);
        assert_eq!((forth.len(), forth[0].len()), (1, 36));
    }

    #[test]
    fn theta_has_two_round_holes() {
        let theta = Scene::new(&points_of(include_str!("../../tests/cases/theta_n250_e0.03.csv")));
        for dot in &theta.skeleton.dots()[..2] {
            let walks = theta.walks(dot);
            assert!(walks[0].len() > 40 && area(&walks[0]) > 0.5, "{} {}", walks[0].len(), area(&walks[0]));
            assert_eq!(winding(theta.skeleton.hole(dot).center, &walks[0]), 1);
        }
    }

    #[test]
    fn an_island_is_walked_around_clockwise() {
        let mut points = ring(60, 10.0);
        points.extend(ring(30, 3.0));
        points.extend(ring(12, 1.2).iter().map(|[x, y]| [x + 0.1, y + 0.1]));
        points.extend([[0.0, 0.0]]);
        let scene = Scene::new(&points);
        let walks = scene.walks(&scene.skeleton.dots()[0]);
        assert_eq!(walks.iter().map(Vec::len).collect::<Vec<_>>(), [60, 30]);
        assert!(area(&walks[0]) > 0.0 && area(&walks[1]) < 0.0);
        assert_eq!(walks[1].iter().map(|[x, y]| x.hypot(*y).round()).collect::<Vec<_>>(), [3.0; 30]);
    }

    #[test]
    fn a_hole_may_open_to_its_island() {
        let mut points = ring(60, 10.0);
        // The inner ring has the wider steps, and what it holds is the wider hole: there the one around it ends.
        points.extend(ring(32, 7.0).into_iter().map(|[x, y]| [x + 0.01, y]));
        let scene = Scene::new(&points);
        let around = scene.skeleton.dots().iter().find(|dot| (1.4..1.7).contains(&dot.death)).unwrap();
        let walks = scene.holes().boundary(around);
        assert_eq!(walks.iter().map(Vec::len).collect::<Vec<_>>(), [60, 32]);
        let on = |walk: &[u32]| steps(walk).any(|[a, b]| [a.min(b), a.max(b)] == around.edge);
        assert_eq!([on(&walks[0]), on(&walks[1])], [false, true]);
    }

    #[test]
    fn a_wheel_is_taken_apart_spoke_by_spoke() {
        let mut points = ring(40, 5.0);
        points.push([0.0, 0.0]);
        let scene = Scene::new(&points);
        let holes = scene.holes();
        let sizes: Vec<usize> = scene.skeleton.dots().iter().map(|dot| holes.faces(dot).len()).collect();
        assert_eq!((sizes.len(), sizes.iter().max()), (40, Some(&40)));
    }

    proptest! {
        #[test]
        fn boundaries_are_closed_walks_of_short_edges(points in clouds()) {
            let scene = Scene::new(&points);
            let holes = scene.holes();
            for dot in scene.skeleton.dots() {
                let walks = holes.boundary(dot);
                let mut passed: Vec<Edge> = walks.iter().flat_map(|walk| steps(walk)).collect();
                for &[a, b] in &passed {
                    prop_assert!(holes.find_edge([a.min(b), a.max(b)]).is_some(), "an edge between basins");
                    prop_assert!(scene.skeleton.half_length([a, b]) <= dot.birth);
                }
                let critical = passed.iter().filter(|[a, b]| [*a.min(b), *a.max(b)] == dot.edge).count();
                prop_assert_eq!(critical, 1);
                let count = passed.len();
                passed.iter_mut().for_each(|edge| edge.sort_unstable());
                passed.sort_unstable();
                passed.dedup();
                prop_assert_eq!(passed.len(), count, "each edge once");
            }
        }

        #[test]
        fn the_outer_walk_is_around_the_centre_and_all_islands(points in clouds()) {
            let scene = Scene::new(&points);
            for dot in scene.skeleton.dots() {
                let walks = scene.walks(dot);
                let center = scene.skeleton.hole(dot).center;
                prop_assert_eq!(walks.iter().map(|walk| winding(center, walk)).sum::<i32>(), 1);
                prop_assert_eq!(winding(center, &walks[0]), 1);
                prop_assert!(area(&walks[0]) > 0.0);
                for island in &walks[1..] {
                    prop_assert!(area(island) < 0.0 && walks[0][0] < island[0]);
                    prop_assert_eq!(winding(island[0], &walks[0]), 1);
                }
            }
        }

        #[test]
        fn the_area_inside_is_that_of_the_triangles(points in clouds()) {
            let scene = Scene::new(&points);
            let holes = scene.holes();
            for dot in scene.skeleton.dots() {
                let triangle = |face: u32| scene.mesh.corners(face).map(|site| scene.mesh.position(site).xy());
                let triangles: f64 = holes.faces(dot).into_iter().map(|face| area(&triangle(face)).abs()).sum();
                let walks: f64 = scene.walks(dot).iter().map(|walk| area(walk)).sum();
                prop_assert!((triangles - walks).abs() <= 1e-9 * triangles, "{triangles} {walks}");
            }
        }

        /// Of all triangles in a hole, the one that names the death is filled last; and holes that meet are nested.
        #[test]
        fn a_hole_is_filled_at_its_death(points in clouds()) {
            let scene = Scene::new(&points);
            let holes = scene.holes();
            let all: Vec<Vec<u32>> = scene.skeleton.dots().iter().map(|dot| holes.faces(dot)).collect();
            for (faces, dot) in all.iter().zip(scene.skeleton.dots()) {
                let weight = |face: &u32| scene.basins.weight(scene.basins.of_face(*face)).sqrt();
                let last = faces.iter().map(weight).max_by(f64::total_cmp);
                prop_assert_eq!(last, Some(dot.death));
            }
            for (a, b) in all.iter().flat_map(|a| all.iter().map(move |b| (a, b))) {
                let common = a.iter().filter(|face| b.contains(face)).count();
                prop_assert!([0, a.len().min(b.len())].contains(&common));
            }
        }

        #[test]
        fn neither_numbering_nor_triangulation_matters((points, shuffled) in clouds_twice()) {
            let [a, b] = [points, shuffled].map(|points| {
                let scene = Scene::new(&points);
                let mut all: Vec<Walks> = scene.skeleton.dots().iter().map(|dot| scene.walks(dot)).collect();
                all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
                all
            });
            prop_assert_eq!(a, b);
        }
    }
}
