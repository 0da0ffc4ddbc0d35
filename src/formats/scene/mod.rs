//! Scenes written down: their points, and their truth.
//!
//! In: frames of a scene.
//! Out: the points in a form that `serve` and `feed` read; the true holes as JSON lines.
//! Invariants: as many frames are written as come in.
//! Must not know: arguments, how scenes are made.

mod points;
mod truth;

pub use points::ScenePoints;
pub use truth::{Header, Truth, WrittenHole};
