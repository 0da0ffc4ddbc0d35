//! The forms of bodies in R^3: circles, a knot, a torus, a sphere, and two circles that pinch.
//!
//! In: shares of the way along a form, a frame's number.
//! Out: positions in the form's own coordinates, and its ideal holes.
//! Invariants: a form has the same number of holes in every frame, in the same order.
//! Must not know: points, noise, where the form is.

use std::f64::consts::TAU;

use super::cycle::{IdealCycle, half_diameter};
use super::vector::Vector;
use super::{FILLED, SHARE_ABOVE};
use crate::scene::shape::{Layout, Pair, Shape};
use crate::scene::turn::{direction, moved, wave};
use crate::scene::wall::Pose;

/// Places of the polygon that stands for a closed curve. Half of it is opposite to the other half.
const CORNERS: u32 = 240;

/// The radius of the circle in the middle of the tube of a torus.
const AROUND: f64 = 1.0;
/// The mean radius of the tube.
const TUBE: f64 = 0.45;
/// The amplitude of the tube's radius, relative to it.
const TUBE_SWELL: f64 = 0.15;
/// The period of the tube's radius, in frames.
const TUBE_PERIOD: f64 = 240.0;

/// The radius of the tube on which the knot goes around.
const KNOT_TUBE: f64 = 0.5;
/// The persistence of true holes of the knot. Where its strands face each other, three more holes begin: their
/// persistence is up to 0.14.
const KNOT_ABOVE: f64 = 0.2;
/// The persistence of true holes of the torus. With 500 points that of holes between points is up to 0.15.
const TORUS_ABOVE: f64 = 0.16;

/// A form.
#[derive(Clone, Debug)]
pub enum Form {
    /// A circle around the origin, in the plane of x and y.
    Circle(f64),
    /// The trefoil knot: twice around a torus, and three times around its tube.
    Knot,
    /// A torus around the z axis, with a tube that swells and shrinks.
    Torus,
    /// A sphere of radius 1.
    Sphere,
    /// The boundary of the union of two discs, in the plane of x and y.
    Pair(Pair),
}

/// A form in a frame.
#[derive(Clone, Debug)]
pub enum Outline {
    /// A circle of this radius.
    Circle(f64),
    /// The knot.
    Knot,
    /// The torus with a tube of this radius.
    Torus(f64),
    /// The sphere.
    Sphere,
    /// Circles without the part inside the other, and the persistence of the smaller one's hole.
    Pair([Pose; 2], f64),
}

impl Form {
    /// The form in a frame.
    pub fn at(&self, frame: f64) -> Outline {
        match self {
            Self::Circle(radius) => Outline::Circle(*radius),
            Self::Knot => Outline::Knot,
            Self::Torus => Outline::Torus(TUBE * (1.0 + TUBE_SWELL * wave(frame / TUBE_PERIOD))),
            Self::Sphere => Outline::Sphere,
            Self::Pair(pair) => {
                let mut layout = Layout::default();
                Shape::Pair(pair.clone()).add_to(frame, [0.0; 2], &mut layout);
                let [larger, smaller] = [0, 1].map(|one| layout.poses[one].clone());
                // In the plane the smaller disc would fill at its radius.
                let persistence = layout.holes[1].persistence - (1.0 - FILLED) * smaller.radius;
                Outline::Pair([larger, smaller], persistence)
            }
        }
    }

    /// The smallest radius that one of its holes ever has. Without holes: infinity.
    pub fn smallest_hole(&self) -> f64 {
        match self {
            Self::Circle(radius) => *radius,
            Self::Knot => half_diameter(&closed(knot)),
            Self::Torus => TUBE * (1.0 - TUBE_SWELL),
            Self::Sphere => f64::INFINITY,
            Self::Pair(pair) => pair.radii[1],
        }
    }

    /// The persistence from which on its holes are true ones. Without holes: infinity.
    pub fn above(&self) -> f64 {
        match self {
            Self::Knot => KNOT_ABOVE,
            Self::Torus => TORUS_ABOVE,
            Self::Circle(_) | Self::Sphere | Self::Pair(_) => SHARE_ABOVE * self.smallest_hole(),
        }
    }

    /// The length that its noise, and its share of the points, are relative to.
    pub fn unit(&self) -> f64 {
        match self {
            Self::Knot => KNOT_TUBE,
            Self::Sphere => 1.0,
            Self::Circle(_) | Self::Torus | Self::Pair(_) => self.smallest_hole(),
        }
    }

    /// Whether points are spread over an area.
    pub fn is_surface(&self) -> bool {
        matches!(self, Self::Torus | Self::Sphere)
    }
}

impl Outline {
    /// The position at shares of the way. A curve needs the first one only. None: that part is missing.
    pub fn place(&self, [along, across]: [f64; 2]) -> Option<Vector> {
        match self {
            Self::Circle(radius) => Some(circle(*radius, along)),
            Self::Knot => Some(knot(along)),
            Self::Torus(tube) => Some(torus(*tube, along, evenly(across))),
            Self::Sphere => Some(sphere(along, across)),
            Self::Pair(poses, _) => {
                let larger = poses[0].radius / (poses[0].radius + poses[1].radius);
                let in_plane = if along < larger {
                    visible(&poses[0], along / larger)
                } else {
                    visible(&poses[1], (along - larger) / (1.0 - larger))
                };
                in_plane.map(|[x, y]| [x, y, 0.0])
            }
        }
    }

