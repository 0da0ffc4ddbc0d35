//! Where the parts of the picture are.
//!
//! In: the size of the page.
//! Out: rectangles in pixels, from the page's upper left corner.
//! Invariants: no two parts overlap; the diagram is square; a page is never so small that a part vanishes.
//! Must not know: what the parts show.

/// The least size of a page.
const LEAST: [u32; 2] = [800, 400];
const MARGIN: f64 = 24.0;
/// Room above the panels: headline, facts, captions, labels of the diagonal gaps.
const HEADER: f64 = 114.0;
/// Room below the panels: numbers and names of axes, legend.
const FOOTER: f64 = 58.0;
/// Room left of the diagram: numbers and name of its axis.
const AXIS: f64 = 74.0;
/// Room right of the diagram: colour bar and its numbers.
const BAR: f64 = 88.0;

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

impl Rect {
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Larger by so much on every side.
    pub fn grown(self, by: f64) -> Self {
        Self { x: self.x - by, y: self.y - by, width: self.width + 2.0 * by, height: self.height + 2.0 * by }
    }
}

/// The parts of a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Width and height of the page.
    pub size: [f64; 2],
    /// The cloud and its skeleton.
    pub plane: Rect,
    /// The persistence diagram.
    pub diagram: Rect,
    /// The colour bar.
    pub bar: Rect,
}

impl Layout {
    /// Divides a page.
    pub fn new(width: u32, height: u32) -> Self {
        let [width, height] = [width.max(LEAST[0]), height.max(LEAST[1])].map(f64::from);
        let tall = height - HEADER - FOOTER;
        let wide = width - 2.0 * MARGIN - AXIS - BAR;
        let side = tall.min(0.5 * wide);
        let diagram = Rect { x: width - MARGIN - BAR - side, y: HEADER, width: side, height: side };
        let bar = Rect { x: diagram.right() + 32.0, width: 12.0, ..diagram };
        let plane = Rect { x: MARGIN, y: HEADER, width: wide - side, height: tall };
        Self { size: [width, height], plane, diagram, bar }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_apart_on_every_page() {
        for [width, height] in [[0, 0], [1200, 560], [800, 4000], [8000, 400], [u32::MAX, u32::MAX]] {
            let Layout { size, plane, diagram, bar } = Layout::new(width, height);
            assert!(plane.width >= 200.0 && diagram.width >= 200.0, "{width} x {height}");
            assert!(plane.right() + AXIS <= diagram.x + 1e-6 * size[0]);
            assert!(diagram.right() < bar.x && bar.right() < size[0]);
            assert!(plane.bottom() < size[1] && diagram.bottom() < size[1]);
            assert_eq!(diagram.width, diagram.height);
        }
    }
}
