//! Canny's edge detector.
//!
//! In: an image. Out: its edge pixels.
//!
//! There are two steps. *Thinning* marks each pixel whose gradient is above the low threshold and not smaller than the
//! gradients of its two neighbours in the gradient's direction. *Following* keeps the marked pixels that are connected,
//! also diagonally, to one whose gradient is above the high threshold.
//!
//! Why ours: no pure Rust library has OpenCV's definition. `imageproc` always blurs, takes the L2 norm and rounds
//! directions in floating point.
//!
//! Invariants: the result equals OpenCV's bit for bit. That fixes which neighbour may be equal, where directions are
//! divided, that gradients outside of the image are 0, and that thresholds are rounded down.
//!
//! Must not know: where images come from.

use super::View;
use super::sobel::Line;

/// No edge.
const NOTHING: u8 = 0;
/// An edge if it is connected to a strong pixel.
const WEAK: u8 = 1;
/// An edge.
const STRONG: u8 = 2;

/// The number of pixels that are thinned together. A run without a gradient above the low threshold is skipped.
const RUN: usize = 64;

/// The tangent of 22.5 degrees, at which OpenCV divides directions, with 16 fractional bits. OpenCV has 13573 with 15
/// fractional bits, which is the same number.
const TANGENT: i32 = 2 * 13_573;

/// The largest possible gradient.
const LARGEST: f64 = 2040.0;

/// A detector with fixed thresholds. It keeps its buffers from image to image.
#[derive(Clone, Debug)]
pub struct Canny {
    low: i16,
    high: i16,
    /// The gradients of three rows: the next one, the one that is thinned, and the previous one.
    lines: [Line; 3],
    /// The mark of each pixel, with a border of [`NOTHING`] that is one pixel wide.
    marks: Vec<u8>,
    /// Indices in `marks` of strong pixels whose neighbours are not checked yet.
    found: Vec<u32>,
    edges: Vec<[u32; 2]>,
}

impl Canny {
    /// Thresholds are at least 0. They may come in any order.
    pub fn new(low: f64, high: f64) -> Self {
        let whole = |threshold: f64| threshold.floor().clamp(0.0, LARGEST) as i16;
        Self {
            low: whole(low.min(high)),
            high: whole(low.max(high)),
            lines: Default::default(),
            marks: Vec::new(),
            found: Vec::new(),
            edges: Vec::new(),
        }
    }

    /// The edge pixels, row by row.
    pub fn edges(&mut self, image: View<'_>) -> &[[u32; 2]] {
        let (width, height) = (image.width(), image.height());
        self.marks.clear();
        self.marks.resize((width + 2) * (height + 2), NOTHING);
        self.lines.iter_mut().for_each(|line| line.reset(width));
        for y in 0..=height {
            self.lines.rotate_right(1);
            let next = &mut self.lines[0];
            if y < height {
                next.take(image.row(y.saturating_sub(1)), image.row(y), image.row((y + 1).min(height - 1)));
            } else {
                next.reset(width);
            }
            if y > 0 {
                self.thin(y - 1, width);
            }
        }
        self.follow(width + 2);
        self.collect(width, height);
        &self.edges
    }

    /// Marks the edge pixels of a row, and stores the strong ones in `found`.
    fn thin(&mut self, y: usize, width: usize) {
        let [below, here, above] = &self.lines;
        let first = (y + 1) * (width + 2) + 1;
        let marks = &mut self.marks[first..first + width];
        for start in (0..width).step_by(RUN) {
            let run = start..(start + RUN).min(width);
            // Most parts of most images are flat.
            let largest = here.size[run.start + 1..run.end + 1].iter().fold(0, |largest, &size| size.max(largest));
            if largest <= self.low {
                continue;
            }
            let marks = &mut marks[run.clone()];
            mark(Neighbourhood::new(above, here, below, run), self.low, self.high, marks);
            if largest > self.high {
                each_mark(marks, STRONG, |at| self.found.push((first + start + at) as u32));
            }
        }
    }

    /// Makes every weak pixel that is connected to a strong one strong.
    fn follow(&mut self, stride: usize) {
        while let Some(at) = self.found.pop() {
            for row in [at as usize - stride, at as usize, at as usize + stride] {
                for near in row - 1..=row + 1 {
                    if self.marks[near] == WEAK {
                        self.marks[near] = STRONG;
                        self.found.push(near as u32);
                    }
                }
            }
        }
    }

