//! What a picture of a skeleton shows.
//!
//! In: a skeleton, a view of it, perhaps the view's simplified form.
//! Out: a [`Scene`]: these, the colours of persistences, and the holes that are drawn.
//! Invariants: of equally persistent holes, all are drawn or none; the number of holes drawn is bounded.
//! Must not know: pixels.

use hopes::topology::{Dot, Hole, Skeleton, View, ViewSpec};

use super::canvas::ramp::Ramp;

/// Vertices and edges of a simplified skeleton.
pub type Simplified<'a> = (&'a [[f64; 2]], &'a [[u32; 2]]);

/// At most so many holes are drawn.
const HOLES: usize = 500;
/// Persistences are the same to the eye if they differ by less than this share.
const SAME: f64 = 1e-6;

/// What is to be shown.
pub(super) struct Scene<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) view: &'a View,
    pub(super) simplified: Option<Simplified<'a>>,
    pub(super) ramp: Ramp,
    /// Holes that are drawn.
    pub(super) holes: Vec<(Dot, Hole)>,
}

impl<'a> Scene<'a> {
    pub(super) fn new(skeleton: &'a Skeleton, view: &'a View, simplified: Option<Simplified<'a>>) -> Self {
        let persistences = skeleton.dots().iter().map(Dot::persistence).filter(|value| value.is_finite());
        let ramp = Ramp::new(persistences.fold(0.0, f64::max));
        Self { skeleton, view, simplified, ramp, holes: drawn_holes(skeleton, view) }
    }

    /// Dots whose critical edges are in the view, the most persistent first.
    pub(super) fn shown_dots(&self) -> impl Iterator<Item = &'a Dot> {
        let dots = self.skeleton.dots();
        self.view.critical.iter().map(move |&index| &dots[index as usize])
    }

    /// The scale of a reduced view.
    pub(super) fn alpha(&self) -> Option<f64> {
        match self.view.spec {
            ViewSpec::Reduced { alpha } => Some(alpha),
            ViewSpec::Full | ViewSpec::Derived { .. } => None,
        }
    }
}

/// Holes of the most persistent dots shown: of equals, all or none.
fn drawn_holes(skeleton: &Skeleton, view: &View) -> Vec<(Dot, Hole)> {
    let shown = || view.critical.iter().map(|&index| &skeleton.dots()[index as usize]);
    let limit = shown().nth(HOLES).map_or(0.0, |next| next.persistence() * (1.0 + SAME));
    let drawn = shown().take_while(|dot| dot.persistence() > limit);
    let holes = drawn.filter_map(|dot| Some((*dot, skeleton.hole(dot)?)));
    holes.filter(|(_, hole)| hole.radius.is_finite() && hole.center.iter().all(|v| v.is_finite())).collect()
}
