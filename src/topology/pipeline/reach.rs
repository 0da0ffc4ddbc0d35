//! How a pipeline computes the newest frame: in one pass, or by following what changed in tiles.
//!
//! In: the change of the cloud.
//! Out: the skeleton, whole or in tiles, and the [`Change`] that leads to it.
//! Invariants: both ways give the same. Each frame is computed once.
//! Must not know: views, formats.

use std::sync::Arc;

use super::stage::Stage;
use super::{Pipeline, tiled};
use crate::topology::cloud::CloudChange;
use crate::topology::frames::{Change, Frame, Tree};
use crate::topology::plane::basins::Basins;
use crate::topology::plane::delaunay::{Delaunay, Update};
use crate::topology::plane::filtration::Filtration;
use crate::topology::plane::reduction::Link;
use crate::topology::plane::tiles::{Tiles, TouchObserver};
use crate::topology::skeleton::Skeleton;

impl Pipeline {
    /// Computes the newest frame, unless that was done.
    pub(super) fn reach(&mut self) {
        if self.progress.is_reached() {
            return;
        }
        self.stages.begin(Stage::Triangulation);
        let change = self.take_change();
        let is_tiles_cheaper = self.is_tiles_cheaper(&change);
        self.touched.clear();
        let mut observer = TouchObserver::new(self.tiles.as_ref().filter(|_| is_tiles_cheaper), &mut self.touched);
        let by = if is_tiles_cheaper { Update::Stepwise } else { Delaunay::faster(&self.cloud, &change) };
        let update = self.delaunay.apply_by(by, &self.cloud, &change, &mut observer);
        self.invalidate_regions(&change, update);
        self.stages.begin(Stage::Reduction);
        let before = self.progress.begin();
        let reported = self.is_followed.then(|| Change::of_cloud(before, &self.cloud, &change));
        self.change = match &mut self.tiles {
            Some(tiles) if is_tiles_cheaper && update == Update::Stepwise => {
                self.whole = None;
                let difference = tiles.follow(&self.cloud, &self.delaunay, &change, &self.touched);
                if let Some(diagram) = &mut self.diagram {
                    diagram.follow(&difference.dots_removed, &difference.dots_added, |dot| {
                        tiled::critical(&self.cloud, dot)
                    });
                }
                reported.map(|reported| tiled::with_difference(reported, &self.cloud, &difference))
            }
            _ => {
                // The old skeleton is dropped before the new one is made, except for what has to be compared.
                let (tiles, whole) = (self.tiles.take(), self.whole.take());
                let gathered = reported.as_ref().and(tiles).map(|tiles| tiled::tree(&self.cloud, &tiles));
                self.diagram = None;
                if is_tiles_cheaper && update == Update::Stepwise {
                    self.tiles = Some(Tiles::new(&self.cloud, &self.delaunay, self.leaf_capacity));
                } else {
                    self.compute_whole();
                }
                let old = gathered.or_else(|| whole.as_deref().map(|frame| Tree::Whole(&frame.skeleton)));
                reported.map(|reported| reported.with_trees(&old.unwrap_or(Tree::Empty), &self.tree()))
            }
        };
        self.stages.begin(Stage::Done);
    }

    /// The change of the cloud, without outliers.
    fn take_change(&mut self) -> CloudChange {
        let change = self.cloud.take_change();
        let Some(outliers) = &mut self.outliers else { return change };
        let change = outliers.follow(&mut self.cloud, &change, [self.progress.reached, self.progress.committed]);
        self.progress.decluttered = Some(outliers.report());
        change
    }

    /// Drops the regions that a change may have changed.
    fn invalidate_regions(&mut self, change: &CloudChange, update: Update) {
        let Self { regions, cloud, .. } = self;
        match update {
            // Streams without tracks have no regions, and pay nothing.
            _ if regions.is_empty() => {}
            // Hardly any region is unchanged after a change of this size.
            Update::Bulk => regions.clear(),
            // A slot that was emptied in this change still has its last position.
            Update::Stepwise => {
                let slots = change.appeared.iter().chain(&change.vanished);
                regions.invalidate(&slots.map(|&slot| cloud.position(slot)).collect::<Vec<_>>());
            }
        }
    }

    /// Whether following a change in tiles costs less than one pass.
    fn is_tiles_cheaper(&mut self, change: &CloudChange) -> bool {
        let vertices = self.cloud.vertex_count() as f64;
        let share = (change.appeared.len() + change.vanished.len()) as f64 / vertices;
        let is_worth_it = match &self.tiles {
            _ if self.always_tiles => return Delaunay::faster(&self.cloud, change) == Update::Stepwise,
            Some(tiles) => tiles.cost(&self.cloud, change) <= vertices,
            // Tiles have to be made first. If they were given up before, only a much smaller change is worth it.
            None => share <= self.tiles_share,
        };
        if self.tiles.is_some() && !is_worth_it {
            self.tiles_share = share / 2.0;
        }
        is_worth_it
    }

    /// The current tree.
    fn tree(&self) -> Tree<'_> {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => tiled::tree(&self.cloud, tiles),
            (None, Some(frame)) => Tree::Whole(&frame.skeleton),
            (None, None) => Tree::Empty,
        }
    }

    /// Computes the frame in one pass.
    fn compute_whole(&mut self) {
        let links = self.contract();
        let skeleton = Skeleton::new(&self.cloud, &self.mesh, &self.basins, links);
        self.whole = Some(Arc::new(self.progress.frame_of(skeleton)));
    }

    fn contract(&mut self) -> Vec<Link> {
        self.delaunay.read_into(&mut self.mesh);
        let (basins, links) = Basins::contract(&self.mesh, Filtration::new(&self.mesh));
        self.basins = basins;
        links
    }

    /// The current frame as a whole.
    pub(super) fn frame(&mut self) -> Arc<Frame> {
        if let (None, Some(tiles)) = (&self.whole, &self.tiles) {
            self.whole = Some(Arc::new(self.progress.frame_of(tiled::skeleton(&self.cloud, tiles))));
        }
        Arc::clone(self.whole.as_ref().expect("a frame that was reached is held"))
    }
}
