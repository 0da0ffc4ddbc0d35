//! `hopes edges` as a process: compared with OpenCV, in every format, and on invalid input.

mod common;
#[path = "edges/delivery.rs"]
mod delivery;
#[path = "edges/golden.rs"]
mod golden;
#[path = "edges/hostile.rs"]
mod hostile;
#[path = "edges/video.rs"]
mod video;

use std::path::Path;

use common::process::{Hopes, hopes};
use rustix::process::Signal;
use serde_json::Value;

/// A gray picture.
#[derive(Clone)]
struct Gray {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

impl Gray {
    /// Black left of a column, and this gray from the column on.
    fn step(width: u32, height: u32, column: u32, gray: u8) -> Self {
        let pixels = (0..width * height).map(|at| if at % width < column { 0 } else { gray }).collect();
        Self { width, height, pixels }
    }

    fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&self.pixels).unwrap();
        writer.finish().unwrap();
        bytes
    }
}

/// A folder with files in it.
fn folder(files: &[(&str, Vec<u8>)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn edges(input: impl AsRef<Path>, arguments: &str) -> Hopes {
    hopes("edges").with(input.as_ref()).and(arguments)
}

/// Points of text, frame by frame.
fn frames(text: &str) -> Vec<Vec<[u32; 2]>> {
    let (mut frames, mut points) = (Vec::new(), Vec::new());
    for line in text.lines() {
        match line.split_once(',') {
            Some((x, y)) => points.push([x.parse().unwrap(), y.parse().unwrap()]),
            None => {
                assert_eq!(line, "");
                frames.push(std::mem::take(&mut points));
            }
        }
    }
    assert_eq!(points, [[0; 2]; 0], "every frame is closed");
    frames
}

/// A column of points, from the top row down; y is up.
fn column(x: u32, rows: std::ops::Range<u32>) -> Vec<[u32; 2]> {
    rows.rev().map(|y| [x, y]).collect()
}

fn without_times(lines: &str) -> Vec<Value> {
    let value = |line| {
        let mut value: Value = serde_json::from_str(line).unwrap();
        value["time"] = Value::Null;
        value
    };
    lines.lines().map(value).collect()
}

#[test]
fn a_folder_gives_one_frame_for_each_picture_in_numeric_order() {
    let pictures = [("f10.PNG", 9), ("f9.png", 5), ("f1.png", 2)];
    let folder = folder(&pictures.map(|(name, at)| (name, Gray::step(12, 3, at, 200).png())));
    std::fs::write(folder.path().join("notes.txt"), "no picture").unwrap();
    let text = edges(folder.path(), "").runs().text();
    assert_eq!(frames(&text), [column(1, 0..3), column(4, 0..3), column(8, 0..3)]);
    let single = edges(folder.path().join("f9.png"), "").with(folder.path().join("f1.png")).runs().text();
    assert_eq!(frames(&single), [column(4, 0..3), column(1, 0..3)], "as they are named");
    assert_eq!(frames(&hopes("edges -").reads(Gray::step(12, 3, 5, 200).png()).text()), [column(4, 0..3)]);
}

#[test]
fn all_formats_give_the_same_points() {
    let folder = Path::new("tests/data/edges/coins.png");
    let skeleton = |form: &str| {
        let points = edges(folder, "--rate 50 --format").and(form).with(folder).runs().out();
        let points = hopes("serve --window frames:1 --full --input").and(form).reads(points).text();
        without_times(&points)
    };
    let text = skeleton("text");
    assert_eq!((text.len(), &text[0]["points"], &text[1]["points"]), (2, &Value::from(2093), &Value::from(2093)));
    assert_eq!(skeleton("jsonl"), text);
    assert_eq!(skeleton("bin"), text);
}

#[test]
fn a_rate_sets_times_and_pace() {
    let folder =
        folder(&[1, 2, 3].map(|at| (["a.png", "b.png", "c.png"][at as usize - 1], Gray::step(9, 2, at, 250).png())));
    let begun = std::time::Instant::now();
    let lines = edges(folder.path(), "--rate 8 --format jsonl").runs().text();
    let expected = "\
{\"points\":[[0,1],[0,0]]}\n{\"commit\":true,\"time\":0.0}
{\"points\":[[1,1],[1,0]]}\n{\"commit\":true,\"time\":0.125}
{\"points\":[[2,1],[2,0]]}\n{\"commit\":true,\"time\":0.25}
";
    assert_eq!(lines, expected);
    assert!(begun.elapsed().as_millis() >= 250, "{:?}", begun.elapsed());
    assert!(!edges(folder.path(), "--format jsonl").runs().text().contains("time"));
}

#[test]
fn a_part_keeps_its_coordinates_and_y_is_up_or_down() {
    let folder = folder(&[("a.png", Gray::step(20, 10, 8, 200).png())]);
    let path = folder.path().join("a.png");
    let found = |arguments: &str| frames(&edges(&path, arguments).runs().text()).remove(0);
    assert_eq!(found("--roi 5,2,6,3"), column(7, 5..8));
    assert_eq!(found("--roi 5,2,6,3 --y-up"), column(7, 5..8), "as it was asked for before");
    assert_eq!(found("--roi 5,2,6,3 --y-down"), [[7, 2], [7, 3], [7, 4]]);
    assert_eq!(found("--roi 8,2,6,3"), [[0; 2]; 0]);
    edges(&path, "--roi 15,0,6,3")
        .runs()
        .fails(1, &["a.png: the part of 6 x 3 pixels from 15,0 reaches beyond", "20 x 10"]);
}

#[test]
fn thresholds_and_blur_are_used() {
    // A step of 100 has a gradient of 400.
    let folder = folder(&[("a.png", Gray::step(40, 8, 20, 100).png())]);
    let count = |arguments: &str| frames(&edges(folder.path(), arguments).runs().text())[0].len();
    assert_eq!(["", "--low 100", "--low 100 --ratio 4", "--high 399.5", "--high 400"].map(count), [0, 8, 0, 8, 0]);
    assert_eq!(["--low 50 --blur 0.5", "--low 50 --blur 20"].map(count), [8, 0]);
}

#[test]
fn invalid_arguments_are_wrong_usage() {
    for (arguments, words) in [
        ("", "<INPUT>"),
        ("- -", "stdin cannot be read twice"),
        ("- --input gray", "--size WxH"),
        ("- --input y4m --size 3x3", "say their size themselves"),
        ("- --size 0x5", "1 to 67108864 pixels"),
        ("- --size 5", "write WxH"),
        ("- --size 99999x99999", "1 to 67108864 pixels"),
        ("- --low -1", "-1 is not a threshold"),
        ("- --low=-1", "-1 is not a threshold"),
        ("- --ratio 0.5", "1 or more"),
        ("- --ratio 2 --high 5", "cannot be used with"),
        ("- --blur 0", "0 is not a standard deviation"),
        ("- --blur 101", "101 is not a standard deviation"),
        ("- --roi 1,2,3", "write X,Y,W,H"),
        ("- --roi 1,2,3,0", "write X,Y,W,H"),
        ("- --rate 0", "above 0"),
        ("- --stream cam", "--to"),
        ("- --to unix:x --format bin", "cannot be used with"),
        ("- --to unix:x -o y", "cannot be used with"),
    ] {
        hopes("edges").and(arguments).runs().fails(2, &[words]);
    }
    hopes("edges tests/data/none.png").runs().fails(1, &["cannot open tests/data/none.png", "No such file"]);
    let empty = tempfile::tempdir().unwrap();
    edges(empty.path(), "").runs().fails(1, &["there is no picture in", ".jpeg"]);
    edges(Path::new("tests/data/edges/text.png"), "-o x.pdf").runs().fails(2, &["x.pdf", ".csv, .txt, .jsonl"]);
    edges(Path::new("tests/data/edges/text.png"), "-o /none/x").runs().fails(1, &["cannot write /none/x"]);
}

#[test]
fn a_signal_ends_after_a_whole_frame_and_a_closed_pipe_is_no_error() {
    let mut running = edges(Path::new("tests/data/edges"), "--rate 2").start();
    running.line().expect("the first frame comes");
    running.signal(Signal::INT);
    let finished = running.finish();
    assert!(finished.err.contains("SIGINT: stopped after"), "{}", finished.err);
    let text = finished.text();
    assert!(text.ends_with("\n\n"), "{:?}", &text[text.len().saturating_sub(20)..]);
    assert!(frames(&text).len() < 10);
    // A process that waits for more video can be stopped too.
    let mut waiting = hopes("edges -").start();
    waiting.say("YUV4MPEG2 W1 H1 Cmono\nFRAME\n.");
    assert_eq!(waiting.line().as_deref(), Some(""), "a pixel has no edge");
    waiting.signal(Signal::TERM);
    assert_eq!(waiting.ends().code, Some(0));
    let mut running = edges(Path::new("tests/data/edges"), "").start();
    drop(running.take_stdout());
    let finished = running.ends();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
}

#[test]
fn the_output_may_go_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points");
    let picture = Path::new("tests/data/edges/text.png");
    assert_eq!(edges(picture, "-o").with(&path).runs().text(), "");
    assert_eq!(std::fs::read(&path).unwrap(), edges(picture, "").runs().out());
    for (name, form) in [("a.CSV", "text"), ("b.jsonl", "jsonl"), ("c.hopes", "bin")] {
        let path = folder.path().join(name);
        assert_eq!(edges(picture, "-o").with(&path).runs().text(), "");
        let expected = edges(picture, "--format").and(form).runs().out();
        assert!(std::fs::read(&path).unwrap() == expected, "the suffix of {name} chooses {form}");
    }
}
