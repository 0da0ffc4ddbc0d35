//! What plays in a scene: rings, pairs of discs that touch, and rings inside rings.
//!
//! In: a frame's number. Out: how each wall stands, and each hole of the ideal shape (infinitely many points, no noise)
//! with its exact persistence. Invariants: an actor has the same walls and the same holes in every frame, in the same
//! order; a hole that is not there has persistence 0; formulas are exact. Must not know: points, noise, other actors,
//! who plays when.

use super::motion::{Cycle, Sway};
use super::turn::{direction, moved};
use super::wall::{Form, Gone, Stand};

/// A hole of the ideal shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ideal {
    /// Its centre.
    pub center: [f64; 2],
    /// Radius of the largest empty disc in it: its death.
    pub radius: f64,
    /// How far from the centre its largest empty discs lie.
    pub orbit: f64,
    /// Death less birth; 0 if it is not there.
    pub persistence: f64,
    /// How many places before it in the list the hole stands that it splits off from, or is merged into.
    pub mate: Option<usize>,
}

/// How a frame looks: all walls, all holes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tableau {
    /// How the walls stand.
    pub stands: Vec<Stand>,
    /// The holes.
    pub ideals: Vec<Ideal>,
}

/// Who plays.
#[derive(Clone, Debug)]
pub enum Actor {
    /// A ring.
    Ring(Ring),
    /// The boundary of the union of two discs.
    Pair(Pair),
    /// Rings around one centre.
    Nest(Nest),
}

impl Actor {
    /// Its walls, each with its radius where the hole that counts for density and noise has radius 1.
    pub fn walls(&self) -> Vec<(Form, f64)> {
        match self {
            Self::Ring(ring) => vec![(ring.form, 1.0)],
            Self::Pair(_) => vec![(Form::Circle, 1.0); 2],
            Self::Nest(nest) => nest.radii.iter().map(|radius| (Form::Circle, radius / nest.least())).collect(),
        }
    }

    /// Puts its walls and holes on the stage, whose own offset is given.
    pub fn play(&self, frame: f64, offset: [f64; 2], tableau: &mut Tableau) {
        match self {
            Self::Ring(ring) => ring.play(frame, offset, tableau),
            Self::Pair(pair) => pair.play(frame, offset, tableau),
            Self::Nest(nest) => nest.play(offset, tableau),
        }
    }

    /// The least radius that a hole of it ever has.
    pub fn least(&self) -> f64 {
        match self {
            Self::Ring(ring) => ring.radius * (1.0 - ring.swell),
            Self::Pair(pair) => pair.radii[1],
            Self::Nest(nest) => nest.least(),
        }
    }

