//! The kinds of scenes, and the shapes of each.
//!
//! In: a kind and random numbers. Out: the scene's composition.
//!
//! Invariants: shapes stand in a row, at least [`CLEARANCE`] apart, or pass each other in such a row. Rings in a row
//! enclose nothing between them. Rings that form a ring or a grid would make holes that the truth does not have, unless
//! the rows are very far apart.
//!
//! Must not know: points, noise.

use super::motion::{Cycle, Oscillation};
use super::random::Random;
use super::shape::{Band, ConcentricRings, Foam, Horseshoe, Pair, Ring, Shape};
use super::turn::direction;
use super::wall::{Bar, Form, WallPlan};

/// The smallest distance of two places in a row. The smallest rings that stand side by side have a radius of 0.7.
const CLEARANCE: f64 = 1.0;

/// The same, of shapes that are not convex: what is in front of a bay of theirs must not close it.
const WIDE_CLEARANCE: f64 = 3.0;

/// The kinds of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Rings that drift.
    Drift,
    /// Rings that stay.
    Static,
    /// Holes that pinch in two.
    Pinch,
    /// Holes that merge.
    Fuse,
    /// Rings that open and close.
    Open,
    /// Rings that pass each other.
    Pass,
    /// Rings that appear and vanish suddenly.
    Vanish,
    /// Rings inside rings.
    Concentric,
    /// Polygons that turn.
    Polygons,
    /// A bar in front of rings.
    Occlusion,
    /// Many rings.
    Crowd,
    /// Rings that swell and shrink.
    Breathe,
    /// All of this in one scene.
    Mixed,
    /// Slender ellipses that turn.
    Ellipses,
    /// Stars that turn.
    Stars,
    /// Thick Cs whose mouths open and close.
    CShapes,
    /// A foam whose walls open and slide.
    Cells,
    /// Rings of uneven density.
    Uneven,
    /// Rings of different densities.
    Densities,
    /// Rings whose number of points jumps.
    Rates,
    /// Very many rings.
    Many,
    /// Rings of very different sizes.
    Sizes,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 22] = [
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
        Self::Ellipses,
        Self::Stars,
        Self::CShapes,
        Self::Cells,
        Self::Uneven,
        Self::Densities,
        Self::Rates,
        Self::Many,
        Self::Sizes,
    ];

    /// The name of the kind.
    pub fn name(self) -> &'static str {
        self.description().0
    }

    /// A description of one line.
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
            Self::Ellipses => ("ellipses", "8 rotating ellipses, 2 to 3.5 times as long as wide"),
            Self::Stars => ("stars", "8 rotating stars of 4 to 7 tips"),
            Self::CShapes => ("cshapes", "4 thick Cs swing; their mouths open until no bay is left, and close again"),
            Self::Cells => {
                ("cells", "a foam of 18 cells: walls vanish and come, others slide past each other (T1 flips)")
            }
            Self::Uneven => ("uneven", "8 rings, each 10 times as dense on one side as on the other"),
            Self::Densities => ("densities", "10 rings whose densities are up to 16 to 1"),
            Self::Rates => ("rates", "8 rings; the number of points of a frame jumps by up to 8 to 1"),
            Self::Many => ("many", "200 rings in four rows"),
            Self::Sizes => ("sizes", "6 rings whose sizes are up to 10 to 1"),
        }
    }
}

/// A bar that sweeps along the row again and again.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    normal: [f64; 2],
    width: f64,
    /// The distance from the middle of the row at which it appears and disappears.
    span: f64,
    speed: f64,
}

impl Sweep {
    /// The bar in a frame.
    pub fn at(&self, frame: f64) -> Bar {
        let offset = (frame * self.speed) % (2.0 * self.span) - self.span;
        Bar { normal: self.normal, offset, width: self.width }
    }
}

