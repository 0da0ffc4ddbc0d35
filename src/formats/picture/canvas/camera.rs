//! From the plane of the points to pixels.
//!
//! In: the points that must be seen.
//! Out: their places in a panel.
//! Invariants: both axes have one scale, y points up; differences are taken before they are scaled, so offsets and
//! units of any magnitude do not matter; one place alone is in the middle.
//! Must not know: what is drawn there.

use super::layout::Rect;

/// Room between the points and the panel's frame.
const PADDING: f64 = 20.0;

/// The least box around points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    low: [f64; 2],
    high: [f64; 2],
}

impl Extent {
    /// The box around nothing.
    pub const EMPTY: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    /// The box around this one and a point.
    pub fn with(self, [x, y]: [f64; 2]) -> Self {
        Self { low: [self.low[0].min(x), self.low[1].min(y)], high: [self.high[0].max(x), self.high[1].max(y)] }
    }

    /// The box around this one and a circle.
    pub fn with_circle(self, [x, y]: [f64; 2], radius: f64) -> Self {
        self.with([x - radius, y - radius]).with([x + radius, y + radius])
    }

    /// Its width and height.
    pub fn size(&self) -> [f64; 2] {
        [0, 1].map(|axis| (self.high[axis] - self.low[axis]).max(0.0))
    }
}

/// Maps the plane to a panel whose corner is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    target: [f64; 2],
    middle: [f64; 2],
    scale: f64,
}

impl Camera {
    /// The largest picture of `extent` that fits.
    pub fn new(extent: Extent, panel: Rect) -> Self {
        let size = extent.size();
        let room = [panel.width, panel.height].map(|side| side - 2.0 * PADDING);
        let fit = (room[0] / size[0]).min(room[1] / size[1]);
        Self {
            target: [0, 1].map(|axis| extent.low[axis] + size[axis] / 2.0),
            middle: [panel.width / 2.0, panel.height / 2.0],
            scale: if fit.is_finite() { fit } else { 0.0 },
        }
    }

    /// Where a point is.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = [x - self.target[0], y - self.target[1]].map(|difference| difference * self.scale);
        [self.middle[0] + dx, self.middle[1] - dy]
    }

    /// Pixels for a unit of the plane; 0 if all points are one.
    pub fn scale(&self) -> f64 {
        self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PANEL: Rect = Rect { x: 7.0, y: 9.0, width: 240.0, height: 140.0 };

    fn camera(points: &[[f64; 2]]) -> Camera {
        Camera::new(points.iter().fold(Extent::EMPTY, |extent, &point| extent.with(point)), PANEL)
    }

    #[test]
    fn y_is_up_and_both_axes_have_one_scale() {
        let camera = camera(&[[0.0, 0.0], [10.0, 10.0]]);
        assert_eq!(camera.scale(), 10.0);
        assert_eq!(camera.place([0.0, 0.0]), [70.0, 120.0]);
        assert_eq!(camera.place([10.0, 10.0]), [170.0, 20.0]);
    }

    #[test]
    fn offsets_and_units_do_not_matter() {
        for (offset, unit) in [(1e8, 1.0), (0.0, 1e-9), (-1e60, 1e59), (0.0, 1e-43)] {
            let camera = camera(&[[offset, offset], [offset + 2.0 * unit, offset + unit]]);
            let place = camera.place([offset + 2.0 * unit, offset + unit]);
            assert!((place[0] - 220.0).abs() < 1e-3 && (place[1] - 20.0).abs() < 1e-3, "{place:?}");
        }
    }

    #[test]
    fn a_line_and_a_point_are_in_the_middle() {
        assert_eq!(camera(&[[3.0, 4.0], [5.0, 4.0]]).place([5.0, 4.0]), [220.0, 70.0]);
        assert_eq!(camera(&[[3.0, 4.0]]).place([3.0, 4.0]), [120.0, 70.0]);
        assert_eq!(camera(&[]).scale(), 0.0);
    }

    #[test]
    fn circles_count_with_their_radius() {
        let extent = Extent::EMPTY.with_circle([1.0, 1.0], 2.0);
        assert_eq!(extent, Extent::EMPTY.with([-1.0, 3.0]).with([3.0, -1.0]));
    }
}
