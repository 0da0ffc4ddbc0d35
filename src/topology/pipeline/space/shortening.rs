//! Closed walks made shorter within their homology class.
//!
//! In: closed walks along edges up to a length, of points in R^d.
//! Out: shorter ones of the same class at that length.
//! Invariant: what is exchanged bounds triangles whose sides are at most that long.
//! Must not know: tracks, how classes are found.
//!
//! Let a, b, c follow each other. If b' is joined to all of them, the triangles a b b' and b c b' are filled, and b may
//! be exchanged for b'; if a and c are joined, b may be left out. Each vertex is moved to where the squares of the
//! distances to its neighbours have the least sum: a walk becomes a closed geodesic, frame by frame.

use crate::topology::metric::rips::ClosedWalk;
use crate::topology::metric::space::{Distances, Points};

/// A vertex is moved if that saves at least this share of the sum of squares.
const WORTH: f64 = 1e-6;

/// Makes walks in one space shorter.
pub struct Shortening<'a> {
    points: &'a Points,
    /// The squares of the lengths from three consecutive vertices to all.
    rows: [Vec<f64>; 3],
}

impl<'a> Shortening<'a> {
    /// For walks in a space.
    pub fn new(points: &'a Points) -> Self {
        let row = || vec![0.0; points.count()];
        Self { points, rows: [row(), row(), row()] }
    }

    /// Makes a walk shorter, moving each vertex at most so many times. Vertices are left out where no step becomes
    /// longer than `step`.
    pub fn shorten(&mut self, walk: &mut ClosedWalk, step: f64, times: usize) {
        for _ in 0..times {
            self.leave_out(walk, step);
            if !self.relocate(walk) {
                break;
            }
        }
        self.leave_out(walk, step);
    }

    /// Divides steps that are longer than `step`. A step that is too long to be one may become two that are.
    pub fn divide(&mut self, walk: &mut ClosedWalk, step: f64) {
        let mut divided: Vec<u32> = Vec::with_capacity(walk.vertices.len());
        for (at, &a) in walk.vertices.iter().enumerate() {
            divided.push(a);
            let c = walk.vertices[(at + 1) % walk.vertices.len()];
            if self.points.length(a, c) > step {
                self.fill(0, a);
                self.fill(2, c);
                divided.extend(self.between(self.rows[0][c as usize], walk.length));
            }
        }
        walk.vertices = divided;
    }

    /// The vertex nearest to the middle of a step, given the square of that: at most `longest` away from both ends, and
    /// so that the squares of both parts have a smaller sum.
    fn between(&self, square: f64, longest: f64) -> Option<u32> {
        let [a, _, c] = &self.rows;
        let longest = self.square(longest);
        let sums = a.iter().zip(c).zip(0..).filter(|((a, c), _)| a.max(**c) <= longest);
        let best = sums.map(|((a, c), place)| (a + c, place)).min_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|&(sum, _)| sum < square).map(|(_, place)| place)
    }

    /// Leaves out vertices whose neighbours are at most so far apart.
    fn leave_out(&self, walk: &mut ClosedWalk, step: f64) {
        let mut kept: Vec<u32> = Vec::with_capacity(walk.vertices.len());
        for &vertex in &walk.vertices {
            while let [.., a, _] = kept[..]
                && self.points.length(a, vertex) <= step
            {
                kept.pop();
            }
            kept.push(vertex);
        }
        // Around the seam.
        while let [a, .., b, _] = kept[..]
            && self.points.length(a, b) <= step
        {
            kept.pop();
        }
        while let [_, a, .., b] = kept[..]
            && self.points.length(a, b) <= step
        {
            kept.remove(0);
        }
        walk.vertices = kept;
    }

    /// Moves each vertex of a walk, one after the other. Returns whether one was moved.
    fn relocate(&mut self, walk: &mut ClosedWalk) -> bool {
        let count = walk.vertices.len();
        let mut is_moved = false;
        for at in 0..count {
            let three = [at + count - 1, at, at + 1].map(|at| walk.vertices[at % count]);
            if at == 0 || count < 3 {
                (0..3).for_each(|row| self.fill(row, three[row]));
            } else {
                self.rows.rotate_left(1);
                self.fill(2, three[2]);
            }
            if let Some(place) = self.better(three[1], walk.length) {
                walk.vertices[at] = place;
                self.fill(1, place);
                is_moved = true;
            }
        }
        is_moved
    }

    /// The vertex to be taken between the neighbours of one.
    fn better(&self, vertex: u32, longest: f64) -> Option<u32> {
        let [a, b, c] = &self.rows;
        let longest = self.square(longest);
        let worth = (1.0 - WORTH) * (a[vertex as usize] + c[vertex as usize]);
        let (mut best, mut least) = (None, worth);
        for (place, ((&a, &b), &c)) in a.iter().zip(b).zip(c).enumerate() {
            if a + c < least && a <= longest && b <= longest && c <= longest {
                (best, least) = (Some(place as u32), a + c);
            }
        }
        best
    }

    fn fill(&mut self, row: usize, vertex: u32) {
        self.points.lengths(vertex, 0, &mut self.rows[row]);
        if !self.points.metric().is_squared() {
            self.rows[row].iter_mut().for_each(|length| *length *= *length);
        }
    }

    /// The square of the distance of a length, up to a factor.
    fn square(&self, length: f64) -> f64 {
        if self.points.metric().is_squared() { length } else { length * length }
    }
}

