//! The rule by its words, in quadratic time, and the filter against it. For tests.
//!
//! In: positions.
//! Out: which pass, R and rho.
//! Invariant: it shares nothing with the filter but the tail of the Poisson distribution.
//! Must not know: trees, changes.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::filter::Filter;
use super::occupancy::Clutter;
use super::rule::Declutter;
use crate::topology::base::on_threads;
use crate::topology::cloud::{Cloud, CloudChange, Slot, Window};

type Point = [f64; 2];

fn square_distance(a: Point, b: Point) -> f64 {
    (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
}

/// The density of clutter, cell by cell.
fn clutter(points: &[Point]) -> Option<Clutter> {
    let range = |axis: usize, exponent: i32| {
        let cells = points.iter().map(|point| (point[axis] * 2f64.powi(-exponent)).floor());
        cells.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], cell| [low.min(cell), high.max(cell)])
    };
    let size = |exponent| [0, 1].map(|axis| range(axis, exponent)).map(|[low, high]| high - low + 1.0);
    let is_thin = |axis: usize| points.iter().all(|point| point[axis] == points[0][axis]);
    if points.is_empty() || is_thin(0) || is_thin(1) {
        return None;
    }
    let fits = |&exponent: &i32| size(exponent).iter().product::<f64>() <= 4.0 * points.len() as f64;
    let exponent = (-420..210).find(fits)?;
    let size = size(exponent);
    if size[0] < 3.0 || size[1] < 3.0 {
        return None;
    }
    let low = [0, 1].map(|axis| range(axis, exponent)[0]);
    let mut cells = BTreeMap::<[i64; 2], u32>::new();
    for point in points {
        let cell = [0, 1].map(|axis| ((point[axis] * 2f64.powi(-exponent)).floor() - low[axis]) as i64);
        *cells.entry(cell).or_default() += 1;
    }
    let block = |[x, y]: [i64; 2]| (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
    let points_in = |cell: [i64; 2]| block(cell).filter_map(|near| cells.get(&near)).sum::<u32>();
    let lone = cells.keys().filter(|&&cell| points_in(cell) == 1).count();
    let occupied: BTreeSet<[i64; 2]> = cells.keys().flat_map(|&cell| block(cell)).collect();
    let empty = ((size[0] + 2.0) * (size[1] + 2.0) - occupied.len() as f64).max(1.0);
    let clutter = Clutter { exponent, per_cell: lone as f64 / empty, cells: size[0] * size[1] };
    (lone > 0).then_some(clutter)
}

/// Which distinct positions pass, with the squares of R and rho.
fn passing(points: &[Point], rule: &Declutter) -> (Vec<bool>, f64, f64) {
    let neighbours = rule.neighbours() as usize;
    let reach = |at: usize| {
        let others = (0..points.len()).filter(|&other| other != at);
        let mut squares: Vec<f64> = others.map(|other| square_distance(points[at], points[other])).collect();
        squares.sort_by(f64::total_cmp);
        squares.get(neighbours - 1).copied().unwrap_or(f64::INFINITY)
    };
    let reaches: Vec<f64> = (0..points.len()).map(reach).collect();
    let rung = |square: f64| {
        let above = (-800..900).find(|&rung: &i32| square <= 2f64.powf(f64::from(rung) / 2.0) * (1.0 + 1e-15));
        above.filter(|_| square.is_finite())
    };
    let clutter = clutter(points);
    let (limit, asks_contrast) = match (rule.radius(), clutter) {
        (Some(radius), _) => (radius * radius, true),
        (None, None) => (f64::INFINITY, false),
        (None, Some(clutter)) => {
            let mut sorted = reaches.clone();
            sorted.sort_by(f64::total_cmp);
            let median = sorted.get(sorted.len().div_ceil(2) - 1).and_then(|&median| rung(median));
            let lone = clutter.rung(rule.neighbours(), rule.expected());
            let rung = lone.zip(median).map(|(lone, median)| lone.max(median + 4));
            (rung.map_or(f64::INFINITY, super::ladder::square), true)
        }
    };
    let passes = |at: usize| {
        let is_witness = |&other: &usize| {
            16.0 * reaches[other] <= reaches[at] && square_distance(points[at], points[other]) <= 2.25 * reaches[at]
        };
        let witnesses = (0..points.len()).filter(is_witness).count();
        reaches[at] <= limit && !(asks_contrast && witnesses >= 2 * neighbours + 2)
    };
    let passes: Vec<bool> = (0..points.len()).map(passes).collect();
    let kept = passes.iter().zip(&reaches).filter(|(passes, _)| **passes).map(|(_, &reach)| reach);
    let rho = kept.fold(0.0, f64::max);
    (passes, limit, rho)
}

