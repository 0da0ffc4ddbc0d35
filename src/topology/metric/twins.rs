//! Vertices at distance zero that are one point under two names.
//!
//! In: a space and its persistence.
//! Out: the vertex that stands for each vertex.
//! Invariants: vertices at distance zero are one if their distances to all others agree to the last bit. Where they do
//! not, which only a matrix or a graph can say, they stay two, joined by an edge of length zero. Leaving out all but
//! the first of such vertices changes nothing else: any edge of another one has the first one in its lune, joined to
//! all the rest of it, so it is no tree edge, no birth and no death.
//! Must not know: skeletons.

use super::rips::Persistence;
use super::space::Distances;

/// For each vertex the first one that is the same point.
pub fn representatives(space: &dyn Distances, persistence: &Persistence) -> Vec<u32> {
    let count = space.count();
    let mut group: Vec<u32> = (0..count as u32).collect();
    let zero = persistence.tree.iter().take_while(|pair| pair.length == 0.0);
    let joined: Vec<[u32; 2]> = zero.map(|pair| pair.ends()).collect();
    for &[a, b] in &joined {
        let (a, b) = (first(&group, a), first(&group, b));
        group[a.max(b) as usize] = a.min(b);
    }
    let mut apart = vec![false; count];
    for b in joined.into_iter().flatten() {
        let first = first(&group, b);
        apart[first as usize] |= row(space, b) != row(space, first);
    }
    let stands_for = |vertex: u32| {
        let first = first(&group, vertex);
        if apart[first as usize] { vertex } else { first }
    };
    (0..count as u32).map(stands_for).collect()
}

fn first(group: &[u32], mut vertex: u32) -> u32 {
    while group[vertex as usize] != vertex {
        vertex = group[vertex as usize];
    }
    vertex
}

fn row(space: &dyn Distances, vertex: u32) -> Vec<f64> {
    let mut row = vec![0.0; space.count()];
    space.lengths(vertex, 0, &mut row);
    row
}

#[cfg(test)]
mod tests {
    use super::super::rips::{Workspace, persistence};
    use super::super::space::Matrix;
    use super::*;

    fn of(count: usize, lower: &[f64]) -> Vec<u32> {
        let space = Matrix::from_lower(count, lower).unwrap();
        representatives(&space, &persistence(&space, f64::INFINITY, &mut Workspace::default()))
    }

    #[test]
    fn twins_are_one_where_all_distances_agree() {
        // 0, 2 and 3 are one point; 1 is another.
        assert_eq!(of(4, &[1.0, 0.0, 1.0, 0.0, 1.0, 0.0]), [0, 1, 0, 0]);
        // 0 and 2 disagree about 1.
        assert_eq!(of(3, &[1.0, 0.0, 2.0]), [0, 1, 2]);
        // 0, 2 are zero apart and 2, 3, but not 0, 3: they disagree.
        assert_eq!(of(4, &[1.0, 0.0, 1.0, 5.0, 1.0, 0.0]), [0, 1, 2, 3]);
        assert_eq!(of(2, &[0.0]), [0, 0]);
        assert_eq!(of(2, &[f64::INFINITY]), [0, 1]);
        assert_eq!(of(1, &[]), [0]);
    }
}
