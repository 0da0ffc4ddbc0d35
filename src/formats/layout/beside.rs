//! Parts of a layout beside each other, in rows, as words stand on a page.
//!
//! In: places of each part.
//! Out: the same, moved as wholes.
//! Invariants: the boxes around parts do not overlap in the first two axes; in the others their middles are one. Parts
//! stand in the order given.
//! Must not know: why they are apart.

/// About how wide the whole is for its height.
const PROPORTION: f64 = 1.4;

/// The room between parts, for that of the largest, where there are few of them and where there are many.
const BETWEEN: [f64; 2] = [0.12, 0.01];

/// Moves parts.
pub fn lay_beside<const K: usize>(parts: &mut [Vec<[f64; K]>]) {
    let boxes: Vec<[Side; K]> = parts.iter().map(|part| std::array::from_fn(|axis| Side::around(part, axis))).collect();
    let sides = |of: &[Side; K]| [0, 1].map(|axis| of.get(axis).map_or(0.0, |side| side.length()));
    let largest = boxes.iter().flat_map(sides).fold(0.0, f64::max);
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let room = unit * (0.4 / (parts.len() as f64).sqrt()).clamp(BETWEEN[1], BETWEEN[0]);
    // In units of the largest part, so that no area overflows.
    let area: f64 = boxes.iter().map(sides).map(|[x, y]| ((x + room) / unit) * ((y + room) / unit)).sum();
    let width = (unit * (PROPORTION * area).sqrt()).max(largest);
    let [mut x, mut top, mut height] = [0.0, 0.0, 0.0_f64];
    for (part, of) in parts.iter_mut().zip(&boxes) {
        let [wide, tall] = sides(of);
        if x > 0.0 && x + wide > width {
            [x, top, height] = [0.0, top - height - room, 0.0];
        }
        let corner = [x, top - tall];
        for place in part {
            for (axis, value) in place.iter_mut().enumerate() {
                *value += corner.get(axis).map_or(-of[axis].middle(), |corner| corner - of[axis].low);
            }
        }
        x += wide + room;
        height = height.max(tall);
    }
}

/// Where a part is along an axis.
#[derive(Clone, Copy)]
struct Side {
    low: f64,
    high: f64,
}

impl Side {
    fn around<const K: usize>(part: &[[f64; K]], axis: usize) -> Self {
        let empty = Self { low: f64::INFINITY, high: f64::NEG_INFINITY };
        part.iter().fold(empty, |side, place| Self { low: side.low.min(place[axis]), high: side.high.max(place[axis]) })
    }

    fn length(self) -> f64 {
        (self.high - self.low).max(0.0)
    }

    fn middle(self) -> f64 {
        self.low.midpoint(self.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_apart_and_keep_their_shapes() {
        let shape = |size: f64| vec![[-size, 0.0, 5.0], [size, 0.5 * size, 7.0], [0.0, -size, 5.0]];
        for unit in [1e-200, 1.0, 1e200] {
            let sizes = [9.0, 5.0, 5.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let before: Vec<Vec<[f64; 3]>> = sizes.iter().map(|size| shape(size * unit)).collect();
            let mut after = before.clone();
            lay_beside(&mut after);
            let boxes: Vec<[Side; 3]> =
                after.iter().map(|part| std::array::from_fn(|axis| Side::around(part, axis))).collect();
            for (a, one) in boxes.iter().enumerate() {
                let is_apart = |axis: usize, other: &[Side; 3]| {
                    one[axis].high < other[axis].low || other[axis].high < one[axis].low
                };
                assert!(boxes[..a].iter().all(|other| is_apart(0, other) || is_apart(1, other)), "{a} of {unit}");
                let by: Vec<f64> = (0..3).map(|at| after[a][at][0] - before[a][at][0]).collect();
                assert!(by.iter().all(|x| (x - by[0]).abs() <= 1e-12 * 90.0 * unit), "{by:?}");
            }
            assert!(after.iter().all(|part| part[0][2] == -1.0 && part[1][2] == 1.0), "{after:?}");
        }
    }

    #[test]
    fn single_vertices_are_a_grid() {
        let mut parts: Vec<Vec<[f64; 2]>> = vec![vec![[3.0, 3.0]]; 100];
        lay_beside(&mut parts);
        let rows: std::collections::BTreeSet<u64> = parts.iter().map(|part| part[0][1].to_bits()).collect();
        assert!((5..=20).contains(&rows.len()), "{}", rows.len());
        lay_beside::<2>(&mut []);
    }
}
