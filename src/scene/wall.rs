//! The points of one wall: their positions on it, their noise, and which are drawn again.
//!
//! In: a [`WallPlan`], density and noise; for every frame a [`Pose`]. Out: the visible points.
//!
//! Invariants: the wall is divided into pieces of equal length; of an uneven wall, of equal mass. Each has one point at
//! a random position, so the density stays the same however many points are drawn again. A point that is not drawn
//! again keeps its position on the wall and its noise, and moves with the wall.
//!
//! Must not know: other walls, holes, time.

use std::f64::consts::TAU;

use super::random::Random;
use super::samples::Samples;
use super::turn::{direction, distance_squared, moved, turned};

/// The form of a wall. Its size is the radius of the largest disc inside; of a line, half its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A circle.
    Circle,
    /// A regular polygon with this number of corners.
    Polygon(u8),
    /// An ellipse with its long axis along x, and this ratio of its axes, above 1.
    Ellipse(f64),
    /// A star with this number of tips, at least 4.
    Star(u8),
    /// A straight line along x.
    Line,
}

/// The distance of a star's tips from its centre. Its other corners are on the disc inside.
const TIPS: f64 = 2.2;

/// Steps of the eccentric angle in which the length of an ellipse is measured. Up to a ratio of 3.5 its pieces are
/// equal to within 3%.
const STEPS: u32 = 256;

impl Form {
    /// The largest distance of the wall from its centre, around a disc of radius 1.
    pub fn reach(self) -> f64 {
        match self {
            Self::Circle | Self::Line => 1.0,
            Self::Polygon(corners) => 1.0 / direction(0.5 / f64::from(corners))[0],
            Self::Ellipse(ratio) => ratio,
            Self::Star(_) => TIPS,
        }
    }

    /// How far along x, both ways, the centres of the discs lie that are at least 0.8 times as large as the largest.
    pub fn ridge(self) -> f64 {
        match self {
            // A disc at x inside an ellipse has the radius sqrt(1 - x^2 / (ratio^2 - 1)).
            Self::Ellipse(ratio) => 0.6 * (ratio * ratio - 1.0).sqrt(),
            _ => 0.0,
        }
    }
}

/// A form whose places are found by their share of its length.
#[derive(Clone, Debug)]
struct Outline {
    form: Form,
    length: f64,
    /// Of an ellipse: the length from the first end of the long axis to each step.
    steps: Vec<f64>,
}

impl Outline {
    /// Around a disc of radius 1.
    fn new(form: Form) -> Self {
        let mut steps = Vec::new();
        let length = match form {
            Form::Circle => TAU,
            Form::Polygon(corners) => 2.0 * f64::from(corners) * half_side(corners),
            Form::Star(tips) => {
                2.0 * f64::from(tips) * distance_squared(star_corner(tips, 0.0), star_corner(tips, 1.0)).sqrt()
            }
            Form::Line => 2.0,
            Form::Ellipse(ratio) => {
                steps = ellipse_lengths(ratio);
                steps.last().copied().unwrap_or(0.0)
            }
        };
        Self { form, length, steps }
    }

    /// The position after a share of the length.
    fn place(&self, share: f64) -> [f64; 2] {
        match self.form {
            Form::Circle => direction(share),
            Form::Polygon(corners) => {
                let sides = share * f64::from(corners);
                let side = sides.floor();
                let along = (2.0 * (sides - side) - 1.0) * half_side(corners);
                turned([1.0, along], direction(side / f64::from(corners)))
            }
            Form::Star(tips) => {
                let sides = share * 2.0 * f64::from(tips);
                let side = sides.floor();
                let [from, [x, y]] = [side, side + 1.0].map(|corner| star_corner(tips, corner));
                moved(from, [x - from[0], y - from[1]], sides - side)
            }
            Form::Line => [2.0 * share - 1.0, 0.0],
            Form::Ellipse(ratio) => on_ellipse(ratio, self.step(share * self.length) / f64::from(STEPS)),
        }
    }

    /// The step, with its fraction, at a length of an ellipse.
    fn step(&self, length: f64) -> f64 {
        let after = self.steps.partition_point(|&until| until <= length).clamp(1, self.steps.len() - 1);
        let [from, to] = [self.steps[after - 1], self.steps[after]];
        (after - 1) as f64 + (length - from) / (to - from)
    }
}

/// The position on an ellipse at an eccentric angle.
fn on_ellipse(ratio: f64, turns: f64) -> [f64; 2] {
    let [x, y] = direction(turns);
    [ratio * x, y]
}

/// The lengths of an ellipse up to each step.
fn ellipse_lengths(ratio: f64) -> Vec<f64> {
    let place = |step: u32| on_ellipse(ratio, f64::from(step) / f64::from(STEPS));
    let chords = (1..=STEPS).map(|step| distance_squared(place(step - 1), place(step)).sqrt());
    let ends = chords.scan(0.0, |length, chord| {
        *length += chord;
        Some(*length)
    });
    std::iter::once(0.0).chain(ends).collect()
}

