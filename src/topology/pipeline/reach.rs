//! How a pipeline reaches the newest committed frame: in one pass, or by following what changed in tiles.
//!
//! In: the change of the cloud. Out: the skeleton, held as a whole or in tiles, and the [`Change`] that leads to it. Invariants: both ways give the same; each frame is
//! computed once. Must not know: views, formats.

use std::sync::Arc;

use super::stage::Stage;
use super::{Pipeline, tiled};
use crate::topology::cloud::CloudChange;
use crate::topology::frames::{Change, Frame, Tree};
use crate::topology::plane::basins::Basins;
use crate::topology::plane::delaunay::{Delaunay, Update};
use crate::topology::plane::filtration::Filtration;
use crate::topology::plane::reduction::Link;
use crate::topology::plane::tiles::{Guide, Tiles};
use crate::topology::skeleton::Skeleton;

impl Pipeline {
    /// Brings what is held to the newest committed frame.
    pub(super) fn reach(&mut self) {
        if self.reached == self.committed {
            return;
        }
        self.stages.begin(Stage::Triangulation);
        let change = self.cloud.take_change();
        let is_for_tiles = self.is_for_tiles(&change);
        self.touched.clear();
        let mut guide = Guide::new(self.tiles.as_ref().filter(|_| is_for_tiles), &mut self.touched);
        let by = if is_for_tiles { Update::Stepwise } else { Delaunay::faster(&self.cloud, &change) };
        let update = self.delaunay.apply_by(by, &self.cloud, &change, &mut guide);
        self.disturb_regions(&change, update);
        self.stages.begin(Stage::Reduction);
        let told = self.is_followed.then(|| Change::of_cloud(self.reached, &self.cloud, &change));
        self.reached = self.committed;
        self.computed += 1;
        self.change = match &mut self.tiles {
            Some(tiles) if is_for_tiles && update == Update::Stepwise => {
                self.whole = None;
                let difference = tiles.follow(&self.cloud, &self.delaunay, &change, &self.touched);
                if let Some(diagram) = &mut self.diagram {
                    diagram.follow(&difference.dots_removed, &difference.dots_added, |dot| {
                        tiled::critical(&self.cloud, dot)
                    });
                }
                told.map(|told| tiled::with_difference(told, &self.cloud, &difference))
            }
            _ => {
                // What is held now goes before the new is made, but for what has to be compared.
                let (tiles, whole) = (self.tiles.take(), self.whole.take());
                let gathered = told.as_ref().and(tiles).map(|tiles| tiled::tree(&self.cloud, &tiles));
                self.diagram = None;
                if is_for_tiles && update == Update::Stepwise {
                    self.tiles = Some(Tiles::new(&self.cloud, &self.delaunay, self.leaf));
                } else {
                    self.compute_whole();
                }
                let old = gathered.or_else(|| whole.as_deref().map(|frame| Tree::Whole(&frame.skeleton)));
                told.map(|told| told.with_trees(&old.unwrap_or(Tree::Empty), &self.tree()))
            }
        };
        self.stages.begin(Stage::Done);
    }

    /// Lets go of regions that a change may have changed.
    fn disturb_regions(&mut self, change: &CloudChange, update: Update) {
        let Self { regions, cloud, .. } = self;
        match update {
            // Most streams are not tracked: their frames pay nothing for this.
            _ if regions.is_empty() => {}
            // So much has changed that hardly any region is untouched.
            Update::Bulk => regions.clear(),
            // A slot that was emptied in this change still says what it held.
            Update::Stepwise => {
                let slots = change.appeared.iter().chain(&change.vanished);
                regions.disturb(&slots.map(|&slot| cloud.position(slot)).collect::<Vec<_>>());
            }
        }
    }

    /// Whether a change is worth being followed in tiles, rather than computed in one pass.
    fn is_for_tiles(&mut self, change: &CloudChange) -> bool {
        let vertices = self.cloud.vertex_count() as f64;
        let share = (change.appeared.len() + change.vanished.len()) as f64 / vertices;
        let is_worth_it = match &self.tiles {
            _ if self.is_for_tiles_only => return Delaunay::faster(&self.cloud, change) == Update::Stepwise,
            Some(tiles) => tiles.cost(&self.cloud, change) <= vertices,
            // Tiles have to be made first. Where they were given up, only much smaller changes are worth another try.
            None => share <= self.worth_tiles,
        };
        if self.tiles.is_some() && !is_worth_it {
            self.worth_tiles = share / 2.0;
        }
        is_worth_it
    }

    /// The tree that is held.
    fn tree(&self) -> Tree<'_> {
        match (&self.tiles, &self.whole) {
            (Some(tiles), _) => tiled::tree(&self.cloud, tiles),
            (None, Some(frame)) => Tree::Whole(&frame.skeleton),
            (None, None) => Tree::Empty,
        }
    }

    /// One pass over everything.
    fn compute_whole(&mut self) {
        let links = self.contract();
        let skeleton = Skeleton::new(&self.cloud, &self.mesh, &self.basins, links);
        self.whole = Some(Arc::new(self.frame_of(skeleton)));
    }

    fn contract(&mut self) -> Vec<Link> {
        self.delaunay.read_into(&mut self.mesh);
        let (basins, links) = Basins::contract(&self.mesh, Filtration::new(&self.mesh));
        self.basins = basins;
        links
    }

    fn frame_of(&self, skeleton: Skeleton) -> Frame {
        Frame { number: self.committed, time: self.time, points: self.points, skeleton }
    }

    /// The frame that is held, as a whole.
    pub(super) fn frame(&mut self) -> Arc<Frame> {
        if let (None, Some(tiles)) = (&self.whole, &self.tiles) {
            self.whole = Some(Arc::new(self.frame_of(tiled::skeleton(&self.cloud, tiles))));
        }
        Arc::clone(self.whole.as_ref().expect("a frame that was reached is held"))
    }
}
