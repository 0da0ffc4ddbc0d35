//! `hopes serve --track`: scenes whose holes are known, and the tracks of their frames.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use crate::common::process::hopes;
use crate::replay::json_lines;

/// Points of a scene.
fn scene(arguments: &str) -> Vec<u8> {
    hopes("scene").and(arguments).runs().out()
}

/// The tracks in the output of `serve`, frame by frame: events and living tracks.
fn tracked(points: &[u8], arguments: &str) -> Vec<(Value, Value)> {
    let text = hopes("serve").and(arguments).reads(points).text();
    let part = |line: &Value, key: &str| line.get(key).unwrap_or_else(|| panic!("{key} is missing: {line}")).clone();
    json_lines(&text).iter().map(|line| (part(line, "tracks"), part(line, "alive"))).collect()
}

#[test]
fn threads_and_the_order_of_points_do_not_matter() {
    for name in ["mixed", "crowd"] {
        let scene_of = |more: &str| scene(&format!("{name} --frames 50 --seed 4 --points-per-radius 8 {more}"));
        for rule in
            ["--track above:0.28", "--track top:7 --track-confirm 1 --track-miss 3", "--track view --track-delta 0.1"]
        {
            let whole = format!("--window frames:1 --track-list {rule}");
            let reference = tracked(&scene_of(""), &whole);
            assert!(reference.iter().any(|(events, _)| events[0]["event"] == "born"), "{name} {rule}");
            for threads in ["--threads 1", "--threads 2", "--threads 8"] {
                assert!(tracked(&scene_of(""), &format!("{whole} {threads}")) == reference, "{name} {rule} {threads}");
            }
            assert!(tracked(&scene_of("--shuffle"), &whole) == reference, "{name} {rule}, shuffled");
            let changes = tracked(&scene_of("--format jsonl"), &format!("--input jsonl --track-list {rule}"));
            assert!(changes == reference, "{name} {rule}, by changes");
        }
    }
}

/// Every true event is reported once, at most three frames late, for the right hole.
#[test]
fn splits_and_mergers_are_reported_once_and_in_time() {
    let folder = tempfile::tempdir().unwrap();
    let truth = folder.path().join("truth");
    for (name, kind) in [("pinch", "split"), ("fuse", "merged")] {
        let made = hopes(&format!("scene {name} --frames 420 --seed 6 --points-per-radius 12 --truth")).with(&truth);
        let points = made.runs().out();
        let truth = json_lines(&fs::read_to_string(&truth).unwrap());
        let above = truth[0]["above"].as_f64().unwrap();
        let tracks = tracked(&points, &format!("--window frames:1 --track-list --track above:{above}"));
        let frames_of = |events: Vec<&Value>| -> Vec<usize> {
            let has = |list: &Value| list.as_array().unwrap().iter().filter(|event| event["event"] == kind).count();
            events.iter().enumerate().flat_map(|(frame, list)| vec![frame; has(list)]).collect()
        };
        let is = frames_of(tracks.iter().map(|(events, _)| events).collect());
        let should = frames_of(truth[1..].iter().map(|line| &line["events"]).collect());
        assert!(should.len() >= 2 && is.len() == should.len(), "{name}: {is:?}, should be {should:?}");
        for (is, should) in is.iter().zip(&should) {
            assert!((*should..=should + 3).contains(is), "{name}: {is}, should be {should}");
        }
        // In nearly every frame there are as many living tracks as holes.
        let count = |list: &Value| list.as_array().map(Vec::len);
        let differ = tracks.iter().zip(&truth[1..]).filter(|((_, alive), line)| count(alive) != count(&line["holes"]));
        assert!(differ.count() < 40, "{name}");
    }
}

#[test]
fn events_and_living_tracks_agree() {
    let tracks =
        tracked(&scene("mixed --frames 300 --seed 2 --noise 0.2"), "--window frames:1 --track-list --track above:0.28");
    let mut alive: BTreeMap<u64, Value> = BTreeMap::new();
    for (events, living) in &tracks {
        for event in events.as_array().unwrap() {
            let id = event["id"].as_u64().unwrap();
            let known = match event["event"].as_str().unwrap() {
                "merged" | "died" => alive.remove(&id),
                _ => alive.insert(id, event.clone()),
            };
            assert_eq!(known.is_none(), ["born", "split"].contains(&event["event"].as_str().unwrap()), "{event}");
        }
        let listed = alive.iter().map(|(id, event)| {
            let [x, y] = [0, 1].map(|axis| event["center"][axis].as_f64().unwrap());
            serde_json::json!([id, x, y, event["radius"], event["birth"], event["death"]])
        });
        assert_eq!(living, &Value::Array(listed.collect()));
    }
}

#[test]
fn tracks_of_serve_are_what_hopes_tracks_reads() {
    let points = scene("pinch --frames 300 --seed 6");
    let lines = hopes("serve --window frames:1 --track above:0.28").reads(&points).text();
    let table: Vec<Vec<String>> = {
        let text = hopes("tracks - --format csv").reads(&lines).text();
        text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let begins = lines.matches(r#""event":"born""#).count() + lines.matches(r#""event":"split""#).count();
    assert!(begins > 4 && table.len() == begins, "{begins}: {table:?}");
    let svg = tempfile::tempdir().unwrap();
    let picture = svg.path().join("lives.svg");
    hopes("tracks - --svg").with(&picture).reads(&lines).out();
    assert!(fs::read_to_string(picture).unwrap().starts_with("<svg"));
}

#[test]
fn invalid_tracking_options_are_refused() {
    for (arguments, words) in [
        ("--track top:0", "none of view, top:M (M from 1) and above:P"),
        ("--track above:-1", "none of view, top:M"),
        ("--track above:inf", "none of view, top:M"),
        ("--track holes", "\"holes\" is none of view"),
        ("--track view --track-confirm 0", "--track-confirm"),
        ("--track view --track-delta=-1", "--track-delta"),
        ("--track-list", "--track"),
        ("--track-miss 3", "--track"),
    ] {
        hopes("serve").and(arguments).reads("").fails(2, &[words]);
    }
}

/// The sky right of the tree is one hole through the whole film, and so is the largest hole around the bunny.
#[test]
fn ids_last_through_a_film() {
    let tracks =
        tracked(include_bytes!("../data/bunny.jsonl"), "--input jsonl --window frames:1 --track above:8 --track-list");
    let is_at = |alive: &Value, id: u64, [left, right]: [f64; 2], [low, high]: [f64; 2]| {
        let track = alive.as_array().unwrap().iter().find(|track| track[0] == id);
        track.is_some_and(|track| {
            let [x, y] = [1, 2].map(|place| track[place].as_f64().unwrap());
            (left..right).contains(&x) && (low..high).contains(&y)
        })
    };
    for (number, (_, alive)) in (1..).zip(&tracks).skip(2) {
        assert!(is_at(alive, 2, [310.0, 360.0], [180.0, 220.0]), "the sky in frame {number}: {alive}");
        assert!(is_at(alive, 4, [90.0, 175.0], [80.0, 140.0]), "the bunny in frame {number}: {alive}");
    }
    let begun =
        tracks.iter().flat_map(|(events, _)| events.as_array().unwrap()).filter(|event| event["event"] == "born");
    assert_eq!(begun.count(), 6);
}
