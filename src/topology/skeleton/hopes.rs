//! HoPeS(C): the minimum spanning tree of the cloud and its critical edges with their labels.
//!
//! In: the vertices of a cloud by id, edges of the tree, dots; outside of the plane also the lengths of the edges.
//! Out: a [`Skeleton`], from which every view of a frame is cut.
//! Invariants: it depends on the cloud alone; ids only name vertices and order the lists. Tree edges are in order of
//! their ends. Dots are in order of persistence, largest first, equal ones in order of their edges. In the plane the
//! persistence of every dot exceeds 1e-12 of its death.
//! Must not know: parameters of views, streams, how it is found.
//!
//! V. Kurlin, "A one-dimensional homologically persistent skeleton of an unstructured point cloud in any metric space",
//! Computer Graphics Forum 34(5), 2015, Definition 7. Scales are radii.

use std::borrow::Cow;
use std::fmt::Debug;
use std::sync::OnceLock;

use super::named::{Critical, EdgeId};
use crate::topology::base::{compensated_sum, in_order, ordinal, pair_key, sort_by_key};
use crate::topology::cloud::{Vertices, quarter_square};

/// An edge of a skeleton: the places of its ends in [`Skeleton::vertices`], the smaller first.
pub type Edge = [u32; 2];

/// The filtration that a skeleton is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filtration {
    /// Alpha complexes of points in the plane. The last point of a hole to be filled is a circumcentre.
    Alpha,
    /// Vietoris-Rips complexes of any space. An edge enters at half its length, a triangle with its longest edge.
    Rips,
}

/// What enters the filtration when a dot dies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Killer {
    /// The triangle whose filling kills the dot, its corners in order of position: in the plane.
    Triangle([u32; 3]),
    /// The longest edge of the triangles whose filling kills the dot: in a Rips filtration.
    Edge(Edge),
    /// Nothing: the dot never dies.
    None,
}

/// A dot of the 1-dimensional persistence diagram, with its critical edge and what kills it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// The scale at which the cycle is born: half the length of the critical edge.
    pub birth: f64,
    /// The scale at which the hole is filled; +infinity if it never is.
    pub death: f64,
    /// The critical edge.
    pub edge: Edge,
    /// What kills the dot.
    pub killer: Killer,
}

impl Dot {
    /// Death minus birth.
    #[inline]
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

/// The last point of a dot's hole to be filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// The point.
    pub center: [f64; 2],
    /// The scale at which it is filled: the death of the dot.
    pub radius: f64,
}

/// The homologically persistent skeleton of a cloud.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    vertices: Vertices,
    tree: Vec<Edge>,
    lengths: Lengths,
    /// The dots in the order in which they were found; if lengths are stored, in order of their edges.
    unsorted: Vec<Dot>,
    /// The dots in order; computed at the first request for all of them.
    dots: OnceLock<Vec<Dot>>,
}

/// How long the edges of a skeleton are.
#[derive(Clone, Debug, Default, PartialEq)]
enum Lengths {
    /// As positions in the plane have it.
    #[default]
    OfPositions,
    /// The half-lengths of the tree edges, in their order. That of a critical edge is the birth of its dot.
    Stored(Vec<f64>),
}

impl PartialEq for Skeleton {
    fn eq(&self, other: &Self) -> bool {
        (self.vertices(), self.tree(), &self.lengths, self.dots())
            == (other.vertices(), other.tree(), &other.lengths, other.dots())
    }
}

impl Skeleton {
    /// A skeleton in the plane: of vertices by id, and of tree edges and dots in any order.
    pub(crate) fn from_parts(vertices: Vertices, mut tree: Vec<Edge>, unsorted: Vec<Dot>) -> Self {
        sort_by_key(&mut tree, |&edge| pair_key(edge, vertices.len()));
        Self::from_sorted(vertices, tree, unsorted)
    }

    /// The same with tree edges that are in order.
    pub(crate) fn from_sorted(vertices: Vertices, tree: Vec<Edge>, unsorted: Vec<Dot>) -> Self {
        Self { vertices, tree, lengths: Lengths::OfPositions, unsorted, dots: OnceLock::new() }
    }

