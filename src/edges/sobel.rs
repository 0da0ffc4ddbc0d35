//! Gradients of an image, row by row, with the result of OpenCV's `Sobel` with an aperture of 3.
//!
//! In: a row of pixels, the row above and the row below. Out: a [`Line`]: of each pixel the gradient in x and in y, and
//! its size in the L1 norm.
//!
//! Invariants: a pixel outside of the image equals the nearest pixel inside. 16 bits are exact: a gradient is at most
//! 1020, its size at most 2040. There is no branch on a pixel, so the compiler can vectorise the loops.
//!
//! Why ours: `canny` needs three rows at a time, in one pass and without whole gradient images, which libraries return.
//!
//! Must not know: what an edge is.

/// The gradients of a row.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// The gradient to the right.
    pub dx: Vec<i16>,
    /// The gradient downwards.
    pub dy: Vec<i16>,
    /// `|dx| + |dy|`, with a 0 before the first and after the last pixel.
    pub size: Vec<i16>,
    /// Of each column: above + 2 here + below. The first and the last column occur twice.
    sum: Vec<i16>,
    /// Of each column: below - above. The first and the last column occur twice.
    difference: Vec<i16>,
}

impl Line {
    /// Sets the width of the rows, and all gradients to 0.
    pub fn reset(&mut self, width: usize) {
        for (line, length) in [
            (&mut self.dx, width),
            (&mut self.dy, width),
            (&mut self.size, width + 2),
            (&mut self.sum, width + 2),
            (&mut self.difference, width + 2),
        ] {
            line.clear();
            line.resize(length, 0);
        }
    }

    /// Computes the gradients of a row. The row has the width that was set.
    pub fn take(&mut self, above: &[u8], here: &[u8], below: &[u8]) {
        let width = here.len();
        let columns = self.sum[1..=width].iter_mut().zip(&mut self.difference[1..=width]);
        for ((sum, difference), ((&above, &here), &below)) in columns.zip(above.iter().zip(here).zip(below)) {
            let (above, here, below) = (i16::from(above), i16::from(here), i16::from(below));
            *sum = above + 2 * here + below;
            *difference = below - above;
        }
        for line in [&mut self.sum, &mut self.difference] {
            line[0] = line[1];
            line[width + 1] = line[width];
        }
        let sums = self.sum[..width].iter().zip(&self.sum[2..]);
        for (dx, (&left, &right)) in self.dx.iter_mut().zip(sums) {
            *dx = right - left;
        }
        let differences = self.difference[..width].iter().zip(&self.difference[1..=width]).zip(&self.difference[2..]);
        for (dy, ((&left, &middle), &right)) in self.dy.iter_mut().zip(differences) {
            *dy = left + 2 * middle + right;
        }
        for (size, (dx, dy)) in self.size[1..=width].iter_mut().zip(self.dx.iter().zip(&self.dy)) {
            *size = dx.abs() + dy.abs();
        }
    }
}
