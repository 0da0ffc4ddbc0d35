//! Which scenes there are, and who plays in each.
//!
//! In: a scene's name and its random numbers. Out: its cast. Invariants: what is not one shape stands in a row, no
//! nearer than [`CLEARANCE`], or passes its mate in such a row: rings in a row enclose nothing between them, while
//! rings in a ring or on a grid would make holes of which the truth knows nothing. Must not know: points, noise.

use std::str::FromStr;

use thiserror::Error;

use super::actor::{Actor, Nest, Pair, Ring};
use super::motion::{Cycle, Sway};
use super::random::Random;
use super::turn::direction;
use super::wall::{Bar, Form};

/// How near to each other places come in a row; the smallest rings that stand side by side have a radius of 0.7.
const CLEARANCE: f64 = 1.0;

/// A scene's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Rings that drift.
    Drift,
    /// Rings that stay.
    Static,
    /// Holes that pinch in two.
    Pinch,
    /// Holes that fuse.
    Fuse,
    /// Rings that open and close.
    Open,
    /// Rings that pass by each other.
    Pass,
    /// Rings that appear and vanish at once.
    Vanish,
    /// Rings inside rings.
    Concentric,
    /// Polygons that rotate.
    Polygons,
    /// A bar in front of rings.
    Occlusion,
    /// Many rings.
    Crowd,
    /// Rings that swell and shrink.
    Breathe,
    /// All of this in one plane.
    Mixed,
}

/// There is no such scene.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no scene {found:?}: choose one of {}", Kind::names())]
pub struct UnknownScene {
    /// What was asked for.
    pub found: String,
}

impl Kind {
    /// Every scene.
    pub const ALL: [Self; 13] = [
        Self::Drift,
        Self::Static,
        Self::Pinch,
        Self::Fuse,
        Self::Open,
        Self::Pass,
        Self::Vanish,
        Self::Concentric,
        Self::Polygons,
        Self::Occlusion,
        Self::Crowd,
        Self::Breathe,
        Self::Mixed,
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        self.description().0
    }

    /// What is to be seen, in a line.
    pub fn about(self) -> &'static str {
        self.description().1
    }

    fn description(self) -> (&'static str, &'static str) {
        match self {
            Self::Drift => ("drift", "8 rings drift on smooth paths"),
            Self::Static => ("static", "8 rings stay; only their points change"),
            Self::Pinch => ("pinch", "4 holes pinch in two, at different times"),
            Self::Fuse => ("fuse", "4 pairs of holes fuse, at different times"),
            Self::Open => {
                ("open", "6 rings open by a gap that grows until they have no hole any more, and close again")
            }
            Self::Pass => ("pass", "4 pairs of rings pass by each other in opposite directions"),
            Self::Vanish => ("vanish", "10 rings appear and vanish at once"),
            Self::Concentric => ("concentric", "3 rings around one centre drift together: a disc and two annuli"),
            Self::Polygons => ("polygons", "8 rotating regular polygons of 3 to 6 corners"),
            Self::Occlusion => ("occlusion", "a thin bar sweeps across 8 rings and hides the points under it"),
            Self::Crowd => ("crowd", "30 rings: some stay, some drift, some come and go"),
            Self::Breathe => ("breathe", "8 rings swell and shrink"),
            Self::Mixed => ("mixed", "all kinds of events in one plane"),
        }
    }

    fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }
}

impl FromStr for Kind {
    type Err = UnknownScene;

    fn from_str(word: &str) -> Result<Self, UnknownScene> {
        let kind = Self::ALL.into_iter().find(|kind| kind.name() == word);
        kind.ok_or_else(|| UnknownScene { found: word.chars().take(40).collect() })
    }
}

/// A bar that sweeps along the row, over and over.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    normal: [f64; 2],
    width: f64,
    /// How far from the middle of the row it turns up and goes.
    span: f64,
    speed: f64,
}

impl Sweep {
    /// The bar as it stands in a frame.
    pub fn at(&self, frame: f64) -> Bar {
        let offset = (frame * self.speed) % (2.0 * self.span) - self.span;
        Bar { normal: self.normal, offset, width: self.width }
    }
}

/// Who plays, and what happens to all of them.
#[derive(Clone, Debug)]
pub struct Cast {
    /// Who plays.
    pub actors: Vec<Actor>,
    /// How the whole scene moves.
    pub drift: Sway,
    /// What goes by in front of it.
    pub sweep: Option<Sweep>,
}