    /// A skeleton of a Rips filtration: of vertices by id, of the edges of a minimum spanning forest with their
    /// half-lengths, and of dots. Edges and dots may be in any order, the ends of edges too. The critical edges of dots
    /// differ, each joins two vertices of one component, and the birth of its dot is its half-length.
    ///
    /// # Panics
    /// If an edge ends at a place where there is no vertex.
    pub fn with_lengths(vertices: Vertices, mut tree: Vec<(Edge, f64)>, mut dots: Vec<Dot>) -> Self {
        let count = vertices.len();
        let in_order = |edge: &mut Edge| {
            edge.sort_unstable();
            assert!((edge[1] as usize) < count, "edge {edge:?} ends at no vertex: there are {count}");
        };
        tree.iter_mut().for_each(|(edge, _)| in_order(edge));
        dots.iter_mut().for_each(|dot| in_order(&mut dot.edge));
        tree.sort_unstable_by_key(|&(edge, _)| edge);
        dots.sort_unstable_by_key(|dot| dot.edge);
        let (tree, lengths) = tree.into_iter().unzip();
        Self { vertices, tree, lengths: Lengths::Stored(lengths), unsorted: dots, dots: OnceLock::new() }
    }

    /// The filtration that it is of.
    pub fn filtration(&self) -> Filtration {
        match self.lengths {
            Lengths::OfPositions => Filtration::Alpha,
            Lengths::Stored(_) => Filtration::Rips,
        }
    }

    /// An edge by the ids of its ends.
    pub(crate) fn edge_id(&self, edge: Edge) -> EdgeId {
        edge.map(|vertex| self.vertices.id(vertex))
    }

    /// The critical edge of a dot by ids, with its label.
    pub(crate) fn critical(&self, dot: &Dot) -> Critical {
        Critical { edge: self.edge_id(dot.edge), birth: dot.birth, death: dot.death }
    }

    /// The first difference from another skeleton in words; none if they are equal.
    pub(crate) fn compare(&self, other: &Self) -> Option<String> {
        first_difference("vertex", self.vertices.iter(), other.vertices.iter())
            .or_else(|| first_difference("tree edge", self.scaled_tree(), other.scaled_tree()))
            .or_else(|| first_difference("dot", self.dots().iter(), other.dots().iter()))
    }

    /// The vertices of the cloud, by id.
    pub fn vertices(&self) -> &Vertices {
        &self.vertices
    }

    /// Edges of the minimum spanning tree, in order. In a space with infinite distances it is a forest.
    pub fn tree(&self) -> &[Edge] {
        &self.tree
    }

    /// The same, with the half-lengths of the edges.
    pub(crate) fn scaled_tree(&self) -> impl ExactSizeIterator<Item = (Edge, f64)> + '_ {
        self.tree.iter().enumerate().map(|(place, &edge)| match &self.lengths {
            Lengths::OfPositions => (edge, self.planar_half_length(edge)),
            Lengths::Stored(lengths) => (edge, lengths[place]),
        })
    }

    /// The dots of the persistence diagram with their critical edges, the most persistent first. They are sorted at the
    /// first call.
    pub fn dots(&self) -> &[Dot] {
        self.dots.get_or_init(|| by_persistence(&self.unsorted, self.vertices.len()))
    }

    /// The dots in any order, without sorting.
    pub(crate) fn unsorted_dots(&self) -> &[Dot] {
        &self.unsorted
    }

    /// The dots of at least this persistence, in order: a prefix of [`dots`](Self::dots), without sorting all of them.
    pub(crate) fn most_persistent(&self, least: f64) -> Cow<'_, [Dot]> {
        if self.dots.get().is_none() {
            let few: Vec<Dot> = self.unsorted.iter().filter(|dot| dot.persistence() >= least).copied().collect();
            if few.len() <= self.unsorted.len() / 2 {
                return by_persistence(&few, self.vertices.len()).into();
            }
        }
        let dots = self.dots();
        dots[..dots.partition_point(|dot| dot.persistence() >= least)].into()
    }

    /// The largest death that is finite; 0 without one.
    pub fn largest_death(&self) -> f64 {
        self.unsorted.iter().map(|dot| dot.death).filter(|death| death.is_finite()).fold(0.0, f64::max)
    }

    /// The length of an edge of the skeleton.
    pub fn length(&self, edge: Edge) -> f64 {
        2.0 * self.half_length(edge)
    }

    /// The scale at which an edge of the skeleton enters: half its length. An edge that is not in the skeleton has one
    /// in the plane only; elsewhere it is +infinity.
    #[inline]
    pub fn half_length(&self, edge: Edge) -> f64 {
        match &self.lengths {
            Lengths::OfPositions => self.planar_half_length(edge),
            Lengths::Stored(lengths) => self.stored_half_length(lengths, edge),
        }
    }

    #[inline]
    fn planar_half_length(&self, edge: Edge) -> f64 {
        let [a, b] = edge.map(|vertex| self.vertices.xy(vertex));
        quarter_square(a, b).sqrt()
    }

    fn stored_half_length(&self, lengths: &[f64], edge: Edge) -> f64 {
        if let Ok(place) = self.tree.binary_search(&edge) {
            return lengths[place];
        }
        let dot = self.unsorted.binary_search_by_key(&edge, |dot| dot.edge);
        dot.map_or(f64::INFINITY, |place| self.unsorted[place].birth)
    }

    /// The length of the minimum spanning tree.
    pub fn tree_length(&self) -> f64 {
        compensated_sum(self.scaled_tree().map(|(_, half_length)| 2.0 * half_length))
    }
}

