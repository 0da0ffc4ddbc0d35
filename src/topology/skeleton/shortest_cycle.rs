//! The shortest cycle of a dot: its critical edge, closed by the shortest path in the tree and in the critical edges
//! that come before it.
//!
//! In: a [`Skeleton`] of any space and dots of it.
//! Out: closed vertex loops.
//! Invariants: a loop has at least three vertices, all different, and begins as that of
//! [`Cycles`](super::cycle::Cycles). It is no longer than that one. Ties are decided by the places of vertices, as
//! [`SkeletonGraph`] says, so by ids.
//! Must not know: how skeletons are found, views.

use super::cycle::from_smallest;
use super::graph::SkeletonGraph;
use super::hopes::{Dot, Skeleton};

/// The graph of a skeleton, to find shortest cycles in.
#[derive(Clone, Debug)]
pub struct ShortestCycles<'a> {
    skeleton: &'a Skeleton,
    graph: SkeletonGraph,
}

impl<'a> ShortestCycles<'a> {
    /// Reads the graph of a skeleton, in linear time.
    pub fn new(skeleton: &'a Skeleton) -> Self {
        Self { skeleton, graph: SkeletonGraph::new(skeleton, skeleton.vertices().len(), |place| place) }
    }

    /// The shortest cycle of a dot of the skeleton, as places in [`Skeleton::vertices`]. The first vertex is not
    /// repeated at the end.
    pub fn cycle(&self, dot: &Dot) -> Vec<u32> {
        from_smallest(self.skeleton, self.graph.cycle(dot.edge, dot.birth))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::topology::skeleton::{Cycles, Edge, Killer};
    use crate::topology::testing::{clouds, labels, lattice, skeleton_of};

    fn half_length(skeleton: &Skeleton, cycle: &[u32]) -> f64 {
        let next = cycle.iter().cycle().skip(1);
        cycle.iter().zip(next).map(|(&a, &b)| skeleton.half_length([a.min(b), a.max(b)])).sum()
    }

    #[test]
    fn a_critical_edge_is_a_short_cut() {
        // A wall between two rooms is critical, and shared by their cycles; the tree alone leads around both.
        let rooms = skeleton_of(&[[0.0, 0.0], [2.0, 0.0], [5.0, 0.0], [0.0, 2.0], [2.0, 2.0], [5.0, 2.0]]);
        let (cycles, shortest) = (Cycles::new(&rooms), ShortestCycles::new(&rooms));
        let both: Vec<Vec<u32>> = rooms.dots().iter().map(|dot| shortest.cycle(dot)).collect();
        assert_eq!(both, [vec![0, 3, 4, 1], vec![1, 4, 5, 2]]);
        assert_eq!(cycles.cycle(&rooms, &rooms.dots()[1]).len(), 6);
    }

    #[test]
    fn squares_of_a_lattice_are_their_own_cycles() {
        let lattice = skeleton_of(&lattice(6, 6));
        let shortest = ShortestCycles::new(&lattice);
        let mut squares: Vec<Vec<u32>> = lattice.dots().iter().map(|dot| shortest.cycle(dot)).collect();
        squares.retain(|cycle| cycle.len() == 4);
        assert!(squares.len() > 12, "most critical edges close a square when they come");
        squares.sort_unstable();
        squares.dedup();
        assert!(squares.iter().all(|cycle| half_length(&lattice, cycle) == 2.0));
    }

    /// A path of four edges of length 1, two critical edges of length 2, and one of length 3 that these close.
    #[test]
    fn ties_go_to_the_fewest_edges_and_then_to_the_smallest_ids() {
        let dot = |edge, birth| Dot { birth, death: 9.0, edge, killer: Killer::Edge(edge) };
        let tree = [[0, 1], [1, 2], [2, 3], [3, 4]].map(|edge| (edge, 1.0)).to_vec();
        let skeleton =
            Skeleton::with_lengths(labels(5), tree, vec![dot([4, 0], 3.0), dot([0, 2], 2.0), dot([2, 4], 2.0)]);
        let shortest = ShortestCycles::new(&skeleton);
        let cycle = |edge| shortest.cycle(skeleton.dots().iter().find(|dot| dot.edge == edge).unwrap());
        assert_eq!(cycle([0, 2]), [0, 1, 2]);
        assert_eq!(cycle([0, 4]), [0, 2, 4], "as long as the path, with fewer edges");
        // Around a square: two ways of equal length and number of edges.
        let tree = vec![([0, 1], 1.0), ([0, 2], 1.0), ([1, 3], 1.0)];
        let square = Skeleton::with_lengths(labels(4), tree, vec![dot([2, 3], 1.0), dot([0, 3], 1.5)]);
        let shortest = ShortestCycles::new(&square);
        let longest = square.dots().iter().find(|dot| dot.birth == 1.5).unwrap();
        assert_eq!(shortest.cycle(longest), [0, 1, 3]);
    }

    proptest! {
        #[test]
        fn cycles_are_simple_and_no_longer_than_those_of_the_tree(points in clouds()) {
            let skeleton = skeleton_of(&points);
            let (cycles, shortest) = (Cycles::new(&skeleton), ShortestCycles::new(&skeleton));
            for dot in skeleton.dots() {
                let cycle = shortest.cycle(dot);
                let mut vertices = cycle.clone();
                vertices.sort_unstable();
                vertices.dedup();
                prop_assert_eq!(vertices.len(), cycle.len());
                prop_assert!(cycle.len() >= 3);
                let along_tree = half_length(&skeleton, &cycles.cycle(&skeleton, dot));
                prop_assert!(half_length(&skeleton, &cycle) <= along_tree * (1.0 + 1e-12));
                let next = cycle.iter().cycle().skip(1);
                let edges: Vec<Edge> = cycle.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]).collect();
                prop_assert!(edges.contains(&dot.edge));
                for edge in edges.iter().filter(|edge| skeleton.tree().binary_search(edge).is_err()) {
                    let critical = skeleton.dots().iter().find(|dot| dot.edge == *edge).expect("in the skeleton");
                    prop_assert!((critical.birth, critical.edge) <= (dot.birth, dot.edge), "{edge:?} comes later");
                }
            }
        }

        /// By Bellman and Ford's algorithm, which looks at all edges again and again.
        #[test]
        fn lengths_are_those_of_shortest_paths(points in clouds()) {
            let skeleton = skeleton_of(&points);
            let shortest = ShortestCycles::new(&skeleton);
            for dot in skeleton.dots() {
                let critical = skeleton.dots().iter().filter(|other| (other.birth, other.edge) < (dot.birth, dot.edge));
                let edges: Vec<Edge> = skeleton.tree().iter().copied().chain(critical.map(|dot| dot.edge)).collect();
                let mut far = vec![f64::INFINITY; skeleton.vertices().len()];
                far[dot.edge[0] as usize] = 0.0;
                for _ in 0..far.len() {
                    for [a, b] in edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]) {
                        let length = skeleton.half_length([a.min(b), a.max(b)]);
                        far[b as usize] = far[b as usize].min(far[a as usize] + length);
                    }
                }
                let wanted = far[dot.edge[1] as usize] + dot.birth;
                prop_assert!((half_length(&skeleton, &shortest.cycle(dot)) - wanted).abs() <= 1e-12 * wanted);
            }
        }
    }
}
