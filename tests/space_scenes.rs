//! Scenes in R^d, and signals: the points are on the true curves, the holes are those of a textbook computation of the
//! Vietoris-Rips filtration, links link, pinches pinch, periods are periods.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use hopes::scene::signal::{Signal, SignalKind, SignalOptions, TrueRun};
use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene, TrueCycle};
use hopes::scene::{Frame, OptionError, TrueEvent};

type SpaceFrame = Frame<Vec<f64>, TrueCycle>;

const CURVES: [SpaceKind; 5] =
    [SpaceKind::Trefoil, SpaceKind::Rings, SpaceKind::Links, SpaceKind::Pinch, SpaceKind::Circle];

fn play(kind: SpaceKind, options: SpaceOptions, count: usize) -> Vec<SpaceFrame> {
    let mut scene = SpaceScene::new(kind, options).unwrap();
    (0..count).map(|_| scene.next_frame()).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

fn nearest<'a>(place: &[f64], others: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    others.map(|other| distance(place, other)).fold(f64::INFINITY, f64::min)
}

// ---- the points and the true curves

/// The radius of the noise, as a length.
fn noise_of(kind: SpaceKind, noise: f64) -> f64 {
    noise * if kind == SpaceKind::Trefoil { 0.5 } else { 1.2 }
}

#[test]
fn points_are_near_the_true_curves_and_the_curves_near_points() {
    for kind in CURVES {
        for noise in [0.0, 0.1] {
            let options = SpaceOptions { noise, points: 1000, ..SpaceOptions::default() };
            for frame in play(kind, options, 500).iter().step_by(23) {
                let curves = || frame.holes.iter().flat_map(|hole| &hole.curve);
                // Half a side of the polygon, and the piece of a point: the knot is the longest curve.
                let (side, piece) = (0.05, 0.05);
                for point in &frame.points {
                    let off = nearest(point, curves());
                    assert!(
                        off <= noise_of(kind, noise) + side,
                        "{kind:?} frame {}: a point is {off} off",
                        frame.number
                    );
                }
                for place in curves() {
                    let off = nearest(place, frame.points.iter());
                    assert!(
                        off <= noise_of(kind, noise) + piece,
                        "{kind:?} frame {}: a place is {off} off",
                        frame.number
                    );
                }
            }
        }
    }
}

/// The unit normal of a flat curve.
fn normal(curve: &[Vec<f64>], center: &[f64]) -> [f64; 3] {
    let spoke = |at: usize| [0, 1, 2].map(|axis| curve[at][axis] - center[axis]);
    let ([ax, ay, az], [bx, by, bz]) = (spoke(0), spoke(curve.len() / 4));
    let normal = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    normal.map(|x| x / length)
}

#[test]
fn points_of_a_torus_are_on_its_tube_evenly() {
    let options = SpaceOptions { noise: 0.0, points: 2000, churn: 1.0, ..SpaceOptions::default() };
    let mut radii: Vec<f64> = Vec::new();
    for frame in play(SpaceKind::Torus, options, 240).iter().step_by(20) {
        let [middle, tube] = &frame.holes[..] else { panic!("{:?}", frame.holes.len()) };
        assert!((middle.radius + tube.radius - 1.0).abs() < 1e-12 && (tube.orbit - 1.0).abs() < 1e-12);
        assert!(distance(&middle.center, &tube.center) < 1e-12);
        let axis = normal(&middle.curve, &middle.center);
        let mut outside = 0;
        for point in &frame.points {
            let from_center: Vec<f64> = point.iter().zip(&middle.center).map(|(a, b)| a - b).collect();
            let up: f64 = from_center.iter().zip(axis).map(|(a, b)| a * b).sum();
            let out = (from_center.iter().map(|x| x * x).sum::<f64>() - up * up).sqrt();
            assert!(((out - 1.0).hypot(up) - tube.radius).abs() < 1e-9);
            outside += u32::from(out > 1.0);
        }
        // The outer half of a torus with a tube of 0.45 has 1/2 + 0.45/pi of its area.
        let share = f64::from(outside) / 2000.0;
        assert!((share - 0.643).abs() < 0.02, "{share}");
        radii.push(tube.radius);
        // No large part is empty: each place of either curve has a point near it.
        let curves = middle.curve.iter().chain(&tube.curve);
        let widest = curves.map(|place| nearest(place, frame.points.iter())).fold(0.0, f64::max);
        assert!(widest < 0.13, "{widest}");
    }
    radii.sort_by(f64::total_cmp);
    assert!(radii[0] < 0.40 && radii[radii.len() - 1] > 0.50, "the tube swells: {radii:?}");
}

