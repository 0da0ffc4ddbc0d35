//! Times the worst frames of degenerate clouds, beside one pass over the same cloud in the same run.
//!
//! In: families of clouds, and a size. Out: one line of JSON a family on stdout: the median frame; the frame that took
//! longest beside one pass over its own cloud, with both times in milliseconds and their ratio; how many of the frames
//! were computed in one pass.
//!
//! A frame is: points in, points out, commit, one step of a follower. One pass is the same for a new pipeline that is
//! given the whole cloud at once. Times are processor time, so that other work on the machine hardly counts. Frames are
//! the same in every round, and each frame and each pass counts with its best time of all rounds. The first frame of a
//! run loads the cloud and is not counted. With `--check` every frame of the last round is compared with recomputation
//! from scratch.
//!
//! `cargo run --release --example worst_frames -- all --points 24000 --frames 12 --rounds 3`

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use hopes::topology::{Follower, Options, Pipeline, ViewSpec};
use rustix::time::{ClockId, clock_gettime};
use serde_json::json;

type Error = Box<dyn std::error::Error>;
type Point = [f64; 2];

/// What comes and what goes in a frame.
type Change = (Vec<Point>, Vec<Point>);

fn main() -> Result<(), Error> {
    let run = Run::from_arguments(std::env::args().skip(1))?;
    rayon::ThreadPoolBuilder::new().num_threads(run.threads).build_global()?;
    for &(name, family) in FAMILIES.iter().filter(|(name, _)| run.family == "all" || run.family == *name) {
        let (cloud, changes) = family(run.points, run.frames);
        println!("{}", measure(&run, name, &cloud, &changes)?);
    }
    Ok(())
}

fn measure(run: &Run, name: &str, cloud: &[Point], changes: &[Change]) -> Result<serde_json::Value, Error> {
    let mut best = vec![Times::default(); changes.len()];
    let mut whole = 0;
    for round in 0..run.rounds {
        let (mut live, mut points) = (Live::default(), cloud.to_vec());
        live.frame(cloud, &[]);
        whole = 0;
        for ((come, go), best) in changes.iter().zip(&mut best) {
            let frame = live.frame(come, go);
            whole += usize::from(live.pipeline.tiles_reduced() == 0);
            points.extend(come);
            let gone: BTreeSet<[u64; 2]> = go.iter().map(|p| p.map(f64::to_bits)).collect();
            points.retain(|p| !gone.contains(&p.map(f64::to_bits)));
            best.keep(frame, Live::default().frame(&points, &[]));
            if run.check && round + 1 == run.rounds {
                live.pipeline.check(&live.follower)?;
            }
        }
    }
    let worst = (0..best.len()).max_by(|&a, &b| best[a].ratio().total_cmp(&best[b].ratio())).ok_or("no frames")?;
    let Times { frame, pass } = best[worst];
    let mut frames: Vec<f64> = best.iter().map(|times| times.frame).collect();
    frames.sort_by(f64::total_cmp);
    Ok(json!({
        "family": name, "points": cloud.len(), "median_ms": round(frames[frames.len() / 2]), "worst": worst,
        "worst_ms": round(frame), "its_pass_ms": round(pass), "ratio": round(frame / pass), "in_one_pass": whole,
        "frames": changes.len(),
    }))
}

/// The best times of a frame and of one pass over its cloud, in milliseconds.
#[derive(Clone, Copy)]
struct Times {
    frame: f64,
    pass: f64,
}

impl Default for Times {
    fn default() -> Self {
        Self { frame: f64::INFINITY, pass: f64::INFINITY }
    }
}

impl Times {
    fn keep(&mut self, frame: f64, pass: f64) {
        (self.frame, self.pass) = (self.frame.min(frame), self.pass.min(pass));
    }

    fn ratio(&self) -> f64 {
        self.frame / self.pass
    }
}

fn round(value: f64) -> f64 {
    (value * 1e2).round() / 1e2
}

/// The processor time of this process so far.
fn processor_ms() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

struct Live {
    pipeline: Pipeline,
    follower: Follower,
}

