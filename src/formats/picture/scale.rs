//! The scale of a persistence diagram.
//!
//! In: a [`Scene`], the side of the panel.
//! Out: births and deaths in pixels.
//! Invariants: both axes begin at 0 and have one scale; a dot that never dies is on the upper edge.
//! Must not know: what is drawn there.

use super::scene::Scene;

/// Room above the highest dot, as a share of its height.
const HEADROOM: f64 = 1.06;

/// Maps births and deaths to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// Side of the panel.
    pub(super) side: f64,
    /// The largest value that fits.
    pub(super) top: f64,
}

impl Scale {
    pub(super) fn new(scene: &Scene<'_>, side: f64) -> Self {
        let deaths = scene.skeleton.dots().iter().map(|dot| dot.death).filter(|death| death.is_finite());
        let highest = deaths.fold(0.0, f64::max);
        let alpha = scene.alpha().filter(|&alpha| alpha <= 2.0 * highest).unwrap_or(0.0);
        Self { side, top: HEADROOM * highest.max(alpha) }
    }

    /// Pixels from 0.
    pub(super) fn length(self, value: f64) -> f64 {
        value.min(self.top) / self.top * self.side
    }

    /// Where a dot is.
    pub(super) fn place(self, birth: f64, death: f64) -> [f64; 2] {
        [self.length(birth), self.side - self.length(death)]
    }
}
