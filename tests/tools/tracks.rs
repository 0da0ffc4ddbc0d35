//! `hopes tracks`: tables and pictures of tracks written by hand, and invalid input.

use roxmltree::{Document, Node};
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::common::process::hopes;

/// An event as serve writes it.
fn event(id: u64, what: &str, birth: f64, death: f64, center: [f64; 2]) -> Value {
    json!({
        "id": id, "event": what, "age": 1, "birth": birth, "death": death, "center": center, "radius": death,
        "area": 1.0, "velocity": [0.0, 0.0],
    })
}

fn with(mut event: Value, key: &str, id: u64) -> Value {
    event[key] = json!(id);
    event
}

/// The relevant part of a line of `serve`.
fn line(stream: &str, frame: u64, time: Option<f64>, events: &[Value]) -> String {
    let view = json!({"kind": "full"});
    let frame =
        json!({"stream": stream, "frame": frame, "from": frame - 1, "time": time, "view": view, "tracks": events});
    format!("{frame}\n")
}

/// Two tracks are born. One splits, leaves the view and comes back; its part and the other one end.
fn lives() -> String {
    [
        line("default", 1, None, &[event(1, "born", 0.5, 2.0, [0.0, 0.0]), event(2, "born", 0.25, 1.0, [9.0, -1.0])]),
        line("default", 2, None, &[event(1, "updated", 0.5, 2.25, [0.5, 0.125])]),
        line("default", 4, None, &[with(event(3, "split", 0.5, 1.25, [1.5, 0.0]), "from", 1)]),
        line("default", 5, None, &[event(1, "unselected", 0.5, 1.0, [0.0, 0.0])]),
        line(
            "default",
            7,
            None,
            &[event(1, "reselected", 0.5, 1.0, [0.0, 0.0]), event(2, "died", 0.25, 1.0, [9.0, -1.0])],
        ),
        line("default", 9, None, &[with(event(3, "merged", 0.5, 1.0, [1.5, 0.0]), "into", 1)]),
        line("default", 10, None, &[]),
    ]
    .concat()
}

// ---- tables

#[test]
fn a_table_has_a_line_for_each_track() {
    let expected = "\
id  from  to  began         ended          persistence    x      y  radius
 1     1  10  born          alive                 1.75  0.5  0.125    2.25
 2     1   7  born          died                  0.75    9     -1       1
 3     4   9  split from 1  merged into 1         0.75  1.5      0    1.25
";
    assert_eq!(hopes("tracks -").reads(lives()).text(), expected);
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), lives()).unwrap();
    assert_eq!(hopes("tracks").with(file.path()).runs().text(), expected);
    assert_eq!(hopes("tracks - --format table").reads(lives().replace('\n', "\r\n\r\n")).text(), expected);
}

#[test]
fn streams_and_times_are_shown_where_there_are_any() {
    let text = [
        line("b,\"", 1, Some(0.5), &[event(1, "born", 0.0, 1.0, [0.0, 0.0])]),
        line("a", 7, None, &[event(1, "born", 0.0, 1.0, [0.0, 0.0])]),
        line("b,\"", 2, Some(1.25), &[event(1, "died", 0.0, 0.5, [0.0, 0.0])]),
    ]
    .concat();
    let expected = "\
stream  id  from  to  from time  to time  began  ended  persistence  x  y  radius
a        1     7   7          -        -  born   alive            1  0  0       1
b,\"      1     1   2        0.5     1.25  born   died             1  0  0       1
";
    assert_eq!(hopes("tracks -").reads(&text).text(), expected);
    let csv = "\
stream,id,from_frame,to_frame,from_time,to_time,began,split_from,ended,merged_into,peak_frame,peak_time,persistence,birth,death,x,y,radius
a,1,7,7,,,born,,alive,,7,,1,0,1,0,0,1
\"b,\"\"\",1,1,2,0.5,1.25,born,,died,,1,0.5,1,0,1,0,0,1
";
    assert_eq!(hopes("tracks - --format csv").reads(&text).text(), csv);
}

