//! Measures and exact tests of points, pairs and triangles.
//!
//! In: positions.
//! Out: circumcircles right to a few units in the last place; the exact signs of orientation, angle and in-circle
//! tests.
//! Invariants: results depend on the positions alone, not on the order of the arguments nor on the triangulation.
//! Must not know: indices, meshes.
//!
//! The filters and expansions follow J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates", Discrete & Computational Geometry 18, 1997, sections 2 and 4.

use std::cmp::Ordering;

use crate::topology::cloud::{Position, half_length_squared};

/// Error bound of a sum of two products of two differences, relative to the sum of the products' magnitudes
/// (Shewchuk's bound A of the orientation test, which has the same shape).
const PRODUCT_SUM_ERROR: f64 = (3.0 + 8.0 * f64::EPSILON) * (f64::EPSILON / 2.0);

/// A cross product below this share of its two products is computed exactly. Above it, rounding costs less than 4e-13.
const CANCELLATION: f64 = 1e-3;

/// A circle of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// The centre; may overflow to infinities for needle-thin triangles.
    pub center: [f64; 2],
    /// The radius, squared; +infinity when it overflows.
    pub radius_squared: f64,
}

/// Exact: compares the angle a-apex-b with a right angle. `Greater` when acute, `Equal` when right, `Less` when obtuse:
/// the sign of the scalar product.
#[inline]
pub fn acuteness(a: Position, apex: Position, b: Position) -> Ordering {
    quick_acuteness(a, apex, b).unwrap_or_else(|| sign(exact_dot(a, apex, b)))
}

/// Exact: whether a triangle has an obtuse angle.
pub fn is_obtuse([a, b, c]: [Position; 3]) -> bool {
    [(a, b, c), (b, c, a), (c, a, b)].into_iter().any(|(p, apex, q)| acuteness(p, apex, q) == Ordering::Less)
}

/// The same where rounding cannot have decided it, else none.
#[inline]
pub fn quick_acuteness(a: Position, apex: Position, b: Position) -> Option<Ordering> {
    let xx = (a.x() - apex.x()) * (b.x() - apex.x());
    let yy = (a.y() - apex.y()) * (b.y() - apex.y());
    let dot = xx + yy;
    let sure = dot.abs() > PRODUCT_SUM_ERROR * (xx.abs() + yy.abs());
    sure.then_some(sign(dot))
}

#[inline]
fn sign(value: f64) -> Ordering {
    (value > 0.0).cmp(&(value < 0.0))
}

/// The result of a quick test whether four points lie on one circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cocircular {
    /// Certainly not.
    No,
    /// Undecided: ask [`are_cocircular`].
    Perhaps,
    /// Certainly.
    Yes,
}

/// A quick test whether `p` and `q`, on either side of the line through `a` and `b`, lie on one circle with them.
///
/// They do if the angles at `p` and `q` sum to two right angles, that is, if their cotangents cancel.
#[inline]
pub fn quick_cocircular(a: Position, b: Position, p: Position, q: Position) -> Cocircular {
    let [left, right] = [p, q].map(|apex| {
        let (ax, ay) = (a.x() - apex.x(), a.y() - apex.y());
        let (bx, by) = (b.x() - apex.x(), b.y() - apex.y());
        let dot = [ax * bx, ay * by];
        let cross = [ax * by, -(ay * bx)];
        [dot[0] + dot[1], dot[0].abs() + dot[1].abs(), (cross[0] + cross[1]).abs(), cross[0].abs() + cross[1].abs()]
    });
    let [dot, dot_bound, cross, cross_bound] = left;
    let [other_dot, other_dot_bound, other_cross, other_cross_bound] = right;
    let cancels = dot * other_cross + other_dot * cross;
    if cancels.abs() > 1e-14 * (dot_bound * other_cross_bound + other_dot_bound * cross_bound) {
        Cocircular::No
    } else if are_small_integers(a, b, p, q) {
        if cancels == 0.0 { Cocircular::Yes } else { Cocircular::No }
    } else {
        Cocircular::Perhaps
    }
}

/// Whether products of four coordinate differences of these points are integers that doubles hold exactly, as for
/// pixels.
fn are_small_integers(a: Position, b: Position, p: Position, q: Position) -> bool {
    let reach = 1024.0;
    [a, b, p, q].iter().all(|v| {
        let integer = |v: f64| v == v.trunc() && v.abs() < 1e15;
        let near = |v: f64, w: f64| (v - w).abs() <= reach;
        integer(v.x()) && integer(v.y()) && near(v.x(), a.x()) && near(v.y(), a.y())
    })
}

/// Exact: whether `a`, `b` and `c` lie on one line.
pub fn are_collinear(a: Position, b: Position, c: Position) -> bool {
    orientation(a, b, c) == Ordering::Equal
}

/// Exact: `Greater` when a, b, c turn counter-clockwise, `Less` when clockwise, `Equal` when on one line.
pub fn orientation(a: Position, b: Position, c: Position) -> Ordering {
    sign(robust::orient2d(coord(a), coord(b), coord(c)))
}

