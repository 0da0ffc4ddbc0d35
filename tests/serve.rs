//! `hopes serve` as a process: a live stream as input, frames as output, under load, bad input and signals.

mod common;
#[path = "serve/spaces.rs"]
mod spaces;

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::thread;

use common::mirror::{FrameLine, Mirror};
use common::process::{Finished, Running, hopes};
use common::random::Random;
use common::reply::Reply;
use common::window::{Keep, Window};
use rustix::process::Signal;
use serde_json::{Value, json};

/// Frames of a finished run.
fn frames(finished: Finished) -> Vec<FrameLine> {
    finished.text().lines().map(FrameLine::of).collect()
}

/// The frames for these arguments and this input.
fn served(arguments: &str, input: impl AsRef<[u8]>) -> Vec<FrameLine> {
    frames(hopes("serve").and(arguments).reads(input))
}

/// The next frame of a dialogue.
fn frame(running: &mut Running) -> FrameLine {
    FrameLine::of(&running.line().expect("a frame is due"))
}

/// The number of points that each frame adds.
fn added(frames: &[FrameLine]) -> Vec<usize> {
    frames.iter().map(|frame| frame.vertices.add.len()).collect()
}

fn bunny() -> String {
    std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/bunny.jsonl")).unwrap()
}

// ---- lines

#[test]
fn a_line_has_exactly_these_keys() {
    let input = "{\"points\":[[0,0],[1,0],[1,1],[0,1]],\"t\":2.5}\n{\"commit\":true}\n{\"retract\":[[1,1]]}\nbad\n";
    let output = hopes("serve --input jsonl").reads(input).text();
    let lines: Vec<Value> = output.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (half_diagonal, checksums) = (0.5f64.sqrt(), [&lines[0]["checksum"], &lines[1]["checksum"]]);
    let expected = [
        json!({
            "stream": "default",
            "frame": 1,
            "from": 0,
            "time": 2.5,
            "points": 4,
            "rejected": 0,
            "view": {"kind": "derived", "k": 1, "l": 1, "ds": half_diagonal - 0.5, "vs": 0.5, "components": 1, "cycles": 1},
            "vertices": {"add": [[0, 0.0, 0.0], [1, 1.0, 0.0], [2, 1.0, 1.0], [3, 0.0, 1.0]], "del": []},
            "edges": {"add": [[0, 1], [0, 3], [2, 3]], "del": []},
            "critical": {"set": [[1, 2, 0.5, half_diagonal]], "del": []},
            "checksum": checksums[0],
        }),
        json!({
            "stream": "default",
            "frame": 2,
            "from": 1,
            "time": 2.5,
            "points": 3,
            "rejected": 1,
            "view": {"kind": "derived", "k": 1, "l": 1, "ds": null, "vs": null, "components": 1, "cycles": 0},
            "vertices": {"add": [], "del": [2]},
            "edges": {"add": [], "del": [[2, 3]]},
            "critical": {"set": [], "del": [[1, 2]]},
            "checksum": checksums[1],
        }),
    ];
    assert_eq!(lines, expected);
    let mirror = Mirror::of(&output);
    assert_eq!(*checksums[1], mirror.checksum());
}

#[test]
fn the_keys_depend_on_the_view() {
    let view = |arguments: &str| -> Value {
        let line = hopes("serve").and(arguments).reads("0 0\n").text();
        serde_json::from_str::<Value>(&line).unwrap()["view"].take()
    };
    assert_eq!(view("--full"), json!({"kind": "full", "components": 1, "cycles": 0}));
    assert_eq!(view("--alpha 2"), json!({"kind": "reduced", "alpha": 2.0, "components": 1, "cycles": 0}));
    let derived = json!({"kind": "derived", "k": 3, "l": 2, "ds": null, "vs": null, "components": 1, "cycles": 0});
    assert_eq!(view("-k 3 -l 2"), derived);
}

#[test]
fn an_empty_input_gives_one_empty_frame() {
    for (arguments, input) in [("", ""), ("", "# nothing\n"), ("--input jsonl", ""), ("--frame-points 5", "")] {
        let frames = served(arguments, input);
        assert_eq!(frames.len(), 1, "{arguments} {input:?}");
        assert!(frames[0].is_empty() && frames[0].points == 0);
        assert_eq!((frames[0].frame, frames[0].from, frames[0].checksum.as_str()), (1, 0, "0000000000000000"));
    }
}