#[test]
fn programs_get_the_same_as_csv_and_as_json() {
    let csv = hopes("tracks - --format csv").reads(lives()).text();
    assert_eq!(csv.lines().nth(3), Some("default,3,4,9,,,split,1,merged,1,4,,0.75,0.5,1.25,1.5,0,1.25"));
    let table: Value = serde_json::from_slice(&hopes("tracks - --format json").reads(lives()).out()).unwrap();
    let moment = |frame: u64| json!({"frame": frame, "time": null});
    assert_eq!(table["streams"], json!([{"stream": "default", "frames": 7, "from": moment(1), "to": moment(10)}]));
    assert_eq!((&table["rejected"], table["tracks"].as_array().unwrap().len()), (&json!(0), 3));
    let peak = json!({
        "frame": 4, "time": null, "persistence": 0.75, "birth": 0.5, "death": 1.25, "center": [1.5, 0.0], "radius": 1.25,
    });
    let expected = json!({
        "stream": "default", "id": 3, "from": moment(4), "to": moment(9),
        "began": "split", "split_from": 1, "ended": "merged", "merged_into": 1, "peak": peak,
    });
    assert_eq!(table["tracks"][2], expected);
}

#[test]
fn the_list_of_living_tracks_counts_too() {
    let mut frame: Value = serde_json::from_str(&line("s", 5, None, &[])).unwrap();
    frame["alive"] = json!([[4, 0.5, 1.5, 3.0, 1.0, 4.0], [5, null, null, null, null, null]]);
    let expected = "\
id  from  to  began   ended  persistence    x    y  radius
 4     5   5  before  alive            3  0.5  1.5       3
 5     5   5  before  alive            -    -    -       -
";
    assert_eq!(hopes("tracks -").reads(frame.to_string()).text(), expected);
}

#[test]
fn no_frames_are_an_empty_table() {
    let heads = "id  from  to  began  ended  persistence  x  y  radius\n";
    assert_eq!(hopes("tracks -").runs().text(), heads);
    assert_eq!(hopes("tracks -").reads(line("s", 1, None, &[])).text(), heads);
    assert_eq!(hopes("tracks -").reads("{\"stream\":\"s\",\"lagged\":[1,2]}\n").text(), heads);
}

// ---- invalid input

#[test]
fn bad_lines_are_reported_and_skipped() {
    let good: Vec<String> = lives().lines().map(str::to_owned).collect();
    let bad = [
        "[1,2".to_owned(),
        line("default", 3, None, &[json!({"id": 9, "event": "vanished"})]),
        line("default", 3, None, &[event(9, "merged", 0.0, 1.0, [0.0, 0.0])]),
        line("default", 2, None, &[event(9, "born", 0.0, 1.0, [0.0, 0.0])]),
        line("default", 3, None, &[event(1, "born", 0.0, 9.0, [0.0, 0.0])]),
        json!({"stream": "default", "frame": 3, "edges": {}}).to_string(),
    ];
    let text = [&good[..2], &bad, &good[2..]].concat().join("\n");
    let finished = hopes("tracks -").reads(text);
    for words in [
        "line 3: \"[1,2\" is no JSON object",
        "line 4: tracks, event 1: \"vanished\" is none of born,",
        "line 6: tracks, event 1: merged needs \"into\"",
        "line 8: frame 2 of stream \"default\" comes after its frame 2",
        "line 10: frame 3: track 1 of stream \"default\" begins, but there was one with that id",
        "line 12: this frame has no tracks: run hopes serve with --track",
    ] {
        assert!(finished.err.contains(words), "{words:?} is missing in {}", finished.err);
    }
    assert_eq!(finished.text(), hopes("tracks -").reads(lives()).text());
}

#[test]
fn input_errors_are_counted() {
    let text = format!("{}{}", lives(), "nonsense\n".repeat(300));
    let finished = hopes("tracks - --format json").reads(text);
    assert!(finished.err.contains("300 lines or points in all could not be used"), "{}", finished.err);
    assert_eq!(finished.err.matches("nonsense").count(), 100, "{}", finished.err);
    let table: Value = serde_json::from_slice(&finished.out()).unwrap();
    assert_eq!(table["rejected"], 300);
}

#[test]
fn strict_stops_at_the_first_bad_line() {
    hopes("tracks - --strict")
        .reads(lives() + "nonsense\n")
        .fails(3, &["line 8: \"nonsense\" is no", "--strict stops here"]);
    hopes("tracks - --strict").reads(lives() + &lives()).fails(3, &["line 8: frame 1 of stream", "after its frame 10"]);
    let table = hopes("tracks -").reads(lives()).text();
    assert_eq!(hopes("tracks - --strict").reads(lives()).text(), table);
}

#[test]
fn frames_without_tracks_say_how_to_get_them() {
    let frame = json!({"stream": "default", "frame": 1, "vertices": {"add": [[0, 0.0, 0.0]], "del": []}}).to_string();
    hopes("tracks -")
        .reads(format!("\n{frame}\n{frame}\n"))
        .fails(1, &["-: line 2: this frame has no tracks", "serve with --track"]);
    let real = hopes("serve").reads("0,0\n1,0\n0,1\n\n").out();
    hopes("tracks -").reads(real).fails(1, &["line 1: this frame has no tracks"]);
}

