//! The shapes of a scene: rings, pairs of discs that touch, concentric rings, horseshoes, foams.
//!
//! In: a frame's number. Out: the pose of each wall, and each hole of the ideal shape (infinitely many points, no
//! noise) with its exact persistence.
//!
//! Invariants: a shape has the same walls and the same holes in every frame, in the same order. A hole that does not
//! exist in a frame has persistence 0. Formulas are exact.
//!
//! Must not know: points, noise, other shapes, which shapes a scene has.

mod foam;
mod horseshoe;

pub use foam::{Band, Foam};
pub use horseshoe::Horseshoe;

use super::motion::{Cycle, Oscillation};
use super::turn::{direction, moved};
use super::wall::{Form, Missing, Pose, WallPlan};

/// A hole of the ideal shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdealHole {
    /// Its centre.
    pub center: [f64; 2],
    /// The radius of its largest empty disc. This is its death.
    pub radius: f64,
    /// The distance from the centre to the centres of its largest empty discs.
    pub orbit: f64,
    /// Half of the segment around the centre on which the centres of its largest empty discs lie, as a vector.
    pub ridge: [f64; 2],
    /// Death minus birth. 0 if the hole does not exist.
    pub persistence: f64,
    /// How many places before this hole in the list its partner is: the hole that it splits off from, or merges into.
    pub partner: Option<usize>,
}

/// The state of a scene in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// The poses of all walls.
    pub poses: Vec<Pose>,
    /// The ideal holes.
    pub holes: Vec<IdealHole>,
}

/// A shape.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A ring.
    Ring(Ring),
    /// The boundary of the union of two discs.
    Pair(Pair),
    /// Concentric rings.
    ConcentricRings(ConcentricRings),
    /// The outline of a thick C.
    Horseshoe(Horseshoe),
    /// Cells that share their walls.
    Foam(Foam),
}

impl Shape {
    /// The walls of the shape.
    pub fn walls(&self) -> Vec<WallPlan> {
        match self {
            Self::Ring(ring) => vec![ring.plan],
            Self::Pair(_) => vec![WallPlan::new(Form::Circle, 1.0); 2],
            Self::ConcentricRings(rings) => {
                let plan = |radius| WallPlan::new(Form::Circle, radius / rings.smallest_hole());
                rings.radii.iter().map(plan).collect()
            }
            Self::Horseshoe(horseshoe) => horseshoe.walls().to_vec(),
            Self::Foam(foam) => foam.walls(),
        }
    }

    /// Adds the poses of its walls and its holes in a frame. `offset` is the movement of the whole scene.
    pub fn add_to(&self, frame: f64, offset: [f64; 2], layout: &mut Layout) {
        match self {
            Self::Ring(ring) => ring.add_to(frame, offset, layout),
            Self::Pair(pair) => pair.add_to(frame, offset, layout),
            Self::ConcentricRings(rings) => rings.add_to(offset, layout),
            Self::Horseshoe(horseshoe) => horseshoe.add_to(frame, offset, layout),
            Self::Foam(foam) => foam.add_to(frame, offset, layout),
        }
    }

    /// The smallest radius that one of its holes ever has.
    pub fn smallest_hole(&self) -> f64 {
        match self {
            Self::Ring(ring) => ring.radius * (1.0 - ring.swell),
            Self::Pair(pair) => pair.radii[1],
            Self::ConcentricRings(rings) => rings.smallest_hole(),
            Self::Horseshoe(horseshoe) => horseshoe.smallest_hole(),
            Self::Foam(foam) => foam.smallest_hole(),
        }
    }

    /// How far in x the shape ever reaches from its place.
    pub fn reach(&self) -> f64 {
        match self {
            Self::Ring(ring) => ring.oscillation.reach[0] + ring.radius * (1.0 + ring.swell) * ring.plan.form.reach(),
            Self::Pair(pair) => pair.reach(),
            Self::ConcentricRings(rings) => rings.radii.iter().copied().fold(0.0, f64::max),
            Self::Horseshoe(horseshoe) => horseshoe.oscillation.reach[0] + horseshoe.radii[1],
            Self::Foam(foam) => foam.reach(),
        }
    }

    /// Moves the shape.
    pub fn shift(&mut self, by: [f64; 2]) {
        let place = match self {
            Self::Ring(ring) => &mut ring.place,
            Self::Pair(pair) => &mut pair.place,
            Self::ConcentricRings(rings) => &mut rings.place,
            Self::Horseshoe(horseshoe) => &mut horseshoe.place,
            Self::Foam(foam) => &mut foam.place,
        };
        *place = moved(*place, by, 1.0);
    }
}

/// One ring.
#[derive(Clone, Debug)]
pub struct Ring {
    /// Its wall.
    pub plan: WallPlan,
    /// The mean radius of its hole.
    pub radius: f64,
    /// Its mean position.
    pub place: [f64; 2],
    /// How it moves around that position.
    pub oscillation: Oscillation,
    /// The amplitude of its radius, relative to the radius.
    pub swell: f64,
    /// The period of the radius in frames, and its phase in turns.
    pub swell_wave: [f64; 2],
    /// Turns in each frame.
    pub spin: f64,
    /// When the ring exists. None: always.
    pub life: Option<Cycle>,
    /// The width of the gap in its wall in radii, below 2. None: no gap.
    pub gap: Option<Cycle>,
    /// The direction of the gap from the centre.
    pub gap_toward: [f64; 2],
}

