//! Criterion benches of the core, each compared with plain `spade` on the same updates, which is the lower limit.
//!
//! Groups: `bulk` (the triangulation from scratch), `insert` and `remove` (1,000 points, one by one), `pass`
//! (filtration, reduction and skeleton of a given mesh), `frame` (points in memory to HoPeS_{1,1}; and 1,000 points
//! replaced anywhere, to the diff of it; `live_frames` has more of these). At n = 1e4 and 1e5, and 1e6 with
//! `HOPES_BENCH_LARGE=1`. Run: `cargo bench --bench pipeline`.

use std::hint::black_box;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hopes::topology::stages::{Basins, Delaunay, Filtration, Mesh};
use hopes::topology::{Cloud, Follower, Options, Pipeline, Skeleton, ViewSpec, Window};
use spade::{DelaunayTriangulation, LastUsedVertexHintGenerator, Point2, Triangulation};

type Spade = DelaunayTriangulation<Point2<f64>, (), (), (), LastUsedVertexHintGenerator>;

/// Points replaced in a frame.
const BATCH: usize = 1_000;

fn sizes() -> Vec<usize> {
    let large = std::env::var_os("HOPES_BENCH_LARGE").is_some();
    [10_000, 100_000, 1_000_000].into_iter().filter(|&n| large || n < 1_000_000).collect()
}

/// Uniform points of the unit square, the same in every run.
fn uniform(n: usize, seed: u64) -> Vec<[f64; 2]> {
    let mut state = seed;
    let mut next = || {
        // SplitMix64: a seeded stream without a dependency.
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..n).map(|_| [next(), next()]).collect()
}

fn sites(points: &[[f64; 2]]) -> Vec<Point2<f64>> {
    points.iter().map(|&[x, y]| Point2::new(x, y)).collect()
}

fn bare(points: &[[f64; 2]]) -> Spade {
    Spade::bulk_load(sites(points)).expect("valid positions")
}

fn cloud(points: &[[f64; 2]], window: Window) -> Cloud {
    let mut cloud = Cloud::new(window, None);
    for &[x, y] in points {
        cloud.insert(x, y, None).expect("valid positions");
    }
    cloud.commit();
    cloud
}

fn triangulated(points: &[[f64; 2]]) -> (Cloud, Delaunay) {
    let mut cloud = cloud(points, Window::All);
    let mut delaunay = Delaunay::default();
    let change = cloud.take_change();
    delaunay.apply(&cloud, &change);
    (cloud, delaunay)
}

fn bulk(c: &mut Criterion) {
    let mut group = c.benchmark_group("bulk");
    for n in sizes() {
        let points = uniform(n, 1);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_with_input(BenchmarkId::new("spade", n), &points, |b, points| {
            b.iter_batched(|| sites(points), Spade::bulk_load, BatchSize::LargeInput);
        });
        group.bench_with_input(BenchmarkId::new("hopes", n), &points, |b, points| {
            let fresh = || {
                let mut cloud = cloud(points, Window::All);
                let change = cloud.take_change();
                (cloud, change, Delaunay::default())
            };
            b.iter_batched_ref(fresh, |(cloud, change, delaunay)| delaunay.apply(cloud, change), BatchSize::LargeInput);
        });
    }
    group.finish();
}

/// One batch inserted into, or removed from, a triangulation of `n` points.
fn steps(c: &mut Criterion, name: &str, inserts: bool) {
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(BATCH as u64));
    for n in sizes() {
        let points = uniform(n, 1);
        let batch = if inserts { uniform(BATCH, 2) } else { points[..BATCH].to_vec() };
        group.bench_function(BenchmarkId::new("spade", n), |b| {
            let spade = bare(&points);
            let run = |mut spade: Spade| {
                for site in sites(&batch) {
                    if inserts {
                        spade.insert(site).expect("valid positions");
                    } else {
                        spade.locate_and_remove(site);
                    }
                }
                spade
            };
            b.iter_batched(|| spade.clone(), run, BatchSize::LargeInput);
        });
        group.bench_function(BenchmarkId::new("hopes", n), |b| {
            let (mut cloud, delaunay) = triangulated(&points);
            for &[x, y] in &batch {
                let done = if inserts { cloud.insert(x, y, None) } else { cloud.retract(x, y) };
                done.expect("valid positions");
            }
            cloud.commit();
            let change = cloud.take_change();
            let run = |mut delaunay: Delaunay| {
                delaunay.apply(&cloud, &change);
                delaunay
            };
            b.iter_batched(|| delaunay.clone(), run, BatchSize::LargeInput);
        });
    }
    group.finish();
}

fn insert(c: &mut Criterion) {
    steps(c, "insert", true);
}

fn remove(c: &mut Criterion) {
    steps(c, "remove", false);
}

fn pass(c: &mut Criterion) {
    let mut group = c.benchmark_group("pass");
    for n in sizes() {
        let (cloud, delaunay) = triangulated(&uniform(n, 1));
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("mesh", n), |b| b.iter(|| delaunay.mesh()));
        let mesh = delaunay.mesh();
        group.bench_function(BenchmarkId::new("filtration", n), |b| b.iter(|| Filtration::new(&mesh)));
        group.bench_function(BenchmarkId::new("skeleton", n), |b| b.iter(|| skeleton(&cloud, &mesh)));
    }
    group.finish();
}

/// All stages after the triangulation.
fn skeleton(cloud: &Cloud, mesh: &Mesh) -> Skeleton {
    let (basins, links) = Basins::contract(mesh, Filtration::new(mesh));
    Skeleton::new(cloud, mesh, &basins, links)
}

fn frame(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    for n in sizes() {
        let points = uniform(n, 1);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("from_scratch", n), |b| b.iter(|| from_scratch(&points)));
        group.bench_function(BenchmarkId::new("replace_1000", n), |b| {
            let window = Window::Points((n as u64).try_into().expect("not zero"));
            let mut pipeline = Pipeline::new(Options { window, ..Options::default() });
            let mut follower = Follower::new(ViewSpec::default());
            pipeline.feed_points(&points, None);
            pipeline.commit(None);
            pipeline.poll_step(&mut follower);
            let mut batches = (2..).map(|seed| uniform(BATCH, seed));
            b.iter(|| {
                let batch = batches.next().expect("there is always a next seed");
                pipeline.feed_points(&batch, None);
                pipeline.commit(None);
                black_box(pipeline.poll_step(&mut follower))
            });
        });
    }
    group.finish();
}

fn from_scratch(points: &[[f64; 2]]) -> usize {
    let mut pipeline = Pipeline::new(Options::default());
    pipeline.feed_points(points, None);
    pipeline.commit(None);
    pipeline.poll_frame().map_or(0, |frame| frame.view(ViewSpec::default()).cycles)
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = bulk, insert, remove, pass, frame
}
criterion_main!(benches);