#[test]
fn missing_files_and_lines_without_frames_are_reported() {
    hopes("tracks /nowhere/at.all").runs().fails(1, &["cannot open /nowhere/at.all", "No such file"]);
    hopes("tracks -").reads("0,0\n1,1\n").fails(1, &["line 1: ", "line 2: ", "- has no frame"]);
    hopes("tracks - --most 5").runs().fails(2, &["--svg"]);
    hopes("tracks - --svg x.svg --most 0").runs().fails(2, &["from 1 to 10000"]);
    hopes("tracks - --svg /nowhere/at/all.svg").reads(lives()).fails(1, &["cannot write /nowhere/at/all.svg"]);
}

#[test]
fn damaged_lines_do_not_cause_panics() {
    let bytes = lives().into_bytes();
    for at in (0..bytes.len()).step_by(19) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        let finished = hopes("tracks - --quiet --format json").reads(&damaged);
        assert!(matches!(finished.code, Some(0 | 1)) && !finished.err.contains("panicked"), "{at}: {}", finished.err);
    }
    let deep = "{\"deep\":".repeat(1 << 18) + "\n{\"deep\":" + &"[".repeat(1 << 20) + "\n";
    let finished = hopes("tracks -").reads(deep + &lives());
    assert!(finished.err.contains("line 1: byte ") && finished.err.contains("line 2: byte "), "{}", finished.err);
    assert_eq!(finished.text().lines().count(), 4);
}

// ---- ends

#[test]
fn a_signal_shows_the_input_read_so_far() {
    let mut running = hopes("tracks - -v").start();
    running.say(lives());
    running.until_read();
    running.signal(Signal::INT);
    running.until_log("SIGINT: stopped after 7 frames");
    assert_eq!((0..4).filter_map(|_| running.line()).count(), 4, "a line of heads and three tracks");
    // Its stdin stays open to the end.
    let finished = running.ends();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
}

#[test]
fn a_closed_pipe_is_no_error() {
    let many: Vec<Value> = (0..5000).map(|id| event(id, "born", 0.0, 1.0, [0.0, 0.0])).collect();
    let mut running = hopes("tracks -").start();
    drop(running.take_stdout());
    running.say(line("s", 1, None, &many));
    drop(running.take_stdin());
    let finished = running.ends();
    assert_eq!((finished.code, finished.err.as_str()), (Some(0), ""));
}

// ---- pictures

/// The picture of an input.
fn picture(text: &str, arguments: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lives.svg");
    hopes("tracks - --svg").with(&path).and(arguments).reads(text).out();
    std::fs::read_to_string(&path).unwrap()
}

fn class<'a>(document: &'a Document<'a>, class: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|node| node.attribute("class") == Some(class)).collect()
}

fn number(node: Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap_or_else(|| panic!("{node:?} has no {name}")).parse().unwrap()
}

fn hint<'a>(bar: Node<'a, 'a>) -> &'a str {
    bar.children().find(|child| child.has_tag_name("title")).and_then(|title| title.text()).unwrap()
}

#[test]
fn bars_show_lifetimes_and_links_show_splits_and_mergers() {
    let text = picture(&lives(), "");
    assert_eq!(text, picture(&lives(), "--axis frame --most 3"), "the same input gives the same bytes");
    let document = Document::parse(&text).unwrap();
    let bars = class(&document, "bar");
    let hints: Vec<&str> = bars.iter().map(|&bar| hint(bar)).collect();
    // The part is next to the track that it split from.
    assert_eq!(
        hints,
        [
            "default, track 1: born in frame 1, alive in frame 10, persistence 1.75 in frame 2 at (0.5, 0.125)",
            "default, track 3: split from 1 in frame 4, merged into 1 in frame 9, persistence 0.75 in frame 4 at (1.5, 0)",
            "default, track 2: born in frame 1, died in frame 7, persistence 0.75 in frame 1 at (9, -1)",
        ]
    );
    let rects = |bar: Node<'_, '_>, class: Option<&str>| -> Vec<[f64; 2]> {
        let rects = bar.children().filter(|node| node.has_tag_name("rect") && node.attribute("class") == class);
        rects.map(|rect| [number(rect, "x"), number(rect, "x") + number(rect, "width")]).collect()
    };
    let [whole] = rects(bars[0], None)[..] else { panic!("one rectangle for all of a life") };
    let frame = |number: f64| whole[0] + (whole[1] - whole[0]) / 9.0 * (number - 1.0);
    let close = |found: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - frame(*expected)).abs() < 0.03, "{found} is not frame {expected}");
        }
    };
    close(rects(bars[0], Some("full")), &[[1.0, 5.0], [7.0, 10.0]]);
    close(rects(bars[1], Some("full")), &[[4.0, 9.0]]);
    close(rects(bars[2], Some("full")), &[[1.0, 7.0]]);
    for (kind, at) in [("split", 4.0), ("merger", 9.0)] {
        let [link] = class(&document, kind)[..] else { panic!("one {kind}") };
        assert!((number(link, "x1") - frame(at)).abs() < 0.03 && link.attribute("x1") == link.attribute("x2"));
        assert!(number(link, "y1") < number(link, "y2"), "from the whole to the part");
    }
    assert_eq!(class(&document, "on").len(), 1, "one lives on");
    for words in [
        "7 frames \u{b7} 3 tracks \u{b7} 1 split \u{b7} 1 merger",
        "frame",
        "split",
        "merger",
        "alive at the end",
        "not selected by the view",
        "persistence",
    ] {
        assert!(document.descendants().any(|node| node.is_text() && node.text() == Some(words)), "{words}");
    }
}

