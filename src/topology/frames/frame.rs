//! A closed frame as a whole.
//!
//! In: nothing.
//! Out: the type that a pipeline gives.
//! Must not know: how skeletons are found.

use crate::topology::declutter::Decluttered;
use crate::topology::skeleton::{Skeleton, View, ViewSpec};

/// One closed frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The number of the commit, from 1.
    pub number: u64,
    /// The time given at its commit.
    pub time: Option<f64>,
    /// The number of points in the window, including duplicates.
    pub points: u64,
    /// How outliers were left out, if that was asked for.
    pub decluttered: Option<Decluttered>,
    /// The skeleton of the cloud, without outliers.
    pub skeleton: Skeleton,
}

impl Frame {
    /// A part of the frame's skeleton.
    pub fn view(&self, spec: ViewSpec) -> View {
        View::new(&self.skeleton, spec)
    }
}
