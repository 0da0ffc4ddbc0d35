//! Lunes: the common neighbours of two vertices that are about to be joined, and whether they are connected.
//!
//! In: the graph so far, and pairs in the total order.
//! Out: a [`Lune`] of each.
//! Invariants: an answer is exact and depends on the graph alone, apart from which vertex stands for a part. What is
//! remembered only makes it fast.
//! Must not know: lengths, classes.
//!
//! Most lunes are connected since one vertex of them is joined to all the rest: it *covers* the lune. The vertex that
//! covered the last lune between a vertex and a block of 64 others is tried first. Where that fails, stars of vertices
//! are united as far as they meet, and only what is left apart then is searched by its edges.

use super::graph_bits::{GraphBits, LANES, lowest, meet, middle};

/// What the lune of a pair is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Lune {
    /// No vertex: the pair is a relative-neighbourhood edge.
    Empty,
    /// Connected.
    Whole,
    /// In several parts; one vertex of each.
    Split(Vec<u32>),
}

/// A graph that grows, and asks for lunes.
#[derive(Clone, Debug, Default)]
pub struct Lunes {
    graph: GraphBits,
    /// For a vertex and a word of others: what covered a lune between them last.
    covering: Vec<u32>,
    lune: Vec<u64>,
    /// What is not reached or covered yet.
    left: Vec<u64>,
    reached: Vec<u64>,
    parts: Vec<Vec<u64>>,
    spare: Vec<Vec<u64>>,
}

impl Lunes {
    /// A graph without edges.
    pub fn new(count: usize) -> Self {
        let graph = GraphBits::new(count);
        let words = graph.words();
        let set = || vec![0; words];
        Self {
            covering: vec![0; count * words],
            lune: set(),
            left: set(),
            reached: set(),
            parts: Vec::new(),
            spare: Vec::new(),
            graph,
        }
    }

    /// Removes all edges. What covered lunes is remembered.
    pub fn clear(&mut self) {
        self.graph.clear();
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.graph.bytes() + self.covering.capacity() * size_of::<u32>()
    }

    /// The graph so far.
    pub fn graph(&self) -> &GraphBits {
        &self.graph
    }

    /// Joins two vertices.
    #[inline]
    pub fn join(&mut self, a: u32, b: u32) {
        self.graph.join(a, b);
    }

    /// The lune of two vertices that are not joined yet.
    #[inline]
    pub fn lune(&mut self, a: u32, b: u32) -> Lune {
        let (at_a, at_b) = self.memory(a, b);
        let first = self.covering[at_a];
        if self.covers(a, b, first) {
            return Lune::Whole;
        }
        let second = self.covering[at_b];
        if second != first && self.covers(a, b, second) {
            self.covering[at_a] = second;
            return Lune::Whole;
        }
        self.search(a, b)
    }

    #[inline]
    fn memory(&self, a: u32, b: u32) -> (usize, usize) {
        let words = self.graph.words();
        (a as usize * words + b as usize / 64, b as usize * words + a as usize / 64)
    }

    /// Whether `c` is in the lune of `a` and `b`, and is joined to all of it.
    #[inline]
    fn covers(&self, a: u32, b: u32, c: u32) -> bool {
        let graph = &self.graph;
        if !(graph.has(a, c) && graph.has(b, c)) {
            return false;
        }
        let (a, _) = graph.row(a).as_chunks::<LANES>();
        let (b, _) = graph.row(b).as_chunks::<LANES>();
        let (c, _) = graph.row(c).as_chunks::<LANES>();
        let mut outside = 0;
        for ((a, b), c) in a.iter().zip(b).zip(c) {
            for lane in 0..LANES {
                outside |= a[lane] & b[lane] & !c[lane];
            }
        }
        outside == 0
    }

    #[inline(never)]
    fn search(&mut self, a: u32, b: u32) -> Lune {
        let mut count = 0;
        for ((lune, a), b) in self.lune.iter_mut().zip(self.graph.row(a)).zip(self.graph.row(b)) {
            *lune = a & b;
            count += lune.count_ones();
        }
        let Some(center) = middle(&self.lune, count) else { return Lune::Empty };
        if self.star_covers(center) {
            let (at_a, at_b) = self.memory(a, b);
            self.covering[at_a] = center;
            self.covering[at_b] = center;
            return Lune::Whole;
        }
        if self.stars_cover() {
            return Lune::Whole;
        }
        self.unite_stars();
        self.split()
    }

    /// Begins with the star of one vertex. Whether it is all of the lune.
    fn star_covers(&mut self, center: u32) -> bool {
        let mut rest = 0;
        let sets = self.left.iter_mut().zip(&mut self.reached);
        for (((left, reached), lune), row) in sets.zip(&self.lune).zip(self.graph.row(center)) {
            *left = lune & !row;
            *reached = lune & row;
            rest |= *left;
        }
        rest == 0
    }

    /// Adds stars of vertices not reached yet, while they meet what is reached. Whether all is reached.
    fn stars_cover(&mut self) -> bool {
        while let Some(vertex) = lowest(&self.left) {
            let row = self.graph.row(vertex);
            if !meet(&self.reached, row) {
                return false;
            }
            let sets = self.left.iter_mut().zip(&mut self.reached);
            for (((left, reached), lune), row) in sets.zip(&self.lune).zip(row) {
                *left &= !row;
                *reached |= lune & row;
            }
        }
        true
    }

