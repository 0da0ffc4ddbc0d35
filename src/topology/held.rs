//! A skeleton as it is held between frames: as a whole after one pass, in tiles after steps. Both answer what followers ask.
//!
//! In: a [`Skeleton`], or [`Tiles`] with the [`Diagram`] of their dots. Out: what [`Held`] promises. Invariants: both give the same answers. Must not
//! know: which frames there were before.

use super::change::{self, TreeEdgeId};
use super::cloud::{Cloud, Vertex};
use super::diagram::Diagram;
use super::diff::Critical;
use super::follow::Held;
use super::gaps::{Selection, select};
use super::skeleton::Skeleton;
use super::tiles::Tiles;
use super::view::ViewSpec;

/// Held as a whole.
pub struct HeldWhole<'a>(pub &'a Skeleton);

impl Held for HeldWhole<'_> {
    fn vertex_count(&self) -> usize {
        self.0.vertices().len()
    }

    fn vertices(&self) -> Vec<Vertex> {
        self.0.vertices().to_vec()
    }

    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId> {
        let is_between = |edge: &TreeEdgeId| low.is_none_or(|low| edge.scale > low) && edge.scale <= high;
        change::tree_of(self.0).filter(is_between).collect()
    }

    fn dots_down_to(&self, persistence: f64) -> Vec<Critical> {
        change::dots_of(self.0).filter(|dot| dot.death - dot.birth >= persistence).collect()
    }

    fn select(&mut self, spec: ViewSpec) -> Option<Selection> {
        match spec {
            ViewSpec::Derived { k, l } => Some(select(self.0, k, l)),
            ViewSpec::Full | ViewSpec::Reduced { .. } => None,
        }
    }
}

/// Held in tiles.
pub struct HeldTiles<'a> {
    /// Names the tiles' slots.
    pub cloud: &'a Cloud,
    /// The skeleton.
    pub tiles: &'a Tiles,
    /// Its dots, once gaps were asked for.
    pub diagram: &'a mut Option<Diagram>,
}

impl HeldTiles<'_> {
    fn dots(&self) -> impl Iterator<Item = Critical> + '_ {
        self.tiles.dots().map(|dot| change::critical(self.cloud, dot))
    }
}

impl Held for HeldTiles<'_> {
    fn vertex_count(&self) -> usize {
        self.cloud.vertex_count()
    }

    fn vertices(&self) -> Vec<Vertex> {
        self.cloud.vertices().map(|(_, vertex)| vertex).collect()
    }

    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId> {
        let edges =
            self.tiles.tree_between(|scale| low.is_some_and(|low| scale.sqrt() <= low), |scale| scale.sqrt() <= high);
        edges.iter().map(|edge| change::tree_edge(self.cloud, edge)).collect()
    }

    fn dots_down_to(&self, persistence: f64) -> Vec<Critical> {
        match &*self.diagram {
            Some(diagram) if diagram.is_tall(persistence) => diagram.down_to(persistence).copied().collect(),
            _ => self.dots().filter(|dot| dot.death - dot.birth >= persistence).collect(),
        }
    }

    fn select(&mut self, spec: ViewSpec) -> Option<Selection> {
        let ViewSpec::Derived { k, l } = spec else { return None };
        let mut diagram = self.diagram.take().unwrap_or_else(|| Diagram::new(self.dots()));
        let selection = diagram.select(k, l, self.tiles.largest_death(), || self.dots());
        *self.diagram = Some(diagram);
        Some(selection)
    }
}
