//! The metrics of R^d: which sum their lengths are, and which distance a length stands for.
//!
//! In: coordinates.
//! Out: lengths of blocks of points, radii.
//! Invariants: a length is summed in the order of the coordinates, one operation after the other, so it is the same
//! double however many are computed at once, and whichever end comes first.
//! Must not know: how points are stored beyond one block.
//!
//! `angular` and `haversine` are taken on the unit sphere: there the square of the chord grows with the angle. So both
//! compare squares of chords, and only what is shown is an angle or an arc.

use super::error::SpaceError;
use crate::topology::base::MAX_DIMENSION;

/// The mean radius of the Earth in metres (IUGG).
pub const EARTH_RADIUS: f64 = 6_371_008.8;

/// A distance of R^d.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Metric {
    /// The root of the sum of squared differences.
    #[default]
    Euclidean,
    /// The sum of absolute differences.
    Manhattan,
    /// The largest absolute difference.
    Chebyshev,
    /// The angle between two vectors, in radians: the arc cosine of their cosine similarity.
    Angular,
    /// The arc between two places on the Earth, in metres; points are longitude and latitude in degrees.
    Haversine,
}

/// How many points are measured at once.
pub const LANES: usize = 8;

/// One coordinate of as many points as are measured at once.
pub type Lane = [f64; LANES];

impl Metric {
    /// Whether points may have so many coordinates.
    ///
    /// # Errors
    /// [`SpaceError::Dimension`], [`SpaceError::NotOnTheSphere`].
    pub fn check_dimension(self, dimension: usize) -> Result<(), SpaceError> {
        match (self, dimension) {
            (Self::Haversine, 1 | 3..=MAX_DIMENSION) => Err(SpaceError::NotOnTheSphere(dimension)),
            (_, 1..=MAX_DIMENSION) => Ok(()),
            _ => Err(SpaceError::Dimension(dimension)),
        }
    }

    /// Whether a point with these finite coordinates has distances. `point` is its number, for the message.
    ///
    /// # Errors
    /// [`SpaceError::NoDirection`], [`SpaceError::Latitude`].
    pub fn check_point(self, point: usize, coordinates: &[f64]) -> Result<(), SpaceError> {
        match (self, coordinates) {
            (Self::Angular, _) if coordinates.iter().all(|&x| x == 0.0) => Err(SpaceError::NoDirection(point)),
            (Self::Haversine, &[_, latitude]) if latitude.abs() > 90.0 => {
                Err(SpaceError::Latitude { point, value: latitude })
            }
            _ => Ok(()),
        }
    }

    /// Whether lengths are squares of distances, or of chords.
    pub fn is_squared(self) -> bool {
        !matches!(self, Self::Manhattan | Self::Chebyshev)
    }

    /// Half of the distance that a length stands for.
    pub fn radius(self, length: f64) -> f64 {
        match self {
            Self::Euclidean => 0.5 * length.sqrt(),
            Self::Manhattan | Self::Chebyshev => 0.5 * length,
            Self::Angular => half_angle(length),
            Self::Haversine => EARTH_RADIUS * half_angle(length),
        }
    }

    /// The distance between two points of one dimension, with finite coordinates.
    ///
    /// # Errors
    /// [`SpaceError::NoDirection`], [`SpaceError::Latitude`].
    pub fn distance(self, p: &[f64], q: &[f64]) -> Result<f64, SpaceError> {
        let between = |p: &[f64], q: &[f64]| 2.0 * self.radius(self.sum(p.iter().zip(q).map(|(p, q)| p - q)));
        if matches!(self, Self::Euclidean | Self::Manhattan | Self::Chebyshev) {
            return Ok(between(p, q));
        }
        let mut places = [p, q].map(|point| vec![0.0; self.width(point.len())]);
        for (number, point) in [p, q].into_iter().enumerate() {
            self.place(number, point, &mut places[number])?;
        }
        Ok(between(&places[0], &places[1]))
    }

    /// The lengths from one point of the block `from` to all points of the block `to`.
    #[inline]
    pub(super) fn lengths(self, from: &[Lane], lane: usize, to: &[Lane]) -> Lane {
        match self {
            Self::Manhattan => fold(from, lane, to, |sum, difference| sum + difference.abs()),
            Self::Chebyshev => fold(from, lane, to, |most, difference| most.max(difference.abs())),
            _ => fold(from, lane, to, |sum, difference| sum + difference * difference),
        }
    }

    /// The length from one point of a block to one of another.
    #[inline]
    pub(super) fn length(self, from: &[Lane], lane: usize, to: &[Lane], other: usize) -> f64 {
        self.sum(from.iter().zip(to).map(|(from, to)| from[lane % LANES] - to[other % LANES]))
    }

    /// The length that differences of coordinates make. Zeros at the end change nothing.
    #[inline]
    pub(super) fn sum(self, differences: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::Manhattan => differences.fold(0.0, |sum, difference| sum + difference.abs()),
            Self::Chebyshev => differences.fold(0.0, |most: f64, difference| most.max(difference.abs())),
            _ => differences.fold(0.0, |sum, difference| sum + difference * difference),
        }
    }

    /// The coordinates that lengths are taken of, from those of one point.
    pub(super) fn place(self, point: usize, coordinates: &[f64], out: &mut [f64]) -> Result<(), SpaceError> {
        self.check_point(point, coordinates)?;
        match self {
            Self::Angular => direction(coordinates, out),
            Self::Haversine => on_the_sphere(coordinates, out),
            _ => out.copy_from_slice(coordinates),
        }
        Ok(())
    }

    /// How many coordinates lengths are taken of, where points have `dimension`.
    pub(super) fn width(self, dimension: usize) -> usize {
        if self == Self::Haversine { 3 } else { dimension }
    }
}

#[inline]
fn fold(from: &[Lane], lane: usize, to: &[Lane], add: impl Fn(f64, f64) -> f64) -> Lane {
    let mut lengths = [0.0; LANES];
    for (from, to) in from.iter().zip(to) {
        let x = from[lane % LANES];
        for (length, &y) in lengths.iter_mut().zip(to) {
            *length = add(*length, x - y);
        }
    }
    lengths
}

/// Half of the angle under which a chord of the unit circle is seen, from the square of the chord.
fn half_angle(squared_chord: f64) -> f64 {
    (0.5 * squared_chord.sqrt()).min(1.0).asin()
}

/// A vector of length one in the same direction. It is scaled by its largest coordinate first, so that no square is
/// lost. The vector is not zero.
fn direction(vector: &[f64], out: &mut [f64]) {
    let largest = vector.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let norm = vector.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt();
    for (out, x) in out.iter_mut().zip(vector) {
        *out = x / largest / norm;
    }
}

fn on_the_sphere(degrees: &[f64], out: &mut [f64]) {
    let (longitude, latitude) = (degrees[0], degrees[1]);
    let (sine, cosine) = turn(latitude);
    let (y, x) = turn(longitude);
    out.copy_from_slice(&[cosine * x, cosine * y, sine]);
}

/// Sine and cosine of degrees. They are exact at multiples of a right angle, so that a pole is one place and a full
/// turn leads back.
fn turn(degrees: f64) -> (f64, f64) {
    let degrees = degrees % 360.0;
    let quarters = (degrees / 90.0).round();
    let (sine, cosine) = (degrees - 90.0 * quarters).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}
