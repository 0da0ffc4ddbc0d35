//! A horseshoe: the outline of a thick C, whose mouth opens and closes.
//!
//! In: a frame's number. Out: the pose of each wall, and each hole with its exact persistence.
//!
//! Invariants: there are two holes. The corridor between the arcs is always there, and bent. The bay inside is there
//! while the mouth is narrow. Formulas are exact.
//!
//! Must not know: points, noise, other shapes.

use super::{IdealHole, Layout};
use crate::scene::motion::{Cycle, Oscillation};
use crate::scene::turn::{direction, moved};
use crate::scene::wall::{Form, Missing, Pose, WallPlan};

/// A horseshoe.
#[derive(Clone, Debug)]
pub struct Horseshoe {
    /// The radii of the inner and the outer arc.
    pub radii: [f64; 2],
    /// Its mean position.
    pub place: [f64; 2],
    /// How it moves around that position.
    pub oscillation: Oscillation,
    /// Half the angle at which the centre sees the mouth, in turns below 1/4. 0 is closed by a wall.
    pub mouth: Cycle,
    /// The mean direction of the mouth in turns, and how it swings.
    pub toward: f64,
    /// By how many turns.
    pub swing: Oscillation<1>,
}

impl Horseshoe {
    /// The radius of the corridor.
    fn corridor(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / 2.0
    }

    /// The radius of its smaller hole.
    pub fn smallest_hole(&self) -> f64 {
        self.corridor().min(self.radii[0])
    }

    /// The inner arc, the outer arc, and both ends.
    pub fn walls(&self) -> [WallPlan; 4] {
        let plan = |form, radius: f64| WallPlan::new(form, radius / self.smallest_hole());
        let end = plan(Form::Line, self.corridor());
        [plan(Form::Circle, self.radii[0]), plan(Form::Circle, self.radii[1]), end, end]
    }

    /// Adds the poses of its walls and its holes in a frame.
    pub fn add_to(&self, frame: f64, offset: [f64; 2], layout: &mut Layout) {
        let center = moved(moved(self.place, self.oscillation.at(frame), 1.0), offset, 1.0);
        let turns = self.toward + self.swing.at(frame)[0];
        let half_mouth = self.mouth.at(frame);
        let [cosine, sine] = direction(half_mouth);
        let missing = if half_mouth > 0.0 { Missing::Gap([1.0, 0.0], cosine) } else { Missing::Nothing };
        layout.poses.extend(self.radii.map(|radius| Pose { center, turns, radius, missing }));
        let (middle, radius) = ((self.radii[0] + self.radii[1]) / 2.0, self.corridor());
        layout.poses.extend([turns + half_mouth, turns - half_mouth].map(|turns| {
            let center = moved(center, direction(turns), middle);
            Pose { center, turns, radius, missing: Missing::Nothing }
        }));
        let hole = |orbit, radius, persistence| IdealHole {
            center,
            radius,
            orbit,
            ridge: [0.0; 2],
            persistence,
            partner: None,
        };
        layout.holes.push(hole(middle, radius, radius));
        // The inner corners of both ends are the narrowest part of the mouth.
        let inner = self.radii[0];
        layout.holes.push(hole(0.0, inner, inner * (1.0 - sine)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(half_mouth: f64) -> Layout {
        let horseshoe = Horseshoe {
            radii: [1.2, 2.8],
            place: [1.0, 0.0],
            oscillation: Oscillation::default(),
            mouth: Cycle::new(&[[half_mouth, 10.0]], 0.0),
            toward: 0.25,
            swing: Oscillation { reach: [0.0], periods: [1.0], phases: [0.0] },
        };
        let mut layout = Layout::default();
        horseshoe.add_to(3.0, [0.0; 2], &mut layout);
        assert_eq!(layout.poses.len(), horseshoe.walls().len());
        layout
    }

    #[test]
    fn the_mouth_takes_from_the_bay_and_not_from_the_corridor() {
        let persistences = |half_mouth| [0, 1].map(|which| layout(half_mouth).holes[which].persistence);
        assert_eq!(persistences(0.0), [2.8 / 2.0 - 1.2 / 2.0, 1.2]);
        // A third of a half turn is seen: its half has the sine 1/2.
        let [corridor, bay] = persistences(1.0 / 12.0);
        assert!((corridor - 0.8).abs() < 1e-12 && (bay - 0.6).abs() < 1e-12, "{bay}");
        assert_eq!(layout(0.1).holes[0].orbit, 2.0);
    }

    #[test]
    fn the_ends_close_the_corridor() {
        let Layout { poses, .. } = layout(0.125);
        for end in &poses[2..] {
            let inner = moved(end.center, direction(end.turns), -end.radius);
            let outer = moved(end.center, direction(end.turns), end.radius);
            for (arc, corner) in poses.iter().zip([inner, outer]) {
                let [x, y] = moved(corner, arc.center, -1.0);
                assert!(((x * x + y * y).sqrt() - arc.radius).abs() < 1e-12);
                assert!((y / arc.radius - direction(0.125)[0]).abs() < 1e-12, "{y}");
            }
        }
    }
}
