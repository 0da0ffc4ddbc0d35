//! A foam: bands of cells that share their walls.
//!
//! In: a frame's number. Out: the pose of each wall, and each cell's hole with its exact persistence.
//!
//! ```text
//! ┌────┬──┬────┬──┐   Two cells of a pair, a wide and a narrow one, merge and split: the wall between opens from
//! ├──┬─┴──┼──┬─┴──┤   its middle. The walls of a band slide to and fro. Where those of two bands pass each
//! └──┴────┴──┴────┘   other, the cells there change their neighbours (a T1 flip).
//! ```
//!
//! Invariants: all cells are rectangles, higher than wide. The wide cell of a pair is first. Formulas are exact.
//!
//! Must not know: points, noise, other shapes.

use super::{IdealHole, Layout};
use crate::scene::motion::{Cycle, Oscillation};
use crate::scene::turn::{direction, moved, turned};
use crate::scene::wall::{Form, Missing, Pose, WallPlan};

/// A foam.
#[derive(Clone, Debug)]
pub struct Foam {
    /// Its position.
    pub place: [f64; 2],
    /// The angle of its bands from the x axis, in turns.
    pub tilt: f64,
    /// The bands, from the bottom to the top.
    pub bands: Vec<Band>,
}

/// A band of pairs of cells.
#[derive(Clone, Debug)]
pub struct Band {
    /// How wide the wall between each pair is open: 0 is closed, 1 is not there.
    pub openings: Vec<Cycle>,
    /// How its inner walls slide along it.
    pub slide: Oscillation<1>,
    /// Whether the wide cell of each pair comes first.
    pub begins_wide: bool,
}

/// A pair of cells in a frame, along the band: its ends, and the wall between.
struct PairOfCells {
    ends: [f64; 2],
    between: f64,
    /// The width of the opening.
    open: f64,
}

impl Foam {
    /// The height of a cell.
    const HEIGHT: f64 = 3.6;
    /// The widths of the cells of a pair.
    const WIDTHS: [f64; 2] = [2.1, 1.4];
    /// How far the walls of a band slide, either way.
    pub const SLIDE: f64 = 0.3;

    fn pairs(&self) -> usize {
        self.bands.iter().map(|band| band.openings.len()).max().unwrap_or(0)
    }

    /// The length of a band, and the height of all.
    fn sides(&self) -> [f64; 2] {
        [self.pairs() as f64 * Self::WIDTHS.iter().sum::<f64>(), self.bands.len() as f64 * Self::HEIGHT]
    }

    /// The radius of the smallest hole: of the narrow cell at an end that slides in.
    pub fn smallest_hole(&self) -> f64 {
        (Self::WIDTHS[1] - Self::SLIDE) / 2.0
    }

    /// How far it reaches from its place.
    pub fn reach(&self) -> f64 {
        let [length, height] = self.sides();
        (length * length + height * height).sqrt() / 2.0
    }

    /// The lines along the bands, the two ends, then the inner walls of each band.
    pub fn walls(&self) -> Vec<WallPlan> {
        let [length, height] = self.sides();
        let line = |length: f64| WallPlan::new(Form::Line, length / 2.0 / self.smallest_hole());
        let inner = self.bands.len() * (2 * self.pairs() - 1);
        let along = vec![line(length); self.bands.len() + 1];
        [along, vec![line(height); 2], vec![line(Self::HEIGHT); inner]].concat()
    }

    /// Adds the poses of its walls and its holes in a frame.
    pub fn add_to(&self, frame: f64, offset: [f64; 2], layout: &mut Layout) {
        let [length, height] = self.sides();
        let place = |at: [f64; 2]| moved(moved(self.place, turned(at, direction(self.tilt)), 1.0), offset, 1.0);
        let pose = |at, turns, length: f64| Pose {
            center: place(at),
            turns: self.tilt + turns,
            radius: length / 2.0,
            missing: Missing::Nothing,
        };
        let level = |number: usize| number as f64 * Self::HEIGHT - height / 2.0;
        layout.poses.extend((0..=self.bands.len()).map(|number| pose([0.0, level(number)], 0.0, length)));
        layout.poses.extend([-1.0, 1.0].map(|side| pose([side * length / 2.0, 0.0], 0.25, height)));
        for (number, band) in self.bands.iter().enumerate() {
            let y = level(number) + Self::HEIGHT / 2.0;
            for pair in band.pairs(frame, length) {
                let mut between = pose([pair.between, y], 0.25, Self::HEIGHT);
                if pair.open >= Self::HEIGHT {
                    between.missing = Missing::All;
                } else if pair.open > 0.0 {
                    between.missing = Missing::Inside(between.center, pair.open / 2.0);
                }
                layout.poses.push(between);
                if pair.ends[1] < length / 2.0 {
                    layout.poses.push(pose([pair.ends[1], y], 0.25, Self::HEIGHT));
                }
                layout.holes.extend(pair.holes(band.begins_wide).map(|hole| IdealHole {
                    center: place([hole.center[0], y]),
                    ridge: turned(hole.ridge, direction(self.tilt)),
                    ..hole
                }));
            }
        }
    }
}