impl Default for Live {
    fn default() -> Self {
        Self { pipeline: Pipeline::new(Options::default()), follower: Follower::new(ViewSpec::default()) }
    }
}

impl Live {
    /// The milliseconds of a frame.
    fn frame(&mut self, come: &[Point], go: &[Point]) -> f64 {
        let start = processor_ms();
        assert_eq!(self.pipeline.feed_points(come, None), []);
        assert_eq!(self.pipeline.feed_retractions(go), []);
        self.pipeline.commit(None);
        let step = self.pipeline.poll_step(&mut self.follower);
        let time = processor_ms() - start;
        drop(step);
        time
    }
}

/// The options of a run.
struct Run {
    family: String,
    points: usize,
    frames: usize,
    rounds: usize,
    threads: usize,
    check: bool,
}

impl Run {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Result<Self, Error> {
        let usage = "usage: worst_frames all|FAMILY [--points N] [--frames N] [--rounds N] [--threads N] [--check]";
        let family = arguments.next().ok_or(usage)?;
        let mut run = Self { family, points: 24_000, frames: 12, rounds: 3, threads: 1, check: false };
        while let Some(name) = arguments.next() {
            let mut number = || -> Result<usize, Error> { Ok(arguments.next().ok_or(usage)?.parse()?) };
            match name.as_str() {
                "--points" => run.points = number()?,
                "--frames" => run.frames = number()?,
                "--rounds" => run.rounds = number()?,
                "--threads" => run.threads = number()?,
                "--check" => run.check = true,
                _ => return Err(usage.into()),
            }
        }
        if run.family != "all" && FAMILIES.iter().all(|(name, _)| *name != run.family) {
            return Err(format!("no family {:?}; there are {:?}", run.family, FAMILIES.map(|(name, _)| name)).into());
        }
        Ok(run)
    }
}

/// Makes a cloud of about so many points, and so many frames.
type Family = fn(usize, usize) -> (Vec<Point>, Vec<Change>);