/// Which way pairs go.
#[derive(Clone, Copy)]
enum Course {
    /// Joined, then apart.
    Pinch,
    /// Apart, then joined.
    Fuse,
    /// One after the other.
    Both,
}

/// Who plays in a scene.
pub fn cast(kind: Kind, random: &mut Random) -> Cast {
    let slow = Sway { reach: [4.0, 3.0], periods: [1400.0, 1100.0], phases: [0.0, 0.1] };
    let mut sweep = None;
    let (places, drift) = match kind {
        Kind::Drift => (each(8, |_| vec![swaying(random, [1.0, 1.5], 250.0)]), Sway::default()),
        Kind::Static => (each(8, |_| vec![Actor::Ring(ring(random))]), Sway::default()),
        Kind::Pinch => (each(4, |share| vec![pair(random, Course::Pinch, share)]), slow),
        Kind::Fuse => (each(4, |share| vec![pair(random, Course::Fuse, share)]), slow),
        Kind::Open => (each(6, |share| vec![opening(random, share)]), Sway::default()),
        Kind::Pass => (each(4, |share| passing(random, share / 2.0)), Sway::default()),
        Kind::Vanish => (each(10, |_| vec![vanishing(random)]), Sway::default()),
        Kind::Concentric => (vec![vec![nest()]], slow),
        Kind::Polygons => (each(8, |share| vec![polygon(random, 3 + (share * 8.0) as u8 % 4)]), Sway::default()),
        Kind::Occlusion => (each(8, |_| vec![Actor::Ring(Ring::new(random.between(1.0, 1.2)))]), Sway::default()),
        Kind::Crowd => (each(30, |share| vec![one_of_many(random, (share * 30.0).round() as u32)]), Sway::default()),
        Kind::Breathe => (each(8, |_| vec![breathing(random)]), Sway::default()),
        Kind::Mixed => (everything(random), slow),
    };
    let (actors, half) = row(places);
    if kind == Kind::Occlusion {
        // Where it takes most of the smallest ring, a cap as deep as it is wide, it leaves more than half of the hole's
        // persistence.
        sweep = Some(Sweep { normal: direction(0.02), width: 0.12, span: half + 1.0, speed: 0.35 });
    }
    Cast { actors, drift, sweep }
}

/// So many places; the function is given which share of them comes before.
fn each(count: u32, place: impl FnMut(f64) -> Vec<Actor>) -> Vec<Vec<Actor>> {
    (0..count).map(|number| f64::from(number) / f64::from(count)).map(place).collect()
}

/// Puts places side by side, around the origin; gives half the length of the row.
fn row(places: Vec<Vec<Actor>>) -> (Vec<Actor>, f64) {
    let mut end = -CLEARANCE;
    let mut actors = Vec::new();
    for place in places {
        let reach = place.iter().map(Actor::reach).fold(0.0, f64::max);
        let middle = end + CLEARANCE + reach;
        end = middle + reach;
        actors.extend(place.into_iter().map(|mut actor| {
            actor.shift(middle);
            actor
        }));
    }
    actors.iter_mut().for_each(|actor| actor.shift(-end / 2.0));
    (actors, end / 2.0)
}

fn ring(random: &mut Random) -> Ring {
    Ring::new(random.between(0.8, 1.2))
}

/// A ring that moves around its place, in about that many frames.
fn swaying(random: &mut Random, reach: [f64; 2], period: f64) -> Actor {
    let periods = [(); 2].map(|()| period * random.between(1.0, 1.5));
    let phases = [random.unit(), random.unit()];
    Actor::Ring(Ring { sway: Sway { reach, periods, phases }, ..ring(random) })
}

