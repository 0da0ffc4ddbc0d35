//! Degrees of longitude and latitude as metres in a plane.
//!
//! In: points in degrees, x = longitude and y = latitude.
//! Out: metres east and north of an origin, and back; for series of inputs, their points so.
//! Invariants: the same point and origin give the same metres, so that a point can be taken back. The origin is given,
//! or the first point that can be one. What is no place on Earth is refused by name; what is no number is left to
//! others. The shortest way around the Earth counts: neighbours on both sides of the 180th meridian stay neighbours.
//! Must not know: how points are read, where they go.
//!
//! The projection is the local equirectangular one, on a sphere of the Earth's mean radius. Shapes are true near the
//! origin. Distances there are true to half a hundredth, as the Earth is no sphere, and less so far north or south of
//! it. It is written here in three lines; crates such as `proj` bind a large library for all projections.

use hopes::topology::Exact;
use thiserror::Error;

use crate::daemon::{Batch, Input, Point, Positions};

/// The Earth's mean radius, in metres.
const RADIUS: f64 = 6_371_008.8;
/// Farther north or south, degrees of longitude are too short for a plane.
const NEAREST_TO_POLE: f64 = 89.5;
/// Degrees are written to a ten-thousandth of a millimetre.
const GRAIN: f64 = 1e12;

/// Why a point has no place in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ProjectionError {
    /// Beyond the ends of longitude or latitude.
    #[error(
        "longitude {}, latitude {} is no place on Earth: x is -360 to 360, y is -90 to 90; or are the columns swapped?",
        Exact(*.0), Exact(*.1)
    )]
    NotOnEarth(f64, f64),
    /// An origin at a pole.
    #[error("latitude {} is too near to a pole to project around: the origin is at most {NEAREST_TO_POLE} degrees away from the equator", Exact(*.0))]
    Pole(f64),
}

/// A plane that touches the Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    origin: [f64; 2],
    /// Metres for a degree.
    scale: [f64; 2],
}

impl Projection {
    /// The plane that touches the Earth at a longitude and a latitude.
    ///
    /// # Errors
    /// [`ProjectionError`].
    pub fn around(origin: [f64; 2]) -> Result<Self, ProjectionError> {
        let [_, latitude] = on_earth(origin)?;
        if latitude.abs() > NEAREST_TO_POLE {
            return Err(ProjectionError::Pole(latitude));
        }
        let [east, north] = [RADIUS * latitude.to_radians().cos(), RADIUS];
        Ok(Self { origin, scale: [east, north].map(f64::to_radians) })
    }

    /// Longitude and latitude of the origin.
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Metres east and north of the origin.
    ///
    /// # Errors
    /// [`ProjectionError::NotOnEarth`].
    pub fn metres(&self, point: [f64; 2]) -> Result<[f64; 2], ProjectionError> {
        let [longitude, latitude] = on_earth(point)?;
        let east = match longitude - self.origin[0] {
            east if east > 180.0 => east - 360.0,
            east if east < -180.0 => east + 360.0,
            east => east,
        };
        Ok([east * self.scale[0], (latitude - self.origin[1]) * self.scale[1]])
    }

    /// Longitude and latitude again, to far less than a millimetre.
    pub fn degrees(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let rounded = |degrees: f64| (degrees * GRAIN).round() / GRAIN;
        [self.origin[0] + x / self.scale[0], self.origin[1] + y / self.scale[1]].map(rounded)
    }
}

fn on_earth([longitude, latitude]: [f64; 2]) -> Result<[f64; 2], ProjectionError> {
    let is_beyond = longitude.abs() > 360.0 || latitude.abs() > 90.0;
    if is_beyond { Err(ProjectionError::NotOnEarth(longitude, latitude)) } else { Ok([longitude, latitude]) }
}

/// Projects points as they come.
#[derive(Clone, Debug)]
pub struct Projector {
    projection: Option<Projection>,
}

impl Projector {
    /// Around an origin, or around the first point that comes.
    pub fn new(projection: Option<Projection>) -> Self {
        if let Some(projection) = &projection {
            announce(projection);
        }
        Self { projection }
    }

    /// The plane, once a point has come.
    pub fn projection(&self) -> Option<&Projection> {
        self.projection.as_ref()
    }

    /// A point in metres.
    ///
    /// # Errors
    /// [`ProjectionError`].
    pub fn metres(&mut self, point: [f64; 2]) -> Result<[f64; 2], ProjectionError> {
        if !point.iter().all(|value| value.is_finite()) {
            return Ok(point);
        }
        let projection = match self.projection {
            Some(projection) => projection,
            None => {
                let projection = Projection::around(point)?;
                announce(&projection);
                *self.projection.insert(projection)
            }
        };
        projection.metres(point)
    }