fn first_difference<T: PartialEq + Debug>(
    what: &str,
    mut ours: impl ExactSizeIterator<Item = T>,
    mut theirs: impl ExactSizeIterator<Item = T>,
) -> Option<String> {
    let (our_count, their_count) = (ours.len(), theirs.len());
    for place in 0..our_count.max(their_count) {
        let (our, their) = (ours.next(), theirs.next());
        if our != their {
            return Some(format!("{what} {place} of {our_count} is {our:?}, and should be {their:?} of {their_count}"));
        }
    }
    None
}

fn by_persistence(dots: &[Dot], vertex_count: usize) -> Vec<Dot> {
    let descending = |place: u32| !ordinal(dots[place as usize].persistence());
    let order = in_order(dots.len(), descending, |place| pair_key(dots[place as usize].edge, vertex_count));
    order.into_iter().map(|place| dots[place as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::testing::labels;

    /// A million dots are read in one pass after the other, so each of them stays small.
    #[test]
    fn dots_are_small() {
        assert_eq!(size_of::<Dot>(), 40);
    }

    #[test]
    fn stored_lengths_are_found_for_every_edge() {
        let dot = |edge, birth, death| Dot { birth, death, edge, killer: Killer::None };
        let dots = vec![dot([3, 0], 2.5, 3.0), dot([1, 0], 2.0, f64::INFINITY)];
        let skeleton = Skeleton::with_lengths(labels(5), vec![([3, 2], 1.5), ([2, 0], 0.5), ([1, 2], 1.0)], dots);
        assert_eq!(skeleton.tree(), [[0, 2], [1, 2], [2, 3]]);
        let edges = [[0, 2], [1, 2], [2, 3], [0, 1], [0, 3], [3, 4]];
        let half_lengths = edges.map(|edge| skeleton.half_length(edge));
        assert_eq!(half_lengths, [0.5, 1.0, 1.5, 2.0, 2.5, f64::INFINITY]);
        assert_eq!(skeleton.dots().iter().map(|dot| dot.edge).collect::<Vec<_>>(), [[0, 1], [0, 3]]);
        assert_eq!((skeleton.tree_length(), skeleton.largest_death()), (6.0, 3.0));
    }

    #[test]
    #[should_panic(expected = "edge [2, 5] ends at no vertex")]
    fn edges_join_vertices() {
        Skeleton::with_lengths(labels(5), vec![([5, 2], 1.0)], Vec::new());
    }

    #[test]
    fn the_first_difference_is_named() {
        let of = |half_length: f64| Skeleton::with_lengths(labels(2), vec![([0, 1], half_length)], Vec::new());
        assert_eq!(of(1.0).compare(&of(1.0)), None);
        let what = of(1.0).compare(&of(2.0)).expect("the lengths differ");
        assert_eq!(what, "tree edge 0 of 1 is Some(([0, 1], 1.0)), and should be Some(([0, 1], 2.0)) of 1");
        assert!(of(1.0).compare(&Skeleton::default()).is_some_and(|what| what.starts_with("vertex 0 of 2 is Some")));
    }
}
