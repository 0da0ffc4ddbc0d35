//! The cycle of a dot: its critical edge, closed by the tree path between the edge's ends.
//!
//! In: a [`Skeleton`] and dots of it.
//! Out: closed vertex loops.
//! Invariants: a loop has at least three vertices, all different. It begins at its smallest vertex by position (in a
//! space without coordinates: by id) and goes on to the smaller of that one's neighbours, so it depends on the cloud
//! alone. The cost is proportional to its length. Nothing recurses, however long a path is.
//! Must not know: how skeletons are found, views.

use super::hopes::{Dot, Skeleton};

/// The minimum spanning tree of a skeleton, with a root in each component, so that a path is found by going up from
/// both ends.
#[derive(Clone, Debug)]
pub struct Cycles {
    /// The parent of each vertex; a root is its own parent.
    parent: Vec<u32>,
    /// The number of edges between each vertex and its root.
    depth: Vec<u32>,
}

impl Cycles {
    /// Roots the tree of a skeleton, in linear time.
    pub fn new(skeleton: &Skeleton) -> Self {
        let (parent, order) = strip_leaves(skeleton);
        let mut depth = vec![0; parent.len()];
        // Vertices are in order before their parents, so in reverse order parents come first.
        for &vertex in order.iter().rev() {
            let above = parent[vertex as usize];
            if above != vertex {
                depth[vertex as usize] = depth[above as usize] + 1;
            }
        }
        Self { parent, depth }
    }

    /// The cycle of a dot of the same skeleton, as places in [`Skeleton::vertices`]. The first vertex is not repeated
    /// at the end.
    pub fn cycle(&self, skeleton: &Skeleton, dot: &Dot) -> Vec<u32> {
        let [a, b] = dot.edge;
        from_smallest(skeleton, self.path(a, b))
    }

    /// The path in the tree from `a` to `b`, both included.
    fn path(&self, a: u32, b: u32) -> Vec<u32> {
        let (mut from_a, mut from_b) = (vec![a], vec![b]);
        let (mut a, mut b) = (a, b);
        while a != b {
            // The deeper end goes up, so neither can pass the vertex where the two paths meet.
            if self.depth[a as usize] >= self.depth[b as usize] {
                a = self.parent[a as usize];
                from_a.push(a);
            } else {
                b = self.parent[b as usize];
                from_b.push(b);
            }
        }
        from_b.pop();
        from_a.extend(from_b.into_iter().rev());
        from_a
    }
}

/// The same loop from its smallest vertex on, towards the smaller of that one's neighbours.
pub(super) fn from_smallest(skeleton: &Skeleton, mut cycle: Vec<u32>) -> Vec<u32> {
    let vertices = skeleton.vertices();
    let first = (0..cycle.len()).min_by(|&a, &b| vertices.compare(cycle[a], cycle[b])).unwrap_or(0);
    cycle.rotate_left(first);
    if vertices.compare(cycle[cycle.len() - 1], cycle[1]).is_lt() {
        cycle[1..].reverse();
    }
    cycle
}

