//! Criterion benches of edge detection on one core: a frame of 1280 x 720 pixels, made of twelve copies of a piece of a
//! film, and one of noise, with the paper's thresholds and with low ones.
//!
//! A camera of 60 frames a second leaves 16.7 ms for each. Run: `cargo bench --bench edges`.

use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hopes::edges::{Detector, Options, View};

const WIDTH: usize = 1280;
const HEIGHT: usize = 720;

/// Copies of a piece of a film, in rows and columns.
fn film() -> Vec<u8> {
    let file = File::open("tests/data/edges/bunny-gray.png").expect("it is part of the project");
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().expect("it is a PNG");
    let mut piece = vec![0; reader.output_buffer_size().expect("it is small")];
    reader.next_frame(&mut piece).expect("it is whole");
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    (0..WIDTH * HEIGHT).map(|at| piece[(at / WIDTH % height) * width + at % WIDTH % width]).collect()
}

/// Every run of pixels is different. This is the worst case.
fn noise() -> Vec<u8> {
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..WIDTH * HEIGHT).map(|_| next()).collect()
}

fn edges(c: &mut Criterion) {
    let mut group = c.benchmark_group("edges");
    group.throughput(Throughput::Elements((WIDTH * HEIGHT) as u64));
    let paper = Options::default();
    let settings = [
        ("150-450", paper),
        ("30-90", Options { low: 30.0, high: 90.0, blur: None }),
        ("blur 1.4, 30-90", Options { low: 30.0, high: 90.0, blur: Some(1.4) }),
    ];
    for (picture, pixels) in [("film", film()), ("noise", noise())] {
        let view = View::new(&pixels, WIDTH as u32, HEIGHT as u32).expect("all pixels are there");
        for (name, options) in settings {
            let mut detector = Detector::new(options).expect("the options make sense");
            group.bench_function(BenchmarkId::new(picture, name), |b| b.iter(|| black_box(detector.edges(view).len())));
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30);
    targets = edges
}
criterion_main!(benches);
