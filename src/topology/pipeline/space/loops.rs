//! The short loops through a vertex, of different kinds.
//!
//! In: points of R^d, a vertex, how long a step and a loop may be.
//! Out: closed walks through the vertex, the shortest first.
//! Invariants: each is two shortest paths from the vertex, closed by a step. At a quarter the two paths are apart: else
//! the loop is filled, or goes a long way to another one and back. Halfway those of two loops are apart: else the loops
//! are alike. It is not known whether they are of different classes.
//! Must not know: tracks, classes.
//!
//! The shortest loop through a vertex in each class but zero is closed so by one step (Horton 1987). Of all these loops
//! only the first of each kind are taken, as geometry tells them apart; classes are asked for later.
//!
//! Cost: Dijkstra's algorithm as far as half the length of a loop, and a comparison for each step there.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::topology::metric::space::{Distances, Points};

/// So many loops are taken at most.
const MOST: usize = 8;

/// What loops are looked for.
#[derive(Clone, Copy, Debug)]
pub struct LoopSearch {
    /// The longest step.
    pub step: f64,
    /// The least length between two paths that are apart.
    pub apart: f64,
    /// The longest loop: the sum of its steps, by radii.
    pub longest: f64,
}

/// A loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// Its vertices.
    pub vertices: Vec<u32>,
    /// The sum of its steps, by radii.
    pub extent: f64,
}

/// A loop by the ends of the step that closes it.
#[derive(Clone, Copy, Debug)]
struct Closing {
    extent: f64,
    ends: [u32; 2],
}

/// The shortest paths from a vertex.
struct Paths<'a> {
    points: &'a Points,
    wanted: LoopSearch,
    /// How far each vertex is; +infinity if it is not reached.
    far: Vec<f64>,
    /// The vertex before each one that is reached.
    before: Vec<u32>,
    /// The vertices on the way to each one that is settled: at a quarter, and halfway.
    passed: Vec<Option<[u32; 2]>>,
    found: Vec<Closing>,
}

/// Loops through a vertex, the shortest first.
pub fn loops(points: &Points, through: u32, wanted: LoopSearch) -> Vec<Loop> {
    let mut row = vec![0.0; points.count()];
    points.lengths(through, 0, &mut row);
    // No loop leaves this ball.
    let is_near = |&vertex: &u32| 2.0 * points.radius(row[vertex as usize]) <= wanted.longest;
    let near: Vec<u32> = (0..row.len() as u32).filter(is_near).collect();
    let through = near.partition_point(|&vertex| vertex < through) as u32;
    let points = points.subset(&near);
    let count = points.count();
    let (far, before, passed) = (vec![f64::INFINITY; count], vec![through; count], vec![None; count]);
    let mut paths = Paths { points: &points, wanted, far, before, passed, found: Vec::new() };
    paths.explore(through);
    let named = |closing: Closing| {
        let around = paths.around(through, closing.ends).into_iter();
        Loop { vertices: around.map(|vertex| near[vertex as usize]).collect(), extent: closing.extent }
    };
    paths.kinds().into_iter().map(named).collect()
}