// ---- what commits a frame

#[test]
fn a_blank_line_commits_a_frame() {
    let frames = served("", "0 0\n1 0\n\n# a comment\n2 0\n \t\r\n\n3 0\n");
    assert_eq!(added(&frames), [2, 1, 0, 1]);
    let frames = served("--input jsonl", "[0,0]\n\n[1,0]\n[2,0]\n\n");
    assert_eq!(added(&frames), [1, 2], "the end closes no frame that nothing has come into");
}

#[test]
fn a_commit_may_set_the_time_of_its_frame() {
    let input = r#"[0,0]
        {"commit":true,"time":7.5}
        [1,0,3]
        {"commit":true}
        {"commit":true,"t":8}
        {"points":[[2,0],[3,0]],"t":9}
        {"points":[[4,0]],"t":5}"#;
    let frames = served("--input jsonl", input);
    assert_eq!(added(&frames), [1, 1, 0, 3]);
    let times: Vec<_> = frames.iter().map(|frame| frame.time).collect();
    assert_eq!(times, [Some(7.5), Some(3.0), Some(8.0), Some(9.0)], "without one, the newest of the points' times");
}

#[test]
fn a_number_of_points_commits_a_frame() {
    let points = |count: usize| -> String { (0..count).map(|i| format!("{},{}\n", i % 100, i / 100)).collect() };
    assert_eq!(added(&served("--frame-points 3", points(6))), [3, 3]);
    assert_eq!(added(&served("--frame-points 3", points(7))), [3, 3, 1], "the end closes the last");
    assert_eq!(added(&served("--frame-points 5000", points(12_000))), [5000, 5000, 2000]);
    // Points at known positions count, refused ones do not, and a blank line starts again from 0.
    assert_eq!(added(&served("--frame-points 2", "0,0\n0,0\nnan,0\n1,0\nx\n2,0\n3,0\n\n4,0\n5,0\n")), [1, 2, 1, 2]);
    let listed = r#"{"points":[[0,0],[1,0],[2,0],[3,0],[4,0]]}"#;
    assert_eq!(added(&served("--input jsonl --frame-points 2", listed)), [2, 2, 1]);
}

#[test]
fn refusals_after_a_full_frame_are_reported_at_the_end() {
    let frames = served("--frame-points 1", "0,0\nnan,0\n");
    assert_eq!((added(&frames), frames.iter().map(|frame| frame.rejected).sum::<u64>()), (vec![1, 0], 1));
}

#[test]
fn an_interval_commits_a_frame() {
    let mut running = hopes("serve --frame-every 20ms").start();
    let mut mirror = Mirror::default();
    let mut until = |running: &mut Running, points: usize| {
        loop {
            let frame = frame(running);
            mirror.follow(&frame);
            if frame.points == points {
                return frame;
            }
        }
    };
    running.say("0 0\n1 0\n");
    until(&mut running, 2);
    running.say("1 1\n");
    until(&mut running, 3);
    let idle = until(&mut running, 3);
    assert!(idle.is_empty(), "a frame closes even when nothing has come: {idle:?}");
    assert_eq!(running.finish().code, Some(0));
}

#[test]
fn a_comment_after_a_point_does_not_delay_the_point() {
    for tail in ["# a comment\n", "# one\n# two\n# and a half", "2"] {
        let mut running = hopes("serve --frame-every 10ms").start();
        running.say("1 0\n".to_owned() + tail);
        let points = (0..1000).map(|_| frame(&mut running).points).find(|&points| points > 0);
        assert_eq!(points, Some(1), "{tail:?}");
    }
}

#[test]
fn a_frame_without_change_is_a_line_with_empty_lists() {
    let frames = served("", "0 0\n1 0\n\n\n0 0\n\n");
    assert_eq!(frames.len(), 3);
    for (number, frame) in (2..).zip(&frames[1..]) {
        assert!(frame.is_empty(), "{frame:?}");
        assert_eq!((frame.frame, frame.from, frame.points), (number, number - 1, 2));
        assert_eq!(frame.checksum, frames[0].checksum);
    }
}

