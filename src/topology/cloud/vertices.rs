//! Lists of vertices of any space: ids, and as many coordinates a vertex as the space has.
//!
//! In: ids with coordinates, one by one.
//! Out: [`Vertices`].
//! Invariants: all vertices of a list have the same number of coordinates. In a space without coordinates (distances
//! only) it is 0, and a vertex is its id. Two empty lists are equal, whatever their dimension.
//! Must not know: how a cloud stores them, distances.

use std::cmp::Ordering;
use std::fmt;

use super::site::Site;
use super::vertex::{Vertex, VertexId};

/// Vertices with their coordinates.
///
/// No coordinate is NaN or a negative zero. Who makes a list sees to that.
#[derive(Clone, Default)]
pub struct Vertices {
    ids: Vec<VertexId>,
    dimension: usize,
    /// Those of the first vertex, then those of the second, and so on.
    coordinates: Vec<f64>,
}

impl Vertices {
    /// An empty list with room for `count` vertices of `dimension` coordinates.
    pub fn with_capacity(dimension: usize, count: usize) -> Self {
        Self { ids: Vec::with_capacity(count), dimension, coordinates: Vec::with_capacity(dimension * count) }
    }

    /// Appends a vertex. An empty list takes its dimension.
    ///
    /// # Panics
    /// If the vertices before have another number of coordinates.
    #[inline]
    pub fn push(&mut self, id: VertexId, coordinates: &[f64]) {
        if self.ids.is_empty() {
            self.dimension = coordinates.len();
        }
        assert_eq!(coordinates.len(), self.dimension, "all vertices of a list are in one space");
        self.ids.push(id);
        self.coordinates.extend_from_slice(coordinates);
    }

    /// The number of vertices.
    #[inline]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The number of coordinates of a vertex; 0 in a space without coordinates.
    #[inline]
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The ids, in the order of the list.
    pub fn ids(&self) -> &[VertexId] {
        &self.ids
    }

    /// The id of the vertex at a place.
    #[inline]
    pub fn id(&self, place: u32) -> VertexId {
        self.ids[place as usize]
    }

    /// The coordinates of the vertex at a place.
    #[inline]
    pub fn coordinates(&self, place: u32) -> &[f64] {
        let first = place as usize * self.dimension;
        &self.coordinates[first..first + self.dimension]
    }

    /// The coordinates of all vertices, one after the other.
    pub fn all_coordinates(&self) -> &[f64] {
        &self.coordinates
    }

    /// The first two coordinates of the vertex at a place: its position in the plane. A coordinate that the space does
    /// not have is 0.
    #[inline]
    pub fn xy(&self, place: u32) -> [f64; 2] {
        first_two(self.coordinates(place))
    }

    /// The positions in the plane of all vertices, as [`xy`](Self::xy) gives them.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = [f64; 2]> + Clone + '_ {
        self.iter().map(|(_, coordinates)| first_two(coordinates))
    }

    /// The vertices, in the order of the list.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (VertexId, &[f64])> + Clone {
        (0..self.len() as u32).map(|place| (self.id(place), self.coordinates(place)))
    }

    /// The order of two vertices: by their first coordinate, then by the second, and so on, at last by place.
    #[inline]
    pub fn compare(&self, a: u32, b: u32) -> Ordering {
        compare_coordinates(self.coordinates(a), self.coordinates(b)).then(a.cmp(&b))
    }

    /// The bytes that the list takes outside of itself.
    pub fn heap_size(&self) -> usize {
        size_of_val(self.ids.as_slice()) + size_of_val(self.coordinates.as_slice())
    }
}

#[inline]
fn first_two(coordinates: &[f64]) -> [f64; 2] {
    match *coordinates {
        [x, y, ..] => [x, y],
        [x] => [x, 0.0],
        [] => [0.0, 0.0],
    }
}

