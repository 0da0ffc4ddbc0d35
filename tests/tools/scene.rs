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
    assert_eq!(list.lines().count(), 13);
    assert!(list.starts_with("drift       8 rings drift on smooth paths\n"), "{list}");
    for line in list.lines() {
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
fn invalid_scenes_are_refused() {
    for (arguments, words) in [
        ("", &["<NAME>"][..]),
        ("pinched", &["no scene \"pinched\"", "choose one of drift, static, pinch"]),
        ("drift --frames 0", &["--frames"]),
        ("drift --noise 0.4", &["a noise of 0.4", "must be 0 to 0.3"]),
        ("drift --noise nan", &["not a finite number"]),
        ("drift --churn 0", &["a churn of 0", "must be 0.01 to 1"]),
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
