//! A step: what changed in a view between two frames.
//!
//! In: nothing.
//! Out: the type that followers give.
//! Must not know: how changes are found, formats.

use super::diff::{Checksum, Diff};
use crate::topology::declutter::Decluttered;
use crate::topology::skeleton::{Selection, ViewSpec};

/// The change of a view between two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The number of the frame it leads to.
    pub number: u64,
    /// The number of the frame it starts from; 0 for the empty view.
    pub from: u64,
    /// The time given at the frame's commit.
    pub time: Option<f64>,
    /// The number of points in the window, including duplicates.
    pub points: u64,
    /// How outliers were left out, if that was asked for.
    pub decluttered: Option<Decluttered>,
    /// The number of distinct positions, without outliers.
    pub vertices: usize,
    /// The view.
    pub spec: ViewSpec,
    /// The selection by gaps, in a derived view.
    pub selection: Option<Selection>,
    /// The number of connected components of the view, including single vertices.
    pub components: usize,
    /// The number of independent cycles of the view.
    pub cycles: usize,
    /// The change.
    pub diff: Diff,
    /// The checksum of the view that it leads to.
    pub checksum: Checksum,
}
