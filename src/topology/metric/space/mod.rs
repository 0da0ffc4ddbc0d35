//! Finite metric spaces, as the sweep sees them: lengths of pairs.
//!
//! In: coordinates, or distances.
//! Out: [`Distances`] of points in R^d ([`Points`]), of a [`Matrix`] or of a sparse [`Graph`]; a sample of
//! [`landmarks`](landmarks()).
//! Invariants: lengths are symmetric to the last bit, not negative, not NaN; +infinity joins nothing. No triangle
//! inequality is asked. Vertices are numbered in the order that decides ties: by lexicographic position in R^d, by
//! index where only distances are given.
//! Must not know: filtrations, skeletons, files.

mod error;
mod graph;
mod landmarks;
mod matrix;
mod measure;
mod points;
mod table;

pub use crate::topology::base::MAX_DIMENSION;
pub use error::SpaceError;
pub use graph::Graph;
pub use landmarks::{Landmarks, landmarks};
pub use matrix::Matrix;
pub use measure::{EARTH_RADIUS, Metric};
pub use points::Points;
pub use table::Table;

/// Lengths of the pairs of a finite set. A length grows with the distance; it need not be the distance itself, since
/// the filtration only compares.
pub trait Distances: Sync {
    /// The number of vertices.
    fn count(&self) -> usize;

    /// The length of a pair.
    fn length(&self, a: u32, b: u32) -> f64;

    /// The lengths from `a` to the vertices from `first` on, as many as there is room for.
    fn lengths(&self, a: u32, first: u32, out: &mut [f64]);

    /// Whether a single length costs so much that all of them are better computed once, where there is room.
    fn is_costly(&self) -> bool {
        false
    }

    /// The scale of a length, a radius: half of the distance.
    fn radius(&self, length: f64) -> f64;

    /// The largest length whose scale is at most this one; -infinity if there is none. `radius` grows with the length,
    /// and so do the bits of a length, so they are halved until one is left.
    fn longest(&self, radius: f64) -> f64 {
        if self.radius(0.0) > radius {
            return f64::NEG_INFINITY;
        }
        let (mut fits, mut exceeds) = (0, f64::INFINITY.to_bits());
        while exceeds - fits > 1 {
            let middle = fits + (exceeds - fits) / 2;
            if self.radius(f64::from_bits(middle)) <= radius {
                fits = middle;
            } else {
                exceeds = middle;
            }
        }
        f64::from_bits(fits)
    }
}

/// A finite metric space.
#[derive(Clone, Debug)]
pub enum Space {
    /// Points of R^d.
    Points(Points),
    /// All distances.
    Matrix(Matrix),
    /// Some distances.
    Graph(Graph),
}

impl Space {
    /// Its lengths.
    pub fn distances(&self) -> &dyn Distances {
        match self {
            Self::Points(points) => points,
            Self::Matrix(matrix) => matrix,
            Self::Graph(graph) => graph,
        }
    }

    /// These vertices alone; they must be in increasing order.
    pub fn subset(&self, chosen: &[u32]) -> Self {
        match self {
            Self::Points(points) => Self::Points(points.subset(chosen)),
            Self::Matrix(matrix) => Self::Matrix(matrix.subset(chosen)),
            Self::Graph(graph) => Self::Graph(graph.subset(chosen)),
        }
    }
}

#[cfg(test)]
mod tests;
