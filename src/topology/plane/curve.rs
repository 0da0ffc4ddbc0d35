//! How positions are spread over the plane: an order along a space-filling curve, and a test whether they lie in few
//! lines or clumps.
//!
//! In: positions.
//! Out: their places along the curve; whether they are thin.
//! Invariant: near-linear time for any positions.
//! Must not know: triangulations.

use crate::topology::cloud::Position;

/// A cloud is thin when it fills less than this share (one in 32) of the cells that it could fill.
const THIN_SHARE: usize = 32;

/// The bounding box of most of some positions. A few outliers must not put all others into one cell.
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

/// Sample sizes: for the spread of all positions, and for a rough order of them.
const SAMPLE: usize = 1024;
const SMALL_SAMPLE: usize = 64;

impl Bounds {
    fn of(positions: impl ExactSizeIterator<Item = Position>, sample: usize) -> Self {
        let stride = positions.len().div_ceil(sample).max(1);
        let sample: Vec<Position> = positions.step_by(stride).collect();
        let range = |axis: usize| {
            let mut values: Vec<f64> = sample.iter().map(|position| position.xy()[axis]).collect();
            values.sort_unstable_by(f64::total_cmp);
            let outside = values.len() / 32;
            [outside, values.len().saturating_sub(outside + 1)].map(|place| values.get(place).copied().unwrap_or(0.0))
        };
        let [[left, right], [bottom, top]] = [0, 1].map(range);
        Self { low: [left, bottom], high: [right, top] }
    }

    /// The cell of a position on a grid whose last column and row have the number `last`; the nearest cell, if the
    /// position is outside the box.
    fn cell(&self, position: Position, last: f64) -> [u16; 2] {
        let v = position.xy();
        // A box of width 0 gives NaN, which the cast turns into 0.
        [0, 1].map(|axis| ((v[axis] - self.low[axis]) / (self.high[axis] - self.low[axis]) * last).min(last) as u16)
    }
}

/// The places of positions in an order in which neighbours are near in the plane (Morton order in their bounding box).
pub fn along_curve(positions: impl ExactSizeIterator<Item = Position> + Clone) -> Vec<usize> {
    let bounds = Bounds::of(positions.clone(), SMALL_SAMPLE);
    let mut keyed: Vec<(u32, u32)> = (positions.zip(0..))
        .map(|(position, place)| {
            let [x, y] = bounds.cell(position, f64::from(u16::MAX));
            (interleave(x) | interleave(y) << 1, place)
        })
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, place)| place as usize).collect()
}

/// The bits of `v` at even places.
fn interleave(v: u16) -> u32 {
    let mut bits = u32::from(v);
    for (shift, mask) in [(8, 0x00FF_00FF), (4, 0x0F0F_0F0F), (2, 0x3333_3333), (1, 0x5555_5555)] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// Whether the sites lie along few lines or in few clumps. On a grid with a cell for every four sites, others fill most
/// cells.
///
/// Bulk loading such a cloud may take quadratic time. `spade` works from the mean position outwards: a long run on one
/// line is inserted as if nothing else were there, and sites in one direction from the mean are inserted last, each
/// with a long search.
pub fn is_thin(positions: impl ExactSizeIterator<Item = Position> + Clone) -> bool {
    let count = positions.len();
    let side = (count as f64 / 4.0).sqrt().max(1.0);
    let bounds = Bounds::of(positions.clone(), SAMPLE);
    let mut filled = vec![false; (side as usize + 1).pow(2)];
    // All sites are counted. A sample would need a coarser grid, on which twenty lines are no longer few.
    for position in positions {
        let [x, y] = bounds.cell(position, side);
        filled[x as usize * (side as usize + 1) + y as usize] = true;
    }
    filled.into_iter().filter(|&filled| filled).count() * THIN_SHARE < count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn positions(count: u32, at: impl Fn(u32, f64) -> [f64; 2]) -> Vec<Position> {
        // The fractional parts of multiples of the golden ratio are spread evenly.
        let spread = |slot: u32| (f64::from(slot) * 0.618_033_988_749_894_9).fract();
        let position = |slot: u32| {
            let [x, y] = at(slot, spread(slot));
            Position::new(x, y).unwrap()
        };
        (0..count).map(position).collect()
    }

    /// Bulk loading takes ten times as long on such a cloud as rounds do.
    #[test]
    fn many_sites_on_twenty_lines_are_thin() {
        let count = 200_000;
        assert!(is_thin(positions(count, |slot, along| [along, f64::from(slot % 20)]).into_iter()));
        assert!(!is_thin(positions(count, |slot, across| [f64::from(slot), across]).into_iter()));
    }
}
