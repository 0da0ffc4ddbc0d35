//! HoPeS(C): the minimum spanning tree of the cloud and its critical edges with their labels.
//!
//! In: the vertices of a cloud (by id) and a [`Mesh`] of them. Out: a [`Skeleton`], the whole answer for one frame, from which every
//! view is cut. Invariants: it depends on the cloud alone (ids name vertices and order the lists, nothing else); tree edges
//! are in order of their ends; dots are by persistence, largest first, equal ones by their edges; every dot's
//! persistence exceeds 1e-12 of its death. Must not know: parameters of views, streams.
//!
//! V. Kurlin, "A one-dimensional homologically persistent skeleton of an unstructured point cloud in any metric space",
//! Computer Graphics Forum 34(5), 2015, Definition 7; scales are radii.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::cmp::Ordering;
use std::sync::OnceLock;

use super::basins::Basins;
use super::cloud::{Cloud, Slot, Vertex};
use super::geometry::{circumcircle, distance, half_length_squared};
use super::mesh::Mesh;
use super::parts::both;
use super::reduction::{Elders, Link, Pair, TotalOrder, reduce};
use super::sorting::{in_order, ordinal, sort_by_key};
use super::tiles::Tiles;

/// A dot whose persistence is at most this share of its death is rounding, not topology.
pub const DIAGONAL: f64 = 1e-12;

/// An edge of a skeleton: indices of its ends in [`Skeleton::vertices`], the smaller first.
pub type Edge = [u32; 2];

/// A point of the 1-dimensional persistence diagram, with the critical edge and the hole that it labels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// The scale at which the cycle is born: half the length of the critical edge.
    pub birth: f64,
    /// The scale at which the hole is filled.
    pub death: f64,
    /// The critical edge.
    pub edge: Edge,
    /// The triangle whose filling kills the dot, by position.
    pub triangle: [u32; 3],
}

impl Dot {
    /// Death minus birth.
    #[inline]
    pub fn persistence(&self) -> f64 {
        self.death - self.birth
    }
}

/// Where a dot's hole is: the last of it to be filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// The point that is filled last.
    pub center: [f64; 2],
    /// The scale at which it is filled: the dot's death.
    pub radius: f64,
}

/// The homologically persistent skeleton of a cloud.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    vertices: Vec<Vertex>,
    tree: Vec<Edge>,
    /// Dots as they were found.
    found: Vec<Dot>,
    /// The same in order, once somebody has asked for all of them.
    dots: OnceLock<Vec<Dot>>,
}

impl PartialEq for Skeleton {
    fn eq(&self, other: &Self) -> bool {
        (self.vertices(), self.tree(), self.dots()) == (other.vertices(), other.tree(), other.dots())
    }
}

impl Skeleton {
    /// Computes the skeleton of a cloud's vertices as of its last commit, which are the sites of the mesh, from the links between its basins.
    pub fn new(cloud: &Cloud, mesh: &Mesh, basins: &Basins, links: Vec<Link>) -> Self {
        let (reduction, (vertices, rank)) = both(
            links.len(),
            || reduce(&Dual::new(mesh, basins), basins.count(), &links),
            || ranked_vertices(cloud, mesh),
        );
        let edge_of = |edge: u32| {
            let [a, b] = mesh.edges()[edge as usize].ends.map(|site| rank[site as usize]);
            [a.min(b), a.max(b)]
        };
        let sorted_tree = || {
            let mut tree = Vec::with_capacity(vertices.len());
            tree.extend(reduction.tree().map(edge_of));
            sort_by_key(&mut tree, |&edge| edge_key(edge, vertices.len()));
            tree
        };
        let dots = || {
            let mut found = Vec::with_capacity(basins.count());
            found.extend(reduction.pairs().filter_map(|pair| {
                let (birth, death) = label(basins, pair)?;
                let triangle = basins.triangle(pair.death).map(|site| rank[site as usize]);
                Some(Dot { birth, death, edge: edge_of(pair.edge), triangle })
            }));
            found
        };
        let (tree, found) = both(links.len(), sorted_tree, dots);
        Self { vertices, tree, found, dots: OnceLock::new() }
    }

    /// Gathers the skeleton of a cloud's vertices from the tiles over it.
    pub fn of_tiles(cloud: &Cloud, tiles: &Tiles) -> Self {
        let (vertices, rank) = ranks(cloud);
        let edge_of = |ends: [Slot; 2]| {
            let [a, b] = ends.map(|slot| rank[slot as usize]);
            [a.min(b), a.max(b)]
        };
        let mut tree = Vec::with_capacity(vertices.len());
        tree.extend(tiles.tree().map(|edge| edge_of(edge.ends)));
        sort_by_key(&mut tree, |&edge| edge_key(edge, vertices.len()));
        let found = tiles.dots().map(|dot| Dot {
            birth: dot.birth,
            death: dot.death,
            edge: edge_of(dot.edge),
            triangle: dot.triangle.map(|slot| rank[slot as usize]),
        });
        Self { tree, found: found.collect(), vertices, dots: OnceLock::new() }
    }

