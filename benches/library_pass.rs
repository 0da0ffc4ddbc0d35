//! Times the library on one cloud: from points in memory to all dots, the tree, HoPeS and HoPeS_{1,1}, on one thread or
//! several.
//!
//! In: a file of little-endian doubles, x and y in turn. Out: one line of JSON on stdout with the seconds of each
//! repetition: the whole, its stages, and `spade`'s own bulk load of the same cloud in the same run. `benches/peers.py`
//! calls it.
//!
//! `cargo run --release --example library_pass -- cloud.bin --repeat 5 --threads 2`

use std::time::Instant;

use hopes::topology::stages::{Basins, Delaunay, Filtration};
use hopes::topology::{Cloud, Options, Pipeline, Skeleton, ViewSpec, Window};
use serde_json::json;
use spade::{DelaunayTriangulation, Point2, Triangulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("usage: library_pass FILE [--repeat N] [--threads N]")?;
    let (mut repeat, mut threads) = (1, 1);
    while let Some(option) = arguments.next() {
        let number = arguments.next().ok_or("an option needs a number")?.parse::<usize>()?;
        match option.as_str() {
            "--repeat" => repeat = number,
            "--threads" => threads = number,
            other => return Err(format!("there is no option {other}").into()),
        }
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    let points = read(&std::fs::read(file)?);
    let rounds: Vec<Round> = (0..repeat).map(|_| round(&points)).collect();
    let column = |of: fn(&Round) -> f64| rounds.iter().map(of).collect::<Vec<f64>>();
    let last = rounds.last().ok_or("--repeat must be at least 1")?;
    println!(
        "{}",
        json!({
            "points": last.skeleton.vertices().len(),
            "dots": last.skeleton.dots().len(),
            "clear_dots": last.skeleton.dots().iter().filter(|dot| dot.persistence() > 1e-9 * dot.death).count(),
            "persistence_sum": last.skeleton.dots().iter().map(|dot| dot.persistence()).sum::<f64>(),
            "mst_length": last.skeleton.tree_length(),
            "seconds": column(|round| round.whole),
            "bulk_seconds": column(|round| round.bare_spade),
            "triangulation_seconds": column(|round| round.stages[1]),
            "rest_seconds": column(|round| round.stages[2..].iter().sum()),
            "stage_seconds": {
                "cloud": column(|round| round.stages[0]),
                "delaunay": column(|round| round.stages[1]),
                "mesh": column(|round| round.stages[2]),
                "filtration": column(|round| round.stages[3]),
                "basins": column(|round| round.stages[4]),
                "skeleton": column(|round| round.stages[5]),
                "view": column(|round| round.stages[6]),
            },
            "peak_rss_bytes": peak_rss(),
        })
    );
    Ok(())
}

fn read(bytes: &[u8]) -> Vec<[f64; 2]> {
    let double = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
    bytes.chunks_exact(16).map(|pair| [double(&pair[..8]), double(&pair[8..])]).collect()
}

struct Round {
    whole: f64,
    bare_spade: f64,
    stages: [f64; 7],
    skeleton: Skeleton,
}

fn round(points: &[[f64; 2]]) -> Round {
    // As for its peers, the time ends with the answer in memory, before anything is freed.
    let (whole, _) = timed(|| {
        let mut pipeline = Pipeline::new(Options::default());
        pipeline.feed_points(points, None);
        pipeline.commit(None);
        let frame = pipeline.poll_frame().expect("a frame was committed");
        let view = frame.view(ViewSpec::default());
        (pipeline, frame, view)
    });
    let sites: Vec<Point2<f64>> = points.iter().map(|&[x, y]| Point2::new(x, y)).collect();
    let (bare_spade, _) = timed(|| DelaunayTriangulation::<Point2<f64>>::bulk_load(sites).expect("valid positions"));
    let (stages, skeleton) = stages(points);
    Round { whole, bare_spade, stages, skeleton }
}

/// The pipeline's stages one by one, in the pipeline's order.
fn stages(points: &[[f64; 2]]) -> ([f64; 7], Skeleton) {
    let (cloud_seconds, (cloud, change)) = timed(|| {
        let mut cloud = Cloud::new(Window::All, None);
        cloud.reserve(points.len());
        for &[x, y] in points {
            cloud.insert(x, y, None).expect("valid positions");
        }
        cloud.commit();
        let change = cloud.take_change();
        (cloud, change)
    });
    let mut delaunay = Delaunay::default();
    let (delaunay_seconds, _) = timed(|| delaunay.apply(&cloud, &change));
    let (mesh_seconds, mesh) = timed(|| delaunay.mesh());
    let (filtration_seconds, filtration) = timed(|| Filtration::new(&mesh));
    let (basins_seconds, (basins, links)) = timed(|| Basins::contract(&mesh, filtration));
    let (skeleton_seconds, skeleton) = timed(|| Skeleton::new(&cloud, &mesh, &basins, links));
    let (view_seconds, _) = timed(|| hopes::topology::View::new(&skeleton, ViewSpec::default()));
    let seconds = [
        cloud_seconds,
        delaunay_seconds,
        mesh_seconds,
        filtration_seconds,
        basins_seconds,
        skeleton_seconds,
        view_seconds,
    ];
    (seconds, skeleton)
}

fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = run();
    (start.elapsed().as_secs_f64(), result)
}

/// The process' peak of resident memory, where the system reports it.
fn peak_rss() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}
