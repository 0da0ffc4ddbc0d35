//! The region that a hole takes up at its birth, as it is kept from frame to frame.
//!
//! In: the walks around a hole, and later where the cloud has changed. Out: a [`Region`]: its boundary, its area, whether a point lies in it, whether a
//! change can have touched it. Invariants: it depends on positions alone, bit for bit; a region that no change touches is still the region of its dot. Must
//! not know: tracks, frames, the triangulation.

use super::cloud::VertexId;
use super::hole::Walks;
use super::position::Position;

/// A vertex of a boundary and where it is.
pub type BoundaryVertex = (VertexId, Position);

/// The region that a hole takes up at its birth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    boundary: Vec<Vec<BoundaryVertex>>,
    area: f64,
    /// Opposite corners of a box around it.
    bounds: [[f64; 2]; 2],
}

impl Region {
    /// From the walks around it.
    pub(super) fn new(walks: Walks, id: impl Fn(u32) -> VertexId) -> Self {
        let named = |walk: Vec<(Position, u32)>| walk.into_iter().map(|(at, slot)| (id(slot), at)).collect();
        let boundary: Vec<Vec<BoundaryVertex>> = walks.into_iter().map(named).collect();
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for (_, position) in boundary.iter().flatten() {
            for (axis, value) in position.xy().into_iter().enumerate() {
                bounds[0][axis] = bounds[0][axis].min(value);
                bounds[1][axis] = bounds[1][axis].max(value);
            }
        }
        let area = boundary.iter().map(|walk| area(walk)).sum();
        Self { boundary, area, bounds }
    }

    /// Closed walks around it, each without its first vertex at the end: the outer one counter-clockwise, then those around islands in it, clockwise. The outer walk
    /// is the cycle of the dot: it is born with the critical edge and filled with the hole.
    pub fn boundary(&self) -> &[Vec<BoundaryVertex>] {
        &self.boundary
    }

    /// Its area, islands left out.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Whether a point lies in it.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        let [low, high] = self.bounds;
        (0..2).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
            && self.boundary.iter().map(|walk| winding(point, walk)).sum::<i32>() != 0
    }

    /// Whether it may be another one after a change, though its dot is the same, whose birth is given.
    ///
    /// All circles around its triangles are empty and end no farther than the birth beyond the boundary: its edges are Gabriel, and no longer than twice the
    /// birth. So what comes or goes farther away changes none of its triangles.
    pub(super) fn is_touched(&self, birth: f64, touched: &Touched) -> bool {
        let Touched::At(places) = touched else { return true };
        // A little more, for what rounding may have taken.
        let margin = birth * (1.0 + 1e-9);
        let [low, high] = self.bounds;
        let first = places.partition_point(|place| place[0] < low[0] - margin);
        let in_columns = places[first..].iter().take_while(|place| place[0] <= high[0] + margin);
        in_columns.into_iter().any(|place| low[1] - margin <= place[1] && place[1] <= high[1] + margin)
    }
}

/// Where vertices have come or gone.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Touched {
    /// Perhaps anywhere.
    Anywhere,
    /// Here, by x.
    At(Vec<[f64; 2]>),
}

impl Touched {
    pub fn at(places: impl Iterator<Item = Position>) -> Self {
        let mut places: Vec<[f64; 2]> = places.map(Position::xy).collect();
        places.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        Self::At(places)
    }
}

fn steps(walk: &[BoundaryVertex]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    walk.iter().zip(walk.iter().cycle().skip(1)).map(|(a, b)| [a.1.xy(), b.1.xy()])
}

/// Positive when counter-clockwise.
fn area(walk: &[BoundaryVertex]) -> f64 {
    let Some([x, y]) = walk.first().map(|first| first.1.xy()) else { return 0.0 };
    steps(walk).map(|[[ax, ay], [bx, by]]| (ax - x) * (by - y) - (bx - x) * (ay - y)).sum::<f64>() / 2.0
}

/// How often a walk goes around a point, counter-clockwise.
fn winding([x, y]: [f64; 2], walk: &[BoundaryVertex]) -> i32 {
    let turn = |[[ax, ay], [bx, by]]: [[f64; 2]; 2]| {
        let cross = (ax - x) * (by - y) - (bx - x) * (ay - y);
        i32::from(ay <= y && by > y && cross > 0.0) - i32::from(by <= y && ay > y && cross < 0.0)
    };
    steps(walk).map(turn).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(walks: &[&[[f64; 2]]]) -> Region {
        let site = |&[x, y]: &[f64; 2]| (Position::new(x, y).unwrap(), 0);
        Region::new(walks.iter().map(|walk| walk.iter().map(site).collect()).collect(), |_| VertexId(0))
    }

    fn square_with_island() -> Region {
        let outer = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        region(&[&outer, &[[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]]])
    }

    #[test]
    fn islands_are_no_part_of_a_region() {
        let region = square_with_island();
        assert_eq!(region.area(), 15.0);
        for (point, is_inside) in [([3.0, 3.0], true), ([1.5, 1.5], false), ([5.0, 3.0], false), ([0.5, 1.5], true)] {
            assert_eq!(region.contains(point), is_inside, "{point:?}");
        }
        assert!(!Region::default().contains([0.0, 0.0]));
    }

    #[test]
    fn a_region_is_touched_from_as_far_as_its_edges_reach() {
        let region = square_with_island();
        let touched = |places: &[[f64; 2]]| Touched::at(places.iter().map(|&[x, y]| Position::new(x, y).unwrap()));
        for (place, is_touched) in [([6.0, 3.0], true), ([6.1, 3.0], false), ([2.0, -2.0], true), ([2.0, 6.5], false)] {
            assert_eq!(region.is_touched(2.0, &touched(&[[-9.0, 3.0], place, [9.0, 3.0]])), is_touched, "{place:?}");
        }
        assert!(region.is_touched(2.0, &Touched::Anywhere));
        assert!(!region.is_touched(2.0, &touched(&[])));
    }
}