/// Lexicographic order.
#[inline]
pub fn compare_coordinates(a: &[f64], b: &[f64]) -> Ordering {
    a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

impl PartialEq for Vertices {
    fn eq(&self, other: &Self) -> bool {
        let is_one_space = self.dimension == other.dimension || self.is_empty();
        is_one_space && self.ids == other.ids && self.coordinates == other.coordinates
    }
}

impl fmt::Debug for Vertices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.iter().map(|(id, coordinates)| (id.0, coordinates))).finish()
    }
}

impl<'a> Extend<(VertexId, &'a [f64])> for Vertices {
    fn extend<I: IntoIterator<Item = (VertexId, &'a [f64])>>(&mut self, vertices: I) {
        vertices.into_iter().for_each(|(id, coordinates)| self.push(id, coordinates));
    }
}

impl<'a> FromIterator<(VertexId, &'a [f64])> for Vertices {
    fn from_iter<I: IntoIterator<Item = (VertexId, &'a [f64])>>(vertices: I) -> Self {
        let mut list = Self::default();
        list.extend(vertices);
        list
    }
}

/// Vertices of a cloud.
impl<S: Site> FromIterator<Vertex<S>> for Vertices {
    fn from_iter<I: IntoIterator<Item = Vertex<S>>>(vertices: I) -> Self {
        let mut vertices = vertices.into_iter().peekable();
        let dimension = vertices.peek().map_or(0, |vertex| vertex.position.coordinates().as_ref().len());
        let mut list = Self::with_capacity(dimension, vertices.size_hint().0);
        vertices.for_each(|vertex| list.push(vertex.id, vertex.position.coordinates().as_ref()));
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(vertices: &[(u64, &[f64])]) -> Vertices {
        vertices.iter().map(|&(id, coordinates)| (VertexId(id), coordinates)).collect()
    }

    #[test]
    fn vertices_have_as_many_coordinates_as_the_space() {
        let space = list(&[(3, &[1.0, 2.0, 3.0]), (7, &[4.0, 5.0, 6.0])]);
        assert_eq!((space.len(), space.dimension()), (2, 3));
        assert_eq!((space.id(1), space.coordinates(1), space.xy(1)), (VertexId(7), &[4.0, 5.0, 6.0][..], [4.0, 5.0]));
        let line = list(&[(0, &[2.5])]);
        assert_eq!((line.coordinates(0), line.xy(0)), (&[2.5][..], [2.5, 0.0]));
        let labels = list(&[(0, &[]), (1, &[]), (4, &[])]);
        assert_eq!((labels.len(), labels.dimension(), labels.coordinates(2)), (3, 0, &[][..]));
        assert_eq!((labels.xy(2), labels.iter().last()), ([0.0, 0.0], Some((VertexId(4), &[][..]))));
    }

    #[test]
    fn empty_lists_are_equal() {
        assert_eq!(Vertices::with_capacity(3, 10), Vertices::default());
        assert_ne!(list(&[(1, &[])]), list(&[(1, &[0.0])]));
        assert_ne!(list(&[(1, &[])]), Vertices::default());
        assert_ne!(list(&[(1, &[0.0])]), list(&[(1, &[1.0])]));
    }

    #[test]
    fn order_is_lexicographic_and_then_by_place() {
        let space = list(&[(0, &[1.0, 2.0, 0.0]), (1, &[1.0, -2.0, 9.0]), (2, &[1.0, 2.0, 0.0])]);
        assert_eq!(
            [space.compare(0, 1), space.compare(1, 2), space.compare(0, 2)].map(Ordering::is_lt),
            [false, true, true]
        );
        let labels = list(&[(5, &[]), (6, &[])]);
        assert_eq!([labels.compare(0, 1), labels.compare(1, 1)], [Ordering::Less, Ordering::Equal]);
    }

    #[test]
    #[should_panic(expected = "one space")]
    fn vertices_of_two_spaces_do_not_mix() {
        list(&[(1, &[0.0, 0.0]), (2, &[0.0])]);
    }
}