    /// Covers the lune with stars, and unites those that meet: the parts.
    fn unite_stars(&mut self) {
        self.left.copy_from_slice(&self.lune);
        while let Some(vertex) = lowest(&self.left) {
            let mut star = self.spare.pop().unwrap_or_else(|| vec![0; self.graph.words()]);
            let sets = star.iter_mut().zip(&mut self.left);
            for (((star, left), lune), row) in sets.zip(&self.lune).zip(self.graph.row(vertex)) {
                *star = lune & row;
                *left &= !row;
            }
            let part = absorb(star, &mut self.parts, &mut self.spare, meet);
            self.parts.push(part);
        }
    }

    /// Parts whose stars do not meet may still be joined by an edge between them. The smallest is asked first.
    fn split(&mut self) -> Lune {
        let mut representatives = Vec::new();
        while self.parts.len() > 1 {
            let part = self.take_smallest();
            match self.edge_out_of(&part) {
                Some(vertex) => {
                    let row = self.graph.row(vertex);
                    let part = absorb(part, &mut self.parts, &mut self.spare, |other, _| meet(other, row));
                    self.parts.push(part);
                }
                None => {
                    representatives.extend(lowest(&part));
                    self.spare.push(part);
                }
            }
        }
        if let Some(last) = self.parts.pop() {
            representatives.extend(lowest(&last));
            self.spare.push(last);
        }
        if representatives.len() == 1 { Lune::Whole } else { Lune::Split(representatives) }
    }

    fn take_smallest(&mut self) -> Vec<u64> {
        let size = |part: &Vec<u64>| part.iter().map(|bits| bits.count_ones()).sum::<u32>();
        let smallest = (0..self.parts.len()).min_by_key(|&place| size(&self.parts[place])).unwrap_or(0);
        self.parts.swap_remove(smallest)
    }

    /// A vertex of the part that has a neighbour in the rest of the lune.
    fn edge_out_of(&self, part: &[u64]) -> Option<u32> {
        let vertices = part.iter().enumerate().flat_map(|(word, &bits)| {
            let first = word as u32 * 64;
            let mut bits = bits;
            std::iter::from_fn(move || {
                let vertex = (bits != 0).then(|| first + bits.trailing_zeros());
                bits &= bits.wrapping_sub(1);
                vertex
            })
        });
        let leads_out = |&vertex: &u32| {
            let row = self.graph.row(vertex);
            row.iter().zip(&self.lune).zip(part).fold(0, |any, ((row, lune), part)| any | row & lune & !part) != 0
        };
        vertices.into_iter().find(leads_out)
    }
}

/// Adds to a part all others that belong to it.
fn absorb(
    mut part: Vec<u64>,
    parts: &mut Vec<Vec<u64>>,
    spare: &mut Vec<Vec<u64>>,
    belongs: impl Fn(&[u64], &[u64]) -> bool,
) -> Vec<u64> {
    let mut place = 0;
    while place < parts.len() {
        if belongs(&parts[place], &part) {
            let other = parts.swap_remove(place);
            for (part, other) in part.iter_mut().zip(&other) {
                *part |= other;
            }
            spare.push(other);
        } else {
            place += 1;
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A graph on the vertices from 2 on, all of them neighbours of 0 and 1.
    fn between(count: u32, edges: &[[u32; 2]]) -> Lune {
        let mut lunes = Lunes::new(count as usize);
        for vertex in 2..count {
            lunes.join(0, vertex);
            lunes.join(1, vertex);
        }
        for &[a, b] in edges {
            lunes.join(a, b);
        }
        lunes.lune(0, 1)
    }

    #[test]
    fn a_lune_is_empty_whole_or_split() {
        assert_eq!(between(2, &[]), Lune::Empty);
        assert_eq!(between(3, &[]), Lune::Whole);
        assert_eq!(between(4, &[[2, 3]]), Lune::Whole);
        assert_eq!(between(4, &[]), Lune::Split(vec![2, 3]));
    }

    #[test]
    fn a_long_path_is_whole_and_a_cut_path_is_split() {
        let path = |cut: u32| (2..199).map(|v| [v, v + 1]).filter(|edge| edge[0] != cut).collect::<Vec<_>>();
        assert_eq!(between(200, &path(0)), Lune::Whole);
        for cut in [2, 63, 64, 100, 127, 198] {
            let Lune::Split(mut parts) = between(200, &path(cut)) else { panic!("cut at {cut}") };
            parts.sort_unstable();
            assert_eq!(parts, [2, cut + 1]);
        }
    }

    #[test]
    fn an_order_of_vertices_that_hides_the_path_does_not_split_it() {
        // Stars of consecutive vertices do not meet: the path goes through them in a large stride.
        let vertex = |place: u32| 2 + place * 79 % 198;
        let edges: Vec<[u32; 2]> = (0..197).map(|place| [vertex(place), vertex(place + 1)]).collect();
        assert_eq!(between(200, &edges), Lune::Whole);
    }
}