    /// How far from its place it ever reaches, in x.
    pub fn reach(&self) -> f64 {
        match self {
            Self::Ring(ring) => ring.sway.reach[0] + ring.radius * (1.0 + ring.swell) * ring.form.reach(),
            Self::Pair(pair) => pair.reach(),
            Self::Nest(nest) => nest.radii.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Moves its place.
    pub fn shift(&mut self, by: f64) {
        let place = match self {
            Self::Ring(ring) => &mut ring.place,
            Self::Pair(pair) => &mut pair.place,
            Self::Nest(nest) => &mut nest.place,
        };
        place[0] += by;
    }
}

/// One ring.
#[derive(Clone, Debug)]
pub struct Ring {
    /// What it looks like.
    pub form: Form,
    /// Radius of its hole, in the mean.
    pub radius: f64,
    /// Around where it is.
    pub place: [f64; 2],
    /// How it moves there.
    pub sway: Sway,
    /// By which share of its radius it swells and shrinks.
    pub swell: f64,
    /// In how many frames it does, and where it begins.
    pub swell_wave: [f64; 2],
    /// Turns a frame.
    pub spin: f64,
    /// When it is there; none: always.
    pub life: Option<Cycle>,
    /// How wide the gap in its wall is, in radii, below 2; none: it has none.
    pub gap: Option<Cycle>,
    /// In which direction from the centre the gap is.
    pub gap_toward: [f64; 2],
}

impl Ring {
    /// A circle that stays.
    pub fn new(radius: f64) -> Self {
        Self {
            form: Form::Circle,
            radius,
            place: [0.0; 2],
            sway: Sway::default(),
            swell: 0.0,
            swell_wave: [1.0, 0.0],
            spin: 0.0,
            life: None,
            gap: None,
            gap_toward: [0.0, 1.0],
        }
    }

    fn play(&self, frame: f64, offset: [f64; 2], tableau: &mut Tableau) {
        let [period, phase] = self.swell_wave;
        let radius = self.radius * (1.0 + self.swell * direction(frame / period + phase)[1]);
        let center = moved(moved(self.place, self.sway.at(frame), 1.0), offset, 1.0);
        let is_there = self.life.as_ref().is_none_or(|life| life.is_on(frame));
        let half_gap = self.gap.as_ref().map_or(0.0, |gap| gap.at(frame) / 2.0);
        let gone = match (is_there, half_gap > 0.0) {
            (false, _) => Gone::All,
            (true, false) => Gone::Nothing,
            (true, true) => Gone::Gap(self.gap_toward, (1.0 - half_gap * half_gap).max(0.0).sqrt()),
        };
        // The two ends of a gap meet when discs of half its width have grown around them.
        let persistence = if is_there { radius * (1.0 - half_gap) } else { 0.0 };
        tableau.ideals.push(Ideal { center, radius, orbit: 0.0, persistence, mate: None });
        tableau.stands.push(Stand { center, turns: self.spin * frame, radius, gone });
    }
}

/// Two discs, of which the boundary of the union is seen. While they overlap, the passage between them is a chord; it
/// makes two holes of one as long as it lies between both centres, and discs of half its width, grown around its ends,
/// close it.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The larger first.
    pub radii: [f64; 2],
    /// Where it is.
    pub place: [f64; 2],
    /// From the first centre to the second.
    pub axis: [f64; 2],
    /// How far apart they are: 0 joined, 1 as far as they ever go, see [`Pair::distance`].
    pub apart: Cycle,
    /// When it is there; none: always.
    pub life: Option<Cycle>,
}

/// What the first disc moves of the distance; the second, which is lighter, moves the rest.
const FIRST_SHARE: f64 = 0.4;

impl Pair {
    /// Frames from the lesser hole's first persistence to the end of the passage.
    pub const PINCHING: f64 = 8.0;
    /// Frames before it, on the way there.
    pub const NEARING: f64 = 2.0;
    /// Frames after it.
    pub const LEAVING: f64 = 20.0;
    /// Values of [`Pair::apart`] for the distances: joined, where the lesser hole's persistence begins, where the
    /// passage ends, and apart.
    pub const STOPS: [f64; 4] = [0.0, 0.1, 0.6, 1.0];

    /// The centres' distance for a value between 0 and 1: straight from stop to stop.
    fn distance(&self, value: f64) -> f64 {
        let [larger, lesser] = self.radii;
        let begin = (larger * larger - lesser * lesser).sqrt();
        let end = larger + lesser;
        let distances = [0.8 * begin, begin, end, end + 0.8 * lesser];
        let leg = Self::STOPS[1..3].iter().filter(|&&stop| value >= stop).count();
        let [from, to] = [Self::STOPS[leg], Self::STOPS[leg + 1]];
        distances[leg] + (distances[leg + 1] - distances[leg]) * (value - from) / (to - from)
    }

    fn reach(&self) -> f64 {
        let farthest = self.distance(1.0);
        (FIRST_SHARE * farthest + self.radii[0]).max((1.0 - FIRST_SHARE) * farthest + self.radii[1])
    }

    /// The lesser hole's persistence.
    fn lesser_persistence(&self, distance: f64) -> f64 {
        let [larger, lesser] = self.radii;
        if distance >= larger + lesser {
            return lesser;
        }
        let chord_at = (distance * distance + larger * larger - lesser * lesser) / (2.0 * distance);
        let half_chord = (larger * larger - chord_at * chord_at).max(0.0).sqrt();
        if chord_at < distance { (lesser - half_chord).max(0.0) } else { 0.0 }
    }

    fn play(&self, frame: f64, offset: [f64; 2], tableau: &mut Tableau) {
        let distance = self.distance(self.apart.at(frame));
        let place = moved(self.place, offset, 1.0);
        let centers = [-FIRST_SHARE, 1.0 - FIRST_SHARE].map(|share| moved(place, self.axis, share * distance));
        let is_there = self.life.as_ref().is_none_or(|life| life.is_on(frame));
        let persistences = [self.radii[0], self.lesser_persistence(distance)];
        for one in [0, 1] {
            let (center, radius, other) = (centers[one], self.radii[one], 1 - one);
            let gone = if is_there { Gone::Inside(centers[other], self.radii[other]) } else { Gone::All };
            let persistence = if is_there { persistences[one] } else { 0.0 };
            let mate = (one == 1).then_some(1);
            tableau.ideals.push(Ideal { center, radius, orbit: 0.0, persistence, mate });
            tableau.stands.push(Stand { center, turns: 0.0, radius, gone });
        }
    }
}

/// Rings around one centre: a disc, and the annuli between rings that follow each other.
#[derive(Clone, Debug)]
pub struct Nest {
    /// The smallest first.
    pub radii: Vec<f64>,
    /// Where it is.
    pub place: [f64; 2],
}

impl Nest {
    /// Its holes, from the inside: orbit and radius.
    fn holes(&self) -> impl Iterator<Item = (f64, f64)> {
        let disc = self.radii.first().map(|&radius| (0.0, radius));
        let annuli = self.radii.windows(2).map(|ring| ((ring[0] + ring[1]) / 2.0, (ring[1] - ring[0]) / 2.0));
        disc.into_iter().chain(annuli)
    }

