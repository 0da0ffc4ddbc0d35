//! `hopes serve` with a metric: streams of points in R^d on stdin.

use std::collections::BTreeMap;

use hopes_protocol::{Banner, Commit, SPACE_FILE_VERSION, SpaceBatch, encode};
use serde_json::Value;

use crate::common::process::hopes;
use crate::common::random::Random;

fn lines(output: &str) -> Vec<Value> {
    output.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn served(arguments: &str, input: impl AsRef<[u8]>) -> Vec<Value> {
    lines(&hopes("serve").and(arguments).reads(input).text())
}

/// Points of a ring in the first two of d coordinates, a frame every `frame` points.
fn ring(dimension: usize, count: usize, frame: usize) -> String {
    let mut random = Random::new(11);
    let mut text = String::new();
    for number in 0..count {
        let [x, y] = random.point();
        let (angle, radius) = (std::f64::consts::TAU * x, 1.0 + 0.1 * y);
        let mut point = vec![0.0; dimension];
        (point[0], point[1]) = (radius * angle.cos(), radius * angle.sin());
        let words: Vec<String> = point.iter().map(f64::to_string).collect();
        text += &format!("{}\n", words.join(","));
        if (number + 1) % frame == 0 {
            text.push('\n');
        }
    }
    text
}

#[test]
fn a_square_in_space_is_a_cycle_whose_vertices_have_three_coordinates() {
    let input = "x,y,z\n0,0,5\n1,0,5\n1,1,5\n0,1,5\n\n2,2,5\n";
    let frames = served("--metric euclidean --check", input);
    assert_eq!(frames.len(), 2);
    let first = &frames[0];
    assert_eq!(
        first["vertices"]["add"],
        serde_json::json!([[0, 0.0, 0.0, 5.0], [1, 1.0, 0.0, 5.0], [2, 1.0, 1.0, 5.0], [3, 0.0, 1.0, 5.0]])
    );
    assert_eq!(first["critical"]["set"].as_array().unwrap().len(), 1);
    let dot = &first["critical"]["set"][0];
    // In the plane the hole of a square is filled at half its diagonal, too.
    assert_eq!((dot[2].as_f64(), dot[3].as_f64()), (Some(0.5), Some(0.5f64.sqrt())));
    assert_eq!(frames[1]["vertices"]["add"], serde_json::json!([[4, 2.0, 2.0, 5.0]]));
    let plane = served("--metric plane", "0,0\n1,0\n1,1\n0,1\n");
    assert_eq!(plane[0]["vertices"]["add"][0], serde_json::json!([0, 0.0, 0.0]));
}

#[test]
fn windows_keep_the_newest_points_and_each_frame_is_that_of_a_file() {
    let frames = served("--metric manhattan --window points:40 --full --check", ring(5, 120, 30));
    assert_eq!(frames.len(), 4);
    let mut held: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for frame in &frames {
        for id in frame["vertices"]["del"].as_array().unwrap() {
            held.remove(&id.as_u64().unwrap()).expect("only what is there leaves");
        }
        for vertex in frame["vertices"]["add"].as_array().unwrap() {
            let [id, point @ ..] = &vertex.as_array().unwrap()[..] else { panic!("a vertex has an id") };
            held.insert(id.as_u64().unwrap(), point.iter().map(|x| x.as_f64().unwrap()).collect());
        }
    }
    assert_eq!(held.len(), 40);
    let of_file: String =
        held.values().map(|point| point.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n").collect();
    let whole: Value =
        serde_json::from_str(&hopes("compute - --metric manhattan --full").reads(of_file).text()).unwrap();
    let last = &frames[3]["view"];
    assert_eq!(last["components"], whole["view"]["components"]);
    assert_eq!(last["cycles"].as_u64().unwrap() as usize, whole["dots"].as_array().unwrap().len());
}

#[test]
fn what_is_no_point_of_the_space_is_counted_and_told_with_its_line() {
    let input = "1,2,3\nnan,0,0\n1,2\n4,5,6\n1,2,3,4\n1,x,3\n1,inf,1\n1e200,0,0\n7,8,9\n";
    let finished = hopes("serve --metric euclidean").reads(input);
    for words in ["line 2", "line 3", "line 5", "line 6", "line 7", "line 8", "2 coordinate(s)", "4 coordinate(s)"] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
    let frames = lines(&finished.text());
    assert_eq!((frames[0]["points"].as_u64(), frames[0]["rejected"].as_u64()), (Some(3), Some(6)));
    hopes("serve --metric euclidean --strict").reads("1,2,3\n1,2\n").fails(3, &["line 2", "2 coordinate(s)"]);
    let latitudes = hopes("serve --metric haversine").reads("lon,lat\n10,95\n10,50\n11,50\n");
    assert!(latitudes.err.contains("latitude"), "{}", latitudes.err);
    assert_eq!(lines(&latitudes.text())[0]["points"], 2);
    let directions = hopes("serve --metric angular").reads("0,0,0\n1,0,0\n0,2,0\n");
    assert!(directions.err.contains("line 1"), "{}", directions.err);
    assert_eq!(lines(&directions.text())[0]["points"], 2);
}

#[test]
fn more_points_than_a_frame_may_cost_are_refused() {
    let many: String = (0..20_000).map(|number| format!("{number},0,0\n")).collect();
    let finished = hopes("serve --metric euclidean").reads(many);
    assert!(finished.err.contains("4096"), "{}", finished.err);
    let frames = lines(&finished.text());
    assert_eq!((frames[0]["points"].as_u64(), frames[0]["rejected"].as_u64()), (Some(4096), Some(20_000 - 4096)));
    let wide = vec!["1"; 5000].join(",");
    hopes("serve --metric euclidean").reads(wide + "\n").fails(1, &["5000 coordinates", "4096"]);
}

#[test]
fn a_series_becomes_delay_vectors() {
    let sine: String = (0..400).map(|time| format!("{}\n", (f64::from(time) * 0.1).sin())).collect();
    let frames = served("--embed 3:15 --window points:200", sine);
    assert_eq!(frames[0]["vertices"]["add"][0].as_array().unwrap().len(), 4);
    assert_eq!((frames[0]["points"].as_u64(), frames[0]["view"]["cycles"].as_u64()), (Some(200), Some(1)));
    hopes("serve --embed 3:15").reads("1,2\n3,4\n").fails(1, &["line 1", "a series has one"]);
}

#[test]
fn options_that_contradict_each_other_are_wrong_usage() {
    for (arguments, words) in [
        ("serve --metric matrix", "hopes compute"),
        ("serve --metric plane --embed 3:1", "--metric"),
        ("serve --metric haversine --embed 3:1", "places on the Earth"),
        ("serve --metric euclidean --project", "--metric haversine"),
        ("serve --metric euclidean --columns 0", "--columns"),
        ("serve --listen unix:x --stream a:dimension=3", "metric=euclidean"),
        ("serve --listen unix:x --stream a:metric=matrix", "no metric of points"),
        ("serve --listen unix:x --stream a:metric=haversine,dimension=3", "haversine takes two"),
        ("serve --listen unix:x --stream a:metric=euclidean,dimension=5000", "4096"),
        ("feed - --metric matrix", "hopes compute"),
    ] {
        hopes(arguments).runs().fails(2, &[words]);
    }
}

#[test]
fn bytes_of_the_protocol_are_read_and_written() {
    let (coordinates, times) = (vec![0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0], Vec::new());
    let batch = SpaceBatch { sequence: 1, dimension: 3, coordinates, times, tags: Vec::new() };
    let broken = SpaceBatch { coordinates: vec![1.0; 4], ..batch.clone() };
    let mut bytes = Banner { lowest: SPACE_FILE_VERSION, highest: SPACE_FILE_VERSION }.encode().to_vec();
    for message in [batch.into(), broken.into(), Commit { sequence: 2, time: Some(7.0) }.into()] {
        bytes.extend(encode(SPACE_FILE_VERSION, 1, &message).unwrap());
    }
    let arguments = "serve --metric euclidean --input bin";
    let finished = hopes(arguments).reads(&bytes);
    assert!(finished.err.contains("no whole points of dimension 3"), "{}", finished.err);
    let frames = lines(&finished.text());
    assert_eq!((frames[0]["points"].as_u64(), frames[0]["time"].as_f64()), (Some(4), Some(7.0)));
    assert_eq!(frames[0]["view"]["cycles"], 1);
    let recording = hopes(arguments).and("--output bin").reads(&bytes).out();
    let played = hopes("replay - --fast --output jsonl").reads(&recording).text();
    assert_eq!(lines(&played), frames);
    let again = hopes("replay - --fast --output bin").reads(&recording).out();
    assert_eq!(hopes("replay - --fast --output jsonl").reads(&again).text(), played);
    assert!(hopes("replay - --fast").reads(&recording).text().contains("points 4"));
}

#[test]
fn tracks_have_centres_of_as_many_coordinates_as_points() {
    let frames: String = (0..6).map(|_| ring(3, 60, 61) + "\n").collect();
    let output = hopes("serve --metric euclidean --window frames:1 --track top:1 --track-list").reads(frames).text();
    let last = lines(&output).pop().unwrap();
    let alive = last["alive"][0].as_array().unwrap();
    assert_eq!(alive.len(), 1 + 3 + 3, "an id, a centre, radius, birth and death");
    let born = lines(&output).into_iter().find(|line| line["tracks"][0]["event"] == "born").expect("a ring is there");
    let track = &born["tracks"][0];
    assert_eq!((track["center"].as_array().unwrap().len(), track["velocity"].as_array().unwrap().len()), (3, 3));
    assert!(track["area"].is_null() && track["radius"].as_f64().unwrap() > 0.9, "{track}");
    let table = hopes("tracks -").reads(&output).text();
    assert!(table.lines().next().unwrap().contains(" z"), "{table}");
    let csv = hopes("tracks - --format csv").reads(&output).text();
    assert!(csv.starts_with("stream,id,") && csv.contains(",birth,death,x,y,z,radius\n"), "{csv}");
    let json = hopes("tracks - --format json").reads(&output).text();
    assert!(json.contains("\"center\":["), "{json}");
}