#[test]
fn a_commit_is_answered_at_once() {
    for (arguments, point, commit) in [("", "0,0\n", "\n"), ("--input jsonl", "[0,0]\n", "{\"commit\":true}\n")] {
        let mut running = hopes("serve").and(arguments).start();
        for number in 1..=100 {
            running.say(point.replacen('0', &number.to_string(), 1));
            running.say(commit);
            let frame = frame(&mut running);
            assert_eq!((frame.frame, frame.points), (number, number as usize));
        }
        let finished = running.finish();
        assert_eq!((finished.code, finished.out.len(), finished.err.as_str()), (Some(0), 0, ""));
    }
}

// ---- a mirror equals the original

/// Sends a random stream, frame by frame, to the program and to a reference window. Compares a mirror of the program's
/// lines with the answer of `compute` for the reference window.
fn assert_mirrored(keep: Keep, window: &str, view: &str, point: fn(&mut Random) -> [f64; 2], retractions: bool) {
    let mut random = Random::new(window.len() as u64 + 100 * view.len() as u64);
    let mut running = hopes("serve --input jsonl --window").and(window).and(view).start();
    let (mut window, mut mirror) = (Window::new(keep), Mirror::default());
    for number in 0..25 {
        let (mut rejected, time) = (0, f64::from(number));
        for _ in 0..random.below(50) {
            if retractions && random.below(3) == 0 {
                let [x, y] = point(&mut random);
                rejected += u64::from(!window.retract([x, y]));
                running.say(format!("{{\"retract\":[[{x},{y}]]}}\n"));
            } else {
                let ([x, y], time) = (point(&mut random), time + 4.0 * random.unit() - 4.0);
                rejected += u64::from(!window.insert([x, y], time));
                running.say(format!("[{x},{y},{time}]\n"));
            }
        }
        window.commit(time);
        running.say(format!("{{\"commit\":true,\"time\":{time}}}\n"));
        let frame = frame(&mut running);
        mirror.follow(&frame);
        let reply = Reply::of(hopes("compute -").and(view).reads(window.as_csv()).out());
        assert_eq!(mirror.picture(), reply.picture(), "frame {number}");
        assert_eq!((frame.time, frame.rejected, frame.points), (Some(time), rejected, reply.points), "frame {number}");
        let ours = (&frame.view.kind, frame.view.k, frame.view.l, frame.view.alpha, frame.view.ds, frame.view.vs);
        let theirs = (&reply.view.kind, reply.view.k, reply.view.l, reply.view.alpha, reply.view.ds, reply.view.vs);
        assert_eq!(ours, theirs, "frame {number}");
        assert_eq!((frame.view.cycles, frame.view.components), (reply.view.cycles, reply.view.components));
    }
    assert_eq!(running.finish().code, Some(0));
}

fn anywhere(random: &mut Random) -> [f64; 2] {
    random.point().map(|v| 10.0 * v - 5.0)
}

/// Soon every position is in use, and all distances tie.
fn on_a_small_grid(random: &mut Random) -> [f64; 2] {
    random.node(7)
}

#[test]
fn a_mirror_of_all_points_is_exact() {
    assert_mirrored(Keep::All, "all", "", anywhere, false);
    assert_mirrored(Keep::All, "all", "--k 2 --l 2", on_a_small_grid, true);
}

#[test]
fn a_mirror_of_the_last_points_is_exact() {
    assert_mirrored(Keep::Points(60), "points:60", "--full", anywhere, false);
    assert_mirrored(Keep::Points(30), "points:30", "--alpha 0.6", on_a_small_grid, true);
    assert_mirrored(Keep::Points(1), "points:1", "", anywhere, false);
}

#[test]
fn a_mirror_of_the_last_frames_is_exact() {
    assert_mirrored(Keep::Frames(3), "frames:3", "--alpha 0.8", anywhere, false);
    assert_mirrored(Keep::Frames(1), "frames:1", "", on_a_small_grid, false);
    assert_mirrored(Keep::Frames(2), "frames:2", "--full", on_a_small_grid, true);
}

#[test]
fn a_mirror_of_the_last_time_is_exact_and_late_points_are_refused() {
    assert_mirrored(Keep::Time(2.5), "time:2.5", "--k 2", anywhere, false);
    assert_mirrored(Keep::Time(3.0), "time:3", "", on_a_small_grid, true);
}

#[test]
fn a_mirror_of_snapped_points_is_exact() {
    assert_mirrored(Keep::Points(50), "points:50", "--resolution 0.5", anywhere, false);
    assert_mirrored(Keep::Frames(2), "frames:2", "--resolution 2 --full", anywhere, false);
}