impl Ring {
    /// A circle that does not move.
    pub fn new(radius: f64) -> Self {
        Self {
            plan: WallPlan::new(Form::Circle, 1.0),
            radius,
            place: [0.0; 2],
            oscillation: Oscillation::default(),
            swell: 0.0,
            swell_wave: [1.0, 0.0],
            spin: 0.0,
            life: None,
            gap: None,
            gap_toward: [0.0, 1.0],
        }
    }

    fn add_to(&self, frame: f64, offset: [f64; 2], layout: &mut Layout) {
        let [period, phase] = self.swell_wave;
        let radius = self.radius * (1.0 + self.swell * direction(frame / period + phase)[1]);
        let center = moved(moved(self.place, self.oscillation.at(frame), 1.0), offset, 1.0);
        let is_there = self.life.as_ref().is_none_or(|life| life.is_on(frame));
        let half_gap = self.gap.as_ref().map_or(0.0, |gap| gap.at(frame) / 2.0);
        let missing = match (is_there, half_gap > 0.0) {
            (false, _) => Missing::All,
            (true, false) => Missing::Nothing,
            (true, true) => Missing::Gap(self.gap_toward, (1.0 - half_gap * half_gap).max(0.0).sqrt()),
        };
        // The two ends of a gap meet when the discs around them have grown to half its width.
        let persistence = if is_there { radius * (1.0 - half_gap) } else { 0.0 };
        let turns = self.spin * frame;
        let ridge = moved([0.0; 2], direction(turns), radius * self.plan.form.ridge());
        layout.holes.push(IdealHole { center, radius, orbit: 0.0, ridge, persistence, partner: None });
        layout.poses.push(Pose { center, turns, radius, missing });
    }
}

/// Two discs, of which the boundary of the union is seen.
///
/// While they overlap, the passage between them is a chord. If the chord lies between both centres, there are two
/// holes: discs around the ends of the chord close it when they have grown to half its length.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The larger one first.
    pub radii: [f64; 2],
    /// Its position.
    pub place: [f64; 2],
    /// The direction from the first centre to the second.
    pub axis: [f64; 2],
    /// The distance of the discs over time: 0 is joined, 1 is the largest distance. See [`Pair::distance`].
    pub apart: Cycle,
    /// When the pair exists. None: always.
    pub life: Option<Cycle>,
}

/// The share of the distance that the first disc moves. The second disc is lighter and moves the rest.
const FIRST_SHARE: f64 = 0.4;

impl Pair {
    /// Frames between the first persistence of the smaller hole and the end of the passage.
    pub const PINCHING: f64 = 8.0;
    /// Frames from joined to the first persistence of the smaller hole.
    pub const NEARING: f64 = 2.0;
    /// Frames from the end of the passage to the largest distance.
    pub const LEAVING: f64 = 20.0;
    /// Values of [`Pair::apart`]: joined, first persistence of the smaller hole, end of the passage, largest distance.
    pub const STOPS: [f64; 4] = [0.0, 0.1, 0.6, 1.0];

    /// The distance of the centres for a value between 0 and 1. It is linear between two stops.
    fn distance(&self, value: f64) -> f64 {
        let [larger, smaller] = self.radii;
        let begin = (larger * larger - smaller * smaller).sqrt();
        let end = larger + smaller;
        let distances = [0.8 * begin, begin, end, end + 0.8 * smaller];
        let leg = Self::STOPS[1..3].iter().filter(|&&stop| value >= stop).count();
        let [from, to] = [Self::STOPS[leg], Self::STOPS[leg + 1]];
        distances[leg] + (distances[leg + 1] - distances[leg]) * (value - from) / (to - from)
    }

    fn reach(&self) -> f64 {
        let farthest = self.distance(1.0);
        (FIRST_SHARE * farthest + self.radii[0]).max((1.0 - FIRST_SHARE) * farthest + self.radii[1])
    }

    /// The persistence of the smaller hole.
    fn smaller_persistence(&self, distance: f64) -> f64 {
        let [larger, smaller] = self.radii;
        if distance >= larger + smaller {
            return smaller;
        }
        let chord_at = (distance * distance + larger * larger - smaller * smaller) / (2.0 * distance);
        let half_chord = (larger * larger - chord_at * chord_at).max(0.0).sqrt();
        if chord_at < distance { (smaller - half_chord).max(0.0) } else { 0.0 }
    }