#[test]
fn spheres_and_cubes_are_filled_evenly() {
    let options = SpaceOptions { points: 2000, noise: 0.0, ..SpaceOptions::default() };
    let sphere = &play(SpaceKind::Sphere, options, 40)[39];
    assert!(sphere.points.iter().all(|point| (distance(point, &[0.0; 3]) - 1.0).abs() < 1e-12));
    for axis in 0..3 {
        let cap = sphere.points.iter().filter(|point| point[axis] > 0.5).count() as f64 / 2000.0;
        assert!((cap - 0.25).abs() < 0.02, "{cap}");
    }
    let cube = &play(SpaceKind::Cube(5), options, 40)[39];
    assert!(cube.points.iter().flatten().all(|x| (0.0..1.0).contains(x)) && cube.points[0].len() == 5);
    for axis in 0..5 {
        let half = cube.points.iter().filter(|point| point[axis] > 0.5).count() as f64 / 2000.0;
        assert!((half - 0.5).abs() < 0.05, "{half}");
    }
    assert!(sphere.holes.is_empty() && cube.holes.is_empty());
}

#[test]
fn holes_have_the_measures_of_their_circles() {
    for kind in [SpaceKind::Rings, SpaceKind::Links, SpaceKind::Circle] {
        for hole in &play(kind, SpaceOptions::default(), 1)[0].holes {
            // A polygon of 240 corners.
            assert!((hole.length / hole.radius - TAU).abs() < 1e-3, "{kind:?}");
            let spokes = hole.curve.iter().map(|place| distance(place, &hole.center));
            assert!(spokes.into_iter().all(|spoke| (spoke - hole.radius).abs() < 1e-9), "{kind:?}");
        }
    }
}

// ---- what happens

/// The linking number of two closed polygons: half the sum of the signs of the crossings that are seen from above.
fn linking_number(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let sides = |curve: &'_ [Vec<f64>]| -> Vec<([f64; 3], [f64; 3])> {
        let at = |place: &Vec<f64>| [place[0], place[1], place[2]];
        curve.iter().zip(curve.iter().cycle().skip(1)).map(|(from, to)| (at(from), at(to))).collect()
    };
    let mut sum = 0.0;
    for (p, q) in sides(a) {
        for (r, s) in sides(b) {
            let (along, other, between) =
                ([q[0] - p[0], q[1] - p[1]], [s[0] - r[0], s[1] - r[1]], [r[0] - p[0], r[1] - p[1]]);
            let cross = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
            let turn = cross(along, other);
            let (t, u) = (cross(between, other) / turn, cross(between, along) / turn);
            if (0.0..1.0).contains(&t) && (0.0..1.0).contains(&u) {
                let heights = [p[2] + t * (q[2] - p[2]), r[2] + u * (s[2] - r[2])];
                sum += turn.signum() * if heights[0] > heights[1] { 1.0 } else { -1.0 };
            }
        }
    }
    sum / 2.0
}

