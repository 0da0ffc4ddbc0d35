//! A camera: the whole picture moves.
//!
//! In: how it moves and how fast; frame by frame. Out: a [`View`], which moves points and holes alike.
//!
//! Invariants: no place of the walls moves by more than the speed in a frame because of the camera, but for what the
//! walls' own motion takes outside of their row. Sizes stay within 1 +- [`ZOOM`].
//!
//! Must not know: shapes, points, noise.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::random::Random;
use super::shape::IdealHole;
use super::turn::{direction, moved, turned, wave};

/// The fastest camera, in radii of the smallest hole a frame.
pub const MOST_SPEED: f64 = 100.0;

/// The frames in which a panning camera comes around.
const ROUND: f64 = 600.0;

/// How much a zooming camera changes sizes, either way.
const ZOOM: f64 = 0.25;

/// How a camera moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// At one speed along a large circle.
    Pan,
    /// It rotates around the middle of the scene. The speed is that of the ends of the scene's row.
    Turn,
    /// It swells and shrinks around the middle of the scene. The speed is the highest that the ends of the row have.
    Zoom,
    /// It jumps to a random place in every frame. The speed is the longest jump.
    Shake,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    motion: Motion,
    speed: f64,
}

/// These words stand for no camera.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0:?} is no camera: write pan, turn, zoom or shake, a colon, and a speed of 0 to 100, as in pan:0.5")]
pub struct UnknownCamera(String);

impl Camera {
    /// A camera of this speed: how far it moves the picture in a frame, in radii of the smallest hole. None: the speed
    /// is not 0 to 100.
    pub fn new(motion: Motion, speed: f64) -> Option<Self> {
        (0.0..=MOST_SPEED).contains(&speed).then_some(Self { motion, speed })
    }

    /// The least factor by which it changes sizes.
    pub(super) fn least_scale(self) -> f64 {
        if self.motion == Motion::Zoom && self.speed > 0.0 { 1.0 - ZOOM } else { 1.0 }
    }
}

impl Motion {
    const ALL: [Self; 4] = [Self::Pan, Self::Turn, Self::Zoom, Self::Shake];

    fn name(self) -> &'static str {
        match self {
            Self::Pan => "pan",
            Self::Turn => "turn",
            Self::Zoom => "zoom",
            Self::Shake => "shake",
        }
    }
}

impl FromStr for Camera {
    type Err = UnknownCamera;

    fn from_str(word: &str) -> Result<Self, UnknownCamera> {
        let camera = word.split_once(':').and_then(|(name, speed)| {
            let motion = Motion::ALL.into_iter().find(|motion| motion.name() == name)?;
            Self::new(motion, speed.parse().ok()?)
        });
        camera.ok_or_else(|| UnknownCamera(word.chars().take(40).collect()))
    }
}

impl fmt::Display for Camera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.motion.name(), self.speed)
    }
}

/// A camera over time.
#[derive(Clone, Debug)]
pub struct Path {
    camera: Camera,
    /// The speed as a length.
    speed: f64,
    /// The distance of the ends of the row from its middle.
    half: f64,
    random: Random,
}

impl Path {
    /// Before the first frame.
    pub fn new(camera: Camera, smallest_radius: f64, half: f64, random: Random) -> Self {
        Self { camera, speed: camera.speed * smallest_radius, half, random }
    }

    /// The view in a frame. Frames are asked for one after the other.
    pub fn next_view(&mut self, frame: f64) -> View {
        let still = View::default();
        match self.camera.motion {
            Motion::Pan => {
                let radius = self.speed * ROUND / TAU;
                let from_begin = moved(direction(frame / ROUND), [1.0, 0.0], -1.0);
                View { shift: moved([0.0; 2], from_begin, radius), ..still }
            }
            Motion::Turn => View { turn: direction(frame * self.speed / self.half / TAU), ..still },
            Motion::Zoom => View { scale: 1.0 + ZOOM * wave(frame * self.speed / self.half / ZOOM / TAU), ..still },
            Motion::Shake => View { shift: moved([0.0; 2], self.random.in_ball(), self.speed / 2.0), ..still },
        }
    }
}

/// How the picture is moved in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    scale: f64,
    turn: [f64; 2],
    shift: [f64; 2],
}

impl Default for View {
    /// Not at all.
    fn default() -> Self {
        Self { scale: 1.0, turn: [1.0, 0.0], shift: [0.0; 2] }
    }
}

impl View {
    /// Where a place is seen.
    pub fn place(&self, place: [f64; 2]) -> [f64; 2] {
        moved(self.shift, turned(place, self.turn), self.scale)
    }

    /// What is seen of a hole.
    pub fn hole(&self, hole: &IdealHole) -> IdealHole {
        IdealHole {
            center: self.place(hole.center),
            radius: self.scale * hole.radius,
            orbit: self.scale * hole.orbit,
            ridge: moved([0.0; 2], turned(hole.ridge, self.turn), self.scale),
            persistence: self.scale * hole.persistence,
            partner: hole.partner,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::turn::distance_squared;
    use super::*;

    fn path(words: &str) -> Path {
        Path::new(words.parse().unwrap(), 2.0, 10.0, Random::new(1))
    }

    #[test]
    fn the_ends_of_the_row_move_at_the_speed() {
        for (words, least) in [("pan:0.5", 0.999), ("turn:0.5", 0.999), ("zoom:0.5", 0.0), ("shake:0.5", 0.0)] {
            let mut path = path(words);
            let ends: Vec<[f64; 2]> =
                (1..2000).map(|frame| path.next_view(f64::from(frame)).place([-10.0, 0.0])).collect();
            let ways: Vec<f64> = ends.windows(2).map(|two| distance_squared(two[0], two[1]).sqrt()).collect();
            let fastest = ways.iter().copied().fold(0.0, f64::max);
            assert!(ways.iter().all(|&way| way >= least) && (0.9..1.0 + 1e-9).contains(&fastest), "{words}: {fastest}");
        }
    }

    #[test]
    fn a_view_moves_a_hole_as_its_points() {
        let view = View { scale: 2.0, turn: [0.0, 1.0], shift: [5.0, 0.0] };
        let hole = IdealHole {
            center: [1.0, 0.0],
            radius: 1.0,
            orbit: 0.5,
            ridge: [3.0, 0.0],
            persistence: 0.7,
            partner: Some(1),
        };
        assert_eq!(view.place([1.0, 0.0]), [5.0, 2.0]);
        let seen = view.hole(&hole);
        assert_eq!((seen.center, seen.radius, seen.orbit), ([5.0, 2.0], 2.0, 1.0));
        assert_eq!((seen.ridge, seen.persistence, seen.partner), ([0.0, 6.0], 1.4, Some(1)));
        assert_eq!(View::default().hole(&hole), hole);
    }

    #[test]
    fn cameras_have_names() {
        for word in ["pan:0.5", "turn:1", "zoom:0", "shake:100"] {
            assert_eq!(word.parse::<Camera>().unwrap().to_string(), word);
        }
        for word in ["", "pan", "pan:", "pan:-1", "pan:101", "pan:nan", "tilt:1", "pan:1:2"] {
            let error = word.parse::<Camera>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("{word:?} is no camera: write pan")), "{error}");
        }
    }
}
