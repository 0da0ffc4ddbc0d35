//! Missing distances: those of shortest paths over the distances that are there.
//!
//! In: a space some of whose distances are infinite.
//! Out: its [`parts`], between which there is no path; [`Paths`], a space of finite distances if it has one part.
//! Invariants: parts are in order of size, the largest first, of equal ones that of the smallest vertex; vertices of a
//! part are in order.
//! Must not know: what distances are used for.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use hopes::topology::spaces::{Distances, Space};

/// Whether all distances are finite.
pub fn is_whole(space: &Space) -> bool {
    if matches!(space, Space::Points(_)) {
        return true;
    }
    let distances = space.distances();
    let mut row = vec![0.0; distances.count()];
    (0..distances.count() as u32).all(|from| {
        distances.lengths(from, 0, &mut row);
        row.iter().all(|length| length.is_finite())
    })
}

/// The vertices that paths join.
pub fn parts(space: &Space) -> Vec<Vec<u32>> {
    let paths = Paths { space };
    let mut is_found = vec![false; paths.count()];
    let mut parts = Vec::new();
    for first in 0..paths.count() as u32 {
        if std::mem::replace(&mut is_found[first as usize], true) {
            continue;
        }
        let mut part = vec![first];
        let mut next = 0;
        while let Some(&vertex) = part.get(next) {
            next += 1;
            paths.each_neighbour(vertex, |other, _| {
                if !std::mem::replace(&mut is_found[other as usize], true) {
                    part.push(other);
                }
            });
        }
        part.sort_unstable();
        parts.push(part);
    }
    parts.sort_by_key(|part| Reverse(part.len()));
    parts
}

/// A space whose distances are those of shortest paths.
pub struct Paths<'a> {
    /// Whose distances are the steps.
    pub space: &'a Space,
}

/// How far a vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Far(f64);

impl Eq for Far {}

impl PartialOrd for Far {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Far {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl Paths<'_> {
    fn each_neighbour(&self, vertex: u32, mut visit: impl FnMut(u32, f64)) {
        if let Space::Graph(graph) = self.space {
            graph
                .neighbours(vertex)
                .iter()
                .filter(|(_, step)| step.is_finite())
                .for_each(|&(to, step)| visit(to, step));
            return;
        }
        let distances = self.space.distances();
        let mut row = vec![0.0; distances.count()];
        distances.lengths(vertex, 0, &mut row);
        for (to, length) in (0..).zip(row).filter(|(_, length)| length.is_finite()) {
            visit(to, 2.0 * distances.radius(length));
        }
    }
}

impl Distances for Paths<'_> {
    fn count(&self) -> usize {
        self.space.distances().count()
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        let mut length = [0.0];
        self.lengths(a, b, &mut length);
        length[0]
    }

    /// Dijkstra's algorithm.
    fn lengths(&self, a: u32, first: u32, out: &mut [f64]) {
        let mut far = vec![f64::INFINITY; self.count()];
        far[a as usize] = 0.0;
        let mut queue = BinaryHeap::from([Reverse((Far(0.0), a))]);
        while let Some(Reverse((Far(here), vertex))) = queue.pop() {
            if here > far[vertex as usize] {
                continue;
            }
            self.each_neighbour(vertex, |to, step| {
                if here + step < far[to as usize] {
                    far[to as usize] = here + step;
                    queue.push(Reverse((Far(here + step), to)));
                }
            });
        }
        out.copy_from_slice(&far[first as usize..][..out.len()]);
    }

    fn radius(&self, length: f64) -> f64 {
        0.5 * length
    }
}

#[cfg(test)]
mod tests {
    use hopes::topology::spaces::{Graph, Matrix};

    use super::*;

    const NONE: f64 = f64::INFINITY;

    #[test]
    fn missing_distances_are_those_of_paths() {
        let graph = Graph::new(6, &[(0, 1, 1.0), (1, 2, 2.0), (2, 3, 0.5), (0, 3, 9.0), (4, 5, NONE)]).unwrap();
        let matrix = Matrix::from_lower(
            6,
            &[1.0, NONE, 2.0, 9.0, NONE, 0.5, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE],
        );
        for space in [Space::Graph(graph), Space::Matrix(matrix.unwrap())] {
            let paths = Paths { space: &space };
            let mut row = [0.0; 6];
            paths.lengths(3, 0, &mut row);
            assert_eq!(row, [3.5, 2.5, 0.5, 0.0, NONE, NONE]);
            assert_eq!((paths.length(0, 3), paths.length(4, 5)), (3.5, NONE));
            assert_eq!(parts(&space), [vec![0, 1, 2, 3], vec![4], vec![5]]);
            assert!(!is_whole(&space));
        }
    }

    #[test]
    fn the_largest_part_is_the_first() {
        let space = Space::Graph(Graph::new(5, &[(1, 4, 1.0), (0, 2, 1.0), (2, 3, 0.0)]).unwrap());
        assert_eq!(parts(&space), [vec![0, 2, 3], vec![1, 4]]);
        assert!(is_whole(&Space::Matrix(Matrix::from_lower(2, &[1.0]).unwrap())));
    }
}
