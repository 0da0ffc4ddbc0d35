//! Files of other programs, as processes: those that are read give the answer that is known, and all others say in one
//! line what they are and what makes points of them.
//!
//! `tests/data/foreign` holds a ring in every format that is read: 24 points on a circle of radius 10, so the right
//! answer is one dot, of birth 10 sin(pi/24) and death 10. Other programs wrote it, as `make.py` there says.

mod common;

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::process::hopes;
use serde_json::Value;

/// Each file, and what its numbers are exact to.
const RINGS: [(&str, f64); 18] = [
    ("ring.npy", 1e-12),
    ("fortran.npy", 1e-12),
    ("big_endian_f4.npy", 1e-5),
    ("records.npy", 1e-5),
    ("ring.npy.gz", 1e-12),
    ("ring.csv.gz", 1e-12),
    ("ascii.ply", 1e-5),
    ("little_endian.ply", 1e-5),
    ("big_endian.ply", 1e-5),
    ("ascii.pcd", 1e-5),
    ("binary.pcd", 1e-5),
    ("compressed.pcd", 1e-5),
    ("ring.geojson", 1e-5),
    ("lines.geojsonl", 1e-5),
    ("array.json", 1e-12),
    ("pretty.json", 1e-12),
    ("utf16.csv", 1e-12),
    // Rounded to a thousandth, and in thousandths.
    ("integers.npy", 1.0),
];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/foreign").join(name)
}

fn assert_ring(name: &str, out: &[u8], tolerance: f64) {
    let scale = if name == "integers.npy" { 1000.0 } else { 1.0 };
    let reply: Value = serde_json::from_slice(out).unwrap();
    let [dot] = &reply["dots"].as_array().unwrap()[..] else { panic!("{name}: {reply}") };
    for (key, expected) in [("birth", 10.0 * scale * (PI / 24.0).sin()), ("death", 10.0 * scale)] {
        let found = dot[key].as_f64().unwrap();
        assert!((found - expected).abs() < tolerance, "{name}: {key} {found}, expected {expected}");
    }
    assert_eq!(reply["rejected"], 0, "{name}");
}

#[test]
fn compute_reads_every_format_by_its_name_and_from_a_pipe() {
    for (name, tolerance) in RINGS {
        let named = hopes("compute --strict").with(data(name)).runs();
        assert_eq!(named.code, Some(0), "{name}: {}", named.err);
        assert_ring(name, &named.out, tolerance);
        let piped = hopes("compute --strict -").reads(fs::read(data(name)).unwrap());
        assert_eq!(piped.code, Some(0), "{name}: {}", piped.err);
        assert_eq!(piped.out, named.out, "{name}");
    }
}

#[test]
fn serve_reads_every_format() {
    for (name, _) in RINGS {
        let finished = hopes("serve --strict").reads(fs::read(data(name)).unwrap());
        assert_eq!(finished.code, Some(0), "{name}: {}", finished.err);
        let frame: Value = serde_json::from_slice(&finished.out).unwrap();
        assert_eq!((frame["points"].as_u64(), frame["view"]["cycles"].as_u64()), (Some(24), Some(1)), "{name}");
    }
}

/// A column that the file names so is the event time, where the window asks for one.
#[test]
fn event_times_in_a_file_are_used() {
    // The stamps are 100 to 123.
    for name in ["ascii.pcd", "binary.pcd", "compressed.pcd"] {
        let out = hopes("serve --window time:3").reads(fs::read(data(name)).unwrap()).text();
        let frame: Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
        assert_eq!((frame["points"].as_u64(), frame["time"].as_f64()), (Some(4), Some(123.0)), "{name}");
    }
}

#[test]
fn what_is_read_of_a_file_is_told_once() {
    let told = |name: &str| hopes("compute").with(data(name)).runs().err;
    for (name, words) in [
        ("ring.geojson", "ring.geojson: GeoJSON: x is longitude, y is latitude, in degrees"),
        (
            "fortran.npy",
            "fortran.npy: an NPY array of shape (24, 3): x is column 1, y is column 2; the others are not read",
        ),
        ("ascii.ply", "ascii.ply: a PLY file: x is the property \"x\", y is \"y\""),
        ("binary.pcd", "binary.pcd: a PCD file: x is the field \"x\", y is \"y\""),
    ] {
        assert_eq!(told(name).matches(words).count(), 1, "{name}: {}", told(name));
    }
}

#[test]
fn a_file_that_is_cut_short_gives_what_came_and_says_what_is_missing() {
    for (name, removed, words) in [
        ("ring.npy", 40, "the file is cut short: 3 of 24 points are missing, after point 21"),
        ("binary.pcd", 1, "the file is cut short: 1 of 24 points are missing, after point 23"),
        ("little_endian.ply", 1, "elements \"face\" are missing"),
        ("ring.csv.gz", 60, "the gzip data end in the middle, at byte "),
        ("array.json", 2, "the text ends"),
        ("ring.geojson", 9, "nothing after it was read"),
    ] {
        let mut bytes = fs::read(data(name)).unwrap();
        bytes.truncate(bytes.len() - removed);
        let finished = hopes("compute -").reads(&bytes);
        assert_eq!(finished.code, Some(0), "{name}: {}", finished.err);
        assert!(finished.err.contains(words), "{name}: {}", finished.err);
        let reply: Value = serde_json::from_slice(&finished.out).unwrap();
        assert!(reply["points"].as_u64().unwrap() >= 12 && reply["rejected"] == 1, "{name}: {reply}");
        assert_eq!(hopes("compute --strict -").reads(&bytes).code, Some(3), "{name}");
        assert_eq!(hopes("serve --strict").reads(&bytes).code, Some(3), "{name}");
    }
}

