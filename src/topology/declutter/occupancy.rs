//! How dense clutter is, by the cells of a grid that hold a lone point.
//!
//! In: positions that come and go, their bounding box.
//! Out: [`Clutter`]: its density, if there is any.
//! Invariants: the grid and the density depend on the positions alone. Cells are squares whose side is a power of two,
//! anchored at the origin: the smallest of which at most [`CELLS_PER_POINT`] a point cover the bounding box. A change
//! of a point costs the same whatever the number of points; the counts are made anew when the side changes.
//! Must not know: neighbours, filters.
//!
//! A block is a cell with the eight around it. Where clutter is a Poisson process of intensity m a cell, a block is
//! empty with probability exp(-9m), and its middle cell is all that is occupied, by one point, with m exp(-9m). So the
//! ratio of the two counts estimates m. Points of walls have others nearby: they hardly ever are alone in a block, and
//! empty blocks lie off the walls. Without clutter the count is 0, and nothing is estimated.

use super::ladder::{exponent, power_of_two};
use crate::topology::cloud::Position;

/// At most so many cells a point.
const CELLS_PER_POINT: f64 = 4.0;

/// A box of fewer columns or rows is too thin to have an inside.
const FEWEST: f64 = 3.0;

/// The density of clutter, on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// The side of a cell is two to this.
    pub exponent: i32,
    /// Clutter points a cell.
    pub per_cell: f64,
    /// The number of cells of the bounding box.
    pub cells: f64,
}

impl Clutter {
    /// The number of clutter points.
    pub fn count(&self) -> f64 {
        self.per_cell * self.cells
    }
}

/// The grid of a bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    exponent: i32,
    /// The first column and row. Whole numbers, which may be too large for integers.
    first: [f64; 2],
    /// The number of columns and of rows.
    size: [f64; 2],
}

impl Shape {
    /// The grid of so many points in a box; none of a box that is too thin.
    fn new([low, high]: [[f64; 2]; 2], points: usize) -> Option<Self> {
        let [width, height] = [high[0] - low[0], high[1] - low[1]];
        if points == 0 || !(width > 0.0 && height > 0.0) {
            return None;
        }
        let most = CELLS_PER_POINT * points as f64;
        let of = |exponent: i32| {
            let first = [0, 1].map(|axis| cell(low[axis], exponent));
            Self { exponent, first, size: [0, 1].map(|axis| cell(high[axis], exponent) - first[axis] + 1.0) }
        };
        let fits = |exponent: i32| of(exponent).cells() <= most;
        let mut side = exponent(width * height / points as f64) / 2;
        while !fits(side) {
            side += 1;
        }
        while fits(side - 1) {
            side -= 1;
        }
        Some(of(side)).filter(|shape| shape.size.iter().all(|&cells| cells >= FEWEST))
    }

    fn cells(&self) -> f64 {
        self.size[0] * self.size[1]
    }
}

/// The column or row of a coordinate.
fn cell(coordinate: f64, exponent: i32) -> f64 {
    (coordinate * power_of_two(-exponent)).floor()
}

/// Counts of points by cells.
#[derive(Clone, Debug, Default)]
pub struct Occupancy {
    shape: Option<Shape>,
    counts: Option<Counts>,
}

impl Occupancy {
    /// Follows a change. `all` gives all positions after it.
    pub fn follow<I: Iterator<Item = Position>>(
        &mut self,
        bounds: [[f64; 2]; 2],
        points: usize,
        [removed, added]: [&[Position]; 2],
        all: impl FnOnce() -> I,
    ) {
        self.shape = Shape::new(bounds, points);
        let Some(shape) = self.shape else {
            self.counts = None;
            return;
        };
        match self.counts.as_mut().filter(|counts| counts.covers(&shape)) {
            Some(counts) => {
                removed.iter().for_each(|&position| counts.remove(position));
                added.iter().for_each(|&position| counts.add(position));
            }
            None => {
                let mut counts = Counts::new(&shape);
                all().for_each(|position| counts.add(position));
                self.counts = Some(counts);
            }
        }
    }

    /// The density of clutter; none if no point is alone.
    pub fn clutter(&self) -> Option<Clutter> {
        let (shape, counts) = (self.shape.as_ref()?, self.counts.as_ref()?);
        // Blocks are counted one cell beyond the box too: points are there in the middle of no block.
        let blocks = (shape.size[0] + 2.0) * (shape.size[1] + 2.0);
        let empty = (blocks - f64::from(counts.occupied_blocks)).max(1.0);
        let per_cell = f64::from(counts.lone) / empty;
        let clutter = Clutter { exponent: shape.exponent, per_cell, cells: shape.cells() };
        (counts.lone > 0).then_some(clutter)
    }

    /// About how many bytes it takes.
    pub fn bytes(&self) -> usize {
        self.counts.as_ref().map_or(0, |counts| counts.cells.len() * size_of::<Cell>())
    }
}

/// A cell.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Points in it.
    points: u32,
    /// Points in its block.
    block: u32,
}

impl Cell {
    fn is_lone(self) -> bool {
        self.points == 1 && self.block == 1
    }
}

/// The cells of a box and a margin around it.
#[derive(Clone, Debug)]
struct Counts {
    exponent: i32,
    /// The first column and row of the box that it was made for. The margin is apart: a sum might be rounded.
    first: [f64; 2],
    margin: [f64; 2],
    size: [usize; 2],
    cells: Vec<Cell>,
    /// Cells whose block has points.
    occupied_blocks: u32,
    /// Cells with a point that is alone in its block.
    lone: u32,
}

impl Counts {
    /// Empty cells for a box that may move on a little.
    fn new(shape: &Shape) -> Self {
        let margin = shape.size.map(|cells| (cells / 8.0).floor() + 2.0);
        let size = [0, 1].map(|axis| (shape.size[axis] + 2.0 * margin[axis]) as usize);
        Self {
            exponent: shape.exponent,
            first: shape.first,
            margin,
            size,
            cells: vec![Cell::default(); size[0] * size[1]],
            occupied_blocks: 0,
            lone: 0,
        }
    }

    /// Whether all points of a box have their blocks here.
    fn covers(&self, shape: &Shape) -> bool {
        self.exponent == shape.exponent
            && [0, 1].into_iter().all(|axis| {
                let before = shape.first[axis] - self.first[axis] + self.margin[axis];
                before >= 1.0 && before + shape.size[axis] < self.size[axis] as f64
            })
    }

    /// The place of a position's cell.
    fn place(&self, position: Position) -> usize {
        let xy = position.xy();
        let [column, row] =
            [0, 1].map(|axis| cell(xy[axis], self.exponent) - self.first[axis] + self.margin[axis]).map(|v| v as usize);
        row * self.size[0] + column
    }

    fn add(&mut self, position: Position) {
        self.change(position, |count| *count += 1);
    }

    fn remove(&mut self, position: Position) {
        self.change(position, |count| *count -= 1);
    }

    fn change(&mut self, position: Position, change: impl Fn(&mut u32)) {
        let place = self.place(position);
        for row in [place - self.size[0], place, place + self.size[0]] {
            for place_near in row - 1..=row + 1 {
                let near = &mut self.cells[place_near];
                let before = *near;
                change(&mut near.block);
                if place_near == place {
                    change(&mut near.points);
                }
                self.occupied_blocks += u32::from(near.block > 0);
                self.occupied_blocks -= u32::from(before.block > 0);
                self.lone += u32::from(near.is_lone());
                self.lone -= u32::from(before.is_lone());
            }
        }
    }
}
