//! `hopes scene`: its formats, its truth, and its errors.

use std::fs;
use std::io::Read;

use serde_json::{Value, json};

use crate::common::mirror::{FrameLine, Mirror};
use crate::common::process::{Finished, hopes};
use crate::common::reply::Picture;
use crate::replay::json_lines;

fn scene(arguments: &str) -> Finished {
    hopes("scene").and(arguments).runs()
}

#[test]
fn scenes_are_listed() {
    let list = scene("--list").text();
    // In the plane, in R^d, signals.
    let counts: Vec<usize> = list.split("\n\n").map(|family| family.lines().count()).collect();
    assert_eq!(counts, [22, 9, 2]);
    assert!(list.starts_with("drift       8 rings drift on smooth paths\n"), "{list}");
    for line in list.lines().filter(|line| !line.is_empty()) {
        let (name, about) = line.split_once(' ').unwrap();
        assert!(!about.trim().is_empty());
        assert!(!scene(&format!("{name} --frames 1")).text().is_empty());
    }
}

/// What a consumer gets for each frame of a scene that is served: the view's numbers, the skeleton, the time.
fn served(scene_arguments: &str, serve_arguments: &str) -> Vec<(Picture, FrameLine)> {
    let points = scene(scene_arguments).out();
    let frames = hopes("serve --full").and(serve_arguments).reads(points).text();
    let mut mirror = Mirror::default();
    let follow = |line: &str| {
        let line = FrameLine::of(line);
        mirror.follow(&line);
        (mirror.picture(), line)
    };
    frames.lines().map(follow).collect()
}

#[test]
fn all_formats_give_the_same_clouds() {
    for name in ["pinch", "vanish", "occlusion"] {
        let scene = format!("{name} --frames 60 --seed 5 --points-per-radius 6");
        let text = served(&scene, "--window frames:1");
        let lines = served(&format!("{scene} --format jsonl"), "--input jsonl");
        let binary = served(&format!("{scene} --format bin"), "--input bin");
        let shuffled = served(&format!("{scene} --format jsonl --shuffle"), "--input jsonl");
        assert_eq!((text.len(), lines.len(), binary.len(), shuffled.len()), (60, 60, 60, 60));
        let all = text.iter().zip(&lines).zip(&binary).zip(&shuffled);
        for (number, (((text, lines), binary), shuffled)) in (1..).zip(all) {
            assert!(text.0 == lines.0 && text.0 == binary.0 && text.0 == shuffled.0, "{name} frame {number}");
            assert_eq!(text.1.rejected + lines.1.rejected + binary.1.rejected + shuffled.1.rejected, 0);
            let time = Some(f64::from(number) / 30.0);
            assert_eq!([text.1.time, lines.1.time, binary.1.time], [None, time, time]);
        }
    }
}

#[test]
fn the_truth_is_written_beside_the_points() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, points] = ["truth", "points"].map(|name| folder.path().join(name));
    let asked = hopes("scene fuse --frames 300 --seed 3 --noise 0.05 --churn 0.2 --points-per-radius 8 --truth");
    let written = asked.with(&truth).and("-o").with(&points).runs().out();
    assert!(written.is_empty());
    let truth_text = fs::read_to_string(&truth).unwrap();
    let lines = json_lines(&truth_text);
    assert_eq!(lines.len(), 301);
    let (above, smallest) = (lines[0]["above"].as_f64().unwrap(), lines[0]["smallest_radius"].as_f64().unwrap());
    assert_eq!(above, 0.4 * smallest);
    let header = json!({
        "scene": "fuse", "seed": 3, "frames": 300, "noise": 0.05, "churn": 0.2, "points_per_radius": 8,
        "above": above, "smallest_radius": smallest,
    });
    assert_eq!(lines[0], header);
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<Vec<_>>().join(" ");
    for (number, line) in lines[1..].iter().enumerate() {
        assert_eq!((keys(line).as_str(), &line["frame"]), ("events frame holes", &json!(number + 1)));
        assert!(line["holes"].as_array().unwrap().iter().all(|hole| keys(hole) == "id orbit radius x y"));
    }
    let events: Vec<&Value> = lines[1..].iter().flat_map(|line| line["events"].as_array().unwrap()).collect();
    assert_eq!(events[0], &json!({"event": "born", "id": 1}));
    let merged = events.iter().find(|event| event["event"] == "merged").expect("the scene is called fuse");
    assert_eq!(keys(merged), "event id into");

    // Neither the format nor the destination of the points changes the truth.
    let again = folder.path().join("again");
    let asked = hopes("scene fuse --frames 300 --seed 3 --noise 0.05 --churn 0.2 --points-per-radius 8 --truth");
    let text = asked.with(&again).and("-o -").runs().out();
    assert!(text == fs::read(&points).unwrap() && truth_text == fs::read_to_string(&again).unwrap());
    asked.with(&again).and("--format bin --shuffle").runs().out();
    assert_eq!(truth_text, fs::read_to_string(&again).unwrap());
}

