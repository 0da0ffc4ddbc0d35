//! Times live frames: some points of a cloud are replaced, and HoPeS_{1,1} is updated. For comparison plain `spade`
//! does the same updates in the same order with the same hint generator, in the same run. (The library starts the
//! search for a new vertex in its leaf of the tiles, where that is closer.)
//!
//! In: a scene and sizes. Out: one line of JSON on stdout: medians over the frames, in milliseconds, of `spade`'s
//! insertions and removals and of the whole frame (points into the window, triangulation, reduction, view, diff), their
//! ratio, reduced tiles, reported changes, peak memory.
//!
//! With `--alone` plain `spade`, whose memory is in the peak too, is left out. With `--check` it is left out too, and
//! every frame is compared with recomputation from scratch, outside of the measured time; the first difference ends the
//! run. With `--tracks M` the M most persistent cycles are tracked too, after the frame; that time is reported
//! separately. With `--declutter` outliers are filtered: that is a part of the frame, and the filter's own time is
//! measured beside it, on a cloud of its own that has the same points; for the first frame too.
//!
//! `cargo run --release --example live_frames -- sweep --points 100000 --replace 1000 --frames 100 --threads 1`

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::num::{NonZeroU32, NonZeroU64};
use std::time::{Duration, Instant};

use hopes::topology::stages::{OutlierFilter, along_curve};
use hopes::topology::{
    Cloud, Declutter, Follower, Options, Pipeline, Position, TrackOptions, TrackRule, Tracker, ViewSpec, Window,
};
use serde_json::json;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, HasPosition, LastUsedVertexHintGenerator, Point2, Triangulation};

type Error = Box<dyn std::error::Error>;
type Point = [f64; 2];

fn main() -> Result<(), Error> {
    let run = Run::from_arguments(std::env::args().skip(1))?;
    rayon::ThreadPoolBuilder::new().num_threads(run.threads).build_global()?;
    let mut scene = Scene::new(&run)?;
    let window = match run.scene.as_str() {
        "camera" => Window::Frames(NonZeroU64::MIN),
        _ => Window::Points(NonZeroU64::new(run.points as u64).ok_or("--points must not be 0")?),
    };
    let declutter = run.declutter.then(Declutter::default);
    let mut pipeline = Pipeline::new(Options { window, declutter, ..Options::default() });
    let mut filter = declutter.map(|rule| (Cloud::new(window, None), OutlierFilter::new(rule)));
    if let Some(leaf) = run.leaf {
        pipeline = pipeline.with_leaf(leaf);
    }
    let mut follower = Follower::new(ViewSpec::default());
    let mut tracker = run.tracks.map(|most| Tracker::new(TrackOptions::new(TrackRule::Top(most))));
    let first = scene.points(run.points);
    let mut bare = (!run.alone).then(|| Bare::new(&first));
    let mut frames = Frames::default();
    // The first frame is loaded, and the tiles are built in the second.
    for (number, batch) in std::iter::once(first).chain((0..=run.frames).map(|_| Vec::new())).enumerate() {
        let batch = if number == 0 { batch } else { scene.points(run.replace) };
        let start = Instant::now();
        pipeline.feed_points(&batch, None);
        pipeline.commit(None);
        let step = pipeline.poll_step(&mut follower).ok_or("there is a new frame")?;
        let ours = start.elapsed();
        let start = Instant::now();
        let alive = tracker.as_mut().and_then(|tracker| pipeline.poll_tracks(tracker)).map(|step| step.alive.len());
        let tracking = start.elapsed();
        if run.check {
            pipeline.check(&follower)?;
        }
        let spade = bare.as_mut().filter(|_| number > 0).map(|bare| bare.replace(&batch, &run.scene));
        let filtering = filter.as_mut().map_or(Ok(0.0), |(cloud, filter)| filtering(cloud, filter, &batch))?;
        if number == 0 {
            frames.first = [ours, Duration::from_secs_f64(filtering)].map(|time| time.as_secs_f64() * 1e3);
        }
        if number < 2 {
            continue;
        }
        frames.filtering.push(filtering * 1e3);
        frames.ours.push(ours.as_secs_f64() * 1e3);
        frames.spade.push(spade.unwrap_or(f64::NAN) * 1e3);
        frames.tracking.push(tracking.as_secs_f64() * 1e3);
        frames.alive.push(alive.unwrap_or(0) as f64);
        frames.tiles.push(pipeline.tiles_reduced() as f64);
        let diff = step.diff;
        frames.changes.push((diff.tree_added.len() + diff.tree_removed.len() + diff.critical_set.len()) as f64);
    }
    let [ours, spade, tiles, changes, tracking, alive] =
        [&frames.ours, &frames.spade, &frames.tiles, &frames.changes, &frames.tracking, &frames.alive]
            .map(|list| median(list));
    let filtering = median(&frames.filtering);
    let [first, first_filtering] = frames.first;
    let declutter = filter.map(|(_, filter)| {
        json!({
            "ms": round(filtering), "share": round(filtering / ours), "filtered": filter.report().filtered,
            "first_ms": round(first_filtering), "first_frame_ms": round(first), "first_share": round(first_filtering / first),
        })
    });
    let tracks = run.tracks.map(|_| json!({ "alive": alive, "ms": round(tracking), "share": round(tracking / ours) }));
    println!(
        "{}",
        json!({
            "scene": run.scene, "points": run.points, "replaced": run.replace, "frames": run.frames, "threads": run.threads,
            "spade_ms": round(spade), "frame_ms": round(ours), "ratio": round(ours / spade), "rest_ms": round(ours - spade),
            "tiles_reduced": tiles, "edges_told": changes, "checked": run.check, "peak_mib": peak_mib(), "tracks": tracks,
            "declutter": declutter,
        })
    );
    Ok(())
}