    /// The first difference from another skeleton, in words; none, if they are the same.
    pub(super) fn compare(&self, other: &Self) -> Option<String> {
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

    /// Dots of the persistence diagram with their critical edges, the most persistent first. They are sorted when first asked for.
    pub fn dots(&self) -> &[Dot] {
        self.dots.get_or_init(|| by_persistence(&self.found, self.vertices.len()))
    }

    /// The same in any order, at once.
    pub(super) fn found(&self) -> &[Dot] {
        &self.found
    }

    /// The dots of at least some persistence, in order: the first ones of [`dots`](Self::dots), without the cost of sorting all.
    pub(super) fn most_persistent(&self, least: f64) -> Cow<'_, [Dot]> {
        if self.dots.get().is_none() {
            let few: Vec<Dot> = self.found.iter().filter(|dot| dot.persistence() >= least).copied().collect();
            if few.len() <= self.found.len() / 2 {
                return by_persistence(&few, self.vertices.len()).into();
            }
        }
        let dots = self.dots();
        dots[..dots.partition_point(|dot| dot.persistence() >= least)].into()
    }

    /// The largest death; 0 without dots.
    pub fn largest_death(&self) -> f64 {
        self.found.iter().map(|dot| dot.death).fold(0.0, f64::max)
    }

    /// The hole of a dot: circumcentre and circumradius of the triangle whose filling kills it.
    pub fn hole(&self, dot: &Dot) -> Hole {
        let circle = circumcircle(dot.triangle.map(|v| self.vertices[v as usize].position));
        Hole { center: circle.center, radius: dot.death }
    }

    /// Length of an edge.
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

    /// Length of the minimum spanning tree.
    pub fn tree_length(&self) -> f64 {
        compensated_sum(self.tree.iter().map(|&edge| self.length(edge)))
    }
}

fn first_difference<T: PartialEq + std::fmt::Debug>(what: &str, ours: &[T], theirs: &[T]) -> Option<String> {
    let place = (0..ours.len().max(theirs.len())).find(|&place| ours.get(place) != theirs.get(place))?;
    let (our, their) = (ours.get(place), theirs.get(place));
    Some(format!("{what} {place} of {} is {our:?}, and should be {their:?} of {}", ours.len(), theirs.len()))
}

/// The vertices by id, and of each site of the mesh its place among them.
fn ranked_vertices(cloud: &Cloud, mesh: &Mesh) -> (Vec<Vertex>, Vec<u32>) {
    let (vertices, rank) = ranks(cloud);
    (vertices, mesh.slots().iter().map(|&slot| rank[slot as usize]).collect())
}

/// The vertices by id, and of each slot its vertex' place among them.
fn ranks(cloud: &Cloud) -> (Vec<Vertex>, Vec<u32>) {
    let mut vertices = Vec::with_capacity(cloud.vertex_count());
    let mut rank_of_slot = vec![0; cloud.slot_count()];
    for (slot, vertex) in cloud.vertices() {
        rank_of_slot[slot as usize] = vertices.len() as u32;
        vertices.push(vertex);
    }
    (vertices, rank_of_slot)
}

/// The label of a pair's critical edge, unless its dot is on the diagonal.
fn label(basins: &Basins, pair: Pair) -> Option<(f64, f64)> {
    let (birth, death) = (pair.scale.sqrt(), basins.weight(pair.death).sqrt());
    (death - birth > DIAGONAL * death).then_some((birth, death))
}

/// The place of an edge among all edges between so many vertices, by the first end, then by the other.
#[inline]
fn edge_key([a, b]: Edge, vertex_count: usize) -> u64 {
    u64::from(a) * vertex_count as u64 + u64::from(b)
}

fn by_persistence(dots: &[Dot], vertex_count: usize) -> Vec<Dot> {
    let descending = |place: u32| !ordinal(dots[place as usize].persistence());
    let order = in_order(dots.len(), descending, |place| edge_key(dots[place as usize].edge, vertex_count));
    order.into_iter().map(|place| dots[place as usize]).collect()
}

/// A sum whose error does not grow with the number of terms (Neumaier).
pub(super) fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
    }
    sum + lost
}

/// The dual graph's total order: equal scales are decided by the edges' ends, by position.
struct Dual<'a> {
    mesh: &'a Mesh,
    basins: &'a Basins,
    /// Of each site: its place by position. Most clouds have no ties, so it is made for the first.
    places: OnceCell<Vec<u32>>,
}

impl<'a> Dual<'a> {
    fn new(mesh: &'a Mesh, basins: &'a Basins) -> Self {
        Self { mesh, basins, places: OnceCell::new() }
    }
}

impl Elders for Dual<'_> {
    fn weight(&self, node: u32) -> f64 {
        self.basins.weight(node)
    }

    fn break_node_tie(&self, a: u32, b: u32) -> Ordering {
        self.basins.break_tie(self.mesh, a, b)
    }
}

impl TotalOrder for Dual<'_> {
    fn is_open(&self, _: u32) -> bool {
        false
    }

    fn break_link_tie(&self, edge: u32) -> u64 {
        let places = self.places.get_or_init(|| self.mesh.places_by_position());
        let [a, b] = self.mesh.edges()[edge as usize].ends.map(|site| places[site as usize]);
        edge_key([a.min(b), a.max(b)], places.len())
    }
}
