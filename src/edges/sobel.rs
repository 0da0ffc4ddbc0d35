//! Gradients of an image, row by row, as OpenCV's `Sobel` with an aperture of 3 has them.
//!
//! In: a row of pixels and the ones above and below. Out: a [`Line`]: the gradient in x and y of each pixel, and its
//! size in the L1 norm. Invariants: what lies outside of an image is as its nearest pixel; all is exact in 16 bits (a
//! gradient is 1020 at the most, its size 2040); there is no branch on a pixel, so that several are computed at once.
//! Must not know: what is an edge.

/// The gradients of a row.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// To the right.
    pub dx: Vec<i16>,
    /// Down.
    pub dy: Vec<i16>,
    /// `|dx| + |dy|`, with a 0 before the first and after the last.
    pub size: Vec<i16>,
    /// Of each column, with the first and the last one twice: above + 2 here + below.
    sum: Vec<i16>,
    /// As that: below - above.
    difference: Vec<i16>,
}

impl Line {
    /// Makes room for rows of that width, with no gradient anywhere.
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

    /// Takes the gradients of a row. All rows have the width that there is room for.
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