/// A corner of a star: every second one is a tip.
fn star_corner(tips: u8, corner: f64) -> [f64; 2] {
    let distance = if corner % 2.0 == 0.0 { 1.0 } else { TIPS };
    moved([0.0; 2], direction(corner / (2.0 * f64::from(tips))), distance)
}

/// Half the length of a side of a polygon around a disc of radius 1.
fn half_side(corners: u8) -> f64 {
    let [cos, sin] = direction(0.5 / f64::from(corners));
    sin / cos
}

/// What a wall is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallPlan {
    /// Its form.
    pub form: Form,
    /// Its size, relative to the hole that counts for density and noise.
    pub size: f64,
    /// How many times as dense as other walls it is.
    pub density: f64,
    /// Whether its density falls from [`THICKEST`] to the reciprocal and rises again, on the way around.
    pub is_uneven: bool,
}

/// The root of 10: the ends of an uneven wall's density are as 10 to 1.
const THICKEST: f64 = 3.162_277_660_168_379_5;

impl WallPlan {
    /// An even wall of the usual density.
    pub fn new(form: Form, size: f64) -> Self {
        Self { form, size, density: 1.0, is_uneven: false }
    }
}

/// The share of an uneven wall's length that has this share of its points. The density is linear on each half.
fn uneven(mass: f64) -> f64 {
    let (fall, mean) = (THICKEST - 1.0 / THICKEST, (THICKEST + 1.0 / THICKEST) / 2.0);
    let near = mass.min(1.0 - mass);
    let share = (THICKEST - (THICKEST * THICKEST - 4.0 * mean * near * fall).max(0.0).sqrt()) / (2.0 * fall);
    if mass <= 0.5 { share } else { 1.0 - share }
}

/// The pose of a wall in a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// The position of its centre.
    pub center: [f64; 2],
    /// Its rotation in turns.
    pub turns: f64,
    /// The radius of the largest disc inside.
    pub radius: f64,
    /// Its missing part.
    pub missing: Missing,
}

impl Pose {
    /// Whether a place on the wall is in its missing part: `ideal` around a disc of radius 1, `place` in the scene.
    pub fn is_missing(&self, ideal: [f64; 2], place: [f64; 2]) -> bool {
        match self.missing {
            Missing::Nothing => false,
            Missing::All => true,
            Missing::Inside(center, radius) => distance_squared(place, center) < radius * radius,
            Missing::Gap(toward, cosine) => ideal[0] * toward[0] + ideal[1] * toward[1] > cosine,
        }
    }
}

/// The part of a wall that is missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Missing {
    /// None.
    Nothing,
    /// All.
    All,
    /// The part inside a disc with this centre and radius.
    Inside([f64; 2], f64),
    /// A gap: its direction from the centre, and the cosine of half the angle at which the centre sees it.
    Gap([f64; 2], f64),
}

/// A thin bar of infinite length. It hides the points under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// The unit vector across the bar.
    pub normal: [f64; 2],
    /// The position of its middle line along the normal.
    pub offset: f64,
    /// How wide it is.
    pub width: f64,
}

impl Bar {
    fn hides(&self, [x, y]: [f64; 2]) -> bool {
        (x * self.normal[0] + y * self.normal[1] - self.offset).abs() <= self.width / 2.0
    }
}

/// The point of one piece of the wall.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The position in the piece, from 0 up to 1.
    along: f64,
    /// The position in a disc of noise of radius 1.
    noise: [f64; 2],
}

impl Sample {
    fn draw(random: &mut Random) -> Self {
        Self { along: random.unit(), noise: random.in_ball() }
    }
}

/// One wall.
#[derive(Clone, Debug)]
pub struct Wall {
    outline: Outline,
    is_uneven: bool,
    samples: Samples<Sample>,
    /// The radius of the noise, relative to the wall's radius.
    noise: f64,
}

impl Wall {
    /// A wall with `density` points in a length of the hole that counts. Noise is the radius of its disc, in radii of
    /// that hole.
    pub fn new(plan: WallPlan, density: f64, noise: f64, random: Random) -> Self {
        let outline = Outline::new(plan.form);
        let mean = if plan.is_uneven { (THICKEST + 1.0 / THICKEST) / 2.0 } else { 1.0 };
        let count = ((outline.length * (density * plan.size) * plan.density * mean).round() as u32).max(3);
        let samples = Samples::new(count, random, Sample::draw);
        Self { outline, is_uneven: plan.is_uneven, samples, noise: noise / plan.size }
    }

    /// Draws a share of the points again.
    pub fn churn(&mut self, share: f64) {
        self.samples.churn(share, Sample::draw);
    }