#[test]
fn the_most_persistent_are_shown_and_the_rest_is_counted() {
    let text = picture(&lives(), "--most 1");
    let document = Document::parse(&text).unwrap();
    assert_eq!(class(&document, "bar").len(), 1);
    assert!(hint(class(&document, "bar")[0]).contains("track 1:"));
    assert!(class(&document, "split").is_empty() && class(&document, "merger").is_empty());
    assert!(text.contains("the 1 most persistent shown, 2 left out"), "{text}");
    assert!(!picture(&lives(), "").contains("left out"));
}

#[test]
fn bars_of_several_streams_are_told_apart() {
    let (long, born) = ("x".repeat(190), [event(31, "born", 0.0, 1.0, [0.0, 0.0])]);
    let text = picture(&(line(&long, 1, None, &born) + &line("a", 1, None, &born)), "");
    let document = Document::parse(&text).unwrap();
    let names = document.descendants().filter(|node| node.has_tag_name("text")).filter_map(|node| node.text());
    let names: Vec<&str> = names.filter(|name| name.ends_with(" 31")).collect();
    assert_eq!(names, ["a 31", &format!("\u{2026}{} 31", "x".repeat(16))]);
}

#[test]
fn any_tracks_make_a_well_formed_document() {
    let many: Vec<Value> = (0..3000).map(|id| event(id, "born", 0.0, id as f64, [0.0, 0.0])).collect();
    let odd = [
        line(
            "<&\">",
            3,
            Some(-8e307),
            &[event(1, "born", 0.0, 1e300, [0.0, 0.0]), event(2, "died", 0.0, 0.0, [0.0, 0.0])],
        ),
        line("<&\">", u64::MAX, Some(1e-320), &[with(event(3, "split", 0.0, 1e-300, [0.0, 0.0]), "from", 77)]),
    ]
    .concat();
    for (input, arguments, bars) in [
        ("", "", 0),
        (&line("s", 1, None, &[]), "", 0),
        (&line("s", 1, Some(0.0), &many), "", 100),
        (&line("s", 1, Some(0.0), &many), "--most 2500 --axis time", 2500),
        (&odd, "--axis time", 3),
        (&odd, "--axis frame", 3),
    ] {
        let text = picture(input, arguments);
        let document = Document::parse(&text).unwrap();
        assert_eq!(class(&document, "bar").len(), bars, "{arguments}");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{arguments}: {text}");
    }
}

#[test]
fn times_are_drawn_only_if_there_are_any() {
    let folder = tempfile::tempdir().unwrap();
    let draw = |text: String| hopes("tracks - --axis time --svg").with(folder.path().join("x.svg")).reads(text);
    draw(lives()).fails(1, &["--axis time: not all frames have a time"]);
    let far =
        [line("s", 1, Some(-1.7e308), &[event(1, "born", 0.0, 1.0, [0.0, 0.0])]), line("s", 2, Some(1.7e308), &[])];
    draw(far.concat()).fails(1, &["too far apart"]);
    let timed = [line("s", 1, Some(5.0), &[event(1, "born", 0.0, 1.0, [0.0, 0.0])]), line("s", 2, Some(7.5), &[])];
    let document = picture(&timed.concat(), "--axis time");
    assert!(document.contains(">time</text>") && document.contains(">7.5</text>"), "{document}");
}