#[test]
fn late_points_are_refused_with_their_line() {
    let finished =
        hopes("serve --window time:10 --columns x,y,t").reads("x,y,t\n# c\n0,0,100\n1,0,89\n2,0,90\n3,0,110\n");
    assert!(finished.err.contains("line 4, point (1, 0): event time 89 is before 90"), "{}", finished.err);
    assert_eq!(finished.err.lines().count(), 1, "{}", finished.err);
    let frames = frames(finished);
    assert_eq!((frames[0].rejected, frames[0].time), (1, Some(110.0)));
    assert_eq!(frames[0].vertices.add.iter().map(|vertex| vertex.1).collect::<Vec<_>>(), [0.0, 3.0]);
}

#[test]
fn a_wild_time_is_refused_with_its_line_and_ends_nothing() {
    let rows = |times: std::ops::Range<u32>| times.map(|time| format!("{time},0,{time}\n")).collect::<String>();
    let input = format!("x,y,t\n{}0,0,9e9\n{}", rows(1..50), rows(50..100));
    let program = hopes("serve --window time:10 --columns x,y,t --frame-points 20");
    let finished = program.reads(&input);
    assert!(
        finished.err.contains("line 51, point (0, 0): event time 9000000000 is too far ahead of 49,"),
        "{}",
        finished.err
    );
    let shown = frames(finished);
    assert_eq!(shown.iter().map(|frame| frame.rejected).sum::<u64>(), 1);
    assert_eq!(shown.last().map(|frame| (frame.points, frame.time)), Some((11, Some(99.0))));
    let strict = program.and("--strict").reads(&input);
    assert!(strict.code == Some(3) && strict.err.contains("line 51"), "{:?}: {}", strict.code, strict.err);
    // A clock that steps back for good is believed.
    let shown = frames(program.reads("x,y,t\n".to_owned() + &rows(500..600) + &rows(100..200)));
    assert_eq!(shown.last().map(|frame| (frame.points, frame.time)), Some((11, Some(199.0))));
}

#[test]
fn frames_of_a_film_are_dated_by_their_commits() {
    let input = bunny();
    let films: Vec<(Value, f64)> = input
        .lines()
        .collect::<Vec<_>>()
        .chunks(2)
        .map(|pair| {
            let [points, commit] = [0, 1].map(|index| serde_json::from_str::<Value>(pair[index]).unwrap());
            (points["points"].clone(), commit["time"].as_f64().unwrap())
        })
        .collect();
    // Less than the time between two frames, and more.
    for length in [0.1, 0.5] {
        let shown = served(&format!("--input jsonl --window time:{length}"), &input);
        assert_eq!(shown.len(), films.len());
        for (frame, (_, time)) in shown.iter().zip(&films) {
            let kept = films.iter().filter(|(_, other)| other <= time && *other >= time - length);
            let places = kept.flat_map(|(points, _)| points.as_array().unwrap()).map(Value::to_string);
            let places = places.collect::<BTreeSet<_>>().len();
            assert_eq!((frame.time, frame.points, frame.rejected), (Some(*time), places, 0), "frame {}", frame.frame);
        }
    }
}

#[test]
fn a_stream_that_closes_its_frames_needs_a_time_in_them() {
    let shown = served("--window time:10 --input jsonl --frame-points 2", "[0,0]\n[1,0,3]\n[2,0]\n[3,0]\n");
    assert_eq!(
        shown.iter().map(|frame| (frame.points, frame.time)).collect::<Vec<_>>(),
        [(2, Some(3.0)), (4, Some(3.0))]
    );
    let finished = hopes("serve --window time:10 --frame-points 2").reads("0 0\n1 0\n2 0\n");
    assert_eq!(finished.err.matches("has no event time").count(), 3, "{}", finished.err);
    assert_eq!(finished.code, Some(1), "no point could be used");
    let finished = Finished { code: Some(0), ..finished };
    assert_eq!(frames(finished).iter().map(|frame| frame.rejected).collect::<Vec<_>>(), [2, 1]);
}

