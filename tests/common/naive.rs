//! HoPeS by its definitions, for a dozen points: all pairs, all triples, a boundary matrix over GF(2).
//!
//! It uses no triangulations, flows or duals. An empty circle through three or more points is taken with all its
//! points, and divided into the fan around the smallest one.

use robust::Coord;

use super::by_position::in_order;
use super::clouds::{Point, distinct};

/// A circle through at least three points with no point inside.
pub struct EmptyCircle {
    /// All points on it, sorted by position.
    pub on: Vec<Point>,
    pub radius: f64,
}

/// A dot by its definition.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct NaiveDot {
    pub edge: [Point; 2],
    pub birth: f64,
    pub death: f64,
}

pub struct Naive {
    pub points: Vec<Point>,
    pub circles: Vec<EmptyCircle>,
    /// Sorted by ends.
    pub tree: Vec<[Point; 2]>,
    /// Sorted by edges.
    pub dots: Vec<NaiveDot>,
}

impl Naive {
    pub fn new(cloud: &[Point]) -> Self {
        let points = distinct(cloud);
        let circles = empty_circles(&points);
        let tree = kruskal(&points);
        let dots = persistence(&points, &circles);
        Self { points, circles, tree, dots }
    }
}

/// All pairs of points, sorted by (length, smaller end, larger end): the total order.
pub fn pairs(points: &[Point]) -> Vec<[Point; 2]> {
    let mut pairs: Vec<(f64, [Point; 2])> = Vec::new();
    for (index, &a) in points.iter().enumerate() {
        pairs.extend(points[index + 1..].iter().map(|&b| (length_squared(a, b), [a, b])));
    }
    in_order(pairs).into_iter().map(|(_, pair)| pair).collect()
}

fn kruskal(points: &[Point]) -> Vec<[Point; 2]> {
    let mut components = Components::new(points);
    in_order(pairs(points).into_iter().filter(|&[a, b]| components.join(a, b)).collect())
}

/// Connected components of a graph on points, computed naively.
pub struct Components {
    label: Vec<(Point, usize)>,
}

impl Components {
    pub fn new(points: &[Point]) -> Self {
        Self { label: points.iter().copied().zip(0..).collect() }
    }

    fn of(&self, point: Point) -> usize {
        self.label.iter().find(|(at, _)| *at == point).expect("a point of the cloud").1
    }

    /// Joins two components. Returns whether they were different.
    pub fn join(&mut self, a: Point, b: Point) -> bool {
        let (a, b) = (self.of(a), self.of(b));
        for (_, label) in self.label.iter_mut().filter(|(_, label)| *label == b) {
            *label = a;
        }
        a != b
    }

    pub fn count(&self) -> usize {
        let mut labels: Vec<usize> = self.label.iter().map(|(_, label)| *label).collect();
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }
}

pub fn length_squared([ax, ay]: Point, [bx, by]: Point) -> f64 {
    (ax - bx) * (ax - bx) + (ay - by) * (ay - by)
}

pub fn half_length([a, b]: [Point; 2]) -> f64 {
    length_squared(a, b).sqrt() / 2.0
}

/// The product of the sides divided by four times the area.
pub fn circumradius([a, b, c]: [Point; 3]) -> f64 {
    let area = robust::orient2d(coord(a), coord(b), coord(c)).abs() / 2.0;
    (length_squared(a, b) * length_squared(b, c) * length_squared(c, a)).sqrt() / (4.0 * area)
}

/// The scalar product of the vectors from `apex` to the ends. It is negative if the angle is obtuse, and 0 if it is
/// right.
pub fn scalar_product(apex: Point, [a, b]: [Point; 2]) -> f64 {
    (a[0] - apex[0]) * (b[0] - apex[0]) + (a[1] - apex[1]) * (b[1] - apex[1])
}

fn coord([x, y]: Point) -> Coord<f64> {
    Coord { x, y }
}