impl Paths<'_> {
    fn explore(&mut self, through: u32) {
        self.far[through as usize] = 0.0;
        // The bits of numbers that are not negative are in their order.
        let mut queue = BinaryHeap::from([Reverse((0_u64, through))]);
        let mut row = vec![0.0; self.points.count()];
        while let Some(Reverse((far, vertex))) = queue.pop() {
            if self.passed[vertex as usize].is_some() {
                continue;
            }
            self.passed[vertex as usize] = Some([0.25, 0.5].map(|share| self.at(share, vertex)));
            self.points.lengths(vertex, 0, &mut row);
            for (&length, next) in row.iter().zip(0..) {
                if length <= self.wanted.step && next != vertex {
                    let to = f64::from_bits(far) + self.points.radius(length);
                    if self.reach(vertex, next, to) {
                        queue.push(Reverse((to.to_bits(), next)));
                    }
                }
            }
        }
    }

    /// Goes along a step. Returns whether it is a shorter path; a step between settled vertices closes a loop.
    fn reach(&mut self, vertex: u32, next: u32, to: f64) -> bool {
        if let (Some([a, _]), Some([b, _])) = (self.passed[vertex as usize], self.passed[next as usize]) {
            let extent = to + self.far[next as usize];
            if extent <= self.wanted.longest && !self.are_near(a, b) {
                self.found.push(Closing { extent, ends: [next, vertex] });
            }
            return false;
        }
        let is_shorter = to < self.far[next as usize] && 2.0 * to <= self.wanted.longest;
        if is_shorter {
            (self.far[next as usize], self.before[next as usize]) = (to, vertex);
        }
        is_shorter
    }

    /// The vertex at a share of the path to another one.
    fn at(&self, share: f64, vertex: u32) -> u32 {
        let far = share * self.far[vertex as usize];
        let mut at = vertex;
        while self.far[at as usize] > far {
            at = self.before[at as usize];
        }
        at
    }

    fn are_near(&self, a: u32, b: u32) -> bool {
        self.points.length(a, b) <= self.wanted.apart
    }

    /// The first loops of different kinds.
    fn kinds(&self) -> Vec<Closing> {
        let mut found = self.found.clone();
        found.sort_unstable_by(|a, b| a.extent.total_cmp(&b.extent).then(a.ends.cmp(&b.ends)));
        let mut kinds: Vec<(Closing, [u32; 2])> = Vec::new();
        for closing in found {
            let [a, b] = closing.ends.map(|end| self.passed[end as usize].map_or(end, |[_, middle]| middle));
            let is_like = |&(_, [c, d]): &(Closing, [u32; 2])| {
                self.are_near(a, c) && self.are_near(b, d) || self.are_near(a, d) && self.are_near(b, c)
            };
            if !kinds.iter().any(is_like) {
                kinds.push((closing, [a, b]));
            }
            if kinds.len() == MOST {
                break;
            }
        }
        kinds.into_iter().map(|(closing, _)| closing).collect()
    }

    /// The loop that a step between two vertices closes.
    fn around(&self, through: u32, [a, b]: [u32; 2]) -> Vec<u32> {
        let back = |from: u32| {
            let before = |&vertex: &u32| (vertex != through).then(|| self.before[vertex as usize]);
            std::iter::successors(Some(from), before)
        };
        let mut around: Vec<u32> = back(a).collect();
        let there = around.len();
        around.extend(back(b).filter(|&vertex| vertex != through));
        around[there..].reverse();
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::metric::space::Metric;

    /// Loops through a point of a cloud that are at most so long.
    fn found(cloud: &[[f64; 2]], through: usize, step: f64, longest: f64) -> Vec<Vec<[f64; 2]>> {
        let points = Points::new(Metric::Euclidean, 2, cloud.as_flattened()).unwrap();
        let place = |vertex: u32| cloud[points.rows()[vertex as usize] as usize];
        let step = points.longest(0.5 * step);
        let wanted = LoopSearch { step, apart: step, longest: 0.5 * longest };
        let found = loops(&points, points.vertices()[through], wanted);
        found.into_iter().map(|found| found.vertices.into_iter().map(place).collect()).collect()
    }

    /// The border of a rectangle from (0,0), in steps of 1, from the origin.
    fn border(width: i32, height: i32) -> Vec<[f64; 2]> {
        let lower = (0..width).map(|x| (x, 0)).chain((0..height).map(|y| (width, y)));
        let upper = (0..width).map(|x| (width - x, height)).chain((0..height).map(|y| (0, height - y)));
        lower.chain(upper).map(|(x, y)| [f64::from(x), f64::from(y)]).collect()
    }

    #[test]
    fn a_ring_has_one_loop_if_it_is_not_too_long() {
        let ring = border(5, 4);
        let all = found(&ring, 3, 1.0, 18.0);
        assert_eq!(all.len(), 1);
        let mut vertices = all[0].clone();
        vertices.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut expected = ring.clone();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(vertices, expected);
        // Each vertex is a step away from the next one.
        for (a, b) in all[0].iter().zip(all[0].iter().cycle().skip(1)) {
            assert_eq!((a[0] - b[0]).abs() + (a[1] - b[1]).abs(), 1.0);
        }
        assert!(found(&ring, 3, 1.0, 17.9).is_empty());
        assert!(found(&ring, 3, 0.9, 18.0).is_empty());
    }

    #[test]
    fn two_rings_with_a_common_side_have_two_loops_and_one_around_both() {
        let mut cloud = border(8, 4);
        cloud.extend((1..4).map(|y| [4.0, f64::from(y)]));
        // From (4,0), where they meet.
        let lengths = |longest| found(&cloud, 4, 1.0, longest).iter().map(Vec::len).collect::<Vec<usize>>();
        assert_eq!(lengths(16.0), [16, 16]);
        assert_eq!(lengths(15.0), [] as [usize; 0]);
    }

    #[test]
    fn a_filled_square_has_none() {
        let grid: Vec<[f64; 2]> = (0..36).map(|at| [f64::from(at % 6), f64::from(at / 6)]).collect();
        assert!(found(&grid, 0, 1.5, 20.0).is_empty());
    }
}