    fn collect(&mut self, width: usize, height: usize) {
        self.edges.clear();
        for y in 0..height {
            let first = (y + 1) * (width + 2) + 1;
            each_mark(&self.marks[first..first + width], STRONG, |x| self.edges.push([x as u32, y as u32]));
        }
    }
}

/// The gradients of a run of pixels and those around them.
struct Neighbourhood<'a> {
    dx: &'a [i16],
    dy: &'a [i16],
    /// Gradient sizes of the row above, this row and the row below. Each has one more pixel at either end.
    sizes: [&'a [i16]; 3],
}

impl<'a> Neighbourhood<'a> {
    fn new(above: &'a Line, here: &'a Line, below: &'a Line, run: std::ops::Range<usize>) -> Self {
        let sizes = [above, here, below].map(|line| &line.size[run.start..run.end + 2]);
        Self { dx: &here.dx[run.clone()], dy: &here.dy[run], sizes }
    }
}

/// Marks a run of pixels. There is no branch on a pixel, so the compiler can vectorise the loop.
fn mark(neighbourhood: Neighbourhood<'_>, low: i16, high: i16, marks: &mut [u8]) {
    let count = marks.len();
    let (dx, dy) = (&neighbourhood.dx[..count], &neighbourhood.dy[..count]);
    let [above, here, below] = neighbourhood.sizes.map(|sizes| &sizes[..count + 2]);
    for at in 0..count {
        let size = here[at + 1];
        let (x, y) = (dx[at].abs(), dy[at].abs());
        // Below 22.5 degrees: y < x tan 22.5. The right side is never a whole number (13573 is odd) unless x is 0. Then
        // either y is not 0 or the pixel is not marked.
        let flat = ((i32::from(x) * TANGENT) >> 16) as i16;
        let is_flat = y <= flat;
        // Above 67.5 degrees, whose tangent is 2 plus the tangent of 22.5 degrees.
        let is_steep = y > flat + 2 * x;
        let is_falling = (dx[at] ^ dy[at]) < 0;
        let across = (size > here[at]) & (size >= here[at + 2]);
        let upright = (size > above[at + 1]) & (size >= below[at + 1]);
        let down = (size > above[at]) & (size > below[at + 2]);
        let up = (size > above[at + 2]) & (size > below[at]);
        let diagonal = (is_falling & up) | (!is_falling & down);
        let is_largest = (is_flat & across) | (!is_flat & ((is_steep & upright) | (!is_steep & diagonal)));
        let is_edge = is_largest & (size > low);
        marks[at] = u8::from(is_edge) + u8::from(is_edge & (size > high));
    }
}