#[test]
fn rings_link_and_part_and_are_two_holes_all_the_time() {
    for seed in 1..4 {
        let frames = play(SpaceKind::Links, SpaceOptions { seed, points: 20, ..SpaceOptions::default() }, 700);
        let number = |frame: usize| {
            let [a, b] = &frames[frame - 1].holes[..] else { panic!("frame {frame}") };
            linking_number(&a.curve, &b.curve).abs()
        };
        // Far apart, linked, apart again, and the same in the next round.
        assert_eq!([1, 50, 200, 345, 400, 550, 695].map(number), [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let ids = |frame: &SpaceFrame| frame.holes.iter().map(|hole| hole.id).collect::<Vec<_>>();
        assert!(frames.iter().all(|frame| ids(frame) == [1, 2]));
        assert!(frames[1..].iter().all(|frame| frame.events.is_empty()));
    }
}

#[test]
fn a_ring_pinches_in_two_and_opens_again() {
    for seed in 1..6 {
        let frames = play(SpaceKind::Pinch, SpaceOptions { seed, points: 20, ..SpaceOptions::default() }, 1200);
        let mut counts: Vec<usize> = frames.iter().map(|frame| frame.holes.len()).collect();
        counts.dedup();
        assert!(counts.starts_with(&[1, 2, 1, 2]) && counts.iter().all(|&count| count <= 2), "seed {seed}: {counts:?}");
        let events: Vec<TrueEvent> = frames.iter().flat_map(|frame| frame.events.clone()).take(4).collect();
        let (first, second) = (TrueEvent::Split { id: 2, from: 1 }, TrueEvent::Split { id: 3, from: 1 });
        assert_eq!(events, [TrueEvent::Born { id: 1, was: None }, first, TrueEvent::Merged { id: 2, into: 1 }, second]);
        for frame in &frames {
            if let [larger, smaller] = &frame.holes[..] {
                assert!(larger.radius > smaller.radius && smaller.radius > 0.7 && larger.radius < 1.06);
                assert!(distance(&larger.center, &smaller.center) > 1.0);
            } else {
                // Around both lobes.
                assert!(frame.holes[0].radius > 1.06, "frame {}", frame.number);
            }
        }
    }
}

#[test]
fn separate_rings_stay_apart_and_move_slowly() {
    for seed in 1..5 {
        let frames = play(SpaceKind::Rings, SpaceOptions { seed, points: 20, ..SpaceOptions::default() }, 800);
        for pair in frames.windows(2) {
            for (before, now) in pair[0].holes.iter().zip(&pair[1].holes) {
                let fastest = before.curve.iter().zip(&now.curve).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
                assert!(before.id == now.id && fastest > 0.0 && fastest < 0.06, "{fastest}");
            }
        }
        for frame in frames.iter().step_by(97) {
            for (number, a) in frame.holes.iter().enumerate() {
                for b in &frame.holes[..number] {
                    let gap = a.curve.iter().map(|place| nearest(place, b.curve.iter())).fold(f64::INFINITY, f64::min);
                    // A ring is filled when discs around its points have 0.87 times its radius.
                    assert!(gap > 2.0 * a.radius.max(b.radius), "seed {seed} frame {}: {gap}", frame.number);
                }
            }
        }
    }
}

// ---- the holes of the filtration

/// The persistence of each class of closed curves of the Vietoris-Rips filtration, by radii, the largest one first.
/// This is the reduction of the boundary matrix of triangles over Z/2, from the book.
fn persistences(points: &[Vec<f64>]) -> Vec<f64> {
    let count = points.len();
    let mut edges: Vec<(f64, usize, usize)> =
        (0..count).flat_map(|b| (0..b).map(move |a| (distance(&points[a], &points[b]), a, b))).collect();
    edges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rank = vec![vec![0; count]; count];
    for (number, &(_, a, b)) in edges.iter().enumerate() {
        (rank[a][b], rank[b][a]) = (number, number);
    }
    let mut triangles: Vec<[usize; 3]> = Vec::new();
    for c in 0..count {
        for b in 0..c {
            for a in 0..b {
                let mut sides = [rank[a][b], rank[a][c], rank[b][c]];
                sides.sort_unstable();
                triangles.push(sides);
            }
        }
    }
    triangles.sort_by_key(|sides| [sides[2], sides[1], sides[0]]);
    let mut columns: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    let mut found = Vec::new();
    for sides in triangles {
        let mut column = vec![0u64; edges.len().div_ceil(64)];
        sides.iter().for_each(|side| column[side / 64] ^= 1 << (side % 64));
        let lowest = |column: &[u64]| {
            let word = column.iter().rposition(|&word| word != 0)?;
            Some(64 * word + 63 - column[word].leading_zeros() as usize)
        };
        while let Some(low) = lowest(&column) {
            let Some(other) = columns.get(&low) else {
                found.push((edges[sides[2]].0 - edges[low].0) / 2.0);
                columns.insert(low, column);
                break;
            };
            column.iter_mut().zip(other).for_each(|(word, other)| *word ^= other);
        }
    }
    found.sort_by(|a, b| b.total_cmp(a));
    found
}

#[test]
fn the_truth_is_what_the_filtration_shows() {
    for kind in CURVES {
        let options = SpaceOptions { points: 75, churn: 0.5, ..SpaceOptions::default() };
        let above = SpaceScene::new(kind, options).unwrap().above().unwrap();
        let frames = play(kind, options, 500);
        let events: Vec<u64> =
            frames.iter().filter(|frame| !frame.events.is_empty()).map(|frame| frame.number).collect();
        for frame in frames.iter().step_by(99) {
            let is_calm = events.iter().all(|&event| event == 1 || frame.number.abs_diff(event) > 4);
            let found = persistences(&frame.points).iter().filter(|&&persistence| persistence >= above).count();
            assert!(found == frame.holes.len() || !is_calm, "{kind:?} frame {}: {found}", frame.number);
        }
    }
}

// ---- the stream

fn bits(points: &[Vec<f64>]) -> Vec<Vec<u64>> {
    let mut bits: Vec<Vec<u64>> = points.iter().map(|point| point.iter().map(|x| x.to_bits()).collect()).collect();
    bits.sort_unstable();
    bits
}

#[test]
fn changes_lead_from_one_cloud_to_the_next() {
    for kind in SpaceKind::ALL {
        for shuffle in [false, true] {
            let mut cloud: BTreeMap<Vec<u64>, u32> = BTreeMap::new();
            for frame in play(kind, SpaceOptions { shuffle, points: 150, ..SpaceOptions::default() }, 60) {
                for point in bits(&frame.gone) {
                    *cloud.get_mut(&point).filter(|count| **count > 0).expect("what goes was there") -= 1;
                }
                bits(&frame.come).into_iter().for_each(|point| *cloud.entry(point).or_default() += 1);
                cloud.retain(|_, count| *count > 0);
                let held = cloud.iter().flat_map(|(point, &count)| (0..count).map(move |_| point.clone()));
                assert_eq!(held.collect::<Vec<_>>(), bits(&frame.points), "{kind:?} frame {}", frame.number);
                let expected = |count: usize| if kind == SpaceKind::Pinch { count < 150 } else { count == 150 };
                assert!(expected(frame.points.len()) && frame.points.iter().all(|p| p.len() == kind.dimension()));
            }
        }
    }
}

#[test]
fn churn_is_the_share_that_is_new() {
    for kind in [SpaceKind::Circle, SpaceKind::Cube(2), SpaceKind::Delay(4)] {
        for churn in [0.01, 0.05, 0.37, 1.0] {
            let frames = play(kind, SpaceOptions { churn, points: 90, ..SpaceOptions::default() }, 101);
            let changed: usize = frames[1..].iter().map(|frame| frame.gone.len()).sum();
            assert!((changed as f64 - 100.0 * churn * 90.0).abs() <= 1.0, "{kind:?} {churn}: {changed}");
        }
    }
}

#[test]
fn delay_vectors_are_those_of_one_series() {
    let frames = play(SpaceKind::Delay(5), SpaceOptions { churn: 0.02, points: 100, ..SpaceOptions::default() }, 30);
    for frame in &frames[1..] {
        // Two vectors are new, and the oldest ones are gone. Every vector but the last three goes on in another one.
        assert_eq!((frame.gone.len(), frame.come.len()), (2, 2));
        let goes_on = |a: &&Vec<f64>| frame.points.iter().any(|b| a[1..] == b[..4]);
        assert_eq!(frame.points.iter().filter(goes_on).count(), 97);
    }
}

#[test]
fn delay_vectors_of_less_than_a_period_have_no_hole() {
    let holes = |points| {
        let scene = SpaceScene::new(SpaceKind::Delay(5), SpaceOptions { points, ..SpaceOptions::default() }).unwrap();
        (scene.above().is_some(), scene.clone().next_frame().holes.len())
    };
    assert_eq!((holes(119), holes(120)), ((false, 0), (true, 1)));
}

#[test]
fn the_seed_decides_everything() {
    for kind in SpaceKind::ALL {
        let options = |seed| SpaceOptions { seed, shuffle: true, points: 60, ..SpaceOptions::default() };
        assert_eq!(play(kind, options(7), 20), play(kind, options(7), 20));
        assert_ne!(play(kind, options(7), 1)[0].points, play(kind, options(8), 1)[0].points);
    }
}

/// The hash FNV-1a of numbers, bit for bit.
fn digest(numbers: impl Iterator<Item = f64>) -> u64 {
    let bytes = numbers.flat_map(|number| number.to_bits().to_le_bytes());
    bytes.fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}

/// The meaning of a seed must not change in any version or on any machine.
#[test]
fn scenes_do_not_change() {
    let space = SpaceKind::ALL.map(|kind| {
        let numbers =
            play(kind, SpaceOptions { points: 120, ..SpaceOptions::default() }, 300).into_iter().flat_map(|frame| {
                let measures = |hole: TrueCycle| [vec![hole.radius, hole.orbit, hole.length], hole.center].concat();
                frame.points.into_iter().flatten().chain(frame.holes.into_iter().flat_map(measures)).collect::<Vec<_>>()
            });
        format!("{} {:016x}", kind.name(), digest(numbers))
    });
    let signals = SignalKind::ALL.map(|kind| {
        let samples = signal(kind, SignalOptions::default(), 500).into_iter().flat_map(|frame| frame.points);
        format!("{} {:016x}", kind.name(), digest(samples.flatten()))
    });
    assert_eq!([space.to_vec(), signals.to_vec()].concat().join("\n"), DIGESTS);
}

const DIGESTS: &str = "\
torus 916555a321062898
trefoil 1919ffcd617b8810
rings3 6453a33315e723b7
links cb83c2508397670a
pinch3 1fdad57c988b83b4
circle 05ef8b89666dfe71
sphere 55d0400943f39069
cube:3 36d371606a6ef4b6
delay:20 79de1427be4daff4
gait 9400bcf10482b162
sine f8917e6431550a5c";

#[test]
fn options_beyond_their_range_are_refused_with_the_range() {
    let usual = SpaceOptions::default();
    let refused = |kind, options: SpaceOptions| SpaceScene::new(kind, options).unwrap_err();
    for points in [0, 2, 100_001] {
        let error = refused(SpaceKind::Torus, SpaceOptions { points, ..usual });
        assert!(error == OptionError::Points(points) && error.to_string().contains("must be 3 to 100000"), "{error}");
    }
    for kind in [SpaceKind::Cube(0), SpaceKind::Cube(4097), SpaceKind::Delay(1), SpaceKind::Delay(101)] {
        assert_eq!(refused(kind, usual), OptionError::Dimension(kind.dimension()));
    }
    let error = refused(SpaceKind::Cube(4096), SpaceOptions { points: 977, ..usual });
    assert!(error.to_string().contains("977 points of 4096 coordinates: a frame has at most 4000000"), "{error}");
    assert!(matches!(refused(SpaceKind::Links, SpaceOptions { noise: 0.31, ..usual }), OptionError::Noise(_)));
    assert!(matches!(refused(SpaceKind::Links, SpaceOptions { churn: f64::NAN, ..usual }), OptionError::Churn(_)));
    for samples in [0, 121] {
        let error = Signal::new(SignalKind::Gait, SignalOptions { samples, ..SignalOptions::default() }).unwrap_err();
        assert!(error == OptionError::Samples(samples) && error.to_string().contains("must be 1 to 120"), "{error}");
    }
    let noisy = SignalOptions { noise: -0.1, ..SignalOptions::default() };
    assert!(matches!(Signal::new(SignalKind::Sine, noisy), Err(OptionError::Noise(_))));
}

// ---- signals

fn signal(kind: SignalKind, options: SignalOptions, frames: usize) -> Vec<Frame<[f64; 1], TrueRun>> {
    let mut signal = Signal::new(kind, options).unwrap();
    (0..frames).map(|_| signal.next_frame()).collect()
}

/// The samples, and the run of each if a frame has one.
fn samples_of(kind: SignalKind, noise: f64, count: usize) -> Vec<(f64, Option<TrueRun>)> {
    let options = SignalOptions { samples: 1, noise, ..SignalOptions::default() };
    let one = |frame: Frame<[f64; 1], TrueRun>| (frame.points[0][0], frame.holes.first().copied());
    signal(kind, options, count).into_iter().map(one).collect()
}

#[test]
fn runs_have_their_period_and_rests_have_none() {
    for kind in SignalKind::ALL {
        let samples = samples_of(kind, 0.0, 3000);
        let mut periods = Vec::new();
        for begin in (0..2160).step_by(720) {
            let run = samples[begin].1.unwrap();
            let values: Vec<f64> = samples[begin..begin + 480].iter().map(|sample| sample.0).collect();
            assert!(samples[begin..begin + 480].iter().all(|sample| sample.1 == Some(run)));
            assert_eq!(run.since, begin as u64 + 1);
            // The signal comes back to itself after the period, and after no shorter time.
            let off =
                |lag: usize| values[..400].iter().zip(&values[lag..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let period = run.period as usize;
            assert!(off(period) < 1e-12 && (1..period).all(|lag| off(lag) > 0.04), "{kind:?} {period}");
            assert!(samples[begin + 480..begin + 720].iter().all(|&(value, run)| value == 0.0 && run.is_none()));
            periods.push(run.period);
        }
        assert!(periods.windows(2).all(|pair| pair[0].abs_diff(pair[1]) >= 10), "{periods:?}");
    }
}

#[test]
fn the_noise_of_a_signal_is_bounded_by_its_share() {
    let (still, noisy) = (samples_of(SignalKind::Gait, 0.0, 2000), samples_of(SignalKind::Gait, 0.2, 2000));
    let largest = still.iter().zip(&noisy).map(|(a, b)| (a.0 - b.0).abs()).fold(0.0, f64::max);
    assert!(largest > 0.19 && largest <= 0.2, "{largest}");
}

#[test]
fn frames_only_cut_a_signal_into_pieces() {
    let one = samples_of(SignalKind::Gait, 0.1, 2400);
    for samples in [4, 7, 120] {
        let options = SignalOptions { samples, ..SignalOptions::default() };
        let frames = signal(SignalKind::Gait, options, 2400 / samples as usize);
        let values: Vec<f64> = frames.iter().flat_map(|frame| frame.come.iter().map(|sample| sample[0])).collect();
        assert!(values.iter().zip(&one).all(|(value, one)| *value == one.0) && values.len() > 2390);
        for (frame, number) in frames.iter().zip(1..) {
            // A frame tells of its last sample.
            assert_eq!(frame.holes.first().copied(), one[number * samples as usize - 1].1);
            assert!(frame.gone.is_empty() && frame.come == frame.points && frame.events.len() <= 1);
        }
        let events: Vec<TrueEvent> = frames.into_iter().flat_map(|frame| frame.events).take(3).collect();
        assert_eq!(
            events,
            [TrueEvent::Born { id: 1, was: None }, TrueEvent::Died { id: 1 }, TrueEvent::Born { id: 2, was: None }]
        );
    }
}