/// Exact: whether the four points lie on one circle. The first three must not be collinear.
pub fn are_cocircular(a: Position, b: Position, c: Position, d: Position) -> bool {
    robust::incircle(coord(a), coord(b), coord(c), coord(d)) == 0.0
}

/// The circumcircle of three points in increasing order that are not collinear.
///
/// It is computed from the vertex of the largest angle, where differences cancel least. A sliver's doubled area is
/// computed exactly, since rounding would leave nothing of it.
pub fn circumcircle(corners: [Position; 3]) -> Circle {
    debug_assert!(corners.is_sorted());
    let [origin, p, q] = from_largest_angle(corners);
    let (px, py) = (p.x() - origin.x(), p.y() - origin.y());
    let (qx, qy) = (q.x() - origin.x(), q.y() - origin.y());
    let (pp, qq) = (px * px + py * py, qx * qx + qy * qy);
    let opposite = 4.0 * half_length_squared(p, q);
    let (left, right) = (px * qy, py * qx);
    let mut cross = left - right;
    if cross.abs() < CANCELLATION * (left.abs() + right.abs()) {
        cross = exact_cross(origin, p, q);
    }
    let (ux, uy) = (qy * pp - py * qq, px * qq - qx * pp);
    Circle {
        center: [origin.x() + 0.5 * (ux / cross), origin.y() + 0.5 * (uy / cross)],
        radius_squared: (pp / cross) * (qq / cross) * opposite * 0.25,
    }
}

/// The squared circumradius of three points in increasing order that are not collinear. Faster than [`circumcircle`].
#[inline]
pub fn circumradius_squared([a, b, c]: [Position; 3]) -> f64 {
    debug_assert!(a < b && b < c);
    let (left, right) = ((b.x() - a.x()) * (c.y() - a.y()), (b.y() - a.y()) * (c.x() - a.x()));
    let mut cross = left - right;
    if cross.abs() < CANCELLATION * (left.abs() + right.abs()) {
        cross = exact_cross(a, b, c);
    }
    let [ab, ac, bc] = [(a, b), (a, c), (b, c)].map(|(p, q)| half_length_squared(p, q));
    // Division comes before multiplication, so only a radius that is too large itself overflows.
    (ab / cross) * (ac / cross) * (16.0 * bc)
}

/// The corners, the one opposite to the longest side first (the first such, if sides tie).
fn from_largest_angle([a, b, c]: [Position; 3]) -> [Position; 3] {
    let (bc, ac, ab) = (half_length_squared(b, c), half_length_squared(a, c), half_length_squared(a, b));
    if bc >= ac && bc >= ab {
        [a, b, c]
    } else if ac >= ab {
        [b, a, c]
    } else {
        [c, a, b]
    }
}

fn coord(p: Position) -> robust::Coord<f64> {
    robust::Coord { x: p.x(), y: p.y() }
}

/// (a - apex) . (b - apex); its sign is exact.
#[cold]
fn exact_dot(a: Position, apex: Position, b: Position) -> f64 {
    let [ax, ay] = [two_diff(a.x(), apex.x()), two_diff(a.y(), apex.y())];
    let [bx, by] = [two_diff(b.x(), apex.x()), two_diff(b.y(), apex.y())];
    // Pixels end here: the products are exact, and so is the sign of their rounded sum.
    let is_short = |difference: [f64; 2]| difference[1] == 0.0 && f64::from(difference[0] as f32) == difference[0];
    if [ax, ay, bx, by].into_iter().all(is_short) {
        return ax[0] * bx[0] + ay[0] * by[0];
    }
    exact_product_sum([ax, bx], [ay, by])
}

/// (p - origin) x (q - origin), right to the last bits.
#[cold]
fn exact_cross(origin: Position, p: Position, q: Position) -> f64 {
    let [px, py] = [two_diff(p.x(), origin.x()), two_diff(origin.y(), p.y())];
    let [qx, qy] = [two_diff(q.x(), origin.x()), two_diff(q.y(), origin.y())];
    exact_product_sum([px, qy], [py, qx])
}

/// The sum of two products of exact differences, in effect rounded once.
fn exact_product_sum(first: [[f64; 2]; 2], second: [[f64; 2]; 2]) -> f64 {
    let exact_differences = [first, second].as_flattened().iter().all(|difference| difference[1] == 0.0);
    if exact_differences {
        // Pixels and other small integers end here: nothing was rounded.
        let [left, right] = [first, second].map(|[a, b]| two_product(a[0], b[0]));
        if left[1] == 0.0 && right[1] == 0.0 {
            return left[0] + right[0];
        }
    }
    let mut sum = Expansion::default();
    sum.add_product(first);
    sum.add_product(second);
    sum.value()
}

/// a * b as a rounded value and its error.
fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, a.mul_add(b, -product)]
}

/// a - b as a rounded value and its error.
fn two_diff(a: f64, b: f64) -> [f64; 2] {
    let x = a - b;
    let virtual_b = a - x;
    let virtual_a = x + virtual_b;
    [x, (a - virtual_a) + (virtual_b - b)]
}