    /// Sends an input on with its points in metres; whether all of it was taken. Points that have no place there are
    /// sent as unreadable.
    pub fn send(&mut self, input: Input, sink: &mut dyn FnMut(Input) -> bool) -> bool {
        let (batch, wrap): (Batch, fn(Batch) -> Input) = match input {
            Input::Points(batch) => (batch, Input::Points),
            Input::Retract(batch) => (batch, Input::Retract),
            other => return sink(other),
        };
        let mut good = Batch { place: batch.place, ..Batch::default() };
        // Points of another space are no longitudes and latitudes.
        let Positions::Plane(points) = &batch.positions else { return sink(wrap(batch)) };
        for (index, &(x, y)) in points.iter().enumerate() {
            let line = batch.lines.get(index).copied();
            match self.metres([x, y]) {
                Ok([x, y]) => {
                    good.positions.push(Point::Plane(x, y));
                    good.times.extend(batch.times.get(index));
                    good.tags.extend(batch.tags.get(index));
                    good.lines.extend(line);
                }
                Err(error) => {
                    let place = line.map_or_else(|| "a point".to_owned(), |line| format!("{} {line}", batch.place));
                    if !sink(Input::Unreadable(format!("{place}: {error}"))) {
                        return false;
                    }
                }
            }
        }
        good.positions.is_empty() || sink(wrap(good))
    }
}

fn announce(projection: &Projection) {
    let [longitude, latitude] = projection.origin;
    tracing::info!("--project: coordinates are metres east and north of longitude {longitude}, latitude {latitude}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, share: f64) {
        assert!((a - b).abs() <= share * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn a_degree_has_its_length() {
        for (latitude, east) in [(0.0, 111_195.08), (45.0, 78_626.79), (60.0, 55_597.54), (-60.0, 55_597.54)] {
            let projection = Projection::around([10.0, latitude]).unwrap();
            let [x, y] = projection.metres([11.0, latitude]).unwrap();
            close(x, east, 1e-7);
            assert_eq!(y, 0.0);
            let [x, y] = projection.metres([10.0, latitude + 1e-3]).unwrap();
            assert_eq!(x, 0.0);
            close(y, 111.195_08, 1e-7);
        }
    }

    #[test]
    fn there_and_back_is_the_same_place() {
        for origin in [[0.0, 0.0], [24.94, 60.17], [-179.9, -45.0], [151.2, -89.0]] {
            let projection = Projection::around(origin).unwrap();
            for offset in [[0.0, 0.0], [0.1, -0.05], [-0.3, 0.2]] {
                let point = [0, 1].map(|axis| ((origin[axis] + offset[axis]) * 1e9_f64).round() / 1e9);
                assert_eq!(projection.degrees(projection.metres(point).unwrap()), point);
            }
        }
    }

    #[test]
    fn neighbours_across_the_meridian_stay_neighbours() {
        let projection = Projection::around([179.999, 10.0]).unwrap();
        let [near, far] = [[-179.999, 10.0], [179.998, 10.0]].map(|point| projection.metres(point).unwrap()[0]);
        assert!(near > 0.0 && near < 250.0 && far < 0.0 && far > -150.0, "{near} {far}");
    }

    #[test]
    fn what_is_not_on_earth_is_refused_and_is_no_origin() {
        let mut projector = Projector::new(None);
        for (point, says) in [([12.0, 91.0], "swapped"), ([361.0, 0.0], "no place on Earth"), ([5.0, 89.9], "pole")] {
            assert!(projector.metres(point).unwrap_err().to_string().contains(says), "{point:?}");
        }
        assert!(projector.metres([f64::NAN, 1.0]).unwrap()[0].is_nan(), "others refuse what is no number");
        assert_eq!(projector.projection(), None);
        assert_eq!(projector.metres([25.0, 60.0]), Ok([0.0, 0.0]));
        assert_eq!(projector.projection().map(Projection::origin), Some([25.0, 60.0]));
    }

    #[test]
    fn inputs_keep_times_and_lines_of_good_points() {
        let mut projector = Projector::new(None);
        let batch = Batch {
            positions: Positions::Plane(vec![(25.0, 60.0), (25.0, 95.0), (25.0, 60.001)]),
            times: vec![1.0, 2.0, 3.0],
            lines: vec![4, 5, 6],
            ..Batch::default()
        };
        let mut sent = Vec::new();
        assert!(projector.send(Input::Points(batch), &mut |input| {
            sent.push(input);
            true
        }));
        let [Input::Unreadable(reason), Input::Points(good)] = &sent[..] else { panic!("{sent:?}") };
        assert!(reason.starts_with("line 5: longitude 25, latitude 95"), "{reason}");
        assert_eq!((good.times.as_slice(), good.lines.as_slice()), (&[1.0, 3.0][..], &[4, 6][..]));
        assert_eq!(good.positions.get(0), Point::Plane(0.0, 0.0));
    }
}
