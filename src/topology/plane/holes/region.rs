//! The region of a hole at its birth.
//!
//! In: the walks around a hole.
//! Out: a [`Region`]: its boundary and area; whether it contains a point, is near to one, or can be changed by a
//! vertex.
//! Invariant: it depends on positions alone, bit for bit.
//! Must not know: tracks, frames, the triangulation.

use std::sync::Arc;

use super::boundary::Walks;
use crate::topology::cloud::{Located, Position, Slot, VertexId};

/// A vertex of a boundary with its position.
pub type BoundaryVertex = (VertexId, Position);

/// The region of a hole at its birth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Region {
    /// Shared between copies.
    boundary: Arc<Vec<Vec<BoundaryVertex>>>,
    area: f64,
    /// Opposite corners of the bounding box.
    bounds: [[f64; 2]; 2],
    /// The same for the circles that have the edges of the boundary as diameters.
    reach: [[f64; 2]; 2],
}

impl Region {
    /// The region inside some walks.
    pub(crate) fn new(walks: Walks, id: impl Fn(Slot) -> VertexId) -> Self {
        let named = |walk: Vec<Located<Slot>>| walk.into_iter().map(|(at, slot)| (id(slot), at)).collect();
        let boundary: Vec<Vec<BoundaryVertex>> = walks.into_iter().map(named).collect();
        let (mut bounds, mut reach) = (NOTHING, NOTHING);
        for [a, b] in boundary.iter().flat_map(|walk| steps(walk)) {
            let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let radius = 0.5 * (b[0] - a[0]).hypot(b[1] - a[1]) * (1.0 + MARGIN);
            widen(&mut bounds, a, 0.0);
            widen(&mut reach, middle, radius);
        }
        let area = boundary.iter().map(|walk| area(walk)).sum();
        Self { boundary: Arc::new(boundary), area, bounds, reach }
    }

    /// Closed walks around the region, each without its first vertex at the end: the outer one counter-clockwise, then
    /// those around islands, clockwise. The outer walk is the cycle of the dot: it is born with the critical edge and
    /// filled with the hole.
    pub fn boundary(&self) -> &[Vec<BoundaryVertex>] {
        &self.boundary
    }

    /// The area, without islands.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Whether a point is in it.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        is_within(self.bounds, point) && self.boundary.iter().map(|walk| winding(point, walk)).sum::<i32>() != 0
    }

    /// Whether a vertex that appears or vanishes at a position may change the region. While the dot keeps its name and
    /// critical edge, no vertex elsewhere does. Proof: let a vertex be in the circumcircle of a triangle of the region.
    /// Then it is in that of the last triangle before the boundary on the way there, or inside the region. That last
    /// triangle does not flow across the boundary, so the part of its circle beyond an edge is inside the circle around
    /// that edge. And only a vertex in there could make a triangle beyond the boundary flow into the region.
    pub(crate) fn is_touched(&self, vertex: Position) -> bool {
        is_within(self.reach, vertex.xy())
    }

    /// Whether a point is at most half of the box' sides away from the bounding box.
    pub(crate) fn is_near(&self, point: [f64; 2]) -> bool {
        let [low, high] = self.bounds;
        let is_there = !self.boundary.is_empty();
        is_there
            && (0..2).all(|axis| {
                let margin = 0.5 * (high[axis] - low[axis]);
                low[axis] - margin <= point[axis] && point[axis] <= high[axis] + margin
            })
    }
}

/// The box around nothing.
const NOTHING: [[f64; 2]; 2] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];

/// Circles are rounded. They are made larger by this share of the radius.
const MARGIN: f64 = 1e-6;

/// Extends a box by a square around a point.
fn widen([low, high]: &mut [[f64; 2]; 2], point: [f64; 2], half_side: f64) {
    for axis in 0..2 {
        low[axis] = low[axis].min(point[axis] - half_side);
        high[axis] = high[axis].max(point[axis] + half_side);
    }
}

fn is_within([low, high]: [[f64; 2]; 2], point: [f64; 2]) -> bool {
    (0..2).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
}

fn steps(walk: &[BoundaryVertex]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    walk.iter().zip(walk.iter().cycle().skip(1)).map(|(a, b)| [a.1.xy(), b.1.xy()])
}

/// Positive when counter-clockwise.
fn area(walk: &[BoundaryVertex]) -> f64 {
    let Some([x, y]) = walk.first().map(|first| first.1.xy()) else { return 0.0 };
    steps(walk).map(|[[ax, ay], [bx, by]]| (ax - x) * (by - y) - (bx - x) * (ay - y)).sum::<f64>() / 2.0
}

/// The winding number of a walk around a point, counter-clockwise.
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
    fn points_near_a_region_may_be_outside() {
        let region = square_with_island();
        for (point, is_near) in [([5.9, -1.9], true), ([6.1, 2.0], false), ([1.5, 1.5], true), ([2.0, -2.1], false)] {
            assert_eq!(region.is_near(point), is_near, "{point:?}");
        }
        assert!(!Region::default().is_near([0.0, 0.0]));
    }

    #[test]
    fn vertices_touch_a_region_near_its_boundary_or_inside() {
        let region = square_with_island();
        for ([x, y], touches) in [([2.0, -2.0], true), ([2.0, 2.0], true), ([2.0, -2.1], false), ([6.1, 2.0], false)] {
            assert_eq!(region.is_touched(Position::new(x, y).unwrap()), touches, "{x}, {y}");
        }
    }
}
