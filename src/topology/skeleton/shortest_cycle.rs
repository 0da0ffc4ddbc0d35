//! The shortest cycle of a dot: its critical edge, closed by the shortest path in the tree and in the critical edges
//! that come before it.
//!
//! In: a [`Skeleton`] of any space and dots of it.
//! Out: closed vertex loops.
//! Invariants: a loop has at least three vertices, all different, and begins as that of
//! [`Cycles`](super::cycle::Cycles). It is no longer than that one. Critical edges come in order of (half-length,
//! smaller end, larger end), ends by their places. Of paths of equal length the one with the fewest edges is taken,
//! then the one whose vertices, from the larger end of the critical edge on, have the smallest ids.
//! Must not know: how skeletons are found, views.
//!
//! Cost: Dijkstra's algorithm from one end of the critical edge, as far as the other end is.

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashMap};

use super::cycle::from_smallest;
use super::hopes::{Dot, Edge, Skeleton};

/// The graph of a skeleton, to find shortest cycles in.
#[derive(Clone, Debug)]
pub struct ShortestCycles<'a> {
    skeleton: &'a Skeleton,
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

/// How far a vertex is: half the length of the path to it, then the number of edges.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Far {
    half_length: f64,
    edges: u32,
}

impl Eq for Far {}

impl PartialOrd for Far {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Far {
    fn cmp(&self, other: &Self) -> Ordering {
        self.half_length.total_cmp(&other.half_length).then(self.edges.cmp(&other.edges))
    }
}

impl<'a> ShortestCycles<'a> {
    /// Reads the graph of a skeleton, in linear time.
    pub fn new(skeleton: &'a Skeleton) -> Self {
        let tree = skeleton.scaled_tree().map(|(edge, half_length)| (edge, half_length, false));
        let critical = skeleton.unsorted_dots().iter().map(|dot| (dot.edge, dot.birth, true));
        let edges: Vec<(Edge, f64, bool)> = tree.chain(critical).collect();
        let mut first = vec![0_u32; skeleton.vertices().len() + 1];
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
        Self { skeleton, first, spokes }
    }

    /// The shortest cycle of a dot of the skeleton, as places in [`Skeleton::vertices`]. The first vertex is not
    /// repeated at the end.
    pub fn cycle(&self, dot: &Dot) -> Vec<u32> {
        let [start, end] = dot.edge;
        let before = self.explore(dot);
        let mut cycle = vec![end];
        let mut at = end;
        while let Some(&(_, previous)) = before.get(&at).filter(|_| at != start) {
            cycle.push(previous);
            at = previous;
        }
        from_smallest(self.skeleton, cycle)
    }

    /// The vertices around one end of a critical edge, up to the other end: how far they are, and the vertex before.
    fn explore(&self, dot: &Dot) -> HashMap<u32, (Far, u32)> {
        let [start, end] = dot.edge;
        let here = Far { half_length: 0.0, edges: 0 };
        let mut reached = HashMap::from([(start, (here, start))]);
        let mut queue = BinaryHeap::from([Reverse((here, start))]);
        while let Some(Reverse((far, vertex))) = queue.pop() {
            if vertex == end {
                break;
            }
            if reached[&vertex].0 != far {
                continue;
            }
            for spoke in self.spokes(vertex).iter().filter(|spoke| !spoke.is_critical || is_before(vertex, spoke, dot))
            {
                let next = Far { half_length: far.half_length + spoke.half_length, edges: far.edges + 1 };
                let known =
                    reached.entry(spoke.to).or_insert((Far { half_length: f64::INFINITY, edges: u32::MAX }, vertex));
                if next < known.0 {
                    queue.push(Reverse((next, spoke.to)));
                }
                *known = (next, vertex).min(*known);
            }
        }
        reached
    }

    fn spokes(&self, vertex: u32) -> &[Spoke] {
        let [from, to] = [vertex, vertex + 1].map(|place| self.first[place as usize] as usize);
        &self.spokes[from..to]
    }
}

/// Whether a critical edge comes before that of a dot.
fn is_before(from: u32, spoke: &Spoke, dot: &Dot) -> bool {
    let ends = [from.min(spoke.to), from.max(spoke.to)];
    spoke.half_length.total_cmp(&dot.birth).then(ends.cmp(&dot.edge)).is_lt()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::topology::skeleton::{Cycles, Killer};
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