/// Removes leaves until one vertex of each component is left, the root. Returns the parent of each vertex and the order
/// of removal.
fn strip_leaves(skeleton: &Skeleton) -> (Vec<u32>, Vec<u32>) {
    let count = skeleton.vertices().len();
    let mut degree = vec![0_u32; count];
    // The exclusive or of the neighbours that are left; for a leaf, its only neighbour.
    let mut parent = vec![0_u32; count];
    for &[a, b] in skeleton.tree() {
        for (vertex, neighbour) in [(a, b), (b, a)] {
            degree[vertex as usize] += 1;
            parent[vertex as usize] ^= neighbour;
        }
    }
    let mut order: Vec<u32> = (0..count as u32).filter(|&vertex| degree[vertex as usize] <= 1).collect();
    let mut next = 0;
    while let Some(&leaf) = order.get(next) {
        next += 1;
        if degree[leaf as usize] == 0 {
            parent[leaf as usize] = leaf;
            continue;
        }
        let above = parent[leaf as usize] as usize;
        parent[above] ^= leaf;
        degree[above] -= 1;
        if degree[above] == 1 {
            order.push(above as u32);
        }
    }
    (parent, order)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::topology::testing::{clouds, clouds_twice, lattice, points_of, ring, skeleton_of};

    fn cycles(skeleton: &Skeleton) -> Vec<Vec<u32>> {
        let cycles = Cycles::new(skeleton);
        skeleton.dots().iter().map(|dot| cycles.cycle(skeleton, dot)).collect()
    }

    fn places(skeleton: &Skeleton, cycle: &[u32]) -> Vec<[f64; 2]> {
        cycle.iter().map(|&vertex| skeleton.vertices().xy(vertex)).collect()
    }

    #[test]
    fn a_square_is_its_own_cycle() {
        let square = skeleton_of(&[[1.0, 1.0], [0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        let [cycle] = &cycles(&square)[..] else { panic!("one dot") };
        assert_eq!(places(&square, cycle), [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    }

    #[test]
    fn two_rooms_have_a_cycle_each() {
        let rooms = skeleton_of(&[[0.0, 0.0], [2.0, 0.0], [5.0, 0.0], [0.0, 2.0], [2.0, 2.0], [5.0, 2.0]]);
        let cycles = cycles(&rooms);
        assert_eq!(places(&rooms, &cycles[0]), [[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]]);
        // The wall between the rooms is the last edge of its length, so it is critical, and the larger cycle passes
        // around both.
        let around = [[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [5.0, 2.0], [5.0, 0.0], [2.0, 0.0]];
        assert_eq!(places(&rooms, &cycles[1]), around);
    }

    #[test]
    fn theta_has_two_long_cycles() {
        let theta = skeleton_of(&points_of(include_str!("../../../tests/cases/theta_n250_e0.03.csv")));
        let cycles = cycles(&theta);
        assert!(cycles[..2].iter().all(|cycle| cycle.len() > 40), "{:?}", &cycles[..2]);
    }

    #[test]
    fn clouds_without_dots_have_no_cycles() {
        for points in [&[][..], &[[1.0, 2.0]], &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]] {
            assert_eq!(cycles(&skeleton_of(points)), Vec::<Vec<u32>>::new());
        }
    }

    #[test]
    fn a_long_way_round_does_not_overflow_the_stack() {
        let circle = skeleton_of(&ring(50_000, 1.0));
        let longest = cycles(&circle).into_iter().map(|cycle| cycle.len()).max();
        assert_eq!(longest, Some(50_000));
    }

    #[test]
    fn a_lattice_has_a_cycle_for_each_of_its_squares() {
        let lattice = skeleton_of(&lattice(6, 6));
        assert_eq!(cycles(&lattice).len(), 25);
        assert!(cycles(&lattice).iter().all(|cycle| cycle.len() % 2 == 0));
    }

    proptest! {
        #[test]
        fn cycles_are_simple_and_made_of_the_tree_and_one_critical_edge(points in clouds()) {
            let skeleton = skeleton_of(&points);
            for (cycle, dot) in cycles(&skeleton).iter().zip(skeleton.dots()) {
                let mut vertices = cycle.clone();
                vertices.sort_unstable();
                vertices.dedup();
                prop_assert_eq!(vertices.len(), cycle.len());
                let next = cycle.iter().cycle().skip(1);
                let edges = cycle.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)]);
                let (tree, others): (Vec<_>, Vec<_>) =
                    edges.partition(|edge| skeleton.tree().binary_search(edge).is_ok());
                prop_assert_eq!(others, [dot.edge]);
                prop_assert!(tree.len() >= 2);
                prop_assert!(tree.iter().all(|&edge| skeleton.half_length(edge) <= dot.birth), "born last");
            }
        }

        #[test]
        fn numbering_does_not_matter((points, shuffled) in clouds_twice()) {
            let [a, b] = [points, shuffled].map(|points| {
                let skeleton = skeleton_of(&points);
                let mut all: Vec<_> = cycles(&skeleton).iter().map(|cycle| places(&skeleton, cycle)).collect();
                all.sort_by(|a, b| a.partial_cmp(b).unwrap());
                all
            });
            prop_assert!(a.iter().all(|cycle| cycle[0] < cycle[1] && cycle[1] < cycle[cycle.len() - 1]));
            prop_assert_eq!(a, b);
        }
    }
}