    fn add_to(&self, frame: f64, offset: [f64; 2], layout: &mut Layout) {
        let distance = self.distance(self.apart.at(frame));
        let place = moved(self.place, offset, 1.0);
        let centers = [-FIRST_SHARE, 1.0 - FIRST_SHARE].map(|share| moved(place, self.axis, share * distance));
        let is_there = self.life.as_ref().is_none_or(|life| life.is_on(frame));
        let persistences = [self.radii[0], self.smaller_persistence(distance)];
        for one in [0, 1] {
            let (center, radius, other) = (centers[one], self.radii[one], 1 - one);
            let missing = if is_there { Missing::Inside(centers[other], self.radii[other]) } else { Missing::All };
            let persistence = if is_there { persistences[one] } else { 0.0 };
            let partner = (one == 1).then_some(1);
            layout.holes.push(IdealHole { center, radius, orbit: 0.0, ridge: [0.0; 2], persistence, partner });
            layout.poses.push(Pose { center, turns: 0.0, radius, missing });
        }
    }
}

/// Concentric rings. Their holes are a disc, and the annuli between two consecutive rings.
#[derive(Clone, Debug)]
pub struct ConcentricRings {
    /// The smallest one first.
    pub radii: Vec<f64>,
    /// Their position.
    pub place: [f64; 2],
}

impl ConcentricRings {
    /// The holes from the inside to the outside: orbit and radius.
    fn holes(&self) -> impl Iterator<Item = (f64, f64)> {
        let disc = self.radii.first().map(|&radius| (0.0, radius));
        let annuli = self.radii.windows(2).map(|ring| ((ring[0] + ring[1]) / 2.0, (ring[1] - ring[0]) / 2.0));
        disc.into_iter().chain(annuli)
    }

    fn smallest_hole(&self) -> f64 {
        self.holes().map(|(_, radius)| radius).fold(f64::INFINITY, f64::min)
    }

    fn add_to(&self, offset: [f64; 2], layout: &mut Layout) {
        let center = moved(self.place, offset, 1.0);
        layout.holes.extend(self.holes().map(|(orbit, radius)| IdealHole {
            center,
            radius,
            orbit,
            ridge: [0.0; 2],
            persistence: radius,
            partner: None,
        }));
        let poses = self.radii.iter().map(|&radius| Pose { center, turns: 0.0, radius, missing: Missing::Nothing });
        layout.poses.extend(poses);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout_of(shape: &Shape, frame: f64) -> Layout {
        let mut layout = Layout::default();
        shape.add_to(frame, [10.0, 0.0], &mut layout);
        assert_eq!(layout.poses.len(), shape.walls().len());
        layout
    }

    fn pair(value: f64) -> Shape {
        let apart = Cycle::new(&[[value, 10.0]], 0.0);
        Shape::Pair(Pair { radii: [1.0, 0.75], place: [0.0; 2], axis: [1.0, 0.0], apart, life: None })
    }

    #[test]
    fn the_passage_of_a_pair_closes_between_its_stops() {
        let smaller = |value| layout_of(&pair(value), 3.0).holes[1].persistence;
        let [joined, begins, ends, apart] = Pair::STOPS;
        assert_eq!((smaller(joined), smaller(apart)), (0.0, 0.75));
        assert!(smaller(begins) < 1e-7 && smaller(ends) > 0.75 - 1e-7);
        let between: Vec<f64> = (0..=10).map(|step| smaller(begins + 0.05 * f64::from(step))).collect();
        assert!(between.is_sorted_by(|a, b| a < b), "{between:?}");
        // The distance of the centres is 1.25 times the larger radius. The triangle with sides 1, 1.25 and 0.75 has a
        // right angle, and its height is half the chord.
        let right = (1.25 - 0.4375f64.sqrt()) / (1.75 - 0.4375f64.sqrt());
        assert!((smaller(begins + (ends - begins) * right) - (0.75 - 0.6)).abs() < 1e-12);
    }

    #[test]
    fn each_disc_of_a_pair_hides_the_part_of_the_other_inside_it() {
        let Layout { poses, holes } = layout_of(&pair(0.3), 0.0);
        assert_eq!(poses[0].missing, Missing::Inside(poses[1].center, 0.75));
        assert_eq!(poses[1].missing, Missing::Inside(poses[0].center, 1.0));
        assert_eq!((holes[0].partner, holes[1].partner), (None, Some(1)));
    }

    #[test]
    fn a_gap_reduces_the_persistence_by_half_its_width() {
        let gap = Some(Cycle::new(&[[1.2, 10.0]], 0.0));
        let shape = Shape::Ring(Ring { gap, ..Ring::new(2.0) });
        let Layout { poses, holes } = layout_of(&shape, 0.0);
        assert!((holes[0].persistence - 0.8).abs() < 1e-12);
        assert_eq!((poses[0].center, poses[0].missing), ([10.0, 0.0], Missing::Gap([0.0, 1.0], 0.8)));
    }

    #[test]
    fn concentric_rings_have_a_disc_and_annuli() {
        let rings = Shape::ConcentricRings(ConcentricRings { radii: vec![1.0, 3.0, 4.5], place: [0.0; 2] });
        let holes: Vec<(f64, f64)> =
            layout_of(&rings, 0.0).holes.iter().map(|hole| (hole.orbit, hole.radius)).collect();
        assert_eq!(holes, [(0.0, 1.0), (2.0, 1.0), (3.75, 0.75)]);
        assert_eq!((rings.smallest_hole(), rings.reach(), rings.walls()[2].size), (0.75, 4.5, 6.0));
    }
}
