//! The hole of a dot at its birth: its triangles and the walks around it.
//!
//! In: the triangle that names a dot's death, its critical edge, and the triangulation.
//! Out: the boundary as closed walks of vertices.
//! Invariants: the hole at birth is the component of the dual graph that the critical edge is about to join to an elder
//! one: all triangles that can be reached from the one that names the death by crossing edges that come before the
//! critical edge in the total order. An attached edge is crossed whatever its scale, since its triangle and the edge
//! cancel: a hole is a union of basins. The cost is proportional to the hole's triangles, whatever the cloud. The
//! boundary consists of Gabriel edges no longer than the critical edge, which is one of them; each is passed once, with
//! the hole on its left. Edges inside the hole, dangling ones included, are not part of the boundary. The walks depend
//! on the cloud alone, not on how cocircular faces are cut into triangles.
//! Must not know: views, frames, how dots are found.

use hashbrown::HashTable;

use crate::topology::cloud::{Located, Position, Slot, half_length_squared};
use crate::topology::plane::delaunay::{Delaunay, HalfEdge, HalfEdges};
use crate::topology::plane::geometry::are_cocircular;

/// The boundary of a hole at its birth: closed walks along the edges of the alpha complex at that scale.
///
/// The first walk is the outer one and runs counter-clockwise. The others run clockwise around islands in the hole. A
/// walk begins at its smallest vertex by position, which is not repeated at its end. It passes a vertex more than once
/// where the boundary touches itself. The critical edge is on the outer walk, or on an island if the component that it
/// joins is inside.
pub type Walks = Vec<Vec<Located<Slot>>>;

/// The boundary of the hole of a dot; none if the triangulation has no such dot.
pub fn boundary(delaunay: &Delaunay, name: [Located<Slot>; 3], critical: [Position; 2]) -> Option<Walks> {
    flood(delaunay, name, critical).map(|flood| flood.walks())
}

/// The triangles of the hole of a dot.
fn flood<'a>(delaunay: &'a Delaunay, name: [Located<Slot>; 3], critical: [Position; 2]) -> Option<Flood<'a>> {
    let plane = delaunay.half_edges()?;
    let maximum = named_maximum(plane, delaunay.edge_out_of(name[0].1)?, name)?;
    let mut flood = Flood { plane, barrier: order(critical), triangles: Vec::new(), seen: NumberSet::default() };
    flood.reach(maximum);
    let mut next = 0;
    while let Some(&face) = flood.triangles.get(next) {
        next += 1;
        for edge in plane.around(face) {
            if flood.is_crossed(edge) {
                let twin = plane.twin(edge);
                if plane.is_outer(twin) {
                    return None;
                }
                flood.reach(twin);
            }
        }
    }
    Some(flood)
}

/// The local maximum of this name, as a half-edge with the maximum on its left. `out` is a half-edge out of the first
/// site of the name.
fn named_maximum(plane: HalfEdges<'_>, out: HalfEdge, name: [Located<Slot>; 3]) -> Option<HalfEdge> {
    if plane.origin(out) != name[0] {
        return None;
    }
    let [a, b, c] = name.map(|site| site.0);
    let on_circle = |site: Located<Slot>| name.contains(&site) || are_cocircular(a, b, c, site.0);
    let mut edge = out;
    loop {
        if !plane.is_outer(edge) && plane.corners(edge).into_iter().all(on_circle) {
            return plane.maximum_on_circle(edge, |_| true).filter(|&maximum| plane.name(maximum) == name);
        }
        edge = plane.turn(edge);
        if edge == out {
            return None;
        }
    }
}

/// The triangles of a hole.
struct Flood<'a> {
    plane: HalfEdges<'a>,
    barrier: Order,
    /// Each as a half-edge with the triangle on its left.
    triangles: Vec<HalfEdge>,
    /// The numbers of these triangles.
    seen: NumberSet,
}