/// The sum of the steps of a walk, by radii.
pub fn extent(points: &Points, walk: &ClosedWalk) -> f64 {
    steps(points, walk).map(|length| points.radius(length)).sum()
}

/// The length of the longest step of a walk.
pub fn longest_step(points: &Points, walk: &ClosedWalk) -> f64 {
    steps(points, walk).fold(0.0, f64::max)
}

fn steps(points: &Points, walk: &ClosedWalk) -> impl Iterator<Item = f64> {
    let next = walk.vertices.iter().cycle().skip(1);
    walk.vertices.iter().zip(next).map(|(&a, &b)| points.length(a, b))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::topology::metric::space::Metric;

    /// Circles of sixty points around the origin, with radii in tenths.
    fn circles(radii: std::ops::Range<u32>) -> Vec<[f64; 2]> {
        let at = |radius: u32, index: u32| {
            let angle = TAU * (f64::from(index) + 0.3 * f64::from(radius)) / 60.0;
            [angle.cos(), angle.sin()].map(|part| 0.1 * f64::from(radius) * part)
        };
        radii.flat_map(|radius| (0..60).map(move |index| at(radius, index))).collect()
    }

    /// A walk around the last of these circles.
    fn around(points: &Points) -> ClosedWalk {
        let count = points.vertices().len();
        ClosedWalk { vertices: points.vertices()[count - 60..].to_vec(), length: points.longest(0.75) }
    }

    fn space(cloud: &[[f64; 2]]) -> Points {
        Points::new(Metric::Euclidean, 2, cloud.as_flattened()).unwrap()
    }

    /// How often a walk goes around the origin.
    fn winding(cloud: &[[f64; 2]], points: &Points, walk: &ClosedWalk) -> f64 {
        let place = |vertex: u32| cloud[points.rows()[vertex as usize] as usize];
        let next = walk.vertices.iter().cycle().skip(1);
        let turn = |(&a, &b): (&u32, &u32)| {
            let ([x, y], [u, v]) = (place(a), place(b));
            (x * v - y * u).atan2(x * u + y * v)
        };
        walk.vertices.iter().zip(next).map(turn).sum::<f64>() / TAU
    }

    #[test]
    fn a_walk_around_a_hole_comes_to_its_rim_and_stays_around_it() {
        let cloud = circles(12..24);
        let points = space(&cloud);
        let mut walk = around(&points);
        assert!(extent(&points, &walk) > 7.0);
        for _ in 0..40 {
            let step = walk.length;
            Shortening::new(&points).shorten(&mut walk, step, 4);
            assert!(longest_step(&points, &walk) <= walk.length);
            assert!((winding(&cloud, &points, &walk) - 1.0).abs() < 1e-9);
        }
        // The rim is half of 2.4 pi long by radii.
        assert!(extent(&points, &walk) < 3.9, "{walk:?}");
    }

    #[test]
    fn a_walk_around_nothing_becomes_a_triangle_at_most() {
        let points = space(&circles(1..20));
        let mut walk = around(&points);
        let step = walk.length;
        Shortening::new(&points).shorten(&mut walk, step, 200);
        assert!(walk.vertices.len() <= 3, "{walk:?}");
    }

    #[test]
    fn a_long_step_is_divided_at_the_vertex_nearest_to_its_middle() {
        let points = space(&[[0.0, 0.0], [0.4, 0.1], [1.0, 0.1], [2.0, 0.0], [1.0, 5.0]]);
        // The vertices are in order of their coordinates: the far one comes before the other end.
        let mut walk = ClosedWalk { vertices: vec![0, 4, 3], length: points.longest(0.6) };
        let step = walk.length;
        Shortening::new(&points).divide(&mut walk, step);
        // No vertex is near enough to both ends of the other steps.
        assert_eq!(walk.vertices, [0, 2, 4, 3]);
    }
}
