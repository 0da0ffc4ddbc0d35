//! Verification of a pipeline against recomputation from scratch.
//!
//! In: a pipeline; or a frame and the skeleton that it should have.
//! Out: the first difference, in words.
//! Invariant: the pipeline computes its newest frame, and does not change otherwise.
//! Must not know: formats.

use thiserror::Error;

use super::Pipeline;
use crate::topology::cloud::CloudChange;
use crate::topology::frames::{Follower, Frame, Snapshot};
use crate::topology::plane::basins::Basins;
use crate::topology::plane::delaunay::Delaunay;
use crate::topology::plane::filtration::Filtration;
use crate::topology::skeleton::{Skeleton, View};

/// A frame differs from one pass over its cloud: a bug of this library.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("frame {frame} contradicts recomputation from scratch: {what}; please report it with the input")]
pub struct Contradiction {
    /// The number of the frame.
    pub frame: u64,
    /// What differs.
    pub what: String,
}

impl Frame {
    /// Compares the frame with the skeleton from scratch, and a follower that is at it with the view of that.
    ///
    /// # Errors [`Contradiction`]: the first difference.
    pub(super) fn check(&self, reference: &Skeleton, follower: &Follower) -> Result<(), Contradiction> {
        let contradiction = |what| Err(Contradiction { frame: self.number, what });
        if let Some(what) = self.skeleton.compare(reference) {
            return contradiction(what);
        }
        let view = View::new(reference, follower.spec());
        let snapshot = Snapshot::new(reference, &view);
        let shown = (follower.edges(), follower.cycles(), follower.checksum());
        let wanted = (view.tree.len(), view.cycles, snapshot.checksum());
        if follower.frame() == self.number && shown != wanted {
            let what = format!("the view's edges, cycles and checksum are {shown:?}, and should be {wanted:?}");
            return contradiction(what);
        }
        Ok(())
    }
}

impl Pipeline {
    /// Compares the newest frame with one pass over its cloud, and a follower with the view of that.
    ///
    /// # Errors [`Contradiction`]: the first difference.
    pub fn check(&mut self, follower: &Follower) -> Result<(), Contradiction> {
        self.reach();
        if let Some(outliers) = &self.outliers {
            outliers.check(&self.cloud, self.progress.reached)?;
        }
        let mut delaunay = Delaunay::default();
        let all = CloudChange { appeared: self.cloud.vertices().map(|(slot, _)| slot).collect(), ..Default::default() };
        delaunay.apply(&self.cloud, &all);
        let mesh = delaunay.mesh();
        let (basins, links) = Basins::contract(&mesh, Filtration::new(&mesh));
        let reference = Skeleton::new(&self.cloud, &mesh, &basins, links);
        let frame = self.frame();
        frame.check(&reference, follower)
    }

    /// Panics when the pipeline is inconsistent. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        self.cloud.check_invariants();
        if self.progress.is_reached() {
            self.delaunay.check_invariants(&self.cloud);
            if let Some(tiles) = &self.tiles {
                tiles.check_shape();
                tiles.check_stars(&self.delaunay);
            }
        }
    }
}
