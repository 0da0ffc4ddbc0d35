//! A step: what has changed in a view from one frame to another.
//!
//! In: nothing. Out: the type that followers give. Must not know: how changes are found, formats.

use super::diff::{Checksum, Diff};
use crate::topology::skeleton::{Selection, ViewSpec};

/// What has changed in a view, from one frame to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Number of the frame it leads to.
    pub number: u64,
    /// Number of the frame it starts from; 0: from nothing.
    pub from: u64,
    /// The time given at the frame's commit.
    pub time: Option<f64>,
    /// Points in the window, duplicates among them.
    pub points: u64,
    /// Distinct positions.
    pub vertices: usize,
    /// What is shown.
    pub spec: ViewSpec,
    /// What the gaps selected, in a derived view.
    pub selection: Option<Selection>,
    /// Number of connected components shown, lone vertices among them.
    pub components: usize,
    /// Number of independent cycles shown.
    pub cycles: usize,
    /// The change.
    pub diff: Diff,
    /// Proves the view that it leads to.
    pub checksum: Checksum,
}