/// The parts of a scene.
#[derive(Clone, Debug)]
pub struct Composition {
    /// The shapes.
    pub shapes: Vec<Shape>,
    /// The motion of the whole scene.
    pub drift: Oscillation,
    /// A bar that hides points.
    pub sweep: Option<Sweep>,
    /// Of how many pieces of a wall one has its point. None: all have.
    pub strides: Option<Cycle>,
    /// Half the length of the row.
    pub half: f64,
}

impl Composition {
    /// Of how many pieces of a wall one has its point in a frame.
    pub fn stride(&self, frame: f64) -> u32 {
        self.strides.as_ref().map_or(1, |strides| strides.at(frame) as u32)
    }
}

/// The directions in which a pair moves.
#[derive(Clone, Copy)]
pub enum PairMotion {
    /// From joined to apart.
    Pinch,
    /// From apart to joined.
    Fuse,
    /// Both, one after the other.
    Both,
}

/// The composition of a scene.
pub fn compose(kind: Kind, random: &mut Random) -> Composition {
    let slow = Oscillation { reach: [4.0, 3.0], periods: [1400.0, 1100.0], phases: [0.0, 0.1] };
    let mut sweep = None;
    let (places, drift) = match kind {
        Kind::Drift => (each(8, |_| vec![oscillating(random, [1.0, 1.5], 250.0)]), Oscillation::default()),
        Kind::Static => (each(8, |_| vec![Shape::Ring(ring(random))]), Oscillation::default()),
        Kind::Pinch => (each(4, |share| vec![Shape::Pair(pair(random, PairMotion::Pinch, share))]), slow),
        Kind::Fuse => (each(4, |share| vec![Shape::Pair(pair(random, PairMotion::Fuse, share))]), slow),
        Kind::Open => (each(6, |share| vec![opening(random, share)]), Oscillation::default()),
        Kind::Pass => (each(4, |share| passing(random, share / 2.0)), Oscillation::default()),
        Kind::Vanish => (each(10, |_| vec![vanishing(random)]), Oscillation::default()),
        Kind::Concentric => (vec![vec![concentric()]], slow),
        Kind::Polygons => (each(8, |share| vec![polygon(random, 3 + (share * 8.0) as u8 % 4)]), Oscillation::default()),
        Kind::Occlusion => {
            (each(8, |_| vec![Shape::Ring(Ring::new(random.between(1.0, 1.2)))]), Oscillation::default())
        }
        Kind::Crowd => {
            (each(30, |share| vec![one_of_many(random, (share * 30.0).round() as u32)]), Oscillation::default())
        }
        Kind::Breathe => (each(8, |_| vec![breathing(random)]), Oscillation::default()),
        Kind::Mixed => (everything(random), slow),
        Kind::Ellipses => {
            (each(8, |share| vec![Shape::Ring(spinning(random, Form::Ellipse(2.0 + 1.5 * share * 8.0 / 7.0)))]), slow)
        }
        Kind::Stars => {
            (each(8, |share| vec![Shape::Ring(spinning(random, Form::Star(4 + (share * 8.0) as u8 % 4)))]), slow)
        }
        Kind::CShapes => (each(4, |share| vec![horseshoe(random, share)]), Oscillation::default()),
        Kind::Cells => (vec![vec![foam(random)]], slow),
        Kind::Uneven => (each(8, |_| vec![uneven(random)]), Oscillation::default()),
        Kind::Densities => (
            each(10, |share| vec![of_density(random, MIXED_DENSITIES[(share * 10.0).round() as usize])]),
            Oscillation::default(),
        ),
        Kind::Rates => (each(8, |_| vec![of_density(random, 4.0)]), Oscillation::default()),
        Kind::Many => (each(50, |_| column(random)), slow),
        Kind::Sizes => (sizes(random), Oscillation::default()),
    };
    let clearance = if matches!(kind, Kind::Stars | Kind::CShapes) { WIDE_CLEARANCE } else { CLEARANCE };
    let (shapes, half) = row(places, clearance);
    if kind == Kind::Occlusion {
        // Where it hides most of the smallest ring, a cap as deep as the bar is wide, the hole keeps more than half of
        // its persistence.
        sweep = Some(Sweep { normal: direction(0.02), width: 0.12, span: half + 1.0, speed: 0.35 });
    }
    let strides = (kind == Kind::Rates).then(|| strides(random));
    Composition { shapes, drift, sweep, strides, half }
}

