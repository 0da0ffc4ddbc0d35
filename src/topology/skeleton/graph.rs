//! The graph of a skeleton, and the shortest cycle of each critical edge in it.
//!
//! In: a [`Skeleton`] of any space, and a number for each of its vertices.
//! Out: the numbers of the vertices of a cycle: a critical edge, closed by the shortest path in the tree and in the
//! critical edges that come before it.
//! Invariants: critical edges come in order of (half-length, smaller end, larger end), ends by their numbers. Of paths
//! of equal length the one with the fewest edges is taken, then the one whose vertices, from the larger end of the
//! critical edge on, have the smallest numbers.
//! Must not know: what the numbers stand for, how skeletons are found, views.
//!
//! Cost: Dijkstra's algorithm from one end of the critical edge, as far as the other end is.

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashMap};

use super::hopes::{Edge, Skeleton};

/// The graph of a skeleton.
#[derive(Clone, Debug)]
pub struct SkeletonGraph {
    /// For each vertex, where its edges begin in `spokes`; and their number at the end.
    first: Vec<u32>,
    /// The edges, from each of their ends.
    spokes: Vec<Spoke>,
}

/// An edge, from one of its ends.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    to: u32,
    half_length: f64,
    is_critical: bool,
}

/// How far a vertex is: half the length of the path to it, the number of its edges, the vertex before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Far {
    half_length: f64,
    edges: u32,
    before: u32,
}

impl Eq for Far {}

impl PartialOrd for Far {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Far {
    fn cmp(&self, other: &Self) -> Ordering {
        self.half_length.total_cmp(&other.half_length).then((self.edges, self.before).cmp(&(other.edges, other.before)))
    }
}

impl SkeletonGraph {
    /// Reads the graph of a skeleton in linear time. `number` gives the vertex at each place in
    /// [`Skeleton::vertices`] another number below `count`.
    pub fn new(skeleton: &Skeleton, count: usize, number: impl Fn(u32) -> u32) -> Self {
        let tree = skeleton.scaled_tree().map(|(edge, half_length)| (edge, half_length, false));
        let critical = skeleton.unsorted_dots().iter().map(|dot| (dot.edge, dot.birth, true));
        let edges: Vec<(Edge, f64, bool)> = tree
            .chain(critical)
            .map(|(edge, half_length, is_critical)| (edge.map(&number), half_length, is_critical))
            .collect();
        let mut first = vec![0_u32; count + 1];
        edges.iter().flat_map(|(edge, ..)| edge).for_each(|&end| first[end as usize] += 1);
        let mut total = 0;
        for count in &mut first {
            total += *count;
            *count = total;
        }
        let mut spokes = vec![Spoke { to: 0, half_length: 0.0, is_critical: false }; 2 * edges.len()];
        for &([a, b], half_length, is_critical) in &edges {
            for (from, to) in [(a, b), (b, a)] {
                // Filled from behind, so that in the end it says where the edges begin.
                first[from as usize] -= 1;
                spokes[first[from as usize] as usize] = Spoke { to, half_length, is_critical };
            }
        }
        Self { first, spokes }
    }

    /// The shortest cycle of a critical edge, from its larger end to its smaller one.
    pub fn cycle(&self, edge: Edge, birth: f64) -> Vec<u32> {
        let [start, end] = [edge[0].min(edge[1]), edge[0].max(edge[1])];
        let reached = self.explore([start, end], birth);
        let mut cycle = vec![end];
        let mut at = end;
        while let Some(far) = reached.get(&at).filter(|_| at != start) {
            at = far.before;
            cycle.push(at);
        }
        cycle
    }

    /// How far the vertices around the smaller end of a critical edge are, up to the other end.
    fn explore(&self, [start, end]: Edge, birth: f64) -> HashMap<u32, Far> {
        let here = Far { half_length: 0.0, edges: 0, before: start };
        let mut reached = HashMap::from([(start, here)]);
        let mut queue = BinaryHeap::from([Reverse((here, start))]);
        while let Some(Reverse((far, vertex))) = queue.pop() {
            if vertex == end {
                break;
            }
            if reached[&vertex] != far {
                continue;
            }
            for spoke in self.spokes(vertex) {
                if spoke.is_critical && !is_before(vertex, spoke, [start, end], birth) {
                    continue;
                }
                let half_length = far.half_length + spoke.half_length;
                let next = Far { half_length, edges: far.edges + 1, before: vertex };
                if reached.get(&spoke.to).is_none_or(|known| next < *known) {
                    reached.insert(spoke.to, next);
                    queue.push(Reverse((next, spoke.to)));
                }
            }
        }
        reached
    }

    fn spokes(&self, vertex: u32) -> &[Spoke] {
        let [from, to] = [vertex, vertex + 1].map(|place| self.first[place as usize] as usize);
        &self.spokes[from..to]
    }
}

/// Whether a critical edge comes before another one.
fn is_before(from: u32, spoke: &Spoke, edge: Edge, birth: f64) -> bool {
    let ends = [from.min(spoke.to), from.max(spoke.to)];
    spoke.half_length.total_cmp(&birth).then(ends.cmp(&edge)).is_lt()
}
