//! The two representations of the current skeleton: whole after one pass, in tiles after steps.
//!
//! In: a [`Skeleton`], or [`Tiles`] with the [`Diagram`] of their dots.
//! Out: the answers of [`HeldSkeleton`] and [`DetectionSource`].
//! Invariant: both give the same answers.
//! Must not know: earlier frames.

use super::holes::hole;
use super::tiled;
use crate::topology::cloud::{Cloud, Position, Site, Slot, Vertices};
use crate::topology::frames::{Diagram, HeldSkeleton, NamedDot};
use crate::topology::plane::elements::TileDot;
use crate::topology::plane::tiles::Tiles;
use crate::topology::skeleton::{Critical, Dot, Killer, Selection, Skeleton, TreeEdgeId, ViewSpec};
use crate::topology::tracks::{Detection, DetectionSource, in_order};

/// A whole skeleton.
pub struct WholeSkeleton<'a, S: Site = Position> {
    /// The cloud as of the skeleton's frame.
    pub cloud: &'a Cloud<S>,
    /// The skeleton.
    pub skeleton: &'a Skeleton,
}

impl<S: Site> WholeSkeleton<'_, S> {
    /// The most persistent dots down to a persistence: at most `most`, and all that are as persistent as the last of
    /// these.
    pub fn first_dots(&self, most: usize, least: f64) -> Vec<&Dot> {
        let mut dots: Vec<&Dot> =
            self.skeleton.unsorted_dots().iter().filter(|dot| dot.persistence() >= least).collect();
        if most == 0 {
            dots.clear();
        } else if most < dots.len() {
            let by_persistence = |a: &&Dot, b: &&Dot| b.persistence().total_cmp(&a.persistence());
            let (_, last, _) = dots.select_nth_unstable_by(most - 1, by_persistence);
            let least = last.persistence();
            dots.retain(|dot| dot.persistence() >= least);
        }
        dots
    }
}

impl WholeSkeleton<'_> {
    /// Detections of dots. Takes time in proportion to the cloud.
    fn detect(&self, dots: &[&Dot]) -> Vec<Detection> {
        // Both lists are by id.
        let slots: Vec<Slot> = self.cloud.vertices().map(|(slot, _)| slot).collect();
        let slot = |vertex: u32| slots[vertex as usize];
        let detection = |dot: &&Dot| {
            let Killer::Triangle(triangle) = dot.killer else { return None };
            let critical = self.skeleton.critical(dot);
            let hole = self.skeleton.hole(dot)?;
            Some(Detection::new(self.cloud, critical, dot.edge.map(slot), triangle.map(slot), hole))
        };
        dots.iter().filter_map(detection).collect()
    }
}

impl<S: Site> HeldSkeleton for WholeSkeleton<'_, S> {
    fn vertex_count(&self) -> usize {
        self.skeleton.vertex_count()
    }

    fn vertices(&self) -> Vertices {
        HeldSkeleton::vertices(&self.skeleton)
    }

    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId> {
        self.skeleton.tree_between(low, high)
    }

    fn dots_down_to(&self, persistence: f64) -> Vec<Critical> {
        self.skeleton.dots_down_to(persistence)
    }

    fn select(&mut self, spec: ViewSpec) -> Option<Selection> {
        self.skeleton.select(spec)
    }
}

impl DetectionSource for WholeSkeleton<'_> {
    type Detection = Detection;

    fn detections(&mut self, most: usize, least: f64) -> Vec<Detection> {
        let mut detections = self.detect(&self.first_dots(most, least));
        in_order(&mut detections);
        detections
    }
}

/// A skeleton in tiles.
pub struct TiledSkeleton<'a> {
    /// Gives the ids of slots.
    pub cloud: &'a Cloud,
    /// The skeleton.
    pub tiles: &'a Tiles,
    /// The diagram of its dots, once gaps were asked for.
    pub diagram: &'a mut Option<Diagram<TileDot>>,
}

impl TiledSkeleton<'_> {
    fn dots(&self) -> impl Iterator<Item = Critical> + '_ {
        self.tiles.dots().map(|dot| tiled::critical(self.cloud, dot))
    }

    fn named_dots(&self) -> impl Iterator<Item = NamedDot<TileDot>> + '_ {
        self.tiles.dots().map(|dot| (tiled::critical(self.cloud, dot), *dot))
    }

    /// Asks the diagram, which is made at the first call.
    fn with_diagram<T>(&mut self, ask: impl Fn(&mut Diagram<TileDot>, &Self) -> T) -> T {
        let mut diagram = self.diagram.take().unwrap_or_else(|| Diagram::new(self.named_dots()));
        let answer = ask(&mut diagram, self);
        *self.diagram = Some(diagram);
        answer
    }
}

impl HeldSkeleton for TiledSkeleton<'_> {
    fn vertex_count(&self) -> usize {
        self.cloud.vertex_count()
    }

    fn vertices(&self) -> Vertices {
        self.cloud.vertices().map(|(_, vertex)| vertex).collect()
    }

    fn tree_between(&self, low: Option<f64>, high: f64) -> Vec<TreeEdgeId> {
        let edges =
            self.tiles.tree_between(|scale| low.is_some_and(|low| scale.sqrt() <= low), |scale| scale.sqrt() <= high);
        edges.iter().map(|edge| tiled::tree_edge(self.cloud, edge)).collect()
    }

    fn dots_down_to(&self, persistence: f64) -> Vec<Critical> {
        match &*self.diagram {
            Some(diagram) if diagram.is_sorted(persistence) => diagram.down_to(persistence).copied().collect(),
            _ => self.dots().filter(|dot| dot.death - dot.birth >= persistence).collect(),
        }
    }

    fn select(&mut self, spec: ViewSpec) -> Option<Selection> {
        let ViewSpec::Derived { k, l } = spec else { return None };
        Some(self.with_diagram(|diagram, held| diagram.select(k, l, held.tiles.largest_death(), || held.named_dots())))
    }
}

impl DetectionSource for TiledSkeleton<'_> {
    type Detection = Detection;

    fn detections(&mut self, most: usize, least: f64) -> Vec<Detection> {
        let named = self
            .with_diagram(|diagram, held| diagram.first(most, least, held.tiles.largest_death(), || held.named_dots()));
        let detection = |(critical, dot): NamedDot<TileDot>| {
            Detection::new(self.cloud, critical, dot.edge, dot.triangle, hole(self.cloud, dot.triangle, dot.death))
        };
        let mut detections: Vec<Detection> = named.into_iter().map(detection).collect();
        in_order(&mut detections);
        detections
    }
}
