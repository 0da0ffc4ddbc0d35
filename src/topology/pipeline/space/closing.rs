//! The cycle that is born with a dot: its critical edge, closed by the shortest path in the tree and in the critical
//! edges that come before it.
//!
//! In: a skeleton, and where its vertices stand in the order of positions; dots by their ids.
//! Out: closed walks by ids.
//! Invariants: of paths of equal length the one with the fewest edges is taken, then the one over the first vertices by
//! position. So it depends on positions alone, unlike [`ShortestCycles`](crate::topology::ShortestCycles), which needs
//! no positions.
//! Must not know: tracks.
//!
//! Cost: Dijkstra's algorithm from one end of the critical edge, as far as the other end is.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::topology::cloud::VertexId;
use crate::topology::metric::rips::Pair;
use crate::topology::skeleton::{Critical, Skeleton};

/// An edge of the skeleton by places. Its length is the scale at which it enters.
#[derive(Clone, Copy, Debug)]
struct Edge {
    pair: Pair,
    is_critical: bool,
}

/// How far a vertex is: the scales of the path to it, the number of its edges, the vertex before.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Far {
    scales: f64,
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
        self.scales.total_cmp(&other.scales).then((self.edges, self.before).cmp(&(other.edges, other.before)))
    }
}

/// The graph of a skeleton.
#[derive(Debug)]
pub struct Closing<'a> {
    /// The vertices by id, each with its place in the order of positions.
    places: &'a [(VertexId, u32)],
    ids: Vec<VertexId>,
    /// The edges at each place.
    edges: Vec<Vec<Edge>>,
}

impl<'a> Closing<'a> {
    /// Reads the graph of a skeleton whose vertices are among these, each with its place in the order of positions.
    pub fn new(skeleton: &Skeleton, places: &'a [(VertexId, u32)]) -> Self {
        let mut ids = vec![VertexId(0); places.len()];
        places.iter().for_each(|&(id, place)| ids[place as usize] = id);
        let mut closing = Self { places, ids, edges: vec![Vec::new(); places.len()] };
        let tree = skeleton.scaled_tree().map(|(edge, scale)| (edge, scale, false));
        let critical = skeleton.unsorted_dots().iter().map(|dot| (dot.edge, dot.birth, true));
        for (edge, scale, is_critical) in tree.chain(critical) {
            let [a, b] = edge.map(|end| closing.place(skeleton.vertices().id(end)));
            let pair = Pair::new(scale, a, b);
            pair.ends().iter().for_each(|&end| closing.edges[end as usize].push(Edge { pair, is_critical }));
        }
        closing
    }

    /// The cycle of a dot of the skeleton.
    pub fn cycle(&self, dot: &Critical) -> Vec<VertexId> {
        let [a, b] = dot.edge.map(|end| self.place(end));
        let critical = Pair::new(dot.birth, a, b);
        let reached = self.explore(critical);
        let mut cycle = vec![critical.b];
        let mut at = critical.b;
        while let Some(far) = reached[at as usize].filter(|_| at != critical.a) {
            at = far.before;
            cycle.push(at);
        }
        cycle.into_iter().map(|place| self.ids[place as usize]).collect()
    }

    /// How far vertices are from the smaller end of a critical edge, up to the other end.
    fn explore(&self, critical: Pair) -> Vec<Option<Far>> {
        let here = Far { scales: 0.0, edges: 0, before: critical.a };
        let mut reached: Vec<Option<Far>> = vec![None; self.ids.len()];
        reached[critical.a as usize] = Some(here);
        let mut queue = BinaryHeap::from([Reverse((here, critical.a))]);
        while let Some(Reverse((far, vertex))) = queue.pop() {
            if vertex == critical.b {
                break;
            }
            if reached[vertex as usize] != Some(far) {
                continue;
            }
            let earlier = |edge: &&Edge| !edge.is_critical || edge.pair.before(&critical);
            for edge in self.edges[vertex as usize].iter().filter(earlier) {
                let next = edge.pair.a + edge.pair.b - vertex;
                let new = Far { scales: far.scales + edge.pair.length, edges: far.edges + 1, before: vertex };
                let known = &mut reached[next as usize];
                if known.is_none_or(|known| new < known) {
                    *known = Some(new);
                    queue.push(Reverse((new, next)));
                }
            }
        }
        reached
    }

    fn place(&self, id: VertexId) -> u32 {
        self.places[self.places.partition_point(|&(other, _)| other < id)].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::cloud::Vertices;
    use crate::topology::metric::rips::Workspace;
    use crate::topology::metric::space::{Metric, Points};

    #[test]
    fn a_cycle_goes_over_the_tree_and_earlier_critical_edges_alone() {
        // A square of side 1, and a longer rectangle to its right that is born later.
        let cloud = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [2.25, 0.0], [2.25, 1.0]];
        let points = Points::new(Metric::Euclidean, 2, cloud.as_flattened()).unwrap();
        let names: Vertices =
            points.rows().iter().map(|&row| (VertexId(row.into()), &cloud[row as usize][..])).collect();
        let skeleton = Skeleton::of_space(&points, &names, None, &mut Workspace::default());
        let places: Vec<(VertexId, u32)> = names.ids().iter().copied().zip(0..).collect();
        let closing = Closing::new(&skeleton, &places);
        let cycle = |birth: f64| {
            let dot = skeleton.dots().iter().find(|dot| dot.birth == birth).unwrap();
            let mut cycle: Vec<u64> = closing.cycle(&skeleton.critical(dot)).iter().map(|id| id.0).collect();
            cycle.sort_unstable();
            cycle
        };
        assert_eq!(skeleton.dots().len(), 2);
        assert_eq!(cycle(0.5), [0, 1, 2, 3]);
        // By the tree alone it would go around both.
        assert_eq!(cycle(0.625), [2, 3, 4, 5]);
    }
}