const FAMILIES: [(&str, Family); 30] = [
    ("uniform", |n, frames| slide(n, frames, |i| [unit(2 * i), unit(2 * i + 1)])),
    // Without its centre, every triangle of a spiral has its inner end as a corner: the oldest point.
    ("spiral", |n, frames| slide(n, frames, |i| spiral(i, n))),
    ("spiral_back", |n, frames| slide(n, frames, |i| spiral(n + frames - i, n))),
    ("spiral_centre", |n, frames| toggle(points(n, |i| spiral(i, n)), frames, |_| vec![[0.0; 2]])),
    // Most of the cloud is elsewhere: the degree is far from the cloud's size.
    ("spiral_aside", |n, frames| aside(n, 8, frames)),
    ("small_spiral_aside", |n, frames| aside(n, 80, frames)),
    ("turns", |n, frames| slide(n, frames, |i| on_circle(i as f64 / 997.0, 1.0 + i as f64 / n as f64))),
    ("fan", |n, frames| toggle(points(n, |i| parabola(i, n)), frames, |k| vec![[0.01 * k as f64, -20.0]])),
    ("parabola", |n, frames| slide(n, frames, |i| parabola(i, n))),
    ("comb", |n, frames| toggle(points(n, |i| comb(i, n)), frames, |k| vec![[0.5, -1e5 - k as f64]])),
    ("hub", |n, frames| with_hubs(&[[0.0; 2]], slide(n, frames, |i| ring(i, n)))),
    ("two_hubs", |n, frames| with_hubs(&[[-0.1, 0.0], [0.1, 0.0]], slide(n, frames, |i| ring(i, n)))),
    ("hub_comes_and_goes", |n, frames| toggle(points(n, |i| ring(i, n)), frames, |_| vec![[0.0; 2]])),
    ("hub_moves", |n, frames| moving(points(n, |i| ring(i, n)), frames, |k| [0.01 * (k % 7) as f64, 0.0])),
    ("hub_among_tiles", |n, frames| after_quiet(points(n, |i| ring(i, n)), frames, |_| vec![[0.0; 2]])),
    ("hubs_among_tiles", |n, frames| {
        after_quiet(points(n, |i| ring(i, n)), frames, |k| points(5, |i| on_circle(unit(i + k), 0.5)))
    }),
    ("hull_hub_among_tiles", |n, frames| after_quiet(points(n, |i| parabola(i, n)), frames, |_| vec![[0.0, -20.0]])),
    ("far_point_among_tiles", |n, frames| after_quiet(points(n, |i| comb(i, n)), frames, |_| vec![[0.5, -1e5]])),
    ("centre_among_tiles", |n, frames| after_quiet(integer_circle(n), frames, |_| vec![[0.0; 2]])),
    ("cocircular", |n, frames| toggle(integer_circle(n), frames, |_| vec![[0.0; 2]])),
    ("cocircular_gaps", |n, frames| {
        let ring = integer_circle(n);
        let gone = ring[ring.len() / 3];
        (
            ring,
            (0..frames)
                .map(|k| if k.is_multiple_of(2) { (vec![], vec![gone]) } else { (vec![gone], vec![]) })
                .collect(),
        )
    }),
    ("near_line", |n, frames| slide(n, frames, |i| [i as f64, 1e-9 * unit(i)])),
    ("near_line_far_point", |n, frames| {
        toggle(points(n, |i| [i as f64, 1e-9 * unit(i)]), frames, |k| vec![[n as f64 / 2.0, 1e9 * (k + 1) as f64]])
    }),
    ("leaves_a_line", |n, frames| toggle(points(n, |i| [i as f64, 0.0]), frames, |_| vec![[n as f64 / 2.0, 10.0]])),
    ("two_lines", |n, frames| slide(n, frames, |i| [(i / 2) as f64, (i % 2) as f64 * 1e4])),
    ("cross", |n, frames| slide(n, frames, |i| cross(i, n))),
    ("line_among_outliers", |n, frames| toggle(outliers(n, 0), frames, |k| outliers(n / 20, n + n * k))),
    ("batches_in_a_cross", |n, frames| {
        toggle(points(n, |i| cross(i, n)), frames, |k| {
            points(n / 20, |i| {
                [unit(i + k * n) * n as f64 - n as f64 / 2.0, unit(i + 9 * k) * n as f64 - n as f64 / 2.0]
            })
        })
    }),
    ("half_stays", |n, frames| slide_by(n, n / 30, frames, |i| [unit(2 * i), unit(2 * i + 1)])),
    ("batches_in_a_ring", |n, frames| {
        let batch = |k: usize| (0..n / 40).map(|i| on_circle(unit(i + 7 * k), 0.1 + 0.5 * unit(i + 9 * k))).collect();
        toggle(points(n, |i| ring(i, n)), frames, batch)
    }),
];

fn points(count: usize, at: impl Fn(usize) -> Point) -> Vec<Point> {
    (0..count).map(at).collect()
}

/// One point in and the oldest out in each frame.
fn slide(count: usize, frames: usize, at: impl Fn(usize) -> Point) -> (Vec<Point>, Vec<Change>) {
    let changes = (0..frames).map(|k| (vec![at(count + k)], vec![at(k)])).collect();
    (points(count, at), changes)
}

/// So many points in and the oldest out in each frame.
fn slide_by(count: usize, by: usize, frames: usize, at: impl Fn(usize) -> Point) -> (Vec<Point>, Vec<Change>) {
    let some = |from: usize| (from..from + by).map(&at).collect();
    let changes = (0..frames).map(|k| (some(count + k * by), some(k * by))).collect();
    (points(count, &at), changes)
}

/// Half of the points nearly on a short line, the others far and wide.
fn outliers(count: usize, first: usize) -> Vec<Point> {
    let at =
        |i: usize| if i.is_multiple_of(2) { [unit(i), unit(i + 7)] } else { [1e-7 * unit(i), 1e-12 * unit(i + 7)] };
    (first..first + count).map(at).collect()
}

/// Some points that come in every even frame and go in the next one.
fn toggle(cloud: Vec<Point>, frames: usize, at: impl Fn(usize) -> Vec<Point>) -> (Vec<Point>, Vec<Change>) {
    let change = |k: usize| if k.is_multiple_of(2) { (at(k / 2), vec![]) } else { (vec![], at(k / 2)) };
    (cloud, (0..frames).map(change).collect())
}