/// The seconds in which a filter follows the points of a frame.
fn filtering(cloud: &mut Cloud, filter: &mut OutlierFilter, batch: &[Point]) -> Result<f64, Error> {
    for &[x, y] in batch {
        cloud.insert(x, y, None)?;
    }
    cloud.commit();
    let change = cloud.take_change();
    let start = Instant::now();
    filter.follow(cloud, &change);
    filter.report();
    Ok(start.elapsed().as_secs_f64())
}

/// The options of a run.
struct Run {
    scene: String,
    points: usize,
    replace: usize,
    frames: usize,
    threads: usize,
    leaf: Option<usize>,
    check: bool,
    alone: bool,
    tracks: Option<NonZeroU32>,
    declutter: bool,
}

impl Run {
    fn from_arguments(mut arguments: impl Iterator<Item = String>) -> Result<Self, Error> {
        let usage = "usage: live_frames sweep|spread|rings|drift|camera [--points N] [--replace N] [--frames N] [--threads N] [--leaf N] [--check] [--alone] [--tracks M] [--declutter]";
        let scene = arguments.next().ok_or(usage)?;
        let mut run = Self {
            scene,
            points: 100_000,
            replace: 1_000,
            frames: 100,
            threads: 1,
            leaf: None,
            check: false,
            alone: false,
            tracks: None,
            declutter: false,
        };
        let mut replace = None;
        while let Some(name) = arguments.next() {
            let mut number = || -> Result<usize, Error> { Ok(arguments.next().ok_or(usage)?.parse()?) };
            match name.as_str() {
                "--points" => run.points = number()?,
                "--replace" => replace = Some(number()?),
                "--frames" => run.frames = number()?,
                "--threads" => run.threads = number()?,
                "--leaf" => run.leaf = Some(number()?),
                "--check" => (run.check, run.alone) = (true, true),
                "--declutter" => run.declutter = true,
                "--alone" => run.alone = true,
                "--tracks" => run.tracks = Some(u32::try_from(number()?)?.try_into()?),
                _ => return Err(usage.into()),
            }
        }
        run.replace = match run.scene.as_str() {
            "camera" => run.points,
            "drift" => replace.unwrap_or(run.points / 100),
            "sweep" | "spread" | "rings" => replace.unwrap_or(run.replace),
            _ => return Err(usage.into()),
        };
        Ok(run)
    }
}

#[derive(Default)]
struct Frames {
    ours: Vec<f64>,
    spade: Vec<f64>,
    tiles: Vec<f64>,
    changes: Vec<f64>,
    tracking: Vec<f64>,
    alive: Vec<f64>,
    filtering: Vec<f64>,
    /// Milliseconds of the first frame, and of its filter.
    first: [f64; 2],
}

fn median(list: &[f64]) -> f64 {
    let mut list = list.to_vec();
    list.sort_by(f64::total_cmp);
    list.get(list.len() / 2).copied().unwrap_or(f64::NAN)
}

fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// The points, the same in every run.
struct Scene {
    kind: String,
    cloud: usize,
    next: usize,
    random: u64,
    /// Edge points of video frames.
    video: Vec<Vec<Point>>,
}

impl Scene {
    fn new(run: &Run) -> Result<Self, Error> {
        let mut video = Vec::new();
        if run.scene == "camera" {
            for line in
                std::fs::read_to_string("tests/data/bunny.jsonl")?.lines().filter(|line| line.contains("points"))
            {
                let line: serde_json::Value = serde_json::from_str(line)?;
                video.push(serde_json::from_value(line["points"].clone())?);
            }
        }
        Ok(Self { kind: run.scene.clone(), cloud: run.points, next: 0, random: 1, video })
    }

