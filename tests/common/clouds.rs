//! Clouds of every difficult kind as proptest strategies: floats, ties, circles, lines, far and tiny clouds.

use proptest::prelude::*;
use proptest::sample::{SizeRange, select};

pub type Point = [f64; 2];

/// The number of cases, unless `PROPTEST_CASES` sets another one. A failing case prints itself, so no file of seeds is
/// needed.
pub fn cases(count: u32) -> ProptestConfig {
    ProptestConfig {
        cases: count,
        failure_persistence: None,
        max_shrink_iters: 10_000,
        max_global_rejects: 100_000,
        ..ProptestConfig::default()
    }
}

/// Where points lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// Anywhere in the unit square: no ties.
    Uniform,
    /// A small integer lattice: many ties, squares and duplicates.
    Lattice,
    /// The same with a step of 0.1: ties differ by an ulp.
    RoundedLattice,
    /// On a line parallel to the x axis.
    Horizontal,
    /// On a line parallel to the y axis.
    Vertical,
    /// Exactly on an oblique line.
    Oblique,
    /// Some 1e-13 beside an oblique line.
    NearlyCollinear,
    /// Integer points of overlapping circles of this radius (5, 25 or 65).
    Circles(i32),
    /// Uniform, 1e8 from the origin.
    Far,
    /// A small integer lattice, 1e8 from the origin.
    FarLattice,
    /// Uniform, of size 1e-9.
    Tiny,
    /// A mixture of several of these.
    Mixture,
}

use Placement::*;

impl Placement {
    /// Exact lines. A cloud on one of them has no triangulation.
    pub const LINES: [Placement; 3] = [Horizontal, Vertical, Oblique];

    /// Coordinates are small integers, or such times a power of two. Ties are exact.
    pub const INTEGERS: [Placement; 7] = [Lattice, Horizontal, Vertical, Oblique, Circles(5), Circles(25), Circles(65)];

    /// Lengths, radii and angles tie with probability 0 only.
    pub const TIE_FREE: [Placement; 3] = [Uniform, Far, Tiny];

    pub fn any() -> impl Strategy<Value = Placement> {
        select(vec![
            Uniform,
            Lattice,
            RoundedLattice,
            Horizontal,
            Vertical,
            Oblique,
            NearlyCollinear,
            Circles(5),
            Circles(25),
            Circles(65),
            Far,
            FarLattice,
            Tiny,
            Mixture,
        ])
    }

    pub fn point(self) -> BoxedStrategy<Point> {
        let unit = || [0.0..1.0_f64, 0.0..1.0_f64];
        let lattice = || [0..12_i32, 0..12_i32].prop_map(|p| p.map(f64::from));
        match self {
            Uniform => unit().boxed(),
            Lattice => lattice().boxed(),
            RoundedLattice => lattice().prop_map(|p| p.map(|v| v * 0.1)).boxed(),
            Horizontal => (0..400_i32).prop_map(|i| [f64::from(i) / 4.0, 3.0]).boxed(),
            Vertical => (0..400_i32).prop_map(|i| [-7.0, f64::from(i) / 4.0]).boxed(),
            Oblique => (0..400_i32).prop_map(|i| [0.75 * f64::from(i), 1.25 * f64::from(i) - 7.0]).boxed(),
            NearlyCollinear => (0..400_i32, -3..=3_i32)
                .prop_map(|(i, off)| [f64::from(i) * 0.37, f64::from(i) * 0.61 + f64::from(off) * 1e-13])
                .boxed(),
            Circles(radius) => (select(circle(radius)), [0..3_i32, 0..3_i32])
                .prop_map(move |(on, centre)| [0, 1].map(|axis| f64::from(on[axis] + centre[axis] * radius)))
                .boxed(),
            Far => unit().prop_map(|p| p.map(|v| v + 1e8)).boxed(),
            FarLattice => lattice().prop_map(|[x, y]| [x + 1e8, y - 1e8]).boxed(),
            Tiny => unit().prop_map(|p| p.map(|v| v * 1e-9)).boxed(),
            Mixture => prop_oneof![
                unit().prop_map(|p| p.map(|v| v * 12.0)),
                lattice(),
                Circles(5).point(),
                Oblique.point(),
                Horizontal.point(),
            ]
            .boxed(),
        }
    }

    pub fn points(self, count: impl Into<SizeRange>) -> BoxedStrategy<Vec<Point>> {
        prop::collection::vec(self.point(), count).boxed()
    }
}

/// All integer points on the circle of an integer radius around the origin.
pub fn circle(radius: i32) -> Vec<[i32; 2]> {
    let side = -radius..=radius;
    side.clone()
        .flat_map(|x| side.clone().map(move |y| [x, y]))
        .filter(|[x, y]| x * x + y * y == radius * radius)
        .collect()
}

/// Clouds of any kind.
pub fn clouds(count: impl Into<SizeRange>) -> impl Strategy<Value = Vec<Point>> {
    let count = count.into();
    Placement::any().prop_flat_map(move |placement| placement.points(count.clone()))
}

/// Clouds of these kinds.
pub fn clouds_on(placements: &'static [Placement], count: impl Into<SizeRange>) -> impl Strategy<Value = Vec<Point>> {
    let count = count.into();
    select(placements).prop_flat_map(move |placement| placement.points(count.clone()))
}

/// A cloud, and the same cloud in another order.
pub fn shuffled(clouds: impl Strategy<Value = Vec<Point>>) -> impl Strategy<Value = (Vec<Point>, Vec<Point>)> {
    clouds.prop_flat_map(|cloud| (Just(cloud.clone()), Just(cloud).prop_shuffle()))
}

/// The distinct positions of a cloud, by x, then y.
pub fn distinct(points: &[Point]) -> Vec<Point> {
    let mut positions: Vec<Point> = points.iter().map(|p| p.map(|v| v + 0.0)).collect();
    positions.sort_by(|a, b| a.partial_cmp(b).expect("coordinates are numbers"));
    positions.dedup();
    positions
}
