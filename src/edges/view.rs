//! A borrowed gray image, or a rectangle of one.
//!
//! In: pixels in memory, row by row. Out: rows.
//!
//! Invariants: a view has at least one pixel and at most [`MOST_PIXELS`], and all of its rows are in memory.
//!
//! Must not know: what is computed from it.

use thiserror::Error;

use super::MOST_PIXELS;

/// A gray image of 8 bits a pixel in borrowed memory.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// From the first pixel of the first row to the last pixel of the last row.
    pixels: &'a [u8],
    width: usize,
    height: usize,
    /// The distance between the beginnings of two rows.
    stride: usize,
}

/// Why a view is not valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ViewError {
    /// The image has no pixels.
    #[error("an image of {width} x {height} has no pixels")]
    Empty {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The image has more than [`MOST_PIXELS`] pixels.
    #[error("an image of {width} x {height} is too large: {MOST_PIXELS} pixels are the most")]
    TooLarge {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The number of bytes does not match the size.
    #[error("{found} bytes are no image of {width} x {height}")]
    Length {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The number of bytes.
        found: usize,
    },
    /// The rectangle reaches beyond the image.
    #[error(
        "the part of {width} x {height} pixels from {x},{y} reaches beyond an image of {outer_width} x {outer_height}"
    )]
    Outside {
        /// First column.
        x: u32,
        /// First row.
        y: u32,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Columns of the image.
        outer_width: usize,
        /// Rows of the image.
        outer_height: usize,
    },
}

/// The number of pixels of an image of this size.
///
/// # Errors
/// [`ViewError`]: there are none, or too many.
pub(super) fn pixels(width: u32, height: u32) -> Result<usize, ViewError> {
    match u64::from(width) * u64::from(height) {
        0 => Err(ViewError::Empty { width, height }),
        pixels @ 1..=MOST_PIXELS => Ok(pixels as usize),
        _ => Err(ViewError::TooLarge { width, height }),
    }
}

impl<'a> View<'a> {
    /// A view of a whole image.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn new(pixels: &'a [u8], width: u32, height: u32) -> Result<Self, ViewError> {
        if self::pixels(width, height)? != pixels.len() {
            return Err(ViewError::Length { width, height, found: pixels.len() });
        }
        Ok(Self { pixels, width: width as usize, height: height as usize, stride: width as usize })
    }

    /// A rectangle of the view: first column, first row, number of columns, number of rows.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn part(self, [x, y, width, height]: [u32; 4]) -> Result<Self, ViewError> {
        self::pixels(width, height)?;
        let reaches = |from: u32, length: u32, end: usize| u64::from(from) + u64::from(length) > end as u64;
        if reaches(x, width, self.width) || reaches(y, height, self.height) {
            let (outer_width, outer_height) = (self.width, self.height);
            return Err(ViewError::Outside { x, y, width, height, outer_width, outer_height });
        }
        let (width, height) = (width as usize, height as usize);
        let first = y as usize * self.stride + x as usize;
        let pixels = &self.pixels[first..first + (height - 1) * self.stride + width];
        Ok(Self { pixels, width, height, stride: self.stride })
    }

    /// The number of pixels in a row.
    pub fn width(self) -> usize {
        self.width
    }

    /// The number of rows.
    pub fn height(self) -> usize {
        self.height
    }

    /// The pixels of a row.
    pub(super) fn row(self, y: usize) -> &'a [u8] {
        &self.pixels[y * self.stride..][..self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_parts_have_the_right_rows() {
        let pixels: Vec<u8> = (0..30).collect();
        let whole = View::new(&pixels, 6, 5).unwrap();
        let part = whole.part([1, 2, 4, 3]).unwrap();
        assert_eq!((part.width(), part.height(), part.row(0), part.row(2)), (4, 3, &pixels[13..17], &pixels[25..29]));
        let corner = part.part([3, 2, 1, 1]).unwrap();
        assert_eq!(corner.row(0), [28]);
        assert_eq!(whole.part([0, 0, 6, 5]).unwrap().row(4), &pixels[24..]);
    }

    #[test]
    fn invalid_views_give_errors_that_say_why() {
        let view = View::new(&[0; 6], 3, 2).unwrap();
        for (refused, words) in [
            (View::new(&[], 0, 7).err(), "0 x 7 has no pixels"),
            (View::new(&[0; 5], 3, 2).err(), "5 bytes are no image of 3 x 2"),
            (View::new(&[0; 5], u32::MAX, u32::MAX).err(), "4294967295 x 4294967295 is too large: 67108864 pixels"),
            (view.part([0, 0, 3, 0]).err(), "has no pixels"),
            (view.part([1, 0, 3, 2]).err(), "the part of 3 x 2 pixels from 1,0 reaches beyond an image of 3 x 2"),
            (view.part([u32::MAX, u32::MAX, 1, 1]).err(), "reaches beyond"),
        ] {
            let refused = refused.expect(words).to_string();
            assert!(refused.contains(words), "{refused}");
        }
    }
}
