//! Edges of gray images, as OpenCV's `Canny` defines them.
//!
//! In: gray images of 8 bits a pixel, as a [`View`] each. Out: edge pixels, row by row. Whoever has colours makes them
//! [`gray`] first.
//!
//! ```text
//! colours ─▶ gray ─▶ (crop) ─▶ (blur) ─▶ sobel ─▶ canny: thin, then follow ─▶ edge pixels
//! ```
//!
//! Invariants: the pixels are exactly those of `cv2.Canny(image, low, high)` with an aperture of 3 and the L1 norm, and
//! blurring before is exactly `cv2.GaussianBlur(image, (0, 0), sigma)`, so thresholds that somebody published mean the
//! same here; integers decide everything; what an image costs is bounded by its pixels. Must not know: files, formats,
//! video, topology.

mod blur;
mod canny;
pub mod gray;
#[cfg(test)]
mod reference;
mod sobel;
mod view;

use thiserror::Error;

use blur::Blur;
use canny::Canny;
pub use view::{View, ViewError};

/// Pixels of an image, at the most.
pub const MOST_PIXELS: u64 = 1 << 26;

/// The widest blur.
pub const MOST_SIGMA: f64 = 100.0;

/// What counts as an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Gradients above it go on with an edge.
    pub low: f64,
    /// Gradients above it begin an edge. The lower of the two is the low one.
    pub high: f64,
    /// Blur before, by a Gaussian of this standard deviation: above 0, to [`MOST_SIGMA`].
    pub blur: Option<f64>,
}

impl Default for Options {
    /// As in the paper.
    fn default() -> Self {
        Self { low: 150.0, high: 450.0, blur: None }
    }
}

/// Options that mean nothing.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OptionError {
    /// [`Options::low`] or [`Options::high`].
    #[error("{0} is no threshold: it must be a number, from 0")]
    Threshold(f64),
    /// [`Options::blur`].
    #[error("{0} is no standard deviation to blur by: take a number above 0, to 100")]
    Sigma(f64),
}

impl Options {
    /// Whether they mean anything.
    ///
    /// # Errors
    /// [`OptionError`]: which one does not.
    pub fn check(&self) -> Result<(), OptionError> {
        for threshold in [self.low, self.high] {
            if !(threshold >= 0.0 && threshold.is_finite()) {
                return Err(OptionError::Threshold(threshold));
            }
        }
        match self.blur {
            Some(sigma) if !(sigma > 0.0 && sigma <= MOST_SIGMA) => Err(OptionError::Sigma(sigma)),
            _ => Ok(()),
        }
    }
}

/// Finds the edges of images, one after the other; what it works with is kept from one to the next.
///
/// ```
/// use hopes::edges::{Detector, Options, View};
///
/// // Dark on the left, light on the right.
/// let pixels: Vec<u8> = (0..8 * 4).map(|at| if at % 8 < 4 { 20 } else { 220 }).collect();
/// let mut detector = Detector::new(Options::default())?;
/// let edges = detector.edges(View::new(&pixels, 8, 4)?);
/// assert_eq!(edges, [[3, 0], [3, 1], [3, 2], [3, 3]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Detector {
    canny: Canny,
    blur: Option<Blur>,
}

impl Detector {
    /// Nothing was seen yet.
    ///
    /// # Errors
    /// [`OptionError`].
    pub fn new(options: Options) -> Result<Self, OptionError> {
        options.check()?;
        Ok(Self { canny: Canny::new(options.low, options.high), blur: options.blur.map(Blur::new) })
    }

    /// The edge pixels of an image: x to the right, y down, row by row.
    pub fn edges(&mut self, image: View<'_>) -> &[[u32; 2]] {
        match &mut self.blur {
            None => self.canny.edges(image),
            Some(blur) => self.canny.edges(blur.blurred(image)),
        }
    }
}
