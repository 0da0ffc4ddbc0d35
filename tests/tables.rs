//! Tables and JSON lines as people have them, as processes: what goes in is what was meant, or is reported.
//!
//! The same ring is written in every way that a table may have: 24 points on a circle of radius 10, so that the right
//! answer is one dot, of birth 10 sin(pi/24) and death 10. What cannot be read must be said, with the exit code.

mod common;

use std::f64::consts::PI;
use std::fs;

use common::process::{Hopes, hopes};
use serde_json::Value;

/// Points on a circle of radius 10 around a centre.
fn ring(center: [f64; 2]) -> Vec<[f64; 2]> {
    let angles = (0..24).map(|index| f64::from(index) * PI / 12.0);
    angles.map(|angle| [center[0] + 10.0 * angle.cos(), center[1] + 10.0 * angle.sin()]).collect()
}

/// The lines of a file, each of a number and a point.
fn lines(write: impl Fn(usize, [f64; 2]) -> String) -> String {
    ring([3.0, 40.0]).into_iter().enumerate().map(|(index, point)| write(index, point)).collect()
}

fn dots(output: &str) -> Vec<(f64, f64)> {
    let reply: Value = serde_json::from_str(output).unwrap();
    let number = |dot: &Value, name: &str| dot[name].as_f64().unwrap();
    reply["dots"].as_array().unwrap().iter().map(|dot| (number(dot, "birth"), number(dot, "death"))).collect()
}

fn assert_ring(what: &str, program: &Hopes, input: &str) {
    let finished = program.reads(input);
    let (out, err) = (String::from_utf8(finished.out.clone()).unwrap(), finished.err.clone());
    assert_eq!(finished.code, Some(0), "{what}: {err}");
    let warned = err.lines().any(|line| line.contains("WARN") && !line.contains("has degrees"));
    assert!(!warned, "{what}: {err}");
    let [(birth, death)] = dots(&out)[..] else { panic!("{what}: {out}") };
    assert!((birth - 10.0 * (PI / 24.0).sin()).abs() < 1e-9 && (death - 10.0).abs() < 1e-9, "{what}: {birth} {death}");
}

/// Ways to write the ring.
fn rings() -> Vec<(&'static str, String)> {
    let comma = |number: f64| number.to_string().replace('.', ",");
    let body = lines(|_, [x, y]| format!("{x},{y}\n"));
    vec![
        ("bare", body.clone()),
        ("CR line ends", body.replace('\n', "\r")),
        ("CR LF line ends", body.replace('\n', "\r\n")),
        ("a header", format!("x,y\n{body}")),
        ("a header of names that say nothing", format!("a,b\n{body}")),
        ("a mark and a header in quotes", format!("\u{feff}\"X\",\"Y\"\n{body}")),
        ("an index", format!(",x,y\n{}", lines(|index, [x, y]| format!("{index},{x},{y}\n")))),
        ("an index with a mark", format!("id,x,y\n{}", lines(|index, [x, y]| format!("#{index},{x},{y}\n")))),
        (
            "an index beside other names",
            format!("\"\",\"V1\",\"V2\"\n{}", lines(|index, [x, y]| format!("\"{index}\",{x},{y}\n"))),
        ),
        ("an index beside numbers", format!(",0,1\n{}", lines(|index, [x, y]| format!("{index},{x},{y}\n")))),
        ("times first", format!("time,x,y\n{}", lines(|index, [x, y]| format!("{index},{x},{y}\n")))),
        ("latitude first", format!("name;lat;lon\n{}", lines(|_, [x, y]| format!("a b;{y};{x}\n")))),
        ("words", format!("Latitude\tLongitude\n{}", lines(|_, [x, y]| format!("{y}\t{x}\n")))),
        ("units", format!("Y [m], X [m]\n{}", lines(|_, [x, y]| format!("{y}, {x}\n")))),
        ("northing first", format!("northing_m easting_m\n{}", lines(|_, [x, y]| format!("{y} {x}\n")))),
        ("a header behind a mark", format!("# z y x\n{}", lines(|index, [x, y]| format!("{index} {y} {x}\n")))),
        ("decimal commas", lines(|_, [x, y]| format!("{};{}\n", comma(x), comma(y)))),
        ("decimal commas and blanks", format!("x y\n{}", lines(|_, [x, y]| format!("{}  {}\n", comma(x), comma(y))))),
        ("blanks and exponents", lines(|_, [x, y]| format!(" {x:.18e}  {y:.18e}\n"))),
        ("JSON lines", lines(|_, [x, y]| format!("[{x},{y}]\n"))),
        ("JSON lines with CR", lines(|_, [x, y]| format!("{{\"x\":{x},\"y\":{y}}}\r"))),
    ]
}

#[test]
fn a_ring_is_a_ring_however_it_is_written() {
    for (what, input) in rings() {
        assert_ring(what, &hopes("compute - --strict"), &input);
    }
    let header = format!("a,b,c\n{}", lines(|index, [x, y]| format!("{y},{index},{x}\n")));
    assert_ring("chosen columns", &hopes("compute - --strict --columns c,a"), &header);
    let marks = lines(|index, [x, y]| format!("#{index},{x},{y}\n"));
    assert_ring("marks", &hopes("compute - --strict --columns 2,3"), &marks);
}

