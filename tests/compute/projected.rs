//! Degrees as metres: `--project`.

use std::f64::consts::TAU;
use std::fmt::Write;

use serde_json::Value;

use crate::common::process::hopes;

/// A ring of 100 m radius at 60 degrees north, as a table of degrees. One degree of longitude is half as long there.
fn ring() -> String {
    let mut text = "lon,lat\n".to_owned();
    for index in 0..24 {
        let (sine, cosine) = (TAU * f64::from(index) / 24.0).sin_cos();
        writeln!(text, "{:.9},{:.9}", 24.94 + 100.0 / 55_597.54 * cosine, 60.0 + 100.0 / 111_195.08 * sine).unwrap();
    }
    text
}

fn json(arguments: &str) -> (Value, String) {
    let finished = hopes("compute - --columns lon,lat").and(arguments).reads(ring());
    let log = finished.err.clone();
    (serde_json::from_slice(&finished.out()).unwrap(), log)
}

#[test]
fn a_ring_of_degrees_has_one_dot_in_metres() {
    let (degrees, log) = json("");
    assert_eq!(degrees["dots"].as_array().unwrap().len(), 4, "oblong: the wrong holes");
    assert!(log.contains("degrees, which are no lengths") && log.contains("--project"), "{log}");
    assert_eq!(degrees["origin"], Value::Null);
    let (metres, log) = json("--project");
    let dots = metres["dots"].as_array().unwrap();
    assert_eq!(dots.len(), 1);
    // The chord of a 24th is 2 r sin(7.5 degrees).
    let [birth, death] = ["birth", "death"].map(|key| dots[0][key].as_f64().unwrap());
    assert!((birth - 13.05).abs() < 0.05 && (death - 100.0).abs() < 0.2, "{birth} {death}");
    assert!(!log.contains("no lengths") && log.contains("east and north of longitude 24.9"), "{log}");
    assert_eq!(metres["origin"][1], 60.0);
    assert_eq!(metres["vertices"][0][0], 0.0, "the first point is the origin");
    // Another origin moves all, and changes nothing else.
    let (moved, _) = json("--project=25,60");
    let moved_dots = moved["dots"].as_array().unwrap();
    assert_eq!(moved_dots.len(), 1);
    assert!((moved_dots[0]["death"].as_f64().unwrap() - death).abs() < 0.5);
    assert_eq!(moved["origin"], serde_json::json!([25.0, 60.0]));
}

#[test]
fn geojson_has_degrees_again() {
    let text = hopes("compute - --columns lon,lat --project --format geojson").reads(ring()).text();
    let map: Value = serde_json::from_str(&text).unwrap();
    let points = map["features"][0]["geometry"]["coordinates"].as_array().unwrap().clone();
    let ring = ring();
    let expected: Vec<Vec<f64>> =
        ring.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    assert_eq!(points.len(), expected.len());
    for (point, expected) in points.iter().zip(&expected) {
        for axis in 0..2 {
            assert!((point[axis].as_f64().unwrap() - expected[axis]).abs() < 1e-9, "{point} {expected:?}");
        }
    }
    let hole = map["features"].as_array().unwrap().iter().find(|f| f["properties"]["role"] == "hole").unwrap();
    let center = &hole["geometry"]["coordinates"];
    assert!((center[0].as_f64().unwrap() - 24.94).abs() < 1e-5 && (center[1].as_f64().unwrap() - 60.0).abs() < 1e-5);
    assert!((hole["properties"]["death"].as_f64().unwrap() - 100.0).abs() < 0.2, "radii stay in metres");
}

#[test]
fn streams_are_projected_and_points_taken_back() {
    let lines: Vec<String> = ring().lines().skip(1).map(|line| format!("[{line}]")).collect();
    let mut input: String = lines.iter().map(|line| format!("{line}\n")).collect();
    input += "{\"commit\":true}\n";
    let back = lines.iter().skip(1).cloned().collect::<Vec<_>>().join(",");
    input += &format!("{{\"retract\":[{back}]}}\n{{\"commit\":true}}\n");
    let served = hopes("serve --input jsonl --project --strict --full").reads(input).text();
    let frames: Vec<Value> = served.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((&frames[0]["view"]["cycles"], &frames[0]["points"]), (&Value::from(1), &Value::from(24)));
    assert_eq!(frames[1]["points"], 1, "all but the first were found again");
}

#[test]
fn what_is_not_on_earth_is_refused_with_its_line() {
    let finished = hopes("compute - --project").reads("25,60\n60,125\n25,60.1\n");
    assert!(finished.err.contains("line 2: longitude 60, latitude 125 is no place on Earth"), "{}", finished.err);
    let answer: Value = serde_json::from_slice(&finished.out()).unwrap();
    assert_eq!((&answer["points"], &answer["rejected"]), (&Value::from(2), &Value::from(1)));
    hopes("compute - --project --strict").reads("25,60\n60,125\n").fails(3, &["line 2", "swapped"]);
    hopes("serve --project --strict").reads("25,60\n60,125\n").fails(3, &["line 2", "no place on Earth"]);
    hopes("compute tests/data/edges/coins.png --project").runs().fails(2, &["a picture has pixels"]);
}