#[test]
fn the_truth_says_how_many_points_are_clutter() {
    let (lines, points) = with_truth("cells --frames 3 --clutter 0.1 --clumps --camera turn:0.25 --churn 1");
    let header = &lines[0];
    assert_eq!(
        [&header["camera"], &header["clutter"], &header["clumps"]],
        [&json!("turn:0.25"), &json!(0.1), &json!(true)]
    );
    let clean = scene("cells --frames 3 --camera turn:0.25 --churn 1").text();
    let frames = |text: &str| text.trim_end().split("\n\n").map(rows).collect::<Vec<_>>();
    let (clean, cluttered) = (frames(&clean), frames(&points));
    for (number, (clean, cluttered)) in clean.iter().zip(&cluttered).enumerate() {
        let strays = lines[number + 1]["clutter"].as_u64().unwrap() as usize;
        assert!(strays > 0 && cluttered.len() == clean.len() + strays);
        assert_eq!(clean[..], cluttered[..clean.len()]);
    }
    // Cells are slender.
    let hole = &lines[1]["holes"][0];
    assert_eq!(hole["ridge"].as_array().map(Vec::len), Some(2), "{hole}");
}

#[test]
fn points_have_as_many_coordinates_as_their_space() {
    for (name, dimension) in [("links", 3), ("torus", 3), ("circle", 2), ("cube:7", 7), ("delay:20", 20)] {
        let text = scene(&format!("{name} --points 50 --frames 2")).text();
        let lines = scene(&format!("{name} --points 50 --frames 2 --format jsonl")).text();
        let frames: Vec<Vec<Vec<f64>>> = text.trim_end().split("\n\n").map(rows).collect();
        assert!(frames.len() == 2 && frames.iter().all(|frame| frame.len() == 50), "{name}");
        assert!(frames.iter().flatten().all(|point| point.len() == dimension), "{name}");
        // The first frame is new as a whole.
        let lines = json_lines(&lines);
        assert_eq!(lines[0]["points"], json!(frames[0]), "{name}");
        assert_eq!(lines[1], json!({"commit": true, "time": 1.0 / 30.0}));
        assert!(
            lines[2]["retract"].as_array().unwrap().iter().all(|point| point.as_array().unwrap().len() == dimension)
        );
    }
}

fn rows(frame: &str) -> Vec<Vec<f64>> {
    frame.lines().map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect()
}

/// The truth of a scene, line by line, and the text of its points.
fn with_truth(arguments: &str) -> (Vec<Value>, String) {
    let folder = tempfile::tempdir().unwrap();
    let truth = folder.path().join("truth");
    let points = hopes("scene").and(arguments).and("--truth").with(&truth).runs().text();
    (json_lines(&fs::read_to_string(&truth).unwrap()), points)
}

#[test]
fn the_truth_in_space_has_centres_radii_and_lengths() {
    let (lines, points) = with_truth("torus --points 60 --frames 3 --seed 4 --churn 0.05");
    assert_eq!((lines.len(), points.lines().count()), (4, 3 * 61));
    let header = json!({
        "scene": "torus", "seed": 4, "frames": 3, "noise": 0.1, "churn": 0.05, "points": 60, "dimension": 3,
        "above": 0.16, "smallest_radius": 0.45 * 0.85,
    });
    assert_eq!(lines[0], header);
    assert_eq!(lines[1]["events"], json!([{"event": "born", "id": 1}, {"event": "born", "id": 2}]));
    for line in &lines[1..] {
        let [middle, tube] = &line["holes"].as_array().unwrap()[..] else { panic!("{line}") };
        let number = |hole: &Value, key: &str| hole[key].as_f64().unwrap();
        assert_eq!(middle["center"].as_array().unwrap().len(), 3);
        assert!((number(middle, "radius") + number(tube, "radius") - 1.0).abs() < 1e-9);
        assert!(number(middle, "length") > 3.0 && number(middle, "orbit") == 0.0 && number(tube, "orbit") > 0.99);
        assert_eq!(tube.as_object().unwrap().len(), 5);
    }
    let (lines, _) = with_truth("cube:3 --points 10 --frames 1");
    assert_eq!((&lines[0]["above"], &lines[0]["noise"], &lines[1]["holes"]), (&json!(null), &json!(0.0), &json!([])));
}

#[test]
fn the_truth_of_a_signal_has_its_period_while_it_runs() {
    let (lines, points) = with_truth("gait --points 5 --frames 160 --noise 0");
    let header = json!({"scene": "gait", "seed": 1, "frames": 160, "noise": 0.0, "samples": 5});
    assert_eq!(lines[0], header);
    let samples: Vec<f64> = points.lines().filter(|line| !line.is_empty()).map(|line| line.parse().unwrap()).collect();
    assert_eq!(samples.len(), 800);
    let [first, second] = [1, 145].map(|frame| lines[frame]["holes"][0].clone());
    for (run, since) in [(&first, 1), (&second, 721)] {
        assert_eq!(run["since"], json!(since));
        let period = run["period"].as_u64().unwrap() as usize;
        let run = &samples[since - 1..(since + 400).min(800)];
        assert!(run.iter().zip(&run[period..]).all(|(a, b)| (a - b).abs() < 1e-9), "{period}");
    }
    assert_ne!(first["period"], second["period"]);
    assert_eq!((&lines[96]["holes"], &lines[97]["holes"]), (&json!([first]), &json!([])));
    assert_eq!(lines[97]["events"], json!([{"event": "died", "id": 1}]));
    assert!(samples[480..720].iter().all(|&sample| sample == 0.0));
}