#[test]
fn a_point_without_a_time_has_the_newest_time() {
    let timeless = hopes("serve --window time:10").reads("0,0\n");
    assert!(timeless.err.contains("line 1, point (0, 0): the point has no event time"), "{}", timeless.err);
    let timed = served("--window time:10 --input jsonl", "[0,0,5]\n[1,0]\n[2,0,4]\n\n[3,0,14.5]\n\n[4,0,15.5]\n\n");
    assert_eq!(timed.iter().map(|frame| frame.points).collect::<Vec<_>>(), [3, 3, 2]);
    assert_eq!(timed[1].vertices.del, [2], "the third point, of time 4, is too old");
    assert_eq!(timed[2].vertices.del, [0, 1], "the second point is as old as the first");
}

#[test]
fn a_video_is_followed_frame_by_frame() {
    let input = bunny();
    let lines: Vec<&str> = input.lines().collect();
    let output = hopes("serve --input jsonl --window frames:1").reads(&input).text();
    let mut mirror = Mirror::default();
    let frames: Vec<FrameLine> = output.lines().map(FrameLine::of).collect();
    assert_eq!(frames.len(), 26);
    for (frame, points) in frames.iter().zip(lines.chunks(2)) {
        mirror.follow(frame);
        let commit: Value = serde_json::from_str(points[1]).unwrap();
        assert_eq!(frame.time, commit["time"].as_f64());
        let reply = Reply::of(hopes("compute - --input jsonl").reads(points[0]).out());
        assert_eq!(mirror.picture(), reply.picture(), "frame {}", frame.frame);
        assert_eq!(frame.view.vs, reply.view.vs);
    }
}

#[test]
fn the_same_input_gives_the_same_output_byte_for_byte() {
    let mut random = Random::new(5);
    let points: String = (0..4000).map(|_| random.node(40)).map(|[x, y]| format!("{x} {y}\n")).collect();
    let garbage = String::from_utf8_lossy(&random.bytes(2000)).into_owned();
    for (arguments, input) in [
        ("--input jsonl --window frames:1 --alpha 3", bunny()),
        ("--window points:500 --frame-points 300", points + &garbage),
    ] {
        let program = hopes("serve").and(arguments);
        assert!(program.reads(&input) == program.reads(&input), "{arguments}");
    }
}

// ---- bad input

#[test]
fn bad_lines_are_named_and_counted_in_their_frame_and_skipped() {
    let input = "x,y\n0,0\n# c\nzwei,2\n1,0\n\nnan,1\n1e300,0\n3\n\n1,1\n0,1\n";
    let finished = hopes("serve").reads(input);
    for reason in [
        "line 4, column 1: \"zwei\" is not a number",
        "line 7, point (NaN, 1): x = NaN is not a finite number",
        "line 8, point (1",
        "line 9, column 2: missing",
    ] {
        assert!(finished.err.contains(reason), "{reason:?} is missing in {}", finished.err);
    }
    // One line says what the header has chosen.
    assert_eq!(finished.err.lines().count(), 5, "{}", finished.err);
    let frames = frames(finished);
    assert_eq!(frames.iter().map(|frame| (frame.points, frame.rejected)).collect::<Vec<_>>(), [(2, 1), (2, 3), (4, 0)]);
    assert_eq!(frames[2].view.cycles, 1);

    let input = "[0,0]\n[1]\n{\"retract\":[[0,0],[5,5]]}\n{\"commit\":false}\n1,1\n{\"x\":1,\"y\":1}\n";
    let finished = hopes("serve --input jsonl").reads(input);
    for reason in ["line 2: 1 element(s)", "line 3, point (5, 5)", "line 4, commit: false", "line 5: \"1,1\""] {
        assert!(finished.err.contains(reason), "{reason:?} is missing in {}", finished.err);
    }
    let frames = self::frames(finished);
    assert_eq!((frames.len(), frames[0].points, frames[0].rejected), (1, 1, 4));
}

#[test]
fn strict_stops_at_the_first_bad_line() {
    for (arguments, input, words) in [
        ("", "0,0\nx,1\n1,1\n", ["line 2,", "\"x\" is not a number"]),
        ("", "# c\nx,y\n\u{20}# c\n0,inf\n", ["line 4,", "y = inf"]),
        ("--window time:1 --columns 1,2,3", "0,0,9\n1,1,3\n", ["line 2,", "event time 3 is before 8"]),
        ("--input jsonl", "[0,0]\n{\"retract\":[[1,1]]}\n", ["line 2,", "no point at (1, 1)"]),
        ("--input jsonl", "[0,0]\n[1,1\n", ["line 2,", "correct the JSON"]),
    ] {
        let program = hopes("serve --strict").and(arguments);
        program.reads(input).fails(3, &[&words[..], &["--strict stops here"]].concat());
    }
    let finished = hopes("serve --strict").reads("0,0\n\n1,0\nx,1\n\n");
    assert_eq!((finished.code, finished.out.iter().filter(|&&byte| byte == b'\n').count()), (Some(3), 1));
}

