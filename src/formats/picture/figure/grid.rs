//! Where the panels of a figure are.
//!
//! In: panels, the proportions of the plane.
//! Out: rectangles in pixels, from the page's upper left corner.
//! Invariants: no two panels overlap; panels of the plane have one size; diagrams are square, with room for their axes.
//! Must not know: what panels show.

use super::super::canvas::layout::Rect;
use super::Panel;

const MARGIN: f64 = 24.0;
/// Room above all panels: headline, facts.
const HEADER: f64 = 84.0;
/// Room below all panels: samples of marks, a bar of round length.
const FOOTER: f64 = 56.0;
const WIDTH: f64 = 460.0;
/// Heights of panels.
const HEIGHTS: [f64; 2] = [300.0, 600.0];
const BETWEEN: f64 = 28.0;
/// Room above a panel: its title, its facts, labels of diagonal gaps.
const CAPTION: f64 = 62.0;
/// Room below a diagram: numbers and name of its axis.
const AXIS_BELOW: f64 = 54.0;
/// Room left of a diagram: numbers and name of its axis.
const AXIS_LEFT: f64 = 62.0;
/// Room right of a diagram: colour bar and its numbers.
const BAR: f64 = 82.0;

/// A panel with its caption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Where the caption begins.
    pub corner: [f64; 2],
    /// The panel.
    pub panel: Rect,
}

/// The places of all panels.
pub struct Grid {
    columns: usize,
    tall: f64,
    cells: Vec<Cell>,
    bottom: f64,
}

impl Grid {
    /// Places panels, for a plane of this width and height.
    pub fn new(panels: &[Panel<'_>], [width, height]: [f64; 2]) -> Self {
        let columns = columns(panels.len());
        let proportion = if width > 0.0 && (height / width).is_finite() { height / width } else { 1.0 };
        let tall = (WIDTH * proportion).clamp(HEIGHTS[0], HEIGHTS[1]).round();
        let mut cells = Vec::with_capacity(panels.len());
        let mut top = HEADER;
        for row in panels.chunks(columns) {
            for (column, panel) in row.iter().enumerate() {
                let corner = [MARGIN + column as f64 * (WIDTH + BETWEEN), top];
                cells.push(cell(corner, tall, panel.is_diagram()));
            }
            let has_axis = row.iter().any(Panel::is_diagram);
            let lowest = cells.iter().map(|cell| cell.panel.bottom()).fold(top, f64::max);
            top = lowest + if has_axis { AXIS_BELOW } else { BETWEEN };
        }
        Self { columns, tall, cells, bottom: top }
    }

    /// Each panel's place.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The size of all panels of the plane.
    pub fn plane(&self) -> Rect {
        Rect { x: 0.0, y: 0.0, width: WIDTH, height: self.tall }
    }

    /// Where lines of text begin.
    pub fn left(&self) -> f64 {
        MARGIN
    }

    /// Where marks are explained.
    pub fn foot(&self) -> Rect {
        Rect { x: MARGIN, y: self.bottom, width: self.width() - 2.0 * MARGIN, height: FOOTER }
    }

    /// Width and height of the page.
    pub fn size(&self) -> [f64; 2] {
        [self.width(), self.bottom + FOOTER]
    }

    fn width(&self) -> f64 {
        2.0 * MARGIN + self.columns as f64 * (WIDTH + BETWEEN) - BETWEEN
    }
}

/// Up to three panels are a row; more are about as many rows as columns.
fn columns(panels: usize) -> usize {
    match panels {
        0..=3 => panels.max(1),
        _ => (2..).find(|side| side * side >= panels).unwrap_or(panels),
    }
}

fn cell(corner: [f64; 2], tall: f64, is_diagram: bool) -> Cell {
    let [x, y] = [corner[0], corner[1] + CAPTION];
    let panel = if is_diagram {
        let side = tall.min(WIDTH - AXIS_LEFT - BAR);
        Rect { x: x + AXIS_LEFT, y, width: side, height: side }
    } else {
        Rect { x, y, width: WIDTH, height: tall }
    };
    Cell { corner, panel }
}

/// The colour bar of a diagram.
pub fn bar_beside(diagram: Rect) -> Rect {
    Rect { x: diagram.right() + 26.0, width: 12.0, ..diagram }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_apart_whatever_their_number() {
        for number in 1..=16 {
            let panels: Vec<Panel<'_>> = (0..number).map(|_| Panel::Cloud).collect();
            for size in [[1.0, 1.0], [0.0, 0.0], [1e-9, 1e9], [9.0, 1.0]] {
                let grid = Grid::new(&panels, size);
                let [width, height] = grid.size();
                assert!(width <= 4.0 * 520.0 && height <= 4.0 * 700.0, "{number}: {width} x {height}");
                for (index, cell) in grid.cells().iter().enumerate() {
                    assert!(cell.panel.right() <= width - MARGIN + 1e-9 && cell.panel.bottom() < height - FOOTER);
                    for other in &grid.cells()[..index] {
                        let is_beside = other.panel.right() < cell.corner[0];
                        assert!(is_beside || other.panel.bottom() < cell.corner[1], "{number}");
                    }
                }
            }
        }
        assert_eq!([1, 2, 3, 4, 5, 6, 9, 10].map(columns), [1, 2, 3, 2, 3, 3, 3, 4]);
    }
}
