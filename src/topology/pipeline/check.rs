//! Comparing what a pipeline holds with what it should hold.
//!
//! In: a pipeline. Out: the first difference from one pass over its cloud, in words. Invariant: nothing held is changed but by reaching the newest frame. Must not know:
//! formats.

use thiserror::Error;

use super::Pipeline;
use crate::topology::cloud::CloudChange;
use crate::topology::frames::{Follower, Snapshot};
use crate::topology::plane::basins::Basins;
use crate::topology::plane::delaunay::Delaunay;
use crate::topology::plane::filtration::Filtration;
use crate::topology::skeleton::{Skeleton, View};

/// What is held of a frame is not what its cloud gives: a fault of this library.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("frame {frame} contradicts recomputation from scratch: {what}; please report it with the input")]
pub struct Contradiction {
    /// The frame.
    pub frame: u64,
    /// What differs.
    pub what: String,
}

impl Pipeline {
    /// Compares what is held of the newest frame with what one pass over its cloud gives, and a follower of it with the view of that.
    ///
    /// # Errors
    /// [`Contradiction`]: the first difference.
    pub fn check(&mut self, follower: &Follower) -> Result<(), Contradiction> {
        self.reach();
        let mut delaunay = Delaunay::default();
        let all = CloudChange { appeared: self.cloud.vertices().map(|(slot, _)| slot).collect(), ..Default::default() };
        delaunay.apply(&self.cloud, &all);
        let mesh = delaunay.mesh();
        let (basins, links) = Basins::contract(&mesh, Filtration::new(&mesh));
        let reference = Skeleton::new(&self.cloud, &mesh, &basins, links);
        let frame = self.frame();
        frame.skeleton.compare(&reference).map_or(Ok(()), |what| Err(Contradiction { frame: self.reached, what }))?;
        let view = View::new(&reference, follower.spec());
        let snapshot = Snapshot::new(&reference, &view);
        let shown = (follower.edges(), follower.cycles(), follower.checksum());
        let wanted = (view.tree.len(), view.cycles, snapshot.checksum());
        if follower.frame() == self.reached && shown != wanted {
            let what = format!("the view's edges, cycles and checksum are {shown:?}, and should be {wanted:?}");
            return Err(Contradiction { frame: self.reached, what });
        }
        Ok(())
    }

    /// Panics when the engine contradicts itself. For tests.
    #[doc(hidden)]
    pub fn check_invariants(&self) {
        self.cloud.check_invariants();
        if self.reached == self.committed {
            self.delaunay.check_invariants(&self.cloud);
            if let Some(tiles) = &self.tiles {
                tiles.check_shape();
                tiles.check_stars(&self.delaunay);
            }
        }
    }
}