    /// Every point, in order along the wall. None: it is not visible. Only the points of every `stride`-th piece are.
    pub fn points(&self, pose: &Pose, bar: Option<Bar>, stride: u32) -> impl Iterator<Item = Option<[f64; 2]>> {
        let (turn, pieces) = (direction(pose.turns), self.samples.len() as f64);
        (0_u32..).zip(self.samples.iter()).map(move |(number, sample)| {
            if !number.is_multiple_of(stride) {
                return None;
            }
            let share = (f64::from(number) + sample.along) / pieces;
            let ideal = self.outline.place(if self.is_uneven { uneven(share) } else { share });
            let place = |local: [f64; 2]| moved(pose.center, turned(local, turn), pose.radius);
            let seen = place(moved(ideal, sample.noise, self.noise));
            (!pose.is_missing(ideal, place(ideal)) && !bar.is_some_and(|bar| bar.hides(seen))).then_some(seen)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: Pose = Pose { center: [3.0, 4.0], turns: 0.0, radius: 2.0, missing: Missing::Nothing };

    fn wall(form: Form, density: f64, noise: f64) -> Wall {
        Wall::new(WallPlan::new(form, 1.0), density, noise, Random::new(1))
    }

    fn seen(wall: &Wall, pose: &Pose) -> Vec<[f64; 2]> {
        wall.points(pose, None, 1).flatten().collect()
    }

    #[test]
    fn points_are_on_the_wall_with_the_given_density() {
        for (form, count) in [(Form::Circle, 101), (Form::Polygon(4), 128), (Form::Polygon(3), 166)] {
            let points = seen(&wall(form, 16.0, 0.0), &POSE);
            assert_eq!(points.len(), count, "{form:?}");
            for point in points {
                let distance = distance_squared(point, POSE.center).sqrt() / 2.0;
                assert!((1.0 - 1e-12..=form.reach() + 1e-12).contains(&distance), "{form:?}: {distance}");
            }
        }
    }

    #[test]
    fn noise_is_bounded_by_its_disc() {
        let wall = wall(Form::Circle, 100.0, 0.1);
        let off = |point| (distance_squared(point, POSE.center).sqrt() - 2.0).abs();
        let largest = seen(&wall, &POSE).into_iter().map(off).fold(0.0, f64::max);
        assert!(largest <= 0.2 + 1e-12 && largest > 0.15, "{largest}");
    }

    #[test]
    fn removed_and_hidden_parts_have_no_points() {
        let wall = wall(Form::Circle, 100.0, 0.0);
        let count = |missing| seen(&wall, &Pose { missing, ..POSE }).len() as f64 / 628.0;
        assert_eq!(count(Missing::All), 0.0);
        // A disc of the same radius around a point of the circle covers a third of the circle.
        assert!((count(Missing::Inside([5.0, 4.0], 2.0)) - 2.0 / 3.0).abs() < 0.01);
        assert!((count(Missing::Gap([0.0, 1.0], 0.5)) - 2.0 / 3.0).abs() < 0.01);
        let bar = Bar { normal: [1.0, 0.0], offset: 3.0, width: 2.0 };
        let under = wall.points(&POSE, Some(bar), 1).filter(Option::is_none).count() as f64 / 628.0;
        // Two arcs of 60 degrees.
        assert!((under - 1.0 / 3.0).abs() < 0.01, "{under}");
    }

    #[test]
    fn points_of_all_forms_are_evenly_spaced() {
        for form in [Form::Circle, Form::Polygon(5), Form::Ellipse(3.5), Form::Star(4), Form::Line] {
            let outline = Outline::new(form);
            let steps = 2000;
            let places: Vec<[f64; 2]> =
                (0..steps).map(|step| outline.place(f64::from(step) / f64::from(steps))).collect();
            let ways: Vec<f64> = places.windows(2).map(|two| distance_squared(two[0], two[1]).sqrt()).collect();
            let mean = outline.length / f64::from(steps);
            // A chord across a corner is shorter.
            let even = ways.iter().filter(|&&way| (way / mean - 1.0).abs() < 0.03).count();
            assert!(even >= ways.len() - 10 && ways.iter().all(|&way| way < 1.03 * mean), "{form:?}: {even}");
            let distances = places.iter().map(|&place| distance_squared(place, [0.0; 2]).sqrt());
            let (nearest, farthest) = distances.fold((f64::MAX, 0.0_f64), |(a, b), c| (a.min(c), b.max(c)));
            let inside = if form == Form::Line { 0.0 } else { 1.0 };
            assert!((nearest - inside).abs() < 1e-3 && (farthest - form.reach()).abs() < 1e-2, "{form:?}: {nearest}");
        }
    }

    #[test]
    fn an_uneven_wall_is_ten_times_as_dense_on_one_side() {
        let plan = WallPlan { is_uneven: true, ..WallPlan::new(Form::Circle, 1.0) };
        let points = seen(&Wall::new(plan, 100.0, 0.0, Random::new(1)), &POSE);
        assert_eq!(points.len(), 1093);
        let within = |toward: f64| points.iter().filter(|point| toward * (point[0] - 3.0) > 2.0 * 0.98).count() as f64;
        let ratio = within(1.0) / within(-1.0);
        assert!((7.0..10.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_stride_leaves_a_share_of_the_pieces() {
        let wall = wall(Form::Circle, 16.0, 0.0);
        let counts = [1, 2, 4].map(|stride| wall.points(&POSE, None, stride).flatten().count());
        assert_eq!(counts, [101, 51, 26]);
        assert_eq!(wall.points(&POSE, None, 4).count(), 101);
    }
}