#[test]
fn strict_stops_while_the_producer_goes_on() {
    let mut running = hopes("serve --strict").start();
    running.say("0,0\n\n");
    assert_eq!(frame(&mut running).points, 1);
    running.say("bad,bad\n");
    assert_eq!(running.ends().code, Some(3));
}

#[test]
fn a_missing_column_is_named() {
    let program = hopes("serve --columns lon,alt");
    program.reads("lon,lat\n1,2\n").fails(1, &["line 1", "\"alt\"", "lon,lat", "number the columns from 1"]);
}

#[test]
fn invalid_arguments_give_an_error_with_a_remedy() {
    for (arguments, words) in [
        ("--window points:0", &["--window", "a number of points, from 1"][..]),
        ("--window last:5", &["all, points:N, frames:N or time:T"]),
        ("--window time:-1", &["must be above 0"]),
        ("--frame-points 0", &["--frame-points"]),
        ("--frame-every 0s", &["--frame-every", "is no time at all"]),
        ("--frame-every 5", &["--frame-every", "write it as 100ms or 2s"]),
        ("--alpha 1 --k 2", &["--alpha", "cannot be used with", "--k"]),
        ("--full --alpha 1", &["cannot be used with"]),
        ("--resolution -1", &["-1"]),
        ("--columns 1,2,3,4", &["choose two, x,y, or three, x,y,t"]),
        ("points.csv", &["points.csv"]),
    ] {
        hopes("serve").and(arguments).runs().fails(2, words);
    }
}

#[test]
fn an_input_that_fails_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let input = std::fs::File::open(folder.path()).unwrap();
    let output = hopes("serve").command().stdin(input).output().unwrap();
    let log = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{log}");
    assert!(log.contains("cannot read the input: line 1"), "{log}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_fails_is_a_failure() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = hopes("serve").command().stdout(full).output().unwrap();
    let log = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{log}");
    assert!(log.contains("cannot write frames") && log.contains("No space left"), "{log}");
}

#[test]
fn a_closed_stderr_does_not_stop_the_program() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let (input, mut producer) = std::io::pipe().unwrap();
    producer.write_all(("bad,0\n".repeat(200) + "0,0\n").as_bytes()).unwrap();
    drop(producer);
    let output = hopes("serve").command().stdin(input).stderr(writer).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let frame = FrameLine::of(std::str::from_utf8(&output.stdout).unwrap());
    assert_eq!((frame.points, frame.rejected), (1, 200));
}

// ---- ends

#[test]
fn a_closed_output_pipe_is_no_error_while_the_producer_goes_on() {
    let mut running = hopes("serve").start();
    let (mut stdin, mut stdout) = (running.take_stdin(), running.take_stdout());
    stdin.write_all(b"0 0\n\n").unwrap();
    stdout.read_exact(&mut [0; 10]).unwrap();
    drop(stdout);
    let producer = thread::spawn(move || {
        // The loop ends when the program closes the pipe.
        while stdin.write_all(b"1 1\n\n").is_ok() {}
    });
    let finished = running.ends();
    assert_eq!((finished.code, finished.err.as_str()), (Some(0), ""));
    producer.join().unwrap();
}

const POLITE: [(Signal, &str, i32); 2] = [(Signal::TERM, "SIGTERM", 143), (Signal::INT, "SIGINT", 130)];

#[test]
fn a_signal_ends_an_idle_stream() {
    for (signal, name, _) in POLITE {
        let mut running = hopes("serve").start();
        running.say("0 0\n\n");
        assert_eq!(frame(&mut running).points, 1);
        let stdin = running.take_stdin();
        running.signal(signal);
        let finished = running.finish();
        drop(stdin);
        assert_eq!((finished.code, finished.out.len()), (Some(0), 0), "no frame without points: {}", finished.err);
        assert!(finished.err.contains(&format!("{name}: stopped after frame 1")), "{}", finished.err);
    }
}