fn pair(random: &mut Random, course: Course, begin: f64) -> Actor {
    let larger = random.between(0.95, 1.05);
    let [joined, begins, ends, apart] = Pair::STOPS;
    let (nearing, pinching, leaving) = (Pair::NEARING, Pair::PINCHING, Pair::LEAVING);
    let (rest, moving) = (random.between(50.0, 80.0).floor(), nearing + pinching + leaving);
    let away = [[joined, nearing], [begins, pinching], [ends, leaving]];
    let back = [[apart, leaving], [ends, pinching], [begins, nearing]];
    let legs: Vec<[f64; 2]> = match course {
        Course::Pinch => [&[[joined, rest]], &away[..], &[[apart, rest], [apart, 0.0]]].concat(),
        Course::Fuse => [&[[apart, rest]], &back[..], &[[joined, rest], [joined, 0.0]]].concat(),
        Course::Both => [&[[joined, rest]], &away[..], &[[apart, rest]], &back[..]].concat(),
    };
    // Where a round does not lead back to its beginning, the pair goes and comes.
    let life = match course {
        Course::Both => None,
        Course::Pinch | Course::Fuse => Some(Cycle::switch(2.0 * rest + moving - 20.0, 20.0, begin)),
    };
    let half_turn = if random.unit() < 0.5 { 0.0 } else { 0.5 };
    let axis = direction(half_turn + random.between(-0.05, 0.05));
    let apart = Cycle::new(&legs, begin);
    Actor::Pair(Pair { radii: [larger, 0.75 * larger], place: [0.0; 2], axis, apart, life })
}

fn opening(random: &mut Random, begin: f64) -> Actor {
    let rest = random.between(50.0, 80.0).floor();
    let gap = Cycle::new(&[[0.0, rest], [0.0, 12.0], [1.9, 30.0], [1.9, 12.0]], begin);
    // Upwards or downwards: a neighbour in front of the gap would close it.
    let toward = if random.unit() < 0.5 { 0.25 } else { 0.75 };
    let gap_toward = direction(toward + random.between(-0.05, 0.05));
    Actor::Ring(Ring { gap: Some(gap), gap_toward, ..ring(random) })
}

/// Two rings that swing past each other.
fn passing(random: &mut Random, phase: f64) -> Vec<Actor> {
    let one = |random: &mut Random, side: f64| {
        let sway = Sway { reach: [3.0, 0.0], periods: [440.0, 1.0], phases: [phase + side / 4.0, 0.0] };
        let radius = random.between(0.9, 1.1);
        Actor::Ring(Ring { place: [0.0, 1.45 * side], sway, ..Ring::new(radius) })
    };
    vec![one(random, 1.0), one(random, -1.0)]
}

fn vanishing(random: &mut Random) -> Actor {
    let life = Cycle::switch(random.between(30.0, 60.0).floor(), random.between(15.0, 35.0).floor(), random.unit());
    Actor::Ring(Ring { life: Some(life), ..ring(random) })
}

fn nest() -> Actor {
    Actor::Nest(Nest { radii: vec![1.0, 3.2, 5.0], place: [0.0; 2] })
}

fn polygon(random: &mut Random, corners: u8) -> Actor {
    let spin = if random.unit() < 0.5 { 1.0 } else { -1.0 } / random.between(300.0, 500.0);
    Actor::Ring(Ring { form: Form::Polygon(corners), spin, ..ring(random) })
}

/// In a crowd every third ring stays, every third drifts, every third comes and goes.
fn one_of_many(random: &mut Random, number: u32) -> Actor {
    match number % 3 {
        0 => Actor::Ring(ring(random)),
        1 => swaying(random, [0.3, 1.0], 160.0),
        _ => {
            let life =
                Cycle::switch(random.between(60.0, 140.0).floor(), random.between(20.0, 60.0).floor(), random.unit());
            Actor::Ring(Ring { life: Some(life), ..ring(random) })
        }
    }
}

fn breathing(random: &mut Random) -> Actor {
    let swell_wave = [random.between(80.0, 140.0), random.unit()];
    Actor::Ring(Ring { swell: 0.3, swell_wave, ..Ring::new(random.between(1.0, 1.2)) })
}

fn everything(random: &mut Random) -> Vec<Vec<Actor>> {
    vec![
        vec![pair(random, Course::Both, 0.0)],
        vec![opening(random, 0.0)],
        vec![swaying(random, [0.5, 1.0], 200.0)],
        vec![polygon(random, 3)],
        vec![vanishing(random)],
        passing(random, 0.0),
        vec![nest()],
        vec![breathing(random)],
        vec![polygon(random, 5)],
        vec![pair(random, Course::Both, 0.5)],
        vec![opening(random, 0.5)],
        vec![Actor::Ring(ring(random))],
        vec![vanishing(random)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_have_names() {
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        let error = "pinched".parse::<Kind>().unwrap_err().to_string();
        assert!(error.contains("no scene \"pinched\"") && error.contains("drift, static, pinch, fuse"), "{error}");
    }
}
