//! A single picture: its edges as a cloud of points, and itself as a small picture to draw under them.
//!
//! In: the bytes of a PNG or a JPEG.
//! Out: edge pixels, y up from the bottom row; a PNG of bounded size.
//! Invariants: the picture is gray, as the detector sees it, and stands as its Exif says. The small picture depends on
//! pixels alone.
//! Must not know: skeletons, where pictures are drawn.

use std::io::Read;

use hopes::edges::{Detector, View, ViewError};
use thiserror::Error;

use super::decode::{self, DecodeError, JPEG, PNG};
use super::image::GrayImage;

/// The longest side of the small picture, in pixels: enough for a panel at twice its size.
const LONGEST: u32 = 960;

/// Why a picture gives no cloud.
#[derive(Debug, Error)]
pub enum PhotoError {
    /// It cannot be read.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// It has no pixels, or too many.
    #[error(transparent)]
    Size(#[from] ViewError),
}

/// A picture in memory.
#[derive(Debug)]
pub struct Photo(GrayImage);

/// Whether a file that begins with these bytes is a picture.
pub fn is_picture(first: &[u8]) -> bool {
    first.starts_with(PNG) || first.starts_with(JPEG)
}

impl Photo {
    /// Reads a picture to its end.
    ///
    /// # Errors
    /// [`PhotoError::Decode`].
    pub fn read(source: impl Read) -> Result<Self, PhotoError> {
        Ok(Self(decode::read(source)?))
    }

    /// Pixels in a row, and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.0.width, self.0.height]
    }

    /// The pixels on edges, row by row; y counts from the bottom row upwards.
    ///
    /// # Errors
    /// [`PhotoError::Size`].
    pub fn edges(&self, detector: &mut Detector) -> Result<Vec<[f64; 2]>, PhotoError> {
        let GrayImage { width, height, ref pixels } = self.0;
        let upright = |&[x, y]: &[u32; 2]| [f64::from(x), f64::from(height - 1 - y)];
        Ok(detector.edges(View::new(pixels, width, height)?).iter().map(upright).collect())
    }

    /// The picture as a PNG, no side of which is longer than a panel needs.
    pub fn small_png(&self) -> Vec<u8> {
        let GrayImage { width, height, pixels } = self.reduced();
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().expect("a picture has pixels, and memory takes all bytes");
        writer.write_image_data(&pixels).expect("there is a byte for each pixel");
        writer.finish().expect("memory takes all bytes");
        bytes
    }

    /// Squares of pixels become one, of their mean level.
    fn reduced(&self) -> GrayImage {
        let GrayImage { width, height, ref pixels } = self.0;
        let step = width.max(height).div_ceil(LONGEST).max(1);
        let [columns, rows] = [width, height].map(|side| side.div_ceil(step));
        let mean = |column: u32, row: u32| {
            let [xs, ys] = [(column, width), (row, height)].map(|(at, end)| at * step..((at + 1) * step).min(end));
            let (mut sum, mut count) = (0_u32, 0_u32);
            for y in ys {
                let start = (y * width) as usize;
                let line = &pixels[start + xs.start as usize..start + xs.end as usize];
                sum += line.iter().map(|&level| u32::from(level)).sum::<u32>();
                count += line.len() as u32;
            }
            ((sum + count / 2) / count) as u8
        };
        let pixels = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        GrayImage { width: columns, height: rows, pixels: pixels.map(|(column, row)| mean(column, row)).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn photo(width: u32, height: u32, level: impl Fn(u32, u32) -> u8) -> Photo {
        let pixels = (0..width * height).map(|at| level(at % width, at / width)).collect();
        Photo(GrayImage { width, height, pixels })
    }

    #[test]
    fn edges_stand_upright() {
        // Light in the top row only: the edge is there.
        let photo = photo(5, 6, |_, y| if y == 0 { 255 } else { 0 });
        let edges = photo.edges(&mut Detector::new(hopes::edges::Options::default()).unwrap()).unwrap();
        assert!(!edges.is_empty() && edges.iter().all(|&[_, y]| y >= 4.0), "{edges:?}");
    }

    #[test]
    fn small_pictures_keep_levels_and_are_small() {
        let as_it_is = photo(3, 2, |x, y| (10 * x + y) as u8).reduced();
        assert_eq!((as_it_is.width, as_it_is.height, as_it_is.pixels), (3, 2, vec![0, 10, 20, 1, 11, 21]));
        let wide = photo(2 * LONGEST + 1, 5, |x, _| if x % 2 == 0 { 0 } else { 90 });
        let reduced = wide.reduced();
        assert_eq!((reduced.width, reduced.height), (641, 2));
        assert!(reduced.pixels.iter().all(|&level| level == 30 || level == 60 || level == 45 || level == 0));
        assert!(is_picture(&wide.small_png()));
    }
}
