//! Where vertices stand in rows of bits: those near each other stand near each other.
//!
//! In: short pairs that join most vertices; or where vertices stood in the frame before.
//! Out: a [`Placement`], a permutation of the vertices.
//! Invariants: it has no influence on any result, only on speed: what is remembered for a block of 64 vertices holds
//! for a neighbourhood.
//! Must not know: lengths.

use super::forest::Forest;

/// A permutation of the vertices.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Placement {
    place: Vec<u32>,
    vertex: Vec<u32>,
}

impl Placement {
    /// Along a walk around the trees that these pairs make.
    pub fn along(count: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut forest = Forest::new(count);
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
        for [a, b] in pairs {
            if forest.join(a, b) {
                neighbours[a as usize].push(b);
                neighbours[b as usize].push(a);
            }
        }
        Self::of(walk(&neighbours))
    }

    /// The vertex at each place.
    fn of(vertex: Vec<u32>) -> Self {
        let mut place = vec![0; vertex.len()];
        for (at, &vertex) in vertex.iter().enumerate() {
            place[vertex as usize] = at as u32;
        }
        Self { place, vertex }
    }

    /// Vertices that were there keep their places; new ones take those that are free.
    ///
    /// `before` gives for each vertex which it was.
    pub fn carried(&self, before: &[Option<u32>]) -> Self {
        let mut vertex = vec![None; before.len()];
        let mut rest = Vec::new();
        for (now, &was) in before.iter().enumerate() {
            let place = was.map(|was| self.place[was as usize] as usize);
            match place.and_then(|place| vertex.get_mut(place)) {
                Some(seat) => *seat = Some(now as u32),
                None => rest.push(now as u32),
            }
        }
        let mut rest = rest.into_iter();
        Self::of(vertex.into_iter().filter_map(|vertex| vertex.or_else(|| rest.next())).collect())
    }

    /// The number of vertices.
    pub fn count(&self) -> usize {
        self.place.len()
    }

    /// Where a vertex stands.
    #[inline]
    pub fn place(&self, vertex: u32) -> u32 {
        self.place[vertex as usize]
    }

    /// Which vertex stands there.
    #[inline]
    pub fn vertex(&self, place: u32) -> u32 {
        self.vertex[place as usize]
    }
}

/// All vertices of a forest, depth first. Leaves come first, so that a path is walked from one end.
fn walk(neighbours: &[Vec<u32>]) -> Vec<u32> {
    let count = neighbours.len() as u32;
    let mut is_seen = vec![false; neighbours.len()];
    let mut order = Vec::with_capacity(neighbours.len());
    let mut stack = Vec::new();
    let leaves = (0..count).filter(|&vertex| neighbours[vertex as usize].len() == 1);
    for start in leaves.chain(0..count) {
        if std::mem::replace(&mut is_seen[start as usize], true) {
            continue;
        }
        stack.push(start);
        while let Some(vertex) = stack.pop() {
            order.push(vertex);
            for &next in &neighbours[vertex as usize] {
                if !std::mem::replace(&mut is_seen[next as usize], true) {
                    stack.push(next);
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_permutation(placement: &Placement) -> bool {
        (0..placement.count() as u32).all(|vertex| placement.vertex(placement.place(vertex)) == vertex)
    }

    #[test]
    fn a_path_is_walked_from_an_end() {
        let path = [[3, 1], [1, 0], [0, 4], [4, 2]];
        let placement = Placement::along(5, path.into_iter());
        assert_eq!(placement.vertex, [2, 4, 0, 1, 3]);
        assert!(is_permutation(&placement));
    }

    #[test]
    fn vertices_keep_their_places_and_new_ones_take_free_ones() {
        let old = Placement::along(5, [[3, 1], [1, 0], [0, 4], [4, 2]].into_iter());
        // 4 and 1 are gone; what was 0, 2 and 3 is now 1, 3 and 0.
        for before in [
            vec![Some(3), Some(0), None, Some(2), None],
            vec![Some(3), Some(0), None, Some(2)],
            vec![Some(3), Some(0), None, Some(2), None, None, None],
        ] {
            let new = old.carried(&before);
            assert!(new.count() == before.len() && is_permutation(&new));
            assert_eq!((new.place(1), new.place(3)), (old.place(0), old.place(2)));
        }
    }
}