#[test]
fn a_signal_leaves_the_open_frame_out() {
    for (signal, name, _) in POLITE {
        let mut running = hopes("serve --window points:10").start();
        running.say("0 0\n\n");
        let mut mirror = Mirror::default();
        mirror.follow(&frame(&mut running));
        running.say("1 0\n0 1\nno point\n");
        running.until_log("line 5,");
        let stdin = running.take_stdin();
        running.signal(signal);
        let finished = running.finish();
        drop(stdin);
        assert_eq!((finished.code, finished.out.len()), (Some(0), 0), "{}", finished.err);
        // Half a scan is not published as a whole one.
        assert!(finished.err.contains("2 points after the last frame are left out"), "{}", finished.err);
        assert!(finished.err.contains(&format!("{name}: stopped after frame 1")), "{}", finished.err);
    }
}

/// Tests that ask the operating system about the process.
#[cfg(target_os = "linux")]
mod under_load {
    use std::process::ChildStdin;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread::JoinHandle;
    use std::time::Duration;

    use super::*;
    use common::process::settled;

    /// Writes in its own thread, and counts. The thread returns the pipe.
    struct Producer {
        thread: JoinHandle<ChildStdin>,
        written: Arc<AtomicUsize>,
    }

    impl Producer {
        fn start(write: impl FnOnce(&AtomicUsize) -> ChildStdin + Send + 'static) -> Self {
            let written = Arc::new(AtomicUsize::new(0));
            let counter = Arc::clone(&written);
            Self { thread: thread::spawn(move || write(&counter)), written }
        }

        /// Waits until the program has begun to write and nothing moves any more. Returns how many units it has
        /// accepted.
        fn until_blocked(&self, running: &Running) -> usize {
            let state = || (self.written.load(Ordering::Relaxed), running.unread());
            let (taken, _) = settled(Duration::from_millis(500), || Some(state()).filter(|&(_, unread)| unread > 0));
            taken
        }
    }

    /// A stream that is blocked, since nobody reads its frames.
    fn blocked() -> Running {
        let mut running = hopes("serve").start();
        let mut stdin = running.take_stdin();
        let producer = Producer::start(move |written| {
            // The loop ends when the program closes the pipe.
            while stdin.write_all(b"\n").is_ok() {
                written.fetch_add(1, Ordering::Relaxed);
            }
            stdin
        });
        producer.until_blocked(&running);
        running
    }

    #[test]
    fn a_second_signal_ends_a_blocked_stream() {
        for (first, second) in [(0, 0), (1, 1), (0, 1), (1, 0)] {
            let mut running = blocked();
            running.signal(POLITE[first].0);
            running.until_handled(POLITE[first].0);
            assert!(running.is_alive(), "the first signal waits for a reader");
            running.signal(POLITE[second].0);
            let finished = running.ends();
            assert_eq!(finished.code, Some(POLITE[second].2), "{}", finished.err);
        }
    }

    #[test]
    fn after_a_signal_all_closed_frames_are_still_written() {
        let mut running = blocked();
        running.signal(Signal::TERM);
        let mut mirror = Mirror::default();
        let mut frames = 0;
        while let Some(line) = running.line() {
            mirror.follow(&FrameLine::of(&line));
            frames += 1;
        }
        let finished = running.ends();
        assert_eq!(finished.code, Some(0), "{}", finished.err);
        assert!(finished.err.contains(&format!("SIGTERM: stopped after frame {frames}")), "{frames}: {}", finished.err);
    }

    /// The largest number of points between input and frame: 16 batches of 4096 in the queue, one being filled, one
    /// being processed.
    const QUEUED: usize = 18 * 4096;

    /// More memory than the program ever needs here: its own pages, the queued points (40 bytes each) and a few small
    /// frames.
    const MEMORY: u64 = 32 << 20;

