//! Spaces: points of any dimension, and distances, from the same files as points of the plane.
//!
//! In: a source, the end of whose name may say what it is; which columns are coordinates, or how distances are written.
//! Out: a whole [`Space`], by [`read_points`] and [`read_distances`]; or points line by line as they arrive, by a
//! [`PointReader`].
//! Invariants: memory is bounded by the most points that are allowed, whatever a file holds or claims. A point that
//! cannot be used is told with its place and counted; distances are whole or refused.
//! Must not know: what is computed of them, files, options.
//!
//! Lines, columns, headers, numbers, encodings and foreign files are read by the reader of the plane, [`Reader`]. Here
//! are the points that it makes (`columns`, `json`), what a point must be (`check`), series of numbers as points
//! (`embedding`), and distances.
//!
//! [`Reader`]: super::Reader

mod check;
mod columns;
mod distances;
mod embedding;
mod error;
mod json;
mod points;
mod whole;

#[cfg(test)]
mod tests;

pub use columns::SpaceColumns;
pub use distances::{DistanceForm, read_distances};
pub use embedding::Embedding;
pub use error::SpaceError;
pub use points::{Coordinates, PointReader, PointRecord, PointSettings};
pub use whole::read_points;

/// The most coordinates of a point.
pub const MOST_COORDINATES: usize = 4096;

/// The most points of which distances are read.
pub const MOST_OF_A_MATRIX: usize = 1 << 16;

/// A finite metric space, as it was read. Points may coincide.
#[derive(Clone, Debug, PartialEq)]
pub enum Space {
    /// Points of which distances are computed.
    Points {
        /// How many coordinates each has; 0 if there are no points.
        dimension: usize,
        /// One point after the other.
        coordinates: Vec<f64>,
    },
    /// All distances.
    Lower {
        /// How many points there are.
        count: usize,
        /// d(1,0), d(2,0), d(2,1), ..., each from 0 to infinity.
        distances: Vec<f64>,
    },
    /// Some distances; the others are infinite.
    Sparse {
        /// How many points there are: one more than the largest index.
        count: usize,
        /// i, j > i and d(i,j), which is finite; sorted, and no pair twice.
        edges: Vec<(u32, u32, f64)>,
    },
}

/// What is told of an input while it is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Notice {
    /// Something that cannot be used: where, and why.
    Refused(String),
    /// What was taken for what, without being asked for.
    Taken(String),
}
