//! A Gaussian blur, as OpenCV's `GaussianBlur(image, (0, 0), sigma)` has it for 8 bits a pixel.
//!
//! In: an image and a standard deviation. Out: an image of the same size. Invariants: as OpenCV, to the bit: weights
//! are whole 256ths, what is lost by rounding one is given to the next, and the middle one gets the rest, so they add
//! up to 256; what lies outside of an image is its mirror image; nothing is rounded before the end. Must not know: what
//! the image is for.

use super::View;

/// Blurs, and keeps the memory for it.
#[derive(Clone, Debug)]
pub struct Blur {
    /// Odd in number; they add up to 256.
    weights: Vec<u16>,
    /// A row and its mirror images at both ends.
    row: Vec<u8>,
    /// The image, blurred along rows: 256 times as light.
    across: Vec<u16>,
    /// A row of sums.
    sums: Vec<u32>,
    pixels: Vec<u8>,
}

impl Blur {
    /// The standard deviation is above 0, and bounded.
    pub fn new(sigma: f64) -> Self {
        Self { weights: weights(sigma), row: Vec::new(), across: Vec::new(), sums: Vec::new(), pixels: Vec::new() }
    }

    /// An image, blurred.
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
            self.mix(y, width, height);
        }
        View::new(&self.pixels, width as u32, height as u32).expect("it is as large as the image that was given")
    }

    /// Blurs along columns: makes one more row.
    fn mix(&mut self, y: usize, width: usize, height: usize) {
        self.sums.clear();
        // For rounding.
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

/// The weights of pixels, from one end to the other.
fn weights(sigma: f64) -> Vec<u16> {
    let count = (sigma * 6.0 + 1.0).round_ties_even() as usize | 1;
    let half = count / 2;
    let bell: Vec<f64> = (1..=half).rev().map(|away| (-0.5 / (sigma * sigma) * (away * away) as f64).exp()).collect();
    let scale = 256.0 / (2.0 * bell.iter().sum::<f64>() + 1.0);
    let mut lost = 0.0;
    let side = bell.iter().map(|height| {
        let exact = height * scale + lost;
        let whole = exact.round_ties_even();
        lost = exact - whole;
        whole as u16
    });
    let side: Vec<u16> = side.collect();
    let middle = 256 - 2 * side.iter().sum::<u16>();
    side.iter().chain([&middle]).chain(side.iter().rev()).copied().collect()
}

/// A row with so many pixels of its mirror image at either end.
fn extend(row: &[u8], reach: usize, extended: &mut Vec<u8>) {
    extended.clear();
    let reach = reach as isize;
    extended.extend((-reach..0).map(|at| row[mirrored(at, row.len())]));
    extended.extend_from_slice(row);
    let length = row.len() as isize;
    extended.extend((length..length + reach).map(|at| row[mirrored(at, row.len())]));
}

/// Which of so many it is, if both ends are mirrors.
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

    /// 256 times what `cv2.getGaussianKernel` gives, but rounded as `cv2.GaussianBlur` does; `tests/edges.rs` compares
    /// whole images.
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
    fn one_colour_stays_as_it_is() {
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