    /// While nobody reads, the producer has to wait and memory is bounded. Nothing is lost once somebody reads.
    #[test]
    fn an_unread_output_blocks_the_producer() {
        const FRAME: usize = 5000;
        const LINE: usize = 125;
        const LINES: usize = 400_000;
        let mut running = hopes("serve --window points:1000").and(&format!("--frame-points {FRAME}")).start();
        let mut stdin = running.take_stdin();
        let producer = Producer::start(move |written| {
            let mut random = Random::new(11);
            for _ in 0..LINES {
                let [x, y] = random.point();
                let line = format!("{:-<1$}\n", format!("{x},{y},"), LINE - 1);
                stdin.write_all(line.as_bytes()).unwrap();
                written.fetch_add(LINE, Ordering::Relaxed);
            }
            stdin
        });
        let taken = producer.until_blocked(&running);
        // Frames: one being filled, two in the queue, one being written, some in the pipe. Bytes: in the reader's
        // buffer and in its pipe.
        let bound = (QUEUED + 6 * FRAME) * LINE + (64 << 10) + (64 << 10);
        assert!(taken < bound, "{taken} of {} bytes were taken, {bound} at the most are due", LINES * LINE);
        assert!(running.peak_memory() < MEMORY, "{}", running.peak_memory());
        let mut mirror = Mirror::default();
        for _ in 0..LINES / FRAME {
            mirror.follow(&frame(&mut running));
        }
        let stdin = producer.thread.join().unwrap();
        assert!(running.peak_memory() < MEMORY, "{}", running.peak_memory());
        drop(stdin);
        let finished = running.finish();
        assert_eq!((finished.code, finished.out.len()), (Some(0), 0), "{}", finished.err);
    }

    /// A hundred megabytes of bad lines: every line is counted, and none uses memory later.
    fn assert_bad_lines_are_skipped(arguments: &str, first: &'static str, last: &'static str) {
        let mut running = hopes("serve").and(arguments).start();
        let noise = Arc::new(Random::new(7).bytes(100_000_000));
        let (mut stdin, fed) = (running.take_stdin(), Arc::clone(&noise));
        let producer = thread::spawn(move || {
            for piece in [first.as_bytes(), &fed, last.as_bytes()] {
                stdin.write_all(piece).unwrap();
            }
            stdin
        });
        let (mut rejected, mut frames, mut points) = (0, 0, 0);
        while points == 0 {
            let frame = frame(&mut running);
            (rejected, frames, points) = (rejected + frame.rejected, frames + 1, frame.points);
        }
        assert_eq!(points, 1, "only the last line is a point");
        assert!(running.peak_memory() < MEMORY, "{}", running.peak_memory());
        drop(producer.join().unwrap());
        let finished = running.finish();
        assert_eq!((finished.code, finished.out.len()), (Some(0), 0), "{}", finished.err);
        assert!(!finished.err.contains("panicked") && finished.err.lines().count() < 110, "{}", finished.err);

        let (mut blank, mut bad) = (0, 0);
        let mut rest = Some(&noise[..]);
        while let Some(bytes) = rest {
            let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let line = &bytes[..end.unwrap_or(bytes.len())];
            rest = end.map(|end| &bytes[end + 1 + usize::from(bytes[end..].starts_with(b"\r\n"))..]);
            match line.trim_ascii().first() {
                None => blank += 1,
                Some(b'#') => {}
                Some(_) => bad += 1,
            }
        }
        assert_eq!((rejected, frames), (bad, blank + 1), "bad lines, blank lines and the last frame");
    }

    #[test]
    fn random_bytes_are_bad_lines_of_csv() {
        assert_bad_lines_are_skipped("", "x,y\n", "\n0,0\n\n");
    }

    #[test]
    fn random_bytes_are_bad_lines_of_json() {
        assert_bad_lines_are_skipped("--input jsonl", "", "\n[0,0]\n\n");
    }
}

// ---- tiles

/// Small changes of a larger cloud are computed in tiles, on any number of threads, and compared with recomputation.
#[test]
fn threads_and_checks_change_nothing() {
    let mut random = Random::new(11);
    let point = |_| {
        let [x, y] = random.point();
        format!("{x},{y}\n")
    };
    let input: String = (0..6000).map(point).collect();
    let said = |more: &str| hopes("serve --window points:3000 --frame-points 100").and(more).reads(&input).text();
    let alone = said("--threads 1");
    assert_eq!(alone.lines().count(), 60);
    for more in ["", "--threads 2", "--threads 8", "--threads 2 --check"] {
        assert!(said(more) == alone, "the output differs with {more:?}");
    }
}

#[test]
fn zero_threads_are_refused() {
    hopes("serve --threads 0").reads("").fails(2, &["--threads", "0"]);
}
