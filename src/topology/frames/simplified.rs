//! A simplified view that is followed from frame to frame.
//!
//! In: whole frames. Out: [`Step`]s. Invariants: steps lead from one simplified view to the next, as [`Snapshot`]s of them say; a vertex has the smallest id of those that it stands for.
//! Must not know: how skeletons are found.
//!
//! Unlike other views this one is computed anew for each frame: a collapse can change all later ones.

use super::diff::{Diff, Snapshot};
use super::frame::Frame;
use super::step::Step;
use crate::topology::skeleton::{ViewSpec, simplify};

/// Follows one simplified view.
#[derive(Clone, Debug)]
pub struct SimplifiedFollower {
    spec: ViewSpec,
    threshold: Option<f64>,
    frame: u64,
    held: Snapshot,
}

impl SimplifiedFollower {
    /// Has seen nothing yet. Edges of half-length below the threshold are collapsed; below the view's own scale (alpha, or vs), if none is given.
    pub fn new(spec: ViewSpec, threshold: Option<f64>) -> Self {
        Self { spec, threshold, frame: 0, held: Snapshot::default() }
    }

    /// Number of the frame it has been brought to; 0 for none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Brings it to a frame.
    pub(crate) fn advance(&mut self, frame: &Frame) -> Step {
        let view = frame.view(self.spec);
        let threshold = self.threshold.unwrap_or_else(|| view.scale());
        let simplified = simplify(&frame.skeleton, &view, threshold);
        let new = Snapshot::of_simplified(&frame.skeleton, &simplified);
        let diff: Diff = self.held.diff(&new);
        let from = std::mem::replace(&mut self.frame, frame.number);
        let checksum = new.checksum();
        self.held = new;
        Step {
            number: frame.number,
            from,
            time: frame.time,
            points: frame.points,
            vertices: frame.skeleton.vertices().len(),
            spec: self.spec,
            selection: view.selection,
            components: view.components,
            cycles: view.cycles,
            diff,
            checksum,
        }
    }
}
