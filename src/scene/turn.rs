//! Angles in turns, with sines and cosines that are the same on every machine.
//!
//! In: numbers of turns, and positions. Out: directions, positions.
//!
//! Invariants: only additions and multiplications are used. IEEE 754 defines them to the last bit, while the sine of
//! the system's library differs between systems. Errors are below 1e-15.
//!
//! Must not know: shapes.

use std::f64::consts::TAU;

/// The unit vector at an angle from the x axis, counterclockwise.
pub fn direction(turns: f64) -> [f64; 2] {
    let turns = turns - turns.floor();
    let quarters = (turns * 4.0).round();
    let (cos, sin) = near_zero((turns - quarters / 4.0) * TAU);
    match quarters as u8 % 4 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}

/// Cosine and sine of an angle in radians of at most an eighth of a turn. This is their series to the precision of
/// doubles.
fn near_zero(angle: f64) -> (f64, f64) {
    let square = angle * angle;
    let series = |first: u32| {
        let terms = (0..8).rev().map(|term| f64::from((2 * term + first) * (2 * term + first + 1)));
        terms.fold(1.0, |sum, divisor| 1.0 - square / divisor * sum)
    };
    (series(1), angle * series(2))
}

/// The sine of an angle.
pub fn wave(turns: f64) -> f64 {
    direction(turns)[1]
}

/// A position, rotated around the origin by the angle of a direction.
pub fn turned([x, y]: [f64; 2], [cos, sin]: [f64; 2]) -> [f64; 2] {
    [x * cos - y * sin, x * sin + y * cos]
}

/// A position, moved by a multiple of a vector.
pub fn moved([x, y]: [f64; 2], [dx, dy]: [f64; 2], lengths: f64) -> [f64; 2] {
    [x + dx * lengths, y + dy * lengths]
}

/// The square of the distance of two positions.
pub fn distance_squared([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax - bx) * (ax - bx) + (ay - by) * (ay - by)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_right() {
        for step in -3000..3000 {
            let turns = f64::from(step) / 701.0;
            let (sin, cos) = (turns * TAU).sin_cos();
            let [x, y] = direction(turns);
            assert!((x - cos).abs() < 1e-14 && (y - sin).abs() < 1e-14, "{turns}: {x} {y}");
        }
        assert_eq!(direction(0.25), [0.0, 1.0]);
    }
}