    /// SplitMix64: a seeded stream without a dependency.
    fn unit(&mut self) -> f64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.random ^ (self.random >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn points(&mut self, count: usize) -> Vec<Point> {
        if self.kind == "camera" {
            return self.picture(count);
        }
        (0..count).map(|_| self.point()).collect()
    }

    fn point(&mut self) -> Point {
        let number = self.next;
        self.next += 1;
        match self.kind.as_str() {
            "spread" => [self.unit(), self.unit()],
            // A scanner goes round ten rings, one after the other. After as many points as the cloud has, it starts
            // again.
            "sweep" => {
                let way = (number % self.cloud) as f64 / self.cloud as f64 * 10.0;
                self.on_ring(way as usize, way.fract(), [0.0; 2])
            }
            // A hundred rings, with points anywhere on any of them.
            "rings" => {
                let (ring, angle) = ((self.unit() * 100.0) as usize, self.unit());
                self.on_ring(ring, angle, [0.0; 2])
            }
            // Ten rings move independently. All points are replaced while a ring moves by one or two diameters.
            _ => {
                let (ring, angle, time) = (number % 10, self.unit(), number as f64 / self.cloud as f64);
                self.on_ring(ring, angle, [time * (ring as f64 - 4.0), time])
            }
        }
    }

    /// A point on a ring of radius 1 with noise of about 5%, at an angle in turns.
    fn on_ring(&mut self, ring: usize, angle: f64, moved: Point) -> Point {
        let radius = 1.0 + 0.1 * (self.unit() + self.unit() + self.unit() - 1.5);
        let (sin, cos) = (angle * TAU).sin_cos();
        [(ring % 4) as f64 * 3.0 + radius * cos + moved[0], (ring / 4) as f64 * 3.0 + radius * sin + moved[1]]
    }

    /// The next frame of the video, next to those after it until there are enough points.
    fn picture(&mut self, count: usize) -> Vec<Point> {
        self.next += 1;
        let frames = self.video.iter().cycle().skip(self.next).take(1 + count / 1000);
        let beside = |(column, frame): (usize, &Vec<Point>)| -> Vec<Point> {
            frame.iter().map(|[x, y]| [x + 500.0 * (column % 16) as f64, y + 300.0 * (column / 16) as f64]).collect()
        };
        frames.enumerate().flat_map(beside).take(count).collect()
    }
}

#[derive(Clone, Copy)]
struct Site {
    position: Point2<f64>,
    /// Its slot among the largest possible number of points.
    place: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

type Spade = DelaunayTriangulation<Site, (), (), (), LastUsedVertexHintGenerator>;

/// Plain `spade`, with the minimum that is needed to remove its oldest vertices.
struct Bare {
    spade: Spade,
    handles: Vec<FixedVertexHandle>,
    points: VecDeque<(Point, u32)>,
    next: usize,
}

impl Bare {
    fn new(points: &[Point]) -> Self {
        let sites: Vec<Site> = points.iter().zip(0..).map(|(&point, place)| site(point, place)).collect();
        let spade = Spade::bulk_load(sites).expect("valid positions");
        let mut handles = vec![FixedVertexHandle::from_index(0); 2 * points.len() + 1];
        spade.vertices().for_each(|vertex| handles[vertex.data().place as usize] = vertex.fix());
        Self { spade, handles, points: points.iter().copied().zip(0..).collect(), next: points.len() }
    }

    /// The seconds of the insertions and removals of one frame.
    fn replace(&mut self, batch: &[Point], scene: &str) -> f64 {
        if scene == "camera" {
            let sites: Vec<Site> = batch.iter().map(|&point| site(point, 0)).collect();
            let start = Instant::now();
            self.spade = Spade::bulk_load(sites).expect("valid positions");
            return start.elapsed().as_secs_f64();
        }
        let places = self.handles.len();
        let coming: Vec<(Point, u32)> =
            batch.iter().zip(self.next..).map(|(&point, number)| (point, (number % places) as u32)).collect();
        self.next += batch.len();
        let going: Vec<(Point, u32)> = self.points.drain(..batch.len()).collect();
        self.points.extend(&coming);
        let (in_order, out_order) = (order(&coming), order(&going));
        let start = Instant::now();
        for index in in_order {
            let (point, place) = coming[index];
            self.handles[place as usize] = self.spade.insert(site(point, place)).expect("valid positions");
        }
        for index in out_order {
            let handle = self.handles[going[index].1 as usize];
            self.spade.remove(handle);
            if let Some(moved) = self.spade.get_vertex(handle) {
                self.handles[moved.data().place as usize] = handle;
            }
        }
        start.elapsed().as_secs_f64()
    }
}

fn site([x, y]: Point, place: u32) -> Site {
    Site { position: Point2::new(x, y), place }
}

/// The order in which the library updates.
fn order(points: &[(Point, u32)]) -> Vec<usize> {
    let positions: Vec<Position> =
        points.iter().map(|&([x, y], _)| Position::new(x, y).expect("valid positions")).collect();
    along_curve(positions.iter().copied())
}

/// The process' peak of resident memory, where the system reports it. Plain `spade` is included.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? / 1024)
}
