//! HoPeS(C): the minimum spanning tree of the cloud and its critical edges with their labels.
//!
//! In: the vertices of a cloud by id, edges of the tree, dots.
//! Out: a [`Skeleton`], from which every view of a frame is cut.
//! Invariants: it depends on the cloud alone; ids only name vertices and order the lists. Tree edges are in order of
//! their ends. Dots are in order of persistence, largest first, equal ones in order of their edges. The persistence of
//! every dot exceeds 1e-12 of its death.
//! Must not know: parameters of views, streams, how it is found.
//!
//! V. Kurlin, "A one-dimensional homologically persistent skeleton of an unstructured point cloud in any metric space",
//! Computer Graphics Forum 34(5), 2015, Definition 7. Scales are radii.

use std::borrow::Cow;
use std::sync::OnceLock;

use super::named::{Critical, EdgeId};
use crate::topology::base::{compensated_sum, in_order, ordinal, pair_key, sort_by_key};
use crate::topology::cloud::{Vertex, distance, half_length_squared};

/// An edge of a skeleton: the places of its ends in [`Skeleton::vertices`], the smaller first.
pub type Edge = [u32; 2];

/// A dot of the 1-dimensional persistence diagram, with its critical edge and the triangle that kills it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// The scale at which the cycle is born: half the length of the critical edge.
    pub birth: f64,
    /// The scale at which the hole is filled.
    pub death: f64,
    /// The critical edge.
    pub edge: Edge,
    /// The triangle whose filling kills the dot, its corners in order of position.
    pub triangle: [u32; 3],
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
    vertices: Vec<Vertex>,
    tree: Vec<Edge>,
    /// The dots in the order in which they were found.
    unsorted: Vec<Dot>,
    /// The dots in order; computed at the first request for all of them.
    dots: OnceLock<Vec<Dot>>,
}

impl PartialEq for Skeleton {
    fn eq(&self, other: &Self) -> bool {
        (self.vertices(), self.tree(), self.dots()) == (other.vertices(), other.tree(), other.dots())
    }
}

impl Skeleton {
    /// A skeleton of vertices by id, and of tree edges and dots in any order.
    pub(crate) fn from_parts(vertices: Vec<Vertex>, mut tree: Vec<Edge>, unsorted: Vec<Dot>) -> Self {
        sort_by_key(&mut tree, |&edge| pair_key(edge, vertices.len()));
        Self::from_sorted(vertices, tree, unsorted)
    }

    /// The same with tree edges that are in order.
    pub(crate) fn from_sorted(vertices: Vec<Vertex>, tree: Vec<Edge>, unsorted: Vec<Dot>) -> Self {
        Self { vertices, tree, unsorted, dots: OnceLock::new() }
    }

    /// An edge by the ids of its ends.
    pub(crate) fn edge_id(&self, edge: Edge) -> EdgeId {
        edge.map(|vertex| self.vertices[vertex as usize].id)
    }

    /// The critical edge of a dot by ids, with its label.
    pub(crate) fn critical(&self, dot: &Dot) -> Critical {
        Critical { edge: self.edge_id(dot.edge), birth: dot.birth, death: dot.death }
    }

    /// The first difference from another skeleton in words; none if they are equal.
    pub(crate) fn compare(&self, other: &Self) -> Option<String> {
        first_difference("vertex", self.vertices(), other.vertices())
            .or_else(|| first_difference("tree edge", self.tree(), other.tree()))
            .or_else(|| first_difference("dot", self.dots(), other.dots()))
    }

    /// The vertices of the cloud, by id.
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// Edges of the minimum spanning tree, in order.
    pub fn tree(&self) -> &[Edge] {
        &self.tree
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

    /// The largest death; 0 without dots.
    pub fn largest_death(&self) -> f64 {
        self.unsorted.iter().map(|dot| dot.death).fold(0.0, f64::max)
    }

    /// The length of an edge.
    pub fn length(&self, edge: Edge) -> f64 {
        let [a, b] = edge.map(|v| self.vertices[v as usize].position);
        distance(a, b)
    }

    /// The scale at which an edge of the skeleton enters: half its length.
    #[inline]
    pub fn half_length(&self, edge: Edge) -> f64 {
        let [a, b] = edge.map(|v| self.vertices[v as usize].position);
        half_length_squared(a, b).sqrt()
    }

    /// The length of the minimum spanning tree.
    pub fn tree_length(&self) -> f64 {
        compensated_sum(self.tree.iter().map(|&edge| self.length(edge)))
    }
}

fn first_difference<T: PartialEq + std::fmt::Debug>(what: &str, ours: &[T], theirs: &[T]) -> Option<String> {
    let place = (0..ours.len().max(theirs.len())).find(|&place| ours.get(place) != theirs.get(place))?;
    let (our, their) = (ours.get(place), theirs.get(place));
    Some(format!("{what} {place} of {} is {our:?}, and should be {their:?} of {}", ours.len(), theirs.len()))
}

fn by_persistence(dots: &[Dot], vertex_count: usize) -> Vec<Dot> {
    let descending = |place: u32| !ordinal(dots[place as usize].persistence());
    let order = in_order(dots.len(), descending, |place| pair_key(dots[place as usize].edge, vertex_count));
    order.into_iter().map(|place| dots[place as usize]).collect()
}