/// A refused point is named by its number in the file, not by a line.
#[test]
fn refused_points_are_named_by_what_the_file_has() {
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)}";
    let values = [1.0_f64, 2.0, f64::NAN, 4.0];
    let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let npy = [&b"\x93NUMPY\x01\x00"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes(), &values].concat();
    for command in ["compute -", "serve"] {
        let finished = hopes(command).reads(&npy);
        assert!(finished.err.contains("point 2, point (NaN, 4): "), "{command}: {}", finished.err);
        let finished = hopes(command).reads("[[1,2],\n[3,null],\n[5,6]]\n");
        assert!(finished.err.contains("element 2, point (3, NaN): "), "{command}: {}", finished.err);
    }
}

/// One line that says what it is, and the exit code of a failure. Of `serve`, its stream says so too.
#[test]
fn other_files_are_refused_in_one_line() {
    let cases: [(&[u8], &str, &str); 12] = [
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "a PNG or JPEG picture", "hopes edges FILE"),
        (b"OFF\n3 1 0\n0 0 0\n", "an OFF file", "awk"),
        (b"v 0 0 0\nv 1 0 0\n", "an OBJ file", "awk"),
        (b"LASF\0\0\0\0", "a LAS or LAZ file", "laspy"),
        (b"PAR1\x15\x04\x15", "a Parquet file", "read_parquet"),
        (b"%PDF-1.7\n", "a PDF document", "pdftoppm"),
        (b"\0\0\0\x20ftypisom", "a video", "ffmpeg"),
        (b"\x28\xb5\x2f\xfd\0", "compressed by zstd", "zstd -dc FILE"),
        (b"HOPES\r\n\x1a\x01\0\x01\0", "in the binary form of hopes", "hopes replay FILE"),
        (b"1\0,\x002\0\n\0", "UTF-16 text without a byte-order mark", "iconv -f UTF-16LE"),
        (b"POINT(1 2)\nPOINT(3 4)\n", "well-known text (WKT)", "grep"),
        (b"<?xml version=\"1.0\"?><gpx></gpx>\n", "a GPX file", "ogr2ogr"),
    ];
    for (bytes, what, command) in cases {
        // `compute` reads pictures by their edges.
        let programs = if bytes.starts_with(b"\x89PNG") { &["serve"][..] } else { &["compute -", "serve"] };
        for &program in programs {
            let finished = hopes(program).reads(bytes);
            let said: Vec<&str> = finished.err.lines().filter(|line| line.contains("this is ")).collect();
            assert_eq!(finished.code, Some(1), "{program}, {what}: {}", finished.err);
            let most = if program == "serve" { 2 } else { 1 };
            assert!(
                (1..=most).contains(&said.len()) && said[0].contains(what) && said[0].contains(command),
                "{}",
                finished.err
            );
            assert!(!finished.err.contains("WARN"), "{}", finished.err);
        }
    }
}

/// The commands in refusals that need only common programs do what they say.
#[test]
fn commands_in_refusals_make_the_points() {
    let directory = tempfile::tempdir().unwrap();
    let cases: [(&str, &[u8], &str); 9] = [
        ("a.off", b"OFF # a model\n# of 3\n3 1 0\n1 2 0\n\n3 4 0\n5 6 0\n3 0 1 2\n", "1 2\n3 4\n5 6\n"),
        ("n.off", b"nOFF\n2\n3 0 0\n1 2\n3 4\n5 6\n", "1 2\n3 4\n5 6\n"),
        ("b.off", b"OFF 3 1 0\n1 2 0\n3 4 0\n5 6 0\n3 0 1 2\n", "1 2\n3 4\n5 6\n"),
        ("a.obj", b"mtllib a.mtl\nv 1 2 0\nvn 0 0 1\nv 3 4 0 1\nf 1 2 3\n", "1 2\n3 4\n"),
        ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 1 2 0\nvertex 3 4 0\n", "1 2\n3 4\n"),
        ("a.wkt", b"POINT (1 2)\nLINESTRING(3 4, 5e1 -6.5)\n", "1 2\n3 4\n5e1 -6.5\n"),
        ("le.csv", b"1\0,\x002\0\n\0", "1,2\n"),
        ("be.csv", b"\x001\0,\x002\0\n", "1,2\n"),
        ("utf32.csv", b"\xff\xfe\0\x001\0\0\0,\0\0\x002\0\0\0\n\0\0\0", "1,2\n"),
    ];
    for (name, bytes, points) in cases {
        let path = directory.path().join(name);
        fs::write(&path, bytes).unwrap();
        let err = hopes("compute").with(&path).runs().err;
        let command = err.lines().next().unwrap().rsplit_once("it: ").or_else(|| err.split_once("vertices: "));
        let command = command.or_else(|| err.split_once("numbers: ")).unwrap().1;
        let command = command.split(" | hopes").next().unwrap().replace("FILE", &path.display().to_string());
        let made = Command::new("sh").args(["-c", &command]).stderr(Stdio::inherit()).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&made.stdout), points, "{command}");
    }
}