impl Flood<'_> {
    fn reach(&mut self, face: HalfEdge) {
        if self.seen.insert(self.plane.face_number(face)) {
            self.triangles.push(face);
        }
    }

    /// Whether the triangles on both sides of an edge are in one basin, or the edge comes before the critical edge.
    fn is_crossed(&self, edge: HalfEdge) -> bool {
        let twin = self.plane.twin(edge);
        let [a, b] = self.plane.ends(edge).map(|site| site.0);
        is_before(order([a, b]), self.barrier)
            || self.plane.flows(edge)
            || !self.plane.is_outer(twin) && self.plane.flows(twin)
    }

    /// Whether the hole ends across a half-edge of one of its triangles.
    fn is_boundary(&self, edge: HalfEdge) -> bool {
        let twin = self.plane.twin(edge);
        self.plane.is_outer(twin) || !self.seen.contains(self.plane.face_number(twin))
    }

    fn walks(&self) -> Walks {
        let mut passed = NumberSet::default();
        let mut walks = Vec::new();
        for edge in self.triangles.iter().flat_map(|&face| self.plane.around(face)) {
            if self.is_boundary(edge) && !passed.contains(self.plane.edge_number(edge)) {
                walks.push(self.walk(edge, &mut passed));
            }
        }
        // The outer walk contains the smallest vertex of all.
        walks.sort_unstable_by_key(|walk| step(walk, 0));
        walks
    }

    /// Walks along the boundary with the hole on the left, until back at `first`.
    fn walk(&self, first: HalfEdge, passed: &mut NumberSet) -> Vec<Located<Slot>> {
        let mut walk = Vec::new();
        let mut edge = first;
        loop {
            passed.insert(self.plane.edge_number(edge));
            walk.push(self.plane.origin(edge));
            edge = self.turn(edge);
            if edge == first {
                break;
            }
        }
        let smallest = (0..walk.len()).min_by_key(|&place| step(&walk, place)).unwrap_or(0);
        walk.rotate_left(smallest);
        walk
    }

    /// The next boundary edge around the end of an edge. Crosses the triangles of the hole there.
    fn turn(&self, edge: HalfEdge) -> HalfEdge {
        let mut next = self.plane.next(edge);
        while !self.is_boundary(next) {
            next = self.plane.next(self.plane.twin(next));
        }
        next
    }
}

/// The begin and the end of the step at `place` of a walk.
fn step(walk: &[Located<Slot>], place: usize) -> [Position; 2] {
    [walk[place], walk[(place + 1) % walk.len()]].map(|site| site.0)
}

/// The squared scale and the ends of a Gabriel edge, by position: its place in the total order.
type Order = (f64, [Position; 2]);

fn order([a, b]: [Position; 2]) -> Order {
    let [a, b] = if b < a { [b, a] } else { [a, b] };
    (half_length_squared(a, b), [a, b])
}

/// Whether an edge comes before another one in the order of the reduction, which is DEcreasing.
fn is_before(a: Order, b: Order) -> bool {
    a.0 > b.0 || a.0 == b.0 && a.1 > b.1
}

/// A set of numbers.
#[derive(Debug, Default)]
struct NumberSet(HashTable<u32>);

impl NumberSet {
    /// Adds a number; returns false if it was there.
    fn insert(&mut self, number: u32) -> bool {
        let is_new = !self.contains(number);
        if is_new {
            self.0.insert_unique(mix(number), number, |&number| mix(number));
        }
        is_new
    }

    fn contains(&self, number: u32) -> bool {
        self.0.find(mix(number), |&other| other == number).is_some()
    }
}

/// Spreads the bits of small numbers over all 64 bits, as the table needs it.
fn mix(number: u32) -> u64 {
    let mixed = u64::from(number).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    mixed ^ (mixed >> 32)
}

#[cfg(test)]
mod tests {
    use std::cmp::Ordering;

    use proptest::prelude::*;

    use super::*;
    use crate::topology::plane::cocircular::by_position;
    use crate::topology::plane::geometry::{acuteness, circumradius_squared};
    use crate::topology::stages::{Basins, Filtration};
    use crate::topology::testing::{Points, clouds, clouds_twice, lattice, points_of, ring};
    use crate::topology::{Cloud, Dot, Edge, Killer, Skeleton, Window};