#[test]
fn options_of_another_family_are_refused() {
    for (arguments, words) in [
        ("drift --points 100", &["drift has no --points", "--points-per-radius"][..]),
        ("torus --points-per-radius 16", &["torus has no --points-per-radius", "is --points"]),
        ("torus --points 100 --points-per-radius 16", &["--points"]),
        ("cube:3 --noise 0.1", &["cube:3 has no --noise", "fill it"]),
        ("gait --churn 0.1", &["gait has no --churn", "a sample never changes"]),
        ("gait --shuffle", &["gait has no --shuffle", "the order of samples"]),
        ("gait --points-per-radius 5", &["gait has no --points-per-radius"]),
        ("gait --points 121", &["121 samples in a frame", "must be 1 to 120"]),
        ("torus --camera pan:1", &["torus has no --camera", "only scenes in the plane have"]),
        ("gait --clutter 0.1", &["gait has no --clutter", "only scenes in the plane have"]),
        ("torus --points 2", &["2 points", "must be 3 to 100000"]),
        ("cube:4096 --points 1000", &["1000 points of 4096 coordinates", "at most 4000000"]),
        ("cube:0", &["no scene \"cube:0\""]),
        ("delay:101", &["no scene \"delay:101\""]),
        ("torus --format bin", &["points of 3 coordinates have no binary form", "text or jsonl"]),
        ("torus -o torus.hopes", &["points of 3 coordinates have no binary form"]),
    ] {
        scene(arguments).fails(2, words);
    }
    hopes("demo --scene torus").runs().fails(2, &["no scene \"torus\" in the plane", "choose one of drift, static"]);
}

#[test]
fn invalid_scenes_are_refused() {
    for (arguments, words) in [
        ("", &["<NAME>"][..]),
        ("pinched", &["no scene \"pinched\"", "choose one of drift, static, pinch"]),
        ("drift --frames 0", &["--frames"]),
        ("drift --noise 0.4", &["a noise of 0.4", "must be 0 to 0.3"]),
        ("drift --noise nan", &["not a finite number"]),
        ("drift --churn 0", &["a churn of 0", "must be 0.01 to 1"]),
        ("drift --camera tilt:1", &["\"tilt:1\" is no camera", "pan, turn, zoom or shake"]),
        ("drift --clutter 2", &["a clutter of 2", "must be 0 to 1"]),
        ("drift --clumps", &["--clutter"]),
        ("drift --points-per-radius 1", &["1 points per radius", "must be 2 to 10000"]),
        ("drift --points-per-radius 1.5", &["not a whole number"]),
        ("drift --seed=-1", &["--seed"]),
        ("drift --list", &["--list"]),
        ("drift --truth -", &["--truth needs a file"]),
        ("drift --truth x -o x", &["name the same file"]),
    ] {
        scene(arguments).fails(2, words);
    }
    scene("drift -o /nowhere/at.all").fails(1, &["cannot write /nowhere/at.all"]);
    scene("drift --truth /nowhere/at.all").fails(1, &["cannot write /nowhere/at.all"]);
}

#[test]
fn a_closed_output_pipe_is_no_error() {
    for format in ["text", "jsonl", "bin"] {
        let mut running = hopes("scene drift --frames 1000000000 --format").and(format).start();
        let mut stdout = running.take_stdout();
        stdout.read_exact(&mut [0; 100_000]).unwrap();
        drop(stdout);
        let finished = running.ends();
        assert_eq!((finished.code, finished.err.as_str()), (Some(0), ""));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_ends_a_scene_with_a_whole_frame() {
    let folder = tempfile::tempdir().unwrap();
    let [truth, points] = ["truth", "points"].map(|name| folder.path().join(name));
    let asked = hopes("scene static --points-per-radius 4 --frames 1000000000 --truth");
    let running = asked.with(&truth).and("-o").with(&points).start();
    let written = || (running.written() > 1 << 21).then_some(());
    crate::common::process::eventually("frames are written", written);
    assert!(!points.exists() && !truth.exists(), "nothing is seen before it is whole");
    running.signal(rustix::process::Signal::INT);
    let finished = running.ends();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    let (truth, points) = (fs::read_to_string(&truth).unwrap(), fs::read_to_string(&points).unwrap());
    assert!(points.ends_with("\n\n") && points.len() > 1 << 16);
    assert_eq!(points.lines().filter(|line| line.is_empty()).count() + 1, json_lines(&truth).len());
}
