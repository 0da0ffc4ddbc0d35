//! Times live frames in R^d: some points of a window are replaced, and HoPeS_{1,1} is computed anew.
//!
//! In: a scene and sizes. Out: one line of JSON on stdout: over the frames, the median and the longest time in
//! milliseconds of a whole frame (points into the window, filtration, view, diff), of tracking after it, and peak
//! memory.
//!
//! With `--tracks M` the M most persistent cycles are tracked. With `--check` every frame is compared with
//! recomputation in fresh memory, outside of the measured time; the first difference ends the run.
//!
//! `cargo run --release --example space_frames -- torus --points 1000 --replace 50 --frames 50 --threads 1`

use std::f64::consts::TAU;
use std::num::{NonZeroU32, NonZeroU64};
use std::time::Instant;

use hopes::topology::{Follower, SpaceOptions, SpacePipeline, SpaceTracker, TrackOptions, TrackRule, ViewSpec, Window};
use serde_json::json;

type Error = Box<dyn std::error::Error>;

const USAGE: &str = "usage: space_frames circle|trefoil|sphere|torus|cube|delay [--points N] [--replace N] [--frames N] \
                     [--threads N] [--tracks M] [--check]";

fn main() -> Result<(), Error> {
    let run = Run::from_arguments(std::env::args().skip(1))?;
    rayon::ThreadPoolBuilder::new().num_threads(run.threads).build_global()?;
    let window = Window::Points(NonZeroU64::new(run.points as u64).ok_or("--points must not be 0")?);
    let options = SpaceOptions { window, max_vertices: 2 * run.points, ..SpaceOptions::default() };
    let mut pipeline = SpacePipeline::new(options)?;
    let mut follower = Follower::new(ViewSpec::default());
    let mut tracker = run.tracks.map(|most| SpaceTracker::new(TrackOptions::new(TrackRule::Top(most))));
    let mut random = Random(1);
    let (mut frames, mut tracking) = (Vec::new(), Vec::new());
    for number in 0..=run.frames {
        let count = if number == 0 { run.points } else { run.replace };
        let points: Vec<Vec<f64>> = (0..count).map(|_| random.point(&run.scene)).collect::<Result<_, _>>()?;
        let start = Instant::now();
        pipeline.feed_points(&points, None);
        pipeline.commit(None);
        // What tracks ask of a frame is answered while it is computed.
        let begun = tracker.as_ref().map(|_| Instant::now());
        let tracked = tracker.as_mut().and_then(|tracker| pipeline.poll_tracks(tracker));
        let of_tracks = begun.map_or(0.0, |begun| begun.elapsed().as_secs_f64() * 1e3);
        pipeline.poll_step(&mut follower).ok_or("there is a new frame")?;
        let whole = start.elapsed().as_secs_f64() * 1e3;
        drop(tracked);
        if run.check {
            pipeline.check(&follower)?;
        }
        if number > 0 {
            frames.push(whole);
            tracking.push(of_tracks);
        }
    }
    let with_tracks = run.tracks.map(|most| json!({ "top": most, "ms": median(&tracking) }));
    println!(
        "{}",
        json!({
            "scene": run.scene, "points": run.points, "replaced": run.replace, "frames": run.frames,
            "threads": run.threads, "frame_ms": median(&frames),
            "longest_ms": round(frames.iter().copied().fold(0.0, f64::max)), "checked": run.check,
            "computed_with_tracks": with_tracks, "peak_mib": peak_mib(),
        })
    );
    Ok(())
}

/// The options of a run.
struct Run {
    scene: String,
    points: usize,
    replace: usize,
    frames: usize,
    threads: usize,
    check: bool,
    tracks: Option<NonZeroU32>,
}

impl Run {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Result<Self, Error> {
        let scene = arguments.next().ok_or(USAGE)?;
        let mut run = Self { scene, points: 1_000, replace: 0, frames: 50, threads: 1, check: false, tracks: None };
        let mut replace = None;
        while let Some(name) = arguments.next() {
            let mut number = || -> Result<usize, Error> { Ok(arguments.next().ok_or(USAGE)?.parse()?) };
            match name.as_str() {
                "--points" => run.points = number()?,
                "--replace" => replace = Some(number()?),
                "--frames" => run.frames = number()?,
                "--threads" => run.threads = number()?,
                "--check" => run.check = true,
                "--tracks" => run.tracks = Some(u32::try_from(number()?)?.try_into()?),
                _ => return Err(USAGE.into()),
            }
        }
        run.replace = replace.unwrap_or(run.points / 20);
        Ok(run)
    }
}

fn median(list: &[f64]) -> f64 {
    let mut list = list.to_vec();
    list.sort_by(f64::total_cmp);
    round(list.get(list.len() / 2).copied().unwrap_or(f64::NAN))
}

fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// SplitMix64: a seeded stream without a dependency.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// From -1 to 1.
    fn either_way(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// The next point of a scene.
    fn point(&mut self, scene: &str) -> Result<Vec<f64>, Error> {
        let angle = TAU * self.unit();
        Ok(match scene {
            "circle" => {
                let radius = 1.0 + 0.1 * self.either_way();
                vec![radius * angle.cos(), radius * angle.sin()]
            }
            "trefoil" => {
                let place = [
                    angle.sin() + 2.0 * (2.0 * angle).sin(),
                    angle.cos() - 2.0 * (2.0 * angle).cos(),
                    -(3.0 * angle).sin(),
                ];
                place.iter().map(|x| x + 0.1 * self.either_way()).collect()
            }
            "sphere" => {
                let height = self.either_way();
                let radius = (1.0 - height * height).sqrt();
                vec![radius * angle.cos(), radius * angle.sin(), height]
            }
            "torus" => {
                // As many points on an area as on any other of its size.
                let around = loop {
                    let around = TAU * self.unit();
                    if 1.4 * self.unit() < 1.0 + 0.4 * around.cos() {
                        break around;
                    }
                };
                let radius = 1.0 + 0.4 * around.cos();
                vec![radius * angle.cos(), radius * angle.sin(), 0.4 * around.sin()]
            }
            "cube" => (0..3).map(|_| self.unit()).collect(),
            // Twenty samples of two tones, with noise.
            "delay" => (0..20)
                .map(|lag| {
                    let phase = angle + 0.3 * f64::from(lag);
                    phase.sin() + 0.5 * (1.618 * phase).sin() + 0.05 * self.either_way()
                })
                .collect(),
            _ => return Err(USAGE.into()),
        })
    }
}

/// The peak of this process' memory, where the system tells it.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kibibytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"))?;
    Some(round(kibibytes.trim().parse::<f64>().ok()? / 1024.0))
}