/// Calls `found` with the index of each mark that equals `wanted`.
fn each_mark(marks: &[u8], wanted: u8, mut found: impl FnMut(usize)) {
    for (number, run) in marks.chunks(RUN).enumerate() {
        // There is no early exit, so the compiler can vectorise the loop.
        if run.iter().fold(false, |is_there, &mark| is_there | (mark == wanted)) {
            let places = run.iter().enumerate().filter(|&(_, &mark)| mark == wanted);
            places.for_each(|(at, _)| found(number * RUN + at));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::edges::reference;

    fn edges(pixels: &[u8], width: u32, low: f64, high: f64) -> Vec<[u32; 2]> {
        let height = pixels.len() as u32 / width;
        Canny::new(low, high).edges(View::new(pixels, width, height).unwrap()).to_vec()
    }

    /// Light pixels are written as `#`.
    fn drawing(rows: &[&str]) -> (Vec<u8>, u32) {
        let pixels = rows.concat().bytes().map(|byte| if byte == b'#' { 200 } else { 0 }).collect();
        (pixels, rows[0].len() as u32)
    }

    #[test]
    fn of_two_equal_gradients_the_first_is_the_edge() {
        let (pixels, width) = drawing(&["..##", "..##", "..##"]);
        assert_eq!(edges(&pixels, width, 150.0, 450.0), [[1, 0], [1, 1], [1, 2]]);
        let (pixels, width) = drawing(&["...", "...", "###", "###"]);
        assert_eq!(edges(&pixels, width, 150.0, 450.0), [[0, 1], [1, 1], [2, 1]]);
    }

    #[test]
    fn an_edge_on_the_border_is_found() {
        // The gradient outside of the image is 0, so the last column can hold a maximum.
        let pixels: Vec<u8> = [0, 0, 0, 250].repeat(3);
        assert_eq!(edges(&pixels, 4, 150.0, 450.0), [[2, 0], [2, 1], [2, 2]]);
        assert_eq!(edges(&[7], 1, 0.0, 0.0), [[0; 2]; 0], "one pixel has no gradient");
        assert_eq!(edges(&[0, 255], 2, 150.0, 450.0), [[0, 0]]);
        assert_eq!(edges(&[0, 255], 1, 150.0, 450.0), [[0, 0]]);
    }

    #[test]
    fn thresholds_are_rounded_down_and_may_come_in_any_order() {
        // An upright step of 100 has a gradient of 400.
        let pixels: Vec<u8> = [0, 0, 100, 100].repeat(3);
        for (low, high, is_edge) in [
            (150.0, 399.9, true),
            (150.0, 400.0, false),
            (400.0, 150.0, false),
            (399.0, 150.0, true),
            (0.0, 0.0, true),
            (1e300, 1e300, false),
        ] {
            assert_eq!(!edges(&pixels, 4, low, high).is_empty(), is_edge, "{low} {high}");
        }
    }

    #[test]
    fn weak_edges_are_kept_if_connected_to_strong_ones_also_diagonally() {
        // A step that fades from 250 to 60 downwards: it begins strong (1000) and goes on weak as long as it is above
        // low.
        let pixels: Vec<u8> = (0..96).flat_map(|y| [0, 0, 250 - 2 * y, 250 - 2 * y]).collect();
        let long = edges(&pixels, 4, 150.0, 900.0);
        assert_eq!(long.len(), 96);
        let short = edges(&pixels, 4, 500.0, 900.0);
        assert!((60..70).contains(&short.len()), "{}", short.len());
        assert_eq!(edges(&pixels, 4, 150.0, 1100.0), [[0; 2]; 0], "nothing begins");
    }

    #[test]
    fn the_result_does_not_depend_on_the_previous_image() {
        let mut canny = Canny::new(150.0, 450.0);
        let (step, width) = drawing(&["..##", "..##", "..##"]);
        let first = canny.edges(View::new(&step, width, 3).unwrap()).to_vec();
        let (other, other_width) = drawing(&["......", "###...", "###...", "......", "......"]);
        let fresh = edges(&other, other_width, 150.0, 450.0);
        assert_eq!(canny.edges(View::new(&other, other_width, 5).unwrap()), fresh);
        assert_eq!(canny.edges(View::new(&step, width, 3).unwrap()), first);
    }

    /// Images with long runs of equal pixels, smooth slopes, and noise. Every sector and every tie occurs.
    fn images() -> impl Strategy<Value = (Vec<u8>, u32)> {
        let pixel = prop_oneof![Just(0_u8), Just(255), 0..4_u8, any::<u8>()];
        let noise = (1..90_usize, 1..20_usize).prop_flat_map(move |(width, height)| {
            (prop::collection::vec(pixel.clone(), width * height), Just(width as u32))
        });
        let slope =
            (1..90_u32, 1..40_u32, -40..40_i32, -40..40_i32, 0..4_i32).prop_map(|(width, height, a, b, bend)| {
                let shade =
                    |x: i32, y: i32| (128 + (a * x + b * y + bend * (x * x - y * y) / 4) / 4).clamp(0, 255) as u8;
                let pixels = (0..height as i32).flat_map(|y| (0..width as i32).map(move |x| shade(x, y))).collect();
                (pixels, width)
            });
        prop_oneof![noise, slope]
    }

    proptest! {
        #[test]
        fn differential_against_the_definition((pixels, width) in images(), low in 0..600_u32, ratio in 1..4_u32) {
            let (low, high) = (f64::from(low), f64::from(low * ratio));
            let expected = reference::canny(&pixels, width as usize, i64::from(low as i32), i64::from(high as i32));
            prop_assert_eq!(edges(&pixels, width, low, high), expected);
        }
    }
}
