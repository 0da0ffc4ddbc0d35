//! What a picture of a skeleton shows.
//!
//! In: a skeleton, where its vertices are drawn, a view of it, perhaps the view's simplified form.
//! Out: a [`Scene`]: these, the colours of persistences, and the holes or cycles that are drawn.
//! Invariants: of equally persistent holes, all are drawn or none, of cycles too; their number is bounded.
//! Must not know: pixels.

use std::borrow::Cow;

use hopes::topology::{Dot, Filtration, Hole, Positions, ShortestCycles, Skeleton, View, ViewSpec};

use super::super::layout::Layout;
use super::canvas::ramp::Ramp;

/// Vertices and edges of a simplified skeleton.
pub type Simplified<'a> = (&'a [[f64; 2]], &'a [[u32; 2]]);

/// A skeleton, and where its vertices are drawn.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The whole skeleton.
    pub skeleton: &'a Skeleton,
    /// The places of its vertices; none in the plane, where they are their positions.
    pub layout: Option<&'a Layout<2>>,
    /// Where points are that were left out as outliers. They are drawn, but are no vertices.
    pub outliers: &'a [[f64; 2]],
}

impl Subject<'_> {
    /// Where a vertex is drawn.
    pub(super) fn xy(&self, vertex: u32) -> [f64; 2] {
        self.layout.map_or_else(|| self.skeleton.vertices().xy(vertex), |layout| layout.places()[vertex as usize])
    }

    /// Where all vertices are drawn.
    pub(super) fn places(&self) -> impl ExactSizeIterator<Item = [f64; 2]> + '_ {
        (0..self.skeleton.vertices().len() as u32).map(|vertex| self.xy(vertex))
    }

    /// Whether lengths on the picture are lengths of the space.
    pub(super) fn has_lengths(&self) -> bool {
        self.layout.is_none_or(Layout::has_lengths)
    }
}

impl<'a> From<&'a Skeleton> for Subject<'a> {
    fn from(skeleton: &'a Skeleton) -> Self {
        Self { skeleton, layout: None, outliers: &[] }
    }
}

/// Where the vertices of a simplified view are drawn.
pub fn places<'a>(positions: &'a Positions, layout: Option<&Layout<2>>) -> Cow<'a, [[f64; 2]]> {
    layout.map_or_else(|| positions.planar().into(), |layout| layout.of_positions(positions).into())
}

/// At most so many holes or cycles are drawn.
const HOLES: usize = 500;
/// Persistences are the same to the eye if they differ by less than this share.
const SAME: f64 = 1e-6;

/// What is to be shown.
pub(super) struct Scene<'a> {
    pub(super) of: Subject<'a>,
    pub(super) skeleton: &'a Skeleton,
    pub(super) view: &'a View,
    pub(super) simplified: Option<Simplified<'a>>,
    pub(super) ramp: Ramp,
    /// Holes that are drawn.
    pub(super) holes: Vec<(Dot, Hole)>,
}

impl<'a> Scene<'a> {
    pub(super) fn new(of: Subject<'a>, view: &'a View, simplified: Option<Simplified<'a>>) -> Self {
        let skeleton = of.skeleton;
        let persistences = skeleton.dots().iter().map(Dot::persistence).filter(|value| value.is_finite());
        let ramp = Ramp::new(persistences.fold(0.0, f64::max));
        Self { of, skeleton, view, simplified, ramp, holes: drawn_holes(skeleton, view) }
    }

    /// Dots whose critical edges are in the view, the most persistent first.
    pub(super) fn shown_dots(&self) -> impl Iterator<Item = &'a Dot> {
        let dots = self.skeleton.dots();
        self.view.critical.iter().map(move |&index| &dots[index as usize])
    }

    /// Whether cycles are drawn: where no hole has a place of its own.
    pub(super) fn has_cycles(&self) -> bool {
        self.skeleton.filtration() == Filtration::Rips && !self.view.critical.is_empty()
    }

    /// The cycles that are drawn, each the shortest of its dot, the most persistent first.
    pub(super) fn cycles(&self) -> Vec<(Dot, Vec<u32>)> {
        if !self.has_cycles() {
            return Vec::new();
        }
        let shortest = ShortestCycles::new(self.skeleton);
        drawn_dots(self.skeleton, self.view).map(|dot| (*dot, shortest.cycle(dot))).collect()
    }

    /// The scale of a reduced view.
    pub(super) fn alpha(&self) -> Option<f64> {
        match self.view.spec {
            ViewSpec::Reduced { alpha } => Some(alpha),
            ViewSpec::Full | ViewSpec::Derived { .. } => None,
        }
    }
}

/// The most persistent dots shown: of equals, all or none.
fn drawn_dots<'a>(skeleton: &'a Skeleton, view: &'a View) -> impl Iterator<Item = &'a Dot> {
    let shown = || view.critical.iter().map(|&index| &skeleton.dots()[index as usize]);
    let limit = shown().nth(HOLES).map_or(0.0, |next| next.persistence() * (1.0 + SAME));
    shown().take_while(move |dot| dot.persistence() > limit)
}

/// Their holes, as far as they have one.
fn drawn_holes(skeleton: &Skeleton, view: &View) -> Vec<(Dot, Hole)> {
    let holes = drawn_dots(skeleton, view).filter_map(|dot| Some((*dot, skeleton.hole(dot)?)));
    holes.filter(|(_, hole)| hole.radius.is_finite() && hole.center.iter().all(|v| v.is_finite())).collect()
}