/// a + b as a rounded value and its error.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let x = a + b;
    let virtual_b = x - a;
    let virtual_a = x - virtual_b;
    [x, (a - virtual_a) + (b - virtual_b)]
}

/// A sum of doubles kept without rounding: components of increasing magnitude that do not overlap.
#[derive(Default)]
struct Expansion {
    components: [f64; 16],
    len: usize,
}

impl Expansion {
    /// Adds one double exactly; needs one more component.
    fn add(&mut self, term: f64) {
        let mut carry = term;
        for component in &mut self.components[..self.len] {
            [carry, *component] = two_sum(carry, *component);
        }
        self.components[self.len] = carry;
        self.len += 1;
    }

    /// Adds the product of two exact differences: four products, each a value and its error.
    fn add_product(&mut self, [a, b]: [[f64; 2]; 2]) {
        for x in a {
            for y in b {
                let [product, error] = two_product(x, y);
                self.add(error);
                self.add(product);
            }
        }
    }

    /// The sum, in effect rounded once: components are added from the smallest.
    fn value(&self) -> f64 {
        self.components[..self.len].iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Position {
        Position::new(x, y).unwrap()
    }

    #[test]
    fn right_angles_are_not_acute_however_small_or_far() {
        for (scale, offset) in [(1.0, 0.0), (2f64.powi(-100), 0.0), (1.0, 1e8), (2f64.powi(180), 0.0)] {
            let p = |x: f64, y: f64| at(x * scale + offset, y * scale + offset);
            assert_eq!(acuteness(p(3.0, 0.0), p(0.0, 0.0), p(0.0, 7.0)), Ordering::Equal, "{scale} {offset}");
            assert_eq!(acuteness(p(3.0, 4.0), p(0.0, 0.0), p(-4.0, 3.0)), Ordering::Equal, "{scale} {offset}");
        }
    }

    #[test]
    fn the_last_bit_decides_an_angle() {
        let tiny = f64::EPSILON;
        assert_eq!(acuteness(at(1.0 + tiny, 1.0), at(0.0, 0.0), at(1.0, -1.0)), Ordering::Greater);
        assert_eq!(acuteness(at(1.0 - tiny, 1.0), at(0.0, 0.0), at(1.0, -1.0)), Ordering::Less);
    }

    #[test]
    fn circumradius_of_a_sliver_is_right() {
        // Height h over a base of 2: R = (1 + h^2) / (2 h), here far from the origin where differences are exact.
        for h in [1e-3, 2f64.powi(-30), 2f64.powi(-50)] {
            let r = circumcircle([at(-1.0, 0.0), at(0.0, h), at(1.0, 0.0)]).radius_squared.sqrt();
            let want = (1.0 + h * h) / (2.0 * h);
            assert!((r / want - 1.0).abs() < 1e-14, "{h}: {r} {want}");
        }
    }

    #[test]
    fn circumcircle_of_a_needle_is_right() {
        // Apex far away: the angle there is tiny, the two at the base nearly right.
        let c = circumcircle([at(-1e6, 0.0), at(0.0, -0.25), at(0.0, 0.25)]);
        let want = (1e12 + 0.0625) / 2e6;
        assert!((c.radius_squared.sqrt() / want - 1.0).abs() < 1e-15);
        assert!((c.center[0] + 1e6 - want).abs() < 1e-9 && c.center[1].abs() < 1e-9);
    }

    #[test]
    fn a_radius_that_overflows_is_infinite() {
        let c = circumcircle([at(0.0, 0.0), at(2f64.powi(200), 2f64.powi(-142)), at(2f64.powi(201), 0.0)]);
        assert_eq!(c.radius_squared, f64::INFINITY);
    }

    #[test]
    fn both_ways_to_a_circumradius_agree() {
        for h in [1.0, 0.3, 1e-3, 2f64.powi(-50)] {
            let corners = [at(-1.0, 0.0), at(0.1, h), at(1.0, 0.0)];
            let (quick, circle) = (circumradius_squared(corners), circumcircle(corners).radius_squared);
            assert!((quick / circle - 1.0).abs() < 1e-12, "{h}: {quick} {circle}");
        }
        assert_eq!(circumradius_squared([at(0.0, 0.0), at(0.0, 2.0), at(2.0, 0.0)]), 2.0);
    }

    #[test]
    fn cocircular_and_collinear_are_exact() {
        let on = [at(0.0, 5.0), at(3.0, 4.0), at(-4.0, 3.0), at(5.0, 0.0)];
        assert!(are_cocircular(on[0], on[1], on[2], on[3]));
        assert!(!are_cocircular(on[0], on[1], on[2], at(5.0, f64::EPSILON)));
        assert!(are_collinear(at(0.0, 0.0), at(1.0, 3.0), at(2.0, 6.0)));
        assert!(!are_collinear(at(0.0, 0.0), at(1.0, 3.0), at(2.0, 6.0 + 4.0 * f64::EPSILON)));
    }
}