/// A point of the cloud goes and comes back, some points come, they go again, and so on.
fn after_quiet(cloud: Vec<Point>, frames: usize, at: impl Fn(usize) -> Vec<Point>) -> (Vec<Point>, Vec<Change>) {
    let one = vec![cloud[cloud.len() / 3]];
    let change = |k: usize| match k % 4 {
        0 => (vec![], one.clone()),
        1 => (one.clone(), vec![]),
        2 => (at(k / 4), vec![]),
        _ => (vec![], at(k / 4)),
    };
    let changes = (0..frames).map(change).collect();
    (cloud, changes)
}

/// One point that is elsewhere in each frame.
fn moving(mut cloud: Vec<Point>, frames: usize, at: impl Fn(usize) -> Point) -> (Vec<Point>, Vec<Change>) {
    cloud.push(at(0));
    (cloud, (0..frames).map(|k| (vec![at(k + 1)], vec![at(k)])).collect())
}

/// The window of a spiral of `1 / share` of the cloud moves on, among uniform points.
fn aside(n: usize, share: usize, frames: usize) -> (Vec<Point>, Vec<Change>) {
    let (mut cloud, changes) = slide(n / share, frames, |i| spiral(i, n / share));
    cloud.extend(points(n - n / share, |i| [2.0 + unit(2 * i), unit(2 * i + 1)]));
    (cloud, changes)
}

/// More points that stay.
fn with_hubs(hubs: &[Point], (mut cloud, changes): (Vec<Point>, Vec<Change>)) -> (Vec<Point>, Vec<Change>) {
    cloud.extend(hubs);
    (cloud, changes)
}

/// The fractional part of a multiple of an irrational number, mixed.
fn unit(i: usize) -> f64 {
    let z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A point at an angle in turns.
fn on_circle(turns: f64, radius: f64) -> Point {
    let (sin, cos) = (turns * TAU).sin_cos();
    [radius * cos, radius * sin]
}

fn spiral(i: usize, n: usize) -> Point {
    on_circle(0.95 * i as f64 / n as f64, 1.0 + 0.3 * i as f64 / n as f64)
}

fn parabola(i: usize, n: usize) -> Point {
    let x = 2.0 * i as f64 / n as f64 - 1.0;
    [x, 0.1 * x * x]
}

/// Teeth of a hundred points each.
fn comb(i: usize, n: usize) -> Point {
    [(i / 100) as f64 * 100.0 / n as f64, (i % 100) as f64]
}

/// Points on a circle, each a tiny bit beside it.
fn ring(i: usize, n: usize) -> Point {
    on_circle(i as f64 * 0.618_033_988_749_894_9, 1.0 + 1e-7 * unit(i + n))
}

fn cross(i: usize, n: usize) -> Point {
    let along = (i % n) as f64 - n as f64 / 2.0 + (i / n) as f64 * 0.5;
    if i.is_multiple_of(2) { [along, 0.0] } else { [0.0, along] }
}

/// Integer points on one circle, exactly: the products of Gaussian primes of some norms and of their conjugates.
fn integer_circle(count: usize) -> Vec<Point> {
    let primes: [[i128; 2]; 8] = [[2, 1], [3, 2], [4, 1], [5, 2], [6, 1], [5, 4], [7, 2], [6, 5]];
    let times = |[a, b]: [i128; 2], [c, d]: [i128; 2]| [a * c - b * d, a * d + b * c];
    let mut found = vec![[1, 0], [0, 1], [-1, 0], [0, -1]];
    for prime in primes {
        if found.len() * 3 > 2 * count {
            break;
        }
        let [a, b] = prime;
        let factors = [times(prime, prime), [a * a + b * b, 0], times([a, -b], [a, -b])];
        found = found.into_iter().flat_map(|point| factors.map(|factor| times(point, factor))).collect();
    }
    found.into_iter().map(|point| point.map(|v| v as f64)).collect()
}