/// `serve` reads the same without being told the format.
#[test]
fn serve_takes_every_form_as_it_is() {
    for (what, input) in rings() {
        let finished = hopes("serve --strict").reads(&input);
        assert_eq!(finished.code, Some(0), "{what}: {}", finished.err);
        let frame: Value = serde_json::from_slice(&finished.out).unwrap();
        assert_eq!((frame["points"].as_u64(), frame["view"]["cycles"].as_u64()), (Some(24), Some(1)), "{what}");
    }
}

/// The header's time dates the points where the window asks for times, and is left alone elsewhere.
#[test]
fn a_window_of_time_takes_the_times_that_the_header_names() {
    let points = |arguments: &str, input: &str| -> u64 {
        let out = hopes("serve").and(arguments).reads(input).text();
        let last: Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
        last["points"].as_u64().unwrap()
    };
    let input = "stamp,x,y\n0,0,0\n1,1,1\n4,2,2\n8,3,3\n9,4,4\n";
    assert_eq!(points("--window time:5", input), 3);
    assert_eq!(points("--window time:4s", input), 2);
    assert_eq!(points("--window time:1m", input), 5);
    assert_eq!(points("--window points:3", input), 3);
    let iso = "timestamp,x,y\n2026-11-29T12:00:00Z,0,0\n2026-11-29 12:00:04,1,1\n2026-11-29T13:00:08+01:00,2,2\n";
    assert_eq!(points("--window time:5s", iso), 2);
    let json = "[0,0,\"2026-11-29T12:00:00Z\"]\n[1,1,\"2026-11-29T12:00:02Z\"]\n\
                {\"x\":2,\"y\":2,\"timestamp\":\"2026-11-29T12:00:04Z\"}\n";
    assert_eq!(points("--window time:3s", json), 2);
}

/// Input that must be reported: what stands in the log, and the exit code without `--strict`. With it, it is 3.
const REPORTED: [(&str, &[&str], i32); 16] = [
    ("1|2\n3|4\n", &["line 1, column 1: \"1|2\"", "line 2"], 1),
    ("The title\nx,y\n1,2\n", &["line 1, column 1: \"The\""], 0),
    ("x,y\n", &["line 1: this header has no rows"], 1),
    ("a,b\n1,2,3\n4,5,6\n", &["line 1, column 1: \"a\""], 0),
    ("x,y\n1,2,3\n4,5\n", &["line 2: 3 columns, and the header has 2"], 0),
    ("x,y\n1,2\n3,4,5,6\n", &["line 3: 4 columns, and the header has 2"], 0),
    ("1,2\nx,y\n3,4\n", &["line 2, column 1: \"x\""], 0),
    ("[1,2]\n3,4\n", &["line 2: \"3,4\" is neither an array nor an object"], 0),
    ("\"60,000\",1\n2,3\n", &["write \"60.000\" if it is decimal, \"60000\" if it marks thousands"], 0),
    ("1;2\n1.234,5;3\n", &["line 2, column 1: \"1.234,5\" has marks of thousands: write \"1234.5\""], 0),
    ("1,2\n\u{2212}3,4\n", &["line 2, column 1", "a minus sign that is no hyphen: write \"-3\""], 0),
    ("{\"points\":[[1,2],[null,4],[5,6]]}\n", &["line 1, point (NaN, 4): x = NaN is not a finite number"], 0),
    ("{\"points\":[[1,2],[3,Infinity],[5,6]]}\n", &["line 1, point (3, inf): y = inf"], 0),
    ("{\"points\":[[1,2],\"a\",[5,6]]}\n", &["line 1, points, point 2: \"a\" is not a point"], 0),
    ("[1,NaN]\n[1,2]\n", &["line 1, point (1, NaN): y = NaN"], 0),
    ("nan,nan\n", &["line 1, point (NaN, NaN)", "nothing in it could be used, of 1 lines or points"], 1),
];

#[test]
fn what_cannot_be_used_is_reported_with_the_file_and_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points");
    let name = path.display().to_string();
    for (input, words, code) in REPORTED {
        fs::write(&path, input).unwrap();
        let finished = hopes("compute").with(&name).runs();
        assert_eq!(finished.code, Some(code), "{input:?}: {}", finished.err);
        assert!(finished.err.contains(&format!("WARN {name}: line ")), "{input:?}: {}", finished.err);
        for word in words {
            assert!(finished.err.contains(word), "{input:?}: {word:?} is missing in {}", finished.err);
        }
        hopes("compute").with(&name).with("--strict").runs().fails(3, &[&name, "--strict stops here"]);
        let served = hopes("serve").reads(input);
        assert_eq!(served.code, Some(code), "{input:?}: {}", served.err);
        assert_eq!(hopes("serve --strict").reads(input).code, Some(3), "{input:?}");
    }
}

/// Of a frame in JSON all points are there but the one that is none.
#[test]
fn one_bad_point_does_not_take_its_frame() {
    let points: Vec<String> = ring([0.0, 0.0]).iter().map(|[x, y]| format!("[{x},{y}]")).collect();
    for bad in
        ["[null,1]", "[1,NaN]", "[1]", "null", "\"a\"", "[1,2,3]", "{\"x\":1,\"y\":2}", "[-Infinity,0]", "[1e999,0]"]
    {
        let input = format!("{{\"points\":[{},{bad},{}]}}\n", points[..9].join(","), points[9..].join(","));
        let finished = hopes("compute -").reads(&input);
        assert!(finished.err.contains("WARN line 1, "), "{bad}: {}", finished.err);
        let out = finished.text();
        assert_eq!(dots(&out).len(), 1, "{bad}");
        assert_eq!(serde_json::from_str::<Value>(&out).unwrap()["rejected"], 1, "{bad}");
    }
}
