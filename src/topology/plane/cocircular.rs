//! Faces with more than three sites on their circle: the triangle that names them, however they are cut into triangles.
//!
//! In: sites on one circle.
//! Out: the triangle of the fan around the smallest site that contains the centre.
//! Invariants: answers depend on positions alone, and are exact.
//! Must not know: triangulations, dots, tiles.

use super::geometry::{Cocircular, are_cocircular, is_obtuse, orientation, quick_cocircular};
use crate::topology::cloud::{Located, Position};

/// The triangle that contains the centre of the circle, of the fan around the smallest site. If the centre is on the
/// border of two triangles, the later one by position. Its corners are in order.
pub fn central_triangle<S: Copy>(sites: &mut [Located<S>]) -> [Located<S>; 3] {
    let smallest = (0..sites.len()).min_by_key(|&index| sites[index].0).unwrap_or(0);
    sites.swap(0, smallest);
    let (&mut apex, around) = sites.split_first_mut().expect("a triangle has corners");
    // The apex is the smallest site, so all others lie within half a turn around it.
    around.sort_unstable_by(|a, b| orientation(apex.0, b.0, a.0));
    let fan = around.windows(2).map(|pair| by_position([apex, pair[0], pair[1]]));
    fan.filter(|triangle| !is_obtuse(triangle.map(|site| site.0)))
        .max_by_key(|triangle| triangle.map(|site| site.0))
        .expect("a maximum holds the centre of its circle, and a fan leaves no gap")
}

/// Three sites in order of position.
pub fn by_position<S: Copy>([a, b, c]: [Located<S>; 3]) -> [Located<S>; 3] {
    let in_order = |a: Located<S>, b: Located<S>| if b.0 < a.0 { [b, a] } else { [a, b] };
    let [a, b] = in_order(a, b);
    let [b, c] = in_order(b, c);
    let [a, b] = in_order(a, b);
    [a, b, c]
}

/// Exact: whether two points on either side of a line through two others lie on one circle with these.
#[inline]
pub fn on_one_circle(a: Position, b: Position, p: Position, q: Position) -> bool {
    match quick_cocircular(a, b, p, q) {
        Cocircular::No => false,
        Cocircular::Yes => true,
        Cocircular::Perhaps => are_cocircular(a, b, p, q),
    }
}
