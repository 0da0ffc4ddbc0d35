//! A Gaussian blur with the result of OpenCV's `GaussianBlur(image, (0, 0), sigma)` for 8 bits a pixel.
//!
//! In: an image and a standard deviation. Out: an image of the same size.
//!
//! Invariants: the result equals OpenCV's bit for bit. Weights are whole 256ths. The rounding error of a weight is
//! added to the next one, and the middle weight gets the rest, so the weights add up to 256. The image is mirrored at
//! its borders. Only the final sum is rounded.
//!
//! Why ours: the blurs of `imageproc` and other crates work in floating point and round differently, so their edges
//! would not be OpenCV's.
//!
//! Must not know: what the image is for.

use super::View;

/// A blur of a fixed width. It keeps its buffers from image to image.
#[derive(Clone, Debug)]
pub struct Blur {
    /// An odd number of weights, which add up to 256.
    weights: Vec<u16>,
    /// A row, extended by its mirror image at both ends.
    row: Vec<u8>,
    /// The image, blurred along rows. Values are multiplied by 256.
    across: Vec<u16>,
    /// A row of sums.
    sums: Vec<u32>,
    pixels: Vec<u8>,
}

impl Blur {
    /// `sigma` is above 0 and at most [`MOST_SIGMA`](super::MOST_SIGMA).
    pub fn new(sigma: f64) -> Self {
        Self { weights: weights(sigma), row: Vec::new(), across: Vec::new(), sums: Vec::new(), pixels: Vec::new() }
    }

    /// The blurred image.
    pub fn blurred(&mut self, image: View<'_>) -> View<'_> {
        let (width, height) = (image.width(), image.height());
        self.across.clear();
        self.across.resize(width * height, 0);
        for (y, across) in self.across.chunks_exact_mut(width).enumerate() {
            extend(image.row(y), self.weights.len() / 2, &mut self.row);
            for (start, &weight) in self.weights.iter().enumerate() {
                for (sum, &pixel) in across.iter_mut().zip(&self.row[start..]) {
                    *sum += weight * u16::from(pixel);
                }
            }
        }
        self.pixels.clear();
        for y in 0..height {
            self.blur_column_sums(y, width, height);
        }
        View::new(&self.pixels, width as u32, height as u32).expect("the blurred image has the size of a valid image")
    }

    /// Blurs along columns: appends one row of pixels.
    fn blur_column_sums(&mut self, y: usize, width: usize, height: usize) {
        self.sums.clear();
        // Half a unit, to round.
        self.sums.resize(width, 1 << 15);
        let reach = (self.weights.len() / 2) as isize;
        for (offset, &weight) in (-reach..).zip(&self.weights) {
            let other = mirrored(y as isize + offset, height);
            for (sum, &across) in self.sums.iter_mut().zip(&self.across[other * width..]) {
                *sum += u32::from(weight) * u32::from(across);
            }
        }
        self.pixels.extend(self.sums.iter().map(|&sum| (sum >> 16) as u8));
    }
}

/// The weights from one end of the kernel to the other.
fn weights(sigma: f64) -> Vec<u16> {
    let count = (sigma * 6.0 + 1.0).round_ties_even() as usize | 1;
    let half = count / 2;
    let gaussian: Vec<f64> =
        (1..=half).rev().map(|away| (-0.5 / (sigma * sigma) * (away * away) as f64).exp()).collect();
    let scale = 256.0 / (2.0 * gaussian.iter().sum::<f64>() + 1.0);
    let mut lost = 0.0;
    let side = gaussian.iter().map(|height| {
        let exact = height * scale + lost;
        let whole = exact.round_ties_even();
        lost = exact - whole;
        whole as u16
    });
    let side: Vec<u16> = side.collect();
    let middle = 256 - 2 * side.iter().sum::<u16>();
    side.iter().chain([&middle]).chain(side.iter().rev()).copied().collect()
}

/// Extends a row by `reach` pixels of its mirror image at either end.
fn extend(row: &[u8], reach: usize, extended: &mut Vec<u8>) {
    extended.clear();
    let reach = reach as isize;
    extended.extend((-reach..0).map(|at| row[mirrored(at, row.len())]));
    extended.extend_from_slice(row);
    let length = row.len() as isize;
    extended.extend((length..length + reach).map(|at| row[mirrored(at, row.len())]));
}

/// Maps a position outside of a row to the position whose pixel is mirrored there.
fn mirrored(at: isize, length: usize) -> usize {
    let last = length as isize - 1;
    if last == 0 {
        return 0;
    }
    let at = at.rem_euclid(2 * last);
    at.min(2 * last - at) as usize
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::edges::reference;

    /// These are 256 times the values of `cv2.getGaussianKernel`, rounded as in `cv2.GaussianBlur`. `tests/edges.rs`
    /// compares whole images.
    #[test]
    fn weights_are_those_of_opencv() {
        assert_eq!(weights(0.05), [256]);
        assert_eq!(weights(0.5), [0, 27, 202, 27, 0]);
        assert_eq!(weights(1.0), [1, 14, 62, 102, 62, 14, 1]);
        assert_eq!(weights(1.4), [1, 8, 26, 56, 74, 56, 26, 8, 1]);
    }

    #[test]
    fn weights_add_up_at_any_width() {
        for step in 1..=10_000 {
            let sigma = f64::from(step) / 100.0;
            let weights = weights(sigma);
            assert_eq!(weights.iter().map(|&weight| u32::from(weight)).sum::<u32>(), 256, "{sigma}");
            assert!(weights.len() % 2 == 1 && weights.iter().eq(weights.iter().rev()), "{sigma}");
        }
    }

    #[test]
    fn an_image_of_one_colour_does_not_change() {
        for colour in [0, 1, 254, 255] {
            let image = [colour; 35];
            let mut blur = Blur::new(3.3);
            assert_eq!(blur.blurred(View::new(&image, 7, 5).unwrap()).row(4), [colour; 7]);
        }
    }

    proptest! {
        #[test]
        fn differential_against_the_definition(
            (pixels, width) in (1..12_usize, 1..12_usize)
                .prop_flat_map(|(width, height)| (prop::collection::vec(any::<u8>(), width * height), Just(width))),
            sigma in 0.05..8.0_f64,
        ) {
            let mut blur = Blur::new(sigma);
            let image = View::new(&pixels, width as u32, (pixels.len() / width) as u32).unwrap();
            let expected = reference::blur(&pixels, width, &weights(sigma));
            let blurred = blur.blurred(image);
            let rows: Vec<u8> = (0..blurred.height()).flat_map(|y| blurred.row(y).to_vec()).collect();
            prop_assert_eq!(rows, expected);
        }
    }
}
