//! Canny's edges: where the gradient is largest across an edge, and strong enough along it.
//!
//! In: an image. Out: its edge pixels. Two steps: *thinning* marks each pixel whose gradient is above the low threshold
//! and not smaller than that of its two neighbours in its direction; *following* keeps those that hang together, also
//! over a corner, with one whose gradient is above the high threshold. No library has OpenCV's definition in pure Rust:
//! `imageproc` blurs, takes the L2 norm and rounds directions in floating point.
//!
//! Invariants: as OpenCV, to the bit: which neighbour may be equal, where directions are cut, that gradients outside of
//! the image are 0, and that thresholds are rounded down. Must not know: where images come from.

use super::View;
use super::sobel::Line;

/// No edge.
const NOTHING: u8 = 0;
/// An edge, if it hangs together with a strong one.
const WEAK: u8 = 1;
/// An edge.
const STRONG: u8 = 2;

/// Pixels that are thinned together, or passed over together where none is above the low threshold.
const RUN: usize = 64;

/// The tangent of 22.5 degrees, by which OpenCV cuts directions, as 16 bits after the point. (There it is 13573 with 15
/// of them, which is the same number.)
const TANGENT: i32 = 2 * 13_573;

/// No gradient is larger.
const LARGEST: f64 = 2040.0;

/// Finds edges, and keeps the memory for it.
#[derive(Clone, Debug)]
pub struct Canny {
    low: i16,
    high: i16,
    /// The row that comes, the one that is thinned, and the one before.
    lines: [Line; 3],
    /// Of each pixel, in a frame of [`NOTHING`] that is one pixel wide.
    marks: Vec<u8>,
    /// Strong pixels whose neighbours are still to be looked at, by their place among the marks.
    found: Vec<u32>,
    edges: Vec<[u32; 2]>,
}

impl Canny {
    /// Thresholds are not negative.
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

    /// Marks the edges of a row, and notes the strong ones.
    fn thin(&mut self, y: usize, width: usize) {
        let [below, here, above] = &self.lines;
        let first = (y + 1) * (width + 2) + 1;
        let marks = &mut self.marks[first..first + width];
        for start in (0..width).step_by(RUN) {
            let run = start..(start + RUN).min(width);
            // Most of most images is flat.
            let largest = here.size[run.start + 1..run.end + 1].iter().fold(0, |largest, &size| size.max(largest));
            if largest <= self.low {
                continue;
            }
            let marks = &mut marks[run.clone()];
            mark(Around::new(above, here, below, run), self.low, self.high, marks);
            if largest > self.high {
                each(marks, STRONG, |at| self.found.push((first + start + at) as u32));
            }
        }
    }

    /// Makes all that hangs together with a strong pixel strong.
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
            each(&self.marks[first..first + width], STRONG, |x| self.edges.push([x as u32, y as u32]));
        }
    }
}

/// The gradients of a run of pixels and those around them.
struct Around<'a> {
    dx: &'a [i16],
    dy: &'a [i16],
    /// Sizes of the row above, this one, and the one below; each from the pixel before the run to the one after.
    sizes: [&'a [i16]; 3],
}

impl<'a> Around<'a> {
    fn new(above: &'a Line, here: &'a Line, below: &'a Line, run: std::ops::Range<usize>) -> Self {
        let sizes = [above, here, below].map(|line| &line.size[run.start..run.end + 2]);
        Self { dx: &here.dx[run.clone()], dy: &here.dy[run], sizes }
    }
}

/// Marks a run of pixels. All is done for each of them, without a branch, so that several are done at once.
fn mark(around: Around<'_>, low: i16, high: i16, marks: &mut [u8]) {
    let count = marks.len();
    let (dx, dy) = (&around.dx[..count], &around.dy[..count]);
    let [above, here, below] = around.sizes.map(|sizes| &sizes[..count + 2]);
    for at in 0..count {
        let size = here[at + 1];
        let (x, y) = (dx[at].abs(), dy[at].abs());
        // Below 22.5 degrees: y < x tan 22.5. The right side is never whole (13573 is odd), but where x is 0, and there
        // either y is not or nothing is marked.
        let flat = ((i32::from(x) * TANGENT) >> 16) as i16;
        let is_flat = y <= flat;
        // Above 67.5 degrees, whose tangent is that of 22.5 degrees and 2.
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

/// Calls for each place of a mark.
fn each(marks: &[u8], wanted: u8, mut found: impl FnMut(usize)) {
    for (number, run) in marks.chunks(RUN).enumerate() {
        // Without an early end, so that several are looked at at once.
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

    /// Light pixels are written as #.
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
        // What lies outside counts as no gradient, so the last column can be a largest one.
        let pixels: Vec<u8> = [0, 0, 0, 250].repeat(3);
        assert_eq!(edges(&pixels, 4, 150.0, 450.0), [[2, 0], [2, 1], [2, 2]]);
        assert_eq!(edges(&[7], 1, 0.0, 0.0), [[0; 2]; 0], "one pixel has no gradient");
        assert_eq!(edges(&[0, 255], 2, 150.0, 450.0), [[0, 0]]);
        assert_eq!(edges(&[0, 255], 1, 150.0, 450.0), [[0, 0]]);
    }

    #[test]
    fn thresholds_are_rounded_down_and_may_come_in_any_order() {
        // A step of 100 upright has a gradient of 400.
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
    fn weak_edges_live_by_strong_ones_over_corners_and_far_away() {
        // A step that fades from 250 to 60 as it goes down: it begins strong (1000), and goes on weak as long as it is
        // above low.
        let pixels: Vec<u8> = (0..96).flat_map(|y| [0, 0, 250 - 2 * y, 250 - 2 * y]).collect();
        let long = edges(&pixels, 4, 150.0, 900.0);
        assert_eq!(long.len(), 96);
        let short = edges(&pixels, 4, 500.0, 900.0);
        assert!((60..70).contains(&short.len()), "{}", short.len());
        assert_eq!(edges(&pixels, 4, 150.0, 1100.0), [[0; 2]; 0], "nothing begins");
    }

    #[test]
    fn a_detector_forgets_the_image_before() {
        let mut canny = Canny::new(150.0, 450.0);
        let (step, width) = drawing(&["..##", "..##", "..##"]);
        let first = canny.edges(View::new(&step, width, 3).unwrap()).to_vec();
        let (other, other_width) = drawing(&["......", "###...", "###...", "......", "......"]);
        let fresh = edges(&other, other_width, 150.0, 450.0);
        assert_eq!(canny.edges(View::new(&other, other_width, 5).unwrap()), fresh);
        assert_eq!(canny.edges(View::new(&step, width, 3).unwrap()), first);
    }

    /// Images with long runs of equal pixels, smooth slopes, and noise, so that every sector and every tie comes up.
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
