//! Edges of gray images, as OpenCV's `Canny` defines them.
//!
//! In: gray images of 8 bits a pixel, each as a [`View`]. Out: edge pixels, row by row. [`gray`] converts colours.
//!
//! ```text
//! colours ─▶ gray ─▶ (crop) ─▶ (blur) ─▶ sobel ─▶ canny: thin, then follow ─▶ edge pixels
//! ```
//!
//! Invariants: the pixels are exactly those of `cv2.Canny(image, low, high)` with an aperture of 3 and the L1 norm. The
//! blur is exactly `cv2.GaussianBlur(image, (0, 0), sigma)`. So published thresholds mean the same here. All decisions
//! are made with integers. The cost of an image is bounded by its number of pixels.
//!
//! Must not know: files, formats, video, topology.

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

/// The largest number of pixels of an image.
pub const MOST_PIXELS: u64 = 1 << 26;

/// The largest standard deviation of a blur.
pub const MOST_SIGMA: f64 = 100.0;

/// The parameters of the detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The low threshold: gradients above it continue an edge.
    pub low: f64,
    /// The high threshold: gradients above it begin an edge. The two thresholds may come in any order.
    pub high: f64,
    /// The standard deviation of a Gaussian blur before: above 0 and at most [`MOST_SIGMA`]. None: no blur.
    pub blur: Option<f64>,
}

impl Default for Options {
    /// The thresholds of the paper.
    fn default() -> Self {
        Self { low: 150.0, high: 450.0, blur: None }
    }
}

/// An option that is out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum OptionError {
    /// [`Options::low`] or [`Options::high`].
    #[error("{0} is not a threshold: it must be a number from 0 up")]
    Threshold(f64),
    /// [`Options::blur`].
    #[error("{0} is not a standard deviation for a blur: it must be above 0 and at most 100")]
    Sigma(f64),
}

impl Options {
    /// Checks the ranges.
    ///
    /// # Errors
    /// [`OptionError`]: which option is out of its range.
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

/// Finds the edges of images. It keeps its buffers from image to image.
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
    /// A detector with these options.
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