impl Band {
    fn pairs(&self, frame: f64, length: f64) -> impl Iterator<Item = PairOfCells> {
        let slide = self.slide.at(frame)[0];
        let count = self.openings.len();
        let pair_length = length / count as f64;
        let first = Foam::WIDTHS[usize::from(!self.begins_wide)];
        self.openings.iter().enumerate().map(move |(number, opening)| {
            // The ends of the band stay.
            let end = |number: usize| match number {
                0 => -length / 2.0,
                _ if number == count => length / 2.0,
                _ => number as f64 * pair_length - length / 2.0 + slide,
            };
            PairOfCells {
                ends: [end(number), end(number + 1)],
                between: number as f64 * pair_length - length / 2.0 + first + slide,
                open: opening.at(frame) * Foam::HEIGHT,
            }
        })
    }
}

impl PairOfCells {
    /// The wide cell's hole, then the narrow one's. Their centres are relative to the middle of the band.
    ///
    /// A disc that touches the far wall of a cell of width w and both ends of an opening of width g in the other has
    /// the radius w/2 + g^2/8w. The passage through the opening closes at the scale g/2.
    fn holes(&self, begins_wide: bool) -> [IdealHole; 2] {
        let widths = self.ends.map(|end| (end - self.between).abs());
        let [wide, narrow] = if begins_wide { [0, 1] } else { [1, 0] };
        let touching = |width: f64, open: f64| width / 2.0 + open * open / (8.0 * width);
        let both = (self.ends[1] - self.ends[0]).min(Foam::HEIGHT) / 2.0;
        let hole = |which: usize, radius: f64, persistence| {
            let inwards = if which == 0 { 1.0 } else { -1.0 };
            IdealHole {
                center: [self.ends[which] + inwards * radius, 0.0],
                radius,
                orbit: 0.0,
                ridge: [0.0, Foam::HEIGHT / 2.0 - radius],
                persistence,
                partner: (which == narrow).then_some(1),
            }
        };
        let elder = touching(widths[wide], self.open).min(both);
        let open = self.open.min(2.0 * widths[narrow]);
        let younger = touching(widths[narrow], open);
        [hole(wide, elder, elder), hole(narrow, younger, younger - open / 2.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foam(open: f64) -> Foam {
        let slide = Oscillation { reach: [0.0], periods: [1.0], phases: [0.0] };
        let band = |begins_wide| Band { openings: vec![Cycle::new(&[[open, 10.0]], 0.0); 2], slide, begins_wide };
        Foam { place: [5.0, 0.0], tilt: 0.0, bands: vec![band(true), band(false)] }
    }

    fn layout(open: f64) -> Layout {
        let mut layout = Layout::default();
        foam(open).add_to(1.0, [0.0, 1.0], &mut layout);
        assert_eq!(layout.poses.len(), foam(open).walls().len());
        assert_eq!(layout.holes.len(), 8);
        layout
    }

    #[test]
    fn closed_cells_are_rectangles_with_a_ridge() {
        let Layout { poses, holes } = layout(0.0);
        let centers: Vec<f64> = holes.iter().map(|hole| hole.center[0]).collect();
        let places = [-2.45, -0.7, 1.05, 2.8, -1.05, -2.8, 2.45, 0.7].map(|x| 5.0 + x);
        assert!(centers.iter().zip(places).all(|(x, place)| (x - place).abs() < 1e-12), "{centers:?}");
        assert!(holes.iter().all(|hole| hole.persistence == hole.radius && hole.ridge[1] == 1.8 - hole.radius));
        assert!(poses.iter().all(|pose| pose.missing == Missing::Nothing));
        assert_eq!((holes[0].partner, holes[1].partner), (None, Some(1)));
    }

    #[test]
    fn an_opening_ends_the_narrow_cell_and_widens_the_other() {
        let persistences: Vec<f64> = (0..=20).map(|step| layout(f64::from(step) / 20.0).holes[1].persistence).collect();
        assert!((persistences[0] - 0.7).abs() < 1e-12 && persistences[20] == 0.0, "{persistences:?}");
        assert!(persistences.is_sorted_by(|a, b| a >= b));
        // Half of an opening of 0.8 is 0.4: (1.4 - 0.4)^2 / 2.8.
        assert!((layout(0.8 / 3.6).holes[1].persistence - 1.0 / 2.8).abs() < 1e-12);
        let all = layout(1.0);
        let merged = all.holes[0];
        assert!((merged.radius - 1.75).abs() < 1e-12 && (merged.center[0] - 3.25).abs() < 1e-12, "{merged:?}");
        assert_eq!(all.poses.iter().filter(|pose| pose.missing == Missing::All).count(), 4);
    }
}
