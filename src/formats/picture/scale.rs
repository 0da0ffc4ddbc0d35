//! The scale of a persistence diagram.
//!
//! In: a [`Scene`], the side of the panel.
//! Out: births and deaths in pixels.
//! Invariants: both axes begin at 0 and have one scale; dots that never die are on a line above all others.
//! Must not know: what is drawn there.

use super::scene::Scene;

/// Room above the highest dot, as a share of its height.
const HEADROOM: f64 = 1.06;
/// The same below the line of dots that never die.
const LINE_HEADROOM: f64 = 1.16;
/// Where that line is, from above.
const LINE: f64 = 14.0;

/// Maps births and deaths to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// Side of the panel.
    pub(super) side: f64,
    /// The largest value that fits.
    pub(super) top: f64,
    /// Whether there are dots that never die.
    has_immortals: bool,
}

impl Scale {
    pub(super) fn new(scene: &Scene<'_>, side: f64) -> Self {
        let dots = scene.skeleton.dots();
        let has_immortals = dots.iter().any(|dot| dot.death.is_infinite());
        let highest =
            dots.iter().map(|dot| if dot.death.is_finite() { dot.death } else { dot.birth }).fold(0.0, f64::max);
        let alpha = scene.alpha().filter(|&alpha| alpha <= 2.0 * highest).unwrap_or(0.0);
        let headroom = if has_immortals { LINE_HEADROOM } else { HEADROOM };
        Self { side, top: headroom * highest.max(alpha), has_immortals }
    }

    /// Pixels from 0.
    pub(super) fn length(self, value: f64) -> f64 {
        value.min(self.top) / self.top * self.side
    }

    /// Where a dot is.
    pub(super) fn place(self, birth: f64, death: f64) -> [f64; 2] {
        let y = if death.is_finite() { self.side - self.length(death) } else { LINE };
        [self.length(birth), y]
    }

    /// Where the line of dots that never die is, if there are any.
    pub(super) fn line(self) -> Option<f64> {
        self.has_immortals.then_some(LINE)
    }
}