/// `count` places. The function gets the share of places before its own.
fn each(count: u32, place: impl FnMut(f64) -> Vec<Shape>) -> Vec<Vec<Shape>> {
    (0..count).map(|number| f64::from(number) / f64::from(count)).map(place).collect()
}

/// Puts places side by side around the origin. Also returns half the length of the row.
fn row(places: Vec<Vec<Shape>>, clearance: f64) -> (Vec<Shape>, f64) {
    let mut end = -clearance;
    let mut shapes = Vec::new();
    for place in places {
        let reach = place.iter().map(Shape::reach).fold(0.0, f64::max);
        let middle = end + clearance + reach;
        end = middle + reach;
        shapes.extend(place.into_iter().map(|mut shape| {
            shape.shift([middle, 0.0]);
            shape
        }));
    }
    shapes.iter_mut().for_each(|shape| shape.shift([-end / 2.0, 0.0]));
    (shapes, end / 2.0)
}

fn ring(random: &mut Random) -> Ring {
    Ring::new(random.between(0.8, 1.2))
}

/// A ring that moves around its place with about this period.
fn drifting(random: &mut Random, reach: [f64; 2], period: f64) -> Ring {
    let periods = [(); 2].map(|()| period * random.between(1.0, 1.5));
    let phases = [random.unit(), random.unit()];
    Ring { oscillation: Oscillation { reach, periods, phases }, ..ring(random) }
}

fn oscillating(random: &mut Random, reach: [f64; 2], period: f64) -> Shape {
    Shape::Ring(drifting(random, reach, period))
}

/// Two discs that move like this. They begin at `begin`, a share of their period.
pub fn pair(random: &mut Random, motion: PairMotion, begin: f64) -> Pair {
    let larger = random.between(0.95, 1.05);
    let [joined, begins, ends, apart] = Pair::STOPS;
    let (nearing, pinching, leaving) = (Pair::NEARING, Pair::PINCHING, Pair::LEAVING);
    let (rest, moving) = (random.between(150.0, 240.0).floor(), nearing + pinching + leaving);
    let away = [[joined, nearing], [begins, pinching], [ends, leaving]];
    let back = [[apart, leaving], [ends, pinching], [begins, nearing]];
    let legs: Vec<[f64; 2]> = match motion {
        PairMotion::Pinch => [&[[joined, rest]], &away[..], &[[apart, rest], [apart, 0.0]]].concat(),
        PairMotion::Fuse => [&[[apart, rest]], &back[..], &[[joined, rest], [joined, 0.0]]].concat(),
        PairMotion::Both => [&[[joined, rest]], &away[..], &[[apart, rest]], &back[..]].concat(),
    };
    // If the motion does not end where it begins, the pair vanishes in between.
    let life = match motion {
        PairMotion::Both => None,
        PairMotion::Pinch | PairMotion::Fuse => Some(Cycle::switch(2.0 * rest + moving - 20.0, 20.0, begin)),
    };
    let half_turn = if random.unit() < 0.5 { 0.0 } else { 0.5 };
    let axis = direction(half_turn + random.between(-0.05, 0.05));
    let apart = Cycle::new(&legs, begin);
    Pair { radii: [larger, 0.75 * larger], place: [0.0; 2], axis, apart, life }
}