/// A filter, its cloud, and what it has told so far.
struct Followed {
    cloud: Cloud,
    filter: Filter,
    rule: Declutter,
    passing: BTreeSet<Slot>,
    outliers: BTreeSet<Slot>,
}

impl Followed {
    fn new(rule: Declutter) -> Self {
        let cloud = Cloud::new(Window::All, None);
        Self { cloud, filter: Filter::new(rule), rule, passing: BTreeSet::new(), outliers: BTreeSet::new() }
    }

    /// Applies what has changed in the cloud, and compares all answers with the rule.
    fn step(&mut self) {
        self.cloud.commit();
        let change = self.cloud.take_change();
        let sides = self.filter.follow(&self.cloud, &change);
        for (told, side) in [(&mut self.passing, &sides.passing), (&mut self.outliers, &sides.outliers)] {
            side.vanished.iter().for_each(|slot| assert!(told.remove(slot), "it was on this side"));
            side.appeared.iter().for_each(|&slot| assert!(told.insert(slot), "it was not on this side"));
        }
        self.filter.check();
        let slots: Vec<Slot> = self.cloud.vertices().map(|(slot, _)| slot).collect();
        let points: Vec<Point> = slots.iter().map(|&slot| self.cloud.position(slot).xy()).collect();
        let (passes, limit, rho) = passing(&points, &self.rule);
        let side = |wanted: bool| -> BTreeSet<Slot> {
            slots.iter().zip(&passes).filter(|(_, passes)| **passes == wanted).map(|(&slot, _)| slot).collect()
        };
        assert_eq!(self.passing, side(true), "of {points:?}");
        assert_eq!(self.outliers, side(false));
        let report = self.filter.report();
        assert_eq!((report.filtered, report.rho), (self.outliers.len(), rho.sqrt()));
        assert_eq!(report.radius, self.rule.radius().unwrap_or(limit.sqrt()));
        let anew = on_threads(3, || {
            let mut anew = Filter::new(self.rule);
            anew.follow(&self.cloud, &CloudChange { appeared: slots, ..CloudChange::default() });
            anew.report()
        });
        assert_eq!(report, anew);
    }
}

/// What happens before a frame.
#[derive(Clone, Debug)]
enum Act {
    /// Points come.
    Come(Vec<Point>),
    /// Of the points that are there, every so manieth goes, from one on.
    Go(usize, usize),
    /// All points of a quarter of the plane go.
    GoWhere(bool, bool),
    /// All points go.
    Empty,
}

