//! A gray image, or a part of one, as the stages look at it.
//!
//! In: pixels in memory, row by row. Out: rows. Invariants: a view has at least one pixel and at most [`MOST_PIXELS`],
//! and all of its rows are there. Must not know: what is looked for in it.

use thiserror::Error;

use super::MOST_PIXELS;

/// A gray image of 8 bits a pixel, in somebody else's memory.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// From the first pixel of the first row to the last of the last.
    pixels: &'a [u8],
    width: usize,
    height: usize,
    /// From one row to the next.
    stride: usize,
}

/// Why there is no such view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ViewError {
    /// Nothing to see.
    #[error("an image of {width} x {height} has no pixels")]
    Empty {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// More than [`MOST_PIXELS`].
    #[error("an image of {width} x {height} is too large: {MOST_PIXELS} pixels are the most")]
    TooLarge {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Its pixels are not all there, or there are more.
    #[error("{found} bytes are no image of {width} x {height}")]
    Length {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Pixels that there are.
        found: usize,
    },
    /// It reaches beyond the image.
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
        /// Columns that there are.
        outer_width: usize,
        /// Rows that there are.
        outer_height: usize,
    },
}

/// How many pixels an image of that size has.
///
/// # Errors
/// [`ViewError`]: none, or too many.
pub(super) fn pixels(width: u32, height: u32) -> Result<usize, ViewError> {
    match u64::from(width) * u64::from(height) {
        0 => Err(ViewError::Empty { width, height }),
        pixels @ 1..=MOST_PIXELS => Ok(pixels as usize),
        _ => Err(ViewError::TooLarge { width, height }),
    }
}

impl<'a> View<'a> {
    /// All of an image.
    ///
    /// # Errors
    /// [`ViewError`].
    pub fn new(pixels: &'a [u8], width: u32, height: u32) -> Result<Self, ViewError> {
        if self::pixels(width, height)? != pixels.len() {
            return Err(ViewError::Length { width, height, found: pixels.len() });
        }
        Ok(Self { pixels, width: width as usize, height: height as usize, stride: width as usize })
    }

    /// A part of it: a column and a row, and how many of each.
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

    /// Pixels in a row.
    pub fn width(self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(self) -> usize {
        self.height
    }

    /// A row.
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
    fn what_is_no_image_says_why() {
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