fn empty_circles(points: &[Point]) -> Vec<EmptyCircle> {
    let mut circles: Vec<EmptyCircle> = Vec::new();
    for (i, &a) in points.iter().enumerate() {
        for (j, &b) in points.iter().enumerate().skip(i + 1) {
            for &c in &points[j + 1..] {
                let turn = robust::orient2d(coord(a), coord(b), coord(c));
                if turn == 0.0 || circles.iter().any(|circle| [a, b, c].iter().all(|p| circle.on.contains(p))) {
                    continue;
                }
                // Positive if the point is inside, for corners in counter-clockwise order.
                let inside = |p: Point| robust::incircle(coord(a), coord(b), coord(c), coord(p)) * turn.signum();
                if points.iter().all(|&p| inside(p) <= 0.0) {
                    let on = points.iter().copied().filter(|&p| inside(p) == 0.0).collect();
                    circles.push(EmptyCircle { on, radius: circumradius([a, b, c]) });
                }
            }
        }
    }
    circles
}

/// The fan of a circle's points around the smallest.
fn fan(on: &[Point]) -> Vec<[Point; 3]> {
    let (&apex, around) = on.split_first().expect("a circle has points");
    let mut around = around.to_vec();
    // The apex is the smallest point by x, then y. Seen from it, slopes cover half a turn.
    around.sort_by(|&a, &b| 0.0.partial_cmp(&robust::orient2d(coord(apex), coord(a), coord(b))).expect("a number"));
    around.windows(2).map(|pair| in_order([apex, pair[0], pair[1]])).collect()
}

/// The 1-dimensional persistence diagram of the alpha filtration, by the reduction of its boundary matrix.
fn persistence(points: &[Point], circles: &[EmptyCircle]) -> Vec<NaiveDot> {
    let mut triangles: Vec<(f64, [Point; 3])> = Vec::new();
    for circle in circles {
        triangles.extend(fan(&circle.on).into_iter().map(|triangle| (circle.radius, triangle)));
    }
    let triangles = in_order(triangles);
    let in_closed_disc = |p: Point, edge| scalar_product(p, edge) <= 0.0;
    let is_gabriel = |edge: [Point; 2]| !points.iter().any(|&p| !edge.contains(&p) && in_closed_disc(p, edge));
    let radius_beside = |edge: [Point; 2]| {
        triangles.iter().find(|(_, triangle)| edge.iter().all(|end| triangle.contains(end))).map(|&(radius, _)| radius)
    };
    let enter = |edge: [Point; 2]| {
        if is_gabriel(edge) { Some(half_length(edge)) } else { radius_beside(edge) }
    };
    // The sort is stable: edges of equal scales keep the order of lengths and ends.
    let mut edges: Vec<([Point; 2], f64)> =
        pairs(points).into_iter().filter_map(|edge| Some((edge, enter(edge)?))).collect();
    edges.sort_by(|a, b| a.1.total_cmp(&b.1));
    assert!(edges.len() <= 128, "a column of the boundary matrix has 128 bits");

    let place = |edge: [Point; 2]| edges.iter().position(|(other, _)| *other == edge).expect("an edge of a triangle");
    let mut columns: Vec<u128> = Vec::new();
    let mut dots = Vec::new();
    for &(death, [a, b, c]) in &triangles {
        let mut column = [[a, b], [b, c], [a, c]].into_iter().fold(0, |column, edge| column ^ 1_u128 << place(edge));
        while let Some(other) = columns.iter().find(|other| other.leading_zeros() == column.leading_zeros()) {
            column ^= other;
        }
        assert_ne!(column, 0, "triangles in the plane enclose nothing");
        let (edge, birth) = edges[column.ilog2() as usize];
        columns.push(column);
        if death - birth > 1e-9 * death {
            dots.push(NaiveDot { edge, birth, death });
        }
    }
    in_order(dots)
}