fn opening(random: &mut Random, begin: f64) -> Shape {
    let rest = random.between(240.0, 400.0).floor();
    let gap = Cycle::new(&[[0.0, rest], [0.0, 12.0], [1.9, 30.0], [1.9, 12.0]], begin);
    // Upwards or downwards, since a neighbour in front of the gap would close it.
    let toward = if random.unit() < 0.5 { 0.25 } else { 0.75 };
    let gap_toward = direction(toward + random.between(-0.05, 0.05));
    Shape::Ring(Ring { gap: Some(gap), gap_toward, ..ring(random) })
}

/// Two rings that move past each other.
fn passing(random: &mut Random, phase: f64) -> Vec<Shape> {
    let one = |random: &mut Random, side: f64| {
        let oscillation = Oscillation { reach: [3.0, 0.0], periods: [440.0, 1.0], phases: [phase + side / 4.0, 0.0] };
        let radius = random.between(0.9, 1.1);
        Shape::Ring(Ring { place: [0.0, 1.45 * side], oscillation, ..Ring::new(radius) })
    };
    vec![one(random, 1.0), one(random, -1.0)]
}

fn vanishing(random: &mut Random) -> Shape {
    let life = Cycle::switch(random.between(150.0, 300.0).floor(), random.between(20.0, 60.0).floor(), random.unit());
    Shape::Ring(Ring { life: Some(life), ..ring(random) })
}

fn concentric() -> Shape {
    Shape::ConcentricRings(ConcentricRings { radii: vec![1.0, 3.2, 5.0], place: [0.0; 2] })
}

fn polygon(random: &mut Random, corners: u8) -> Shape {
    Shape::Ring(spinning(random, Form::Polygon(corners)))
}

/// A wall of this form that turns around its place.
fn spinning(random: &mut Random, form: Form) -> Ring {
    let spin = if random.unit() < 0.5 { 1.0 } else { -1.0 } / random.between(300.0, 500.0);
    Ring { plan: WallPlan::new(form, 1.0), spin, ..ring(random) }
}

fn horseshoe(random: &mut Random, begin: f64) -> Shape {
    let rest = random.between(150.0, 240.0).floor();
    let mouth = Cycle::new(&[[0.0, rest], [0.0, 24.0], [0.22, 60.0], [0.22, 24.0]], begin);
    let swing = Oscillation { reach: [0.05], periods: [random.between(200.0, 300.0)], phases: [random.unit()] };
    // Upwards or downwards, since a neighbour in front of the mouth would narrow it.
    let toward = if random.unit() < 0.5 { 0.25 } else { 0.75 };
    let oscillation =
        Oscillation { reach: [0.3, 1.0], periods: [random.between(250.0, 375.0); 2], phases: [random.unit(), 0.0] };
    Shape::Horseshoe(Horseshoe { radii: [1.2, 2.8], place: [0.0; 2], oscillation, mouth, toward, swing })
}

fn foam(random: &mut Random) -> Shape {
    let tilt = random.between(-0.1, 0.1);
    let band = |number: u32| {
        let opening = |pair: u32| {
            let [closed, open] = [(); 2].map(|()| random.between(100.0, 180.0).floor());
            let legs = [[0.0, closed], [0.0, 10.0], [1.0, open], [1.0, 10.0]];
            Cycle::new(&legs, f64::from(3 * number + pair) / 9.0)
        };
        let openings = [0, 1, 2].map(opening).to_vec();
        let period = random.between(160.0, 240.0);
        let slide = Oscillation { reach: [Foam::SLIDE], periods: [period], phases: [f64::from(number) / 3.0] };
        Band { openings, slide, begins_wide: number.is_multiple_of(2) }
    };
    Shape::Foam(Foam { place: [0.0; 2], tilt, bands: [0, 1, 2].map(band).to_vec() })
}

fn uneven(random: &mut Random) -> Shape {
    let ring = spinning(random, Form::Circle);
    Shape::Ring(Ring { plan: WallPlan { is_uneven: true, ..ring.plan }, ..ring })
}