    type Paths = Vec<Vec<[f64; 2]>>;

    fn triangle(dot: &Dot) -> [u32; 3] {
        let Killer::Triangle(corners) = dot.killer else { panic!("triangles of the plane kill dots: {dot:?}") };
        corners
    }

    /// A cloud with its triangulation and skeleton.
    struct Scene {
        delaunay: Delaunay,
        /// The slot of each vertex of the skeleton.
        slots: Vec<Slot>,
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
            let slots: Vec<Slot> = cloud.vertices().map(|(slot, _)| slot).collect();
            assert!(slots.iter().zip(skeleton.vertices().ids()).all(|(&slot, &id)| cloud.id(slot) == id));
            Self { delaunay, slots, skeleton }
        }

        fn at(&self, vertex: u32) -> Position {
            Position::of_vertex(self.skeleton.vertices().xy(vertex))
        }

        fn flood(&self, dot: &Dot) -> Option<Flood<'_>> {
            let site = |vertex: u32| (self.at(vertex), self.slots[vertex as usize]);
            flood(&self.delaunay, triangle(dot).map(site), dot.edge.map(|vertex| self.at(vertex)))
        }

        /// The corners of all triangles.
        fn faces(&self, dot: &Dot) -> Vec<[Position; 3]> {
            let Some(flood) = self.flood(dot) else { return Vec::new() };
            let corners = |&face: &HalfEdge| by_position(flood.plane.corners(face)).map(|site| site.0);
            flood.triangles.iter().map(corners).collect()
        }

        /// By places in the skeleton's list of vertices.
        fn boundary(&self, dot: &Dot) -> Vec<Vec<u32>> {
            let place = |site: Located<Slot>| self.slots.iter().position(|&slot| slot == site.1).unwrap() as u32;
            let walks = self.flood(dot).map_or(Vec::new(), |flood| flood.walks());
            walks.into_iter().map(|walk| walk.into_iter().map(place).collect()).collect()
        }

        fn walks(&self, dot: &Dot) -> Paths {
            let place = |walk: Vec<u32>| walk.into_iter().map(|vertex| self.at(vertex).xy()).collect();
            self.boundary(dot).into_iter().map(place).collect()
        }

        /// Whether no point is inside the smallest circle around an edge.
        fn is_gabriel(&self, [a, b]: Edge) -> bool {
            let outside = |vertex: u32| acuteness(self.at(a), self.at(vertex), self.at(b)).is_ge();
            (0..self.slots.len() as u32).all(|vertex| [a, b].contains(&vertex) || outside(vertex))
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

    /// The winding number of a walk around a point, counter-clockwise.
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
        assert_eq!(square.faces(dot).len(), 2);
    }

    #[test]
    fn an_acute_triangle_is_a_hole_and_others_are_none() {
        let acute = Scene::new(&[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]);
        assert_eq!(acute.walks(&acute.skeleton.dots()[0]), [[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0]]]);
        let right = Scene::new(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]);
        assert_eq!(right.skeleton.dots(), []);
    }

    #[test]
    fn clouds_without_holes_have_no_boundaries() {
        for points in [&[][..], &[[1.0, 2.0]], &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]]] {
            let scene = Scene::new(points);
            assert_eq!(scene.skeleton.dots(), []);
            let site = |x: f64| (Position::new(x, 0.0).unwrap(), 0);
            assert_eq!(boundary(&scene.delaunay, [0.0, 1.0, 2.0].map(site), [site(0.0).0, site(1.0).0]), None);
        }
    }

    #[test]
    fn unknown_dots_have_no_hole() {
        let scene = Scene::new(&ring(12, 5.0));
        let [dot] = scene.skeleton.dots() else { panic!("one dot") };
        assert_eq!(scene.faces(dot).len(), 10);
        let site = |vertex: u32| (scene.at(vertex), scene.slots[vertex as usize]);
        let critical = dot.edge.map(|vertex| scene.at(vertex));
        let (mut moved, mut other) = (triangle(dot).map(site), triangle(dot).map(site));
        moved[0].0 = Position::new(7.0, 8.0).unwrap();
        other[2] = site((0..12).find(|vertex| !triangle(dot).contains(vertex)).unwrap());
        for name in [moved, other] {
            assert!(flood(&scene.delaunay, name, critical).is_none());
        }
        // With a barrier below all edges, the hole is open to the outer face.
        assert!(flood(&scene.delaunay, triangle(dot).map(site), [critical[0], critical[0]]).is_none());
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
        let points = points_of(include_str!("../../../../tests/cases/cocirc_r65.csv"));
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
        let theta = Scene::new(&points_of(include_str!("../../../../tests/cases/theta_n250_e0.03.csv")));
        for dot in &theta.skeleton.dots()[..2] {
            let walks = theta.walks(dot);
            assert!(walks[0].len() > 40 && area(&walks[0]) > 0.5, "{} {}", walks[0].len(), area(&walks[0]));
            assert_eq!(winding(theta.skeleton.hole(dot).unwrap().center, &walks[0]), 1);
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
        // The inner ring has the longer steps, and its hole is the larger one. The hole around it therefore opens to
        // the inside.
        points.extend(ring(32, 7.0).into_iter().map(|[x, y]| [x + 0.01, y]));
        let scene = Scene::new(&points);
        let around = scene.skeleton.dots().iter().find(|dot| (1.4..1.7).contains(&dot.death)).unwrap();
        let walks = scene.boundary(around);
        assert_eq!(walks.iter().map(Vec::len).collect::<Vec<_>>(), [60, 32]);
        let on = |walk: &[u32]| steps(walk).any(|[a, b]| [a.min(b), a.max(b)] == around.edge);
        assert_eq!([on(&walks[0]), on(&walks[1])], [false, true]);
    }

    #[test]
    fn a_wheel_is_taken_apart_spoke_by_spoke() {
        let mut points = ring(40, 5.0);
        points.push([0.0, 0.0]);
        let scene = Scene::new(&points);
        let sizes: Vec<usize> = scene.skeleton.dots().iter().map(|dot| scene.faces(dot).len()).collect();
        assert_eq!((sizes.len(), sizes.iter().max()), (40, Some(&40)));
    }

    proptest! {
        #[test]
        fn boundaries_are_closed_walks_of_short_edges(points in clouds()) {
            let scene = Scene::new(&points);
            for dot in scene.skeleton.dots() {
                let walks = scene.boundary(dot);
                let mut passed: Vec<Edge> = walks.iter().flat_map(|walk| steps(walk)).collect();
                for &[a, b] in &passed {
                    prop_assert!(scene.is_gabriel([a, b]));
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
                let center = scene.skeleton.hole(dot).unwrap().center;
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
            for dot in scene.skeleton.dots() {
                let triangle = |face: [Position; 3]| area(&face.map(Position::xy)).abs();
                let triangles: f64 = scene.faces(dot).into_iter().map(triangle).sum();
                let walks: f64 = scene.walks(dot).iter().map(|walk| area(walk)).sum();
                prop_assert!((triangles - walks).abs() <= 1e-9 * triangles, "{triangles} {walks}");
            }
        }

        /// The triangle that names the death is filled last of a hole's triangles. Holes that meet are nested.
        #[test]
        fn a_hole_is_filled_at_its_death(points in clouds()) {
            let scene = Scene::new(&points);
            let all: Vec<Vec<[Position; 3]>> = scene.skeleton.dots().iter().map(|dot| scene.faces(dot)).collect();
            for (faces, dot) in all.iter().zip(scene.skeleton.dots()) {
                let last = faces.iter().map(|&face| circumradius_squared(face).sqrt()).fold(0.0, f64::max);
                // A face with more sites on its circle may be cut in another way than for its name.
                prop_assert!((last - dot.death).abs() <= 1e-12 * dot.death, "{last} {}", dot.death);
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
                let mut all: Vec<Paths> = scene.skeleton.dots().iter().map(|dot| scene.walks(dot)).collect();
                all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
                all
            });
            prop_assert_eq!(a, b);
        }
    }
}
