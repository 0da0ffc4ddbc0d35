//! Where a vertex of a graph that shrinks is: in the plane, in a space of coordinates, or at a label.
//!
//! In: places of vertices.
//! Out: how they are ordered, how far they are apart, and where two of them merge.
//! Invariants: in the plane lengths are, bit for bit, those of the skeleton. Elsewhere a length is compared as a
//! half-length, so that lengths that a skeleton stores and those of places are comparable.
//! Must not know: graphs, thresholds.

use std::cmp::Ordering;
use std::rc::Rc;

use crate::topology::cloud::{compare_coordinates, quarter_square};

/// Where the vertices of a simplified view are.
#[derive(Clone, Debug, PartialEq)]
pub enum Positions {
    /// In a space of coordinates.
    Coordinates {
        /// The number of coordinates of a vertex.
        dimension: usize,
        /// Those of the first vertex, then those of the second, and so on.
        flat: Vec<f64>,
    },
    /// In a space without coordinates: at these vertices of the skeleton.
    Labels(Vec<u32>),
}

impl Default for Positions {
    fn default() -> Self {
        Self::Labels(Vec::new())
    }
}

impl Positions {
    /// The number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Self::Coordinates { dimension, flat } => flat.len() / dimension,
            Self::Labels(labels) => labels.len(),
        }
    }

    /// Whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The coordinates of a vertex; none in a space without coordinates.
    pub fn coordinates(&self, place: u32) -> &[f64] {
        match self {
            Self::Coordinates { dimension, flat } => &flat[place as usize * dimension..][..*dimension],
            Self::Labels(_) => &[],
        }
    }

    /// The positions in the plane; none in other spaces.
    pub fn planar(&self) -> &[[f64; 2]] {
        match self {
            Self::Coordinates { dimension: 2, flat } => flat.as_chunks().0,
            Self::Coordinates { .. } | Self::Labels(_) => &[],
        }
    }
}

/// A place of a vertex.
pub trait Place: Clone + PartialEq {
    /// Whether places say how far they are apart. If not, edges keep their lengths when an end moves.
    const HAS_DISTANCES: bool;

    /// A number in the order of half-lengths, for an edge between two places. `stored` is the half-length that the
    /// skeleton has for it, if it has one and neither end has moved.
    fn scale(&self, other: &Self, stored: Option<f64>) -> f64;
    /// The half-length.
    fn half_length(scale: f64) -> f64;
    /// The total order of places.
    fn compare(&self, other: &Self) -> Ordering;
    /// Where two vertices of these degrees merge.
    fn merged(&self, other: &Self, degrees: [usize; 2]) -> Self;
    /// The places of the vertices of a graph.
    fn positions<'a>(places: impl ExactSizeIterator<Item = &'a Self>) -> Positions
    where
        Self: 'a;
}

/// The first end stays, the second, or neither: a bead on a line does not move what it merges with.
fn end_that_stays<P: Clone>(ends: [&P; 2], degrees: [usize; 2]) -> Option<P> {
    match degrees.map(|degree| degree == 2) {
        [true, false] => Some(ends[1].clone()),
        [false, true] => Some(ends[0].clone()),
        [true, true] | [false, false] => None,
    }
}

/// In the plane. Scales are squares of half-lengths.
impl Place for [f64; 2] {
    const HAS_DISTANCES: bool = true;

    /// Bit for bit as for positions of the cloud: an edge that has not moved is below a threshold exactly when its
    /// scale in the skeleton is. (Midpoints are not positions: they may be nearer to 0 than the limit of these.)
    fn scale(&self, other: &Self, _stored: Option<f64>) -> f64 {
        quarter_square(*self, *other)
    }

    fn half_length(scale: f64) -> f64 {
        scale.sqrt()
    }

    fn compare(&self, other: &Self) -> Ordering {
        self[0].total_cmp(&other[0]).then_with(|| self[1].total_cmp(&other[1]))
    }

    fn merged(&self, other: &Self, degrees: [usize; 2]) -> Self {
        let midpoint = || [self[0].midpoint(other[0]), self[1].midpoint(other[1])];
        end_that_stays([self, other], degrees).unwrap_or_else(midpoint)
    }

    fn positions<'a>(places: impl ExactSizeIterator<Item = &'a Self>) -> Positions {
        Positions::Coordinates { dimension: 2, flat: places.flatten().copied().collect() }
    }
}

/// In a space of coordinates. Places are shared, since ties of long vectors may be many.
impl Place for Rc<[f64]> {
    const HAS_DISTANCES: bool = true;

    fn scale(&self, other: &Self, stored: Option<f64>) -> f64 {
        let squares = || self.iter().zip(&**other).map(|(a, b)| (a - b) * (a - b));
        stored.unwrap_or_else(|| squares().sum::<f64>().sqrt() * 0.5)
    }

    fn half_length(scale: f64) -> f64 {
        scale
    }

    fn compare(&self, other: &Self) -> Ordering {
        compare_coordinates(self, other)
    }

    fn merged(&self, other: &Self, degrees: [usize; 2]) -> Self {
        let midpoint = || self.iter().zip(&**other).map(|(a, b)| a.midpoint(*b)).collect();
        end_that_stays([self, other], degrees).unwrap_or_else(midpoint)
    }

    fn positions<'a>(mut places: impl ExactSizeIterator<Item = &'a Self>) -> Positions {
        let Some(first) = places.next() else { return Positions::default() };
        let mut flat = Vec::with_capacity(first.len() * (places.len() + 1));
        flat.extend_from_slice(first);
        places.for_each(|place| flat.extend_from_slice(place));
        Positions::Coordinates { dimension: first.len(), flat }
    }
}

/// At a vertex of the skeleton, in a space without coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label(pub u32);

impl Place for Label {
    const HAS_DISTANCES: bool = false;

    /// Labels do not say how far they are apart; all edges between them have a stored length.
    fn scale(&self, _other: &Self, stored: Option<f64>) -> f64 {
        stored.unwrap_or(f64::INFINITY)
    }

    fn half_length(scale: f64) -> f64 {
        scale
    }

    fn compare(&self, other: &Self) -> Ordering {
        self.0.cmp(&other.0)
    }

    fn merged(&self, other: &Self, [degree, of_other]: [usize; 2]) -> Self {
        match degree.cmp(&of_other) {
            Ordering::Greater => *self,
            Ordering::Less => *other,
            Ordering::Equal => Self(self.0.min(other.0)),
        }
    }

    fn positions<'a>(places: impl ExactSizeIterator<Item = &'a Self>) -> Positions {
        Positions::Labels(places.map(|label| label.0).collect())
    }
}