/// A drifting ring that is so many times as dense as others.
fn of_density(random: &mut Random, density: f64) -> Shape {
    let ring = drifting(random, [1.0, 1.5], 250.0);
    Shape::Ring(Ring { plan: WallPlan { density, ..ring.plan }, ..ring })
}

/// The densities of a row of rings, relative to the usual. Neighbours differ.
const MIXED_DENSITIES: [f64; 10] = [1.0, 0.25, 4.0, 0.5, 2.0, 0.25, 1.0, 4.0, 0.5, 2.0];

/// How the number of points jumps, among 1/2, 1, 2 and 4 times the usual.
fn strides(random: &mut Random) -> Cycle {
    let held = |&stride: &f64| {
        let frames = random.between(20.0, 60.0).floor();
        [[stride, frames], [stride, 0.0]]
    };
    Cycle::new(&[2.0, 8.0, 1.0, 4.0, 2.0, 4.0, 8.0].iter().flat_map(held).collect::<Vec<_>>(), 0.0)
}

/// Rings above each other. The rows that they make are so far apart, and so even, that nothing between them counts as a
/// hole.
fn column(random: &mut Random) -> Vec<Shape> {
    let one = |row: u32| {
        let (periods, phases) = ([random.between(120.0, 200.0), 1.0], [random.unit(), 0.0]);
        let oscillation = Oscillation { reach: [0.3, 0.0], periods, phases };
        let place = [0.0, 24.0 * (f64::from(row) - 1.5)];
        Shape::Ring(Ring { place, oscillation, ..Ring::new(random.between(0.95, 1.05)) })
    };
    (0..4).map(one).collect()
}

/// Rings whose walls are all as dense as that of the smallest.
fn sizes(random: &mut Random) -> Vec<Vec<Shape>> {
    let mut radii = [0.5, 0.8, 1.25, 2.0, 3.2, 5.0];
    random.choose(&mut radii, 6);
    let smallest = 0.5;
    let one = |radius: f64| {
        let periods = [random.between(250.0, 375.0), random.between(250.0, 375.0)];
        let oscillation = Oscillation { reach: [0.4, 0.6], periods, phases: [random.unit(), random.unit()] };
        let plan = WallPlan::new(Form::Circle, radius / smallest);
        vec![Shape::Ring(Ring { plan, oscillation, ..Ring::new(radius) })]
    };
    radii.map(one).to_vec()
}

/// In turn a ring that stays, a ring that drifts, and a ring that comes and goes.
fn one_of_many(random: &mut Random, number: u32) -> Shape {
    match number % 3 {
        0 => Shape::Ring(ring(random)),
        1 => oscillating(random, [0.3, 1.0], 160.0),
        _ => {
            let life =
                Cycle::switch(random.between(120.0, 300.0).floor(), random.between(20.0, 60.0).floor(), random.unit());
            Shape::Ring(Ring { life: Some(life), ..ring(random) })
        }
    }
}

fn breathing(random: &mut Random) -> Shape {
    let swell_wave = [random.between(80.0, 140.0), random.unit()];
    Shape::Ring(Ring { swell: 0.3, swell_wave, ..Ring::new(random.between(1.0, 1.2)) })
}

fn everything(random: &mut Random) -> Vec<Vec<Shape>> {
    vec![
        vec![Shape::Pair(pair(random, PairMotion::Both, 0.0))],
        vec![opening(random, 0.0)],
        vec![oscillating(random, [0.5, 1.0], 200.0)],
        vec![polygon(random, 3)],
        vec![vanishing(random)],
        passing(random, 0.0),
        vec![concentric()],
        vec![breathing(random)],
        vec![polygon(random, 5)],
        vec![Shape::Pair(pair(random, PairMotion::Both, 0.5))],
        vec![opening(random, 0.5)],
        vec![Shape::Ring(ring(random))],
        vec![vanishing(random)],
    ]
}
