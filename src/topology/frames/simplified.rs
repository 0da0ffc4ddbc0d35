//! A follower of a simplified view.
//!
//! In: whole frames.
//! Out: [`Step`]s.
//! Invariants: steps lead from one simplified view to the next, as their [`Snapshot`]s do. A vertex has the smallest id
//! of those merged into it.
//! Must not know: how skeletons are found.
//!
//! Unlike other views it is computed again for each frame, since one collapse can change all later ones.

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
    /// A follower at no frame yet. Edges of half-length below the threshold are collapsed. The default threshold is the
    /// view's own scale (alpha or vs).
    pub fn new(spec: ViewSpec, threshold: Option<f64>) -> Self {
        Self { spec, threshold, frame: 0, held: Snapshot::default() }
    }

    /// The number of the frame that it was updated to; 0 for none.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Updates it to a frame.
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
            decluttered: frame.decluttered,
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