    /// The ideal holes, with positions moved by `place`.
    pub fn cycles(&self, place: impl Fn(Vector) -> Vector) -> Vec<IdealCycle> {
        let moved = |curve: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
            curve.iter().map(|at| place([at[0], at[1], at[2]]).to_vec()).collect()
        };
        let filled_at =
            |curve, persistence| IdealCycle { curve: moved(curve), orbit: None, persistence, partner: None };
        match self {
            Self::Circle(radius) => vec![filled_at(closed(|share| circle(*radius, share)), FILLED * radius)],
            Self::Knot => vec![filled_at(closed(knot), FILLED * KNOT_TUBE)],
            Self::Torus(tube) => {
                let inner = filled_at(closed(|share| torus(*tube, share, 0.5)), FILLED * (AROUND - tube));
                let around_tube = filled_at(closed(|share| torus(*tube, 0.0, share)), FILLED * tube);
                let orbit = Some((place([0.0; 3]).to_vec(), AROUND));
                vec![inner, IdealCycle { orbit, ..around_tube }]
            }
            Self::Sphere => Vec::new(),
            Self::Pair(poses, persistence) => {
                let [larger, smaller] = [&poses[0], &poses[1]].map(arc);
                // The larger disc keeps its id. Until the smaller hole exists, its curve goes around both.
                let is_parted = *persistence >= SHARE_ABOVE * poses[1].radius;
                let first = if is_parted { larger } else { [larger, smaller.clone()].concat() };
                let second = IdealCycle { partner: Some(1), ..filled_at(smaller, *persistence) };
                vec![filled_at(first, FILLED * poses[0].radius), second]
            }
        }
    }
}

/// A closed curve as a polygon.
fn closed(place: impl Fn(f64) -> Vector) -> Vec<Vec<f64>> {
    (0..CORNERS).map(|corner| place(f64::from(corner) / f64::from(CORNERS)).to_vec()).collect()
}

fn circle(radius: f64, share: f64) -> Vector {
    let [x, y] = direction(share);
    [radius * x, radius * y, 0.0]
}

/// Two strands face each other across the tube. When they are joined, the knot is the boundary of a Moebius band.
fn knot(share: f64) -> Vector {
    torus(KNOT_TUBE, 2.0 * share, 3.0 * share)
}

fn torus(tube: f64, around: f64, across: f64) -> Vector {
    let [out, up] = direction(across);
    let [x, y] = direction(around);
    let from_axis = AROUND + tube * out;
    [from_axis * x, from_axis * y, tube * up]
}

/// The angle around the tube, in turns, below which this share of the area of the torus with its mean tube is.
fn evenly(share: f64) -> f64 {
    let thin = TUBE / AROUND;
    // Newton's method for angle + thin sin(angle) = share. After 5 steps the error is below 1e-12.
    (0..5).fold(share, |turns, _| {
        let [cos, sin] = direction(turns);
        turns - (turns + thin / TAU * sin - share) / (1.0 + thin * cos)
    })
}

/// Equal heights of a sphere have equal areas (Archimedes). What is beyond a pole is folded back.
fn sphere(height: f64, around: f64) -> Vector {
    let z = 1.0 - (2.0 * (1.0 - height.abs())).abs();
    let from_axis = (1.0 - z * z).max(0.0).sqrt();
    let [x, y] = direction(around);
    [from_axis * x, from_axis * y, z]
}

/// The position on a circle, unless it is missing there.
fn visible(pose: &Pose, share: f64) -> Option<[f64; 2]> {
    let ideal = direction(share);
    let place = moved(pose.center, ideal, pose.radius);
    (!pose.is_missing(ideal, place)).then_some(place)
}

/// The visible part of a circle, counterclockwise, from behind its missing part.
fn arc(pose: &Pose) -> Vec<Vec<f64>> {
    let places: Vec<Option<[f64; 2]>> =
        (0..CORNERS).map(|corner| visible(pose, f64::from(corner) / f64::from(CORNERS))).collect();
    let count = places.len();
    let first = (0..count).find(|&at| places[at].is_some() && places[(at + count - 1) % count].is_none()).unwrap_or(0);
    let in_order = places[first..].iter().chain(&places[..first]);
    in_order.flatten().map(|&[x, y]| vec![x, y, 0.0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::motion::Cycle;

    #[test]
    fn the_same_share_of_points_is_on_the_same_area_of_a_torus() {
        // Area between two angles of the tube: that of an annulus, stretched over an arc.
        let area = |turns: f64| TAU * turns + TUBE / AROUND * wave(turns);
        for step in 0..100 {
            let share = f64::from(step) / 100.0;
            assert!((area(evenly(share)) - TAU * share).abs() < 1e-12, "{share}");
        }
    }

    #[test]
    fn what_is_beyond_a_pole_is_folded_back() {
        let height = |share| sphere(share, 0.0)[2];
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(height), [-1.0, -0.5, 0.0, 1.0]);
        assert_eq!([-0.125, 1.125].map(height), [-0.75, 0.75]);
        let [x, y, z] = sphere(0.3, 0.7);
        assert!((x * x + y * y + z * z - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_outline_of_two_discs_is_one_curve_in_order() {
        let apart = Cycle::new(&[[0.0, 10.0]], 0.0);
        let form = Form::Pair(Pair { radii: [1.0, 0.75], place: [0.0; 2], axis: [0.6, 0.8], apart, life: None });
        let cycles = form.at(3.0).cycles(|local| local);
        let curve = &cycles[0].curve;
        let side = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let longest = curve.iter().zip(curve.iter().cycle().skip(1)).map(side).fold(0.0, f64::max);
        assert!(longest < 2.0 * TAU / f64::from(CORNERS), "{longest}");
        assert!(cycles[1].persistence < form.above());
    }
}