fn points_of_a_kind() -> impl Strategy<Value = Vec<Point>> {
    let uniform = prop::collection::vec((0.0..8.0, 0.0..8.0).prop_map(|(x, y)| [x, y]), 1..40);
    let lattice = prop::collection::vec((0..9, 0..7).prop_map(|(x, y)| [f64::from(x), f64::from(y)]), 1..40);
    let line = prop::collection::vec((0..60).prop_map(|x| [f64::from(x) * 0.25, 3.0]), 1..30);
    let clump = ((0.0..8.0, 0.0..8.0), 0..30, prop::collection::vec((-1.0..1.0, -1.0..1.0), 1..40)).prop_map(
        |((x, y), scale, points): ((f64, f64), i32, Vec<(f64, f64)>)| {
            let size = 2f64.powi(-scale);
            points.into_iter().map(|(dx, dy)| [x + size * dx, y + size * dy]).collect()
        },
    );
    let ring = ((0.0..8.0, 0.0..8.0), 0.2..2.0, 8..50).prop_map(|((x, y), radius, count): ((f64, f64), f64, i32)| {
        let angle = |place: i32| f64::from(place) / f64::from(count) * std::f64::consts::TAU;
        (0..count).map(|place| [x + radius * angle(place).cos(), y + radius * angle(place).sin()]).collect()
    });
    let far = (-200..200, -1.0..1.0).prop_map(|(power, y): (i32, f64)| vec![[2f64.powi(power), y]]);
    prop_oneof![uniform, lattice, line, clump.clone(), clump, ring.clone(), ring, far]
}

fn acts() -> impl Strategy<Value = Vec<Act>> {
    let act = prop_oneof![
        6 => points_of_a_kind().prop_map(Act::Come),
        3 => (1usize..6, 0usize..5).prop_map(|(every, from)| Act::Go(every, from)),
        1 => (any::<bool>(), any::<bool>()).prop_map(|(x, y)| Act::GoWhere(x, y)),
        1 => Just(Act::Empty),
    ];
    prop::collection::vec(prop::collection::vec(act, 1..3), 1..12)
        .prop_map(|frames: Vec<Vec<Act>>| frames.into_iter().flatten().collect())
}

fn rules() -> impl Strategy<Value = Declutter> {
    let neighbours = prop_oneof![4 => Just(3), 1 => 1u32..9];
    (neighbours, prop::option::weighted(0.3, 0.05..4.0), prop_oneof![Just(1.0), Just(0.05), Just(5.0)]).prop_map(
        |(neighbours, radius, expected): (u32, Option<f64>, f64)| {
            let rule = Declutter::new(neighbours).unwrap().with_expected(expected).unwrap();
            radius.map_or(rule, |radius| rule.with_radius(radius).unwrap())
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn the_filter_follows_the_rule(rule in rules(), acts in acts(), unit in prop_oneof![3 => Just(0), 1 => -140..195]) {
        let unit = 2f64.powi(unit);
        let mut followed = Followed::new(rule);
        for act in acts {
            let there: Vec<Point> = followed.cloud.vertices().map(|(_, vertex)| vertex.position.xy()).collect();
            let gone: Vec<Point> = match act {
                Act::Come(points) => {
                    for [x, y] in points {
                        // Points beyond the limits of coordinates are refused.
                        let _ = followed.cloud.insert(x * unit, y * unit, None);
                    }
                    Vec::new()
                }
                Act::Go(every, from) => there.into_iter().skip(from).step_by(every).collect(),
                Act::GoWhere(right, up) => {
                    let is_there = |point: &Point| (point[0] > 4.0 * unit, point[1] > 4.0 * unit) == (right, up);
                    there.into_iter().filter(is_there).collect()
                }
                Act::Empty => there,
            };
            for [x, y] in gone {
                while followed.cloud.retract(x, y).is_ok() {}
            }
            followed.step();
        }
    }

    #[test]
    fn small_changes_of_a_larger_cloud_are_followed(
        rule in rules(),
        base in prop::collection::vec(points_of_a_kind(), 6..12),
        steps in prop::collection::vec((points_of_a_kind(), 0usize..100, 0usize..9), 1..14),
    ) {
        let mut followed = Followed::new(rule);
        for [x, y] in base.into_iter().flatten() {
            let _ = followed.cloud.insert(x, y, None);
        }
        followed.step();
        for (points, from, count) in steps {
            for [x, y] in points.into_iter().take(12) {
                let _ = followed.cloud.insert(x, y, None);
            }
            let there: Vec<Point> = followed.cloud.vertices().map(|(_, vertex)| vertex.position.xy()).collect();
            for [x, y] in there.into_iter().skip(from).take(count) {
                let _ = followed.cloud.retract(x, y);
            }
            followed.step();
        }
    }
}