    fn least(&self) -> f64 {
        self.holes().map(|(_, radius)| radius).fold(f64::INFINITY, f64::min)
    }

    fn play(&self, offset: [f64; 2], tableau: &mut Tableau) {
        let center = moved(self.place, offset, 1.0);
        let holes =
            self.holes().map(|(orbit, radius)| Ideal { center, radius, orbit, persistence: radius, mate: None });
        tableau.ideals.extend(holes);
        let stands = self.radii.iter().map(|&radius| Stand { center, turns: 0.0, radius, gone: Gone::Nothing });
        tableau.stands.extend(stands);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(actor: &Actor, frame: f64) -> Tableau {
        let mut tableau = Tableau::default();
        actor.play(frame, [10.0, 0.0], &mut tableau);
        assert_eq!(tableau.stands.len(), actor.walls().len());
        tableau
    }

    fn pair(value: f64) -> Actor {
        let apart = Cycle::new(&[[value, 10.0]], 0.0);
        Actor::Pair(Pair { radii: [1.0, 0.75], place: [0.0; 2], axis: [1.0, 0.0], apart, life: None })
    }

    #[test]
    fn the_passage_of_a_pair_closes_from_stop_to_stop() {
        let lesser = |value| played(&pair(value), 3.0).ideals[1].persistence;
        let [joined, begins, ends, apart] = Pair::STOPS;
        assert_eq!((lesser(joined), lesser(apart)), (0.0, 0.75));
        assert!(lesser(begins) < 1e-7 && lesser(ends) > 0.75 - 1e-7);
        let between: Vec<f64> = (0..=10).map(|step| lesser(begins + 0.05 * f64::from(step))).collect();
        assert!(between.is_sorted_by(|a, b| a < b), "{between:?}");
        // Where the centres are a larger radius and a quarter apart, the triangle of sides 1, 1.25 and 0.75 has a right
        // angle: its height is half the chord.
        let right = (1.25 - 0.4375f64.sqrt()) / (1.75 - 0.4375f64.sqrt());
        assert!((lesser(begins + (ends - begins) * right) - (0.75 - 0.6)).abs() < 1e-12);
    }

    #[test]
    fn discs_of_a_pair_cover_each_other() {
        let Tableau { stands, ideals } = played(&pair(0.3), 0.0);
        assert_eq!(stands[0].gone, Gone::Inside(stands[1].center, 0.75));
        assert_eq!(stands[1].gone, Gone::Inside(stands[0].center, 1.0));
        assert_eq!((ideals[0].mate, ideals[1].mate), (None, Some(1)));
    }

    #[test]
    fn a_gap_takes_half_its_width_of_the_persistence() {
        let gap = Some(Cycle::new(&[[1.2, 10.0]], 0.0));
        let actor = Actor::Ring(Ring { gap, ..Ring::new(2.0) });
        let Tableau { stands, ideals } = played(&actor, 0.0);
        assert!((ideals[0].persistence - 0.8).abs() < 1e-12);
        assert_eq!((stands[0].center, stands[0].gone), ([10.0, 0.0], Gone::Gap([0.0, 1.0], 0.8)));
    }

    #[test]
    fn rings_around_one_centre_have_a_disc_and_annuli() {
        let nest = Actor::Nest(Nest { radii: vec![1.0, 3.0, 4.5], place: [0.0; 2] });
        let holes: Vec<(f64, f64)> = played(&nest, 0.0).ideals.iter().map(|hole| (hole.orbit, hole.radius)).collect();
        assert_eq!(holes, [(0.0, 1.0), (2.0, 1.0), (3.75, 0.75)]);
        assert_eq!((nest.least(), nest.reach(), nest.walls()[2].1), (0.75, 4.5, 6.0));
    }
}
