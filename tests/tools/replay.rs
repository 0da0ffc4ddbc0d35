//! `hopes replay`: whole recordings, recordings that are cut off or damaged, and files that are not recordings.

use std::time::{Duration, Instant};

use hopes_protocol::*;
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::common::growing_stream::{GrowingStream, frames, recording, recording_in};
use crate::common::mirror::Mirror as LineMirror;
use crate::common::process::{Finished, hopes};

pub const AT_ONCE: Duration = Duration::ZERO;

/// The messages of a daemon for four frames.
pub fn messages() -> Vec<Message> {
    let mut scene = GrowingStream::new(3);
    let mut messages = vec![scene.opened("cam", 7), scene.snapshot(Cause::Start), scene.diff()];
    messages.push(scene.dots());
    scene.diff();
    messages.extend([Lagged { stream: 3, first: 3, last: 4 }.into(), scene.clone().snapshot(Cause::Lagged)]);
    messages.push(scene.diff());
    messages.extend([
        Heartbeat { stream: 3, frame: 4 }.into(),
        StreamClosed { stream: 3, frame: 4, reason: "its producer\u{1b}[2J wants it".to_owned() }.into(),
    ]);
    messages
}

pub fn at_once(messages: &[Message]) -> Vec<(Duration, Message)> {
    messages.iter().map(|message| (AT_ONCE, message.clone())).collect()
}

pub fn json_lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

pub fn replay(arguments: &str, bytes: impl AsRef<[u8]>) -> Finished {
    hopes("replay -").and(arguments).reads(bytes)
}

/// The lines that are replayed of a damaged recording, and the result of the process.
pub fn played(bytes: &[u8]) -> (usize, Finished) {
    let finished = replay("--fast --output jsonl", bytes);
    assert!(!finished.err.contains("panicked"), "{}", finished.err);
    (json_lines(std::str::from_utf8(&finished.out).unwrap()).len(), finished)
}

#[test]
fn a_recording_is_shown_to_people() {
    let text = replay("--fast", recording(&at_once(&messages()))).text();
    let expected = "\
cam  frame 1  time 0.5  points 1 (1 distinct)  components 1  cycles 0  ds inf vs inf  all 1 (start)
cam  frame 2  time 1  points 2 (2 distinct)  components 1  cycles 0  ds inf vs inf  +2 -0
cam  frame 2  dots 1 of 7:  0.5..2 (0-1)
cam  frames 3 to 4 come as one: this side was too slow
cam  frame 3  time 1.5  points 3 (3 distinct)  components 1  cycles 0  ds inf vs inf  all 5 (lagged)
cam  frame 4  time 2  points 4 (4 distinct)  components 1  cycles 0  ds inf vs inf  +2 -0
cam  closed after frame 4: its producer[2J wants it
";
    assert_eq!(text, expected);
}

#[test]
fn a_recording_is_shown_to_programs() {
    let text = replay("--fast --output jsonl", recording(&at_once(&messages()))).text();
    let lines = json_lines(&text);
    assert_eq!(lines.len(), 6);
    let Message::Diff(diff) = messages()[2].clone() else { panic!("the scene has changed") };
    let view = json!({"kind": "derived", "k": 1, "l": 1, "ds": null, "vs": null, "components": 1, "cycles": 0});
    let expected = json!({
        "stream": "cam", "frame": 2, "from": 1, "time": 1.0, "points": 2, "rejected": 0, "view": view,
        "vertices": {"add": [[1, 1.0, 0.5]], "del": []},
        "edges": {"add": [[0, 1]], "del": []},
        "critical": {"set": [], "del": []},
        "checksum": format!("{:016x}", diff.checksum),
    });
    assert_eq!(lines[1], expected);
    let hole = json!({"center": [1.0, 1.0], "radius": 2.0});
    let dot = json!({"birth": 0.5, "death": 2.0, "edge": [0, 1], "hole": hole});
    assert_eq!(lines[2], json!({"stream": "cam", "frame": 2, "dots": [dot], "total": 7}));
    assert_eq!(lines[3], json!({"stream": "cam", "lagged": [3, 4]}));
    assert_eq!((&lines[4]["from"], &lines[4]["frame"]), (&json!(0), &json!(3)), "a snapshot is a change from nothing");
    let diffs: String = text.lines().take(2).map(|line| format!("{line}\n")).collect();
    assert_eq!(LineMirror::of(&diffs).checksum(), format!("{:016x}", diff.checksum));
}

#[test]
fn a_recording_of_a_recording_is_the_same() {
    let times = (0u64..).map(Duration::from_millis);
    let bytes = recording(&times.zip(messages()).collect::<Vec<_>>());
    assert_eq!(replay("--fast --output bin", &bytes).out(), bytes);
}

/// Files are written in one version and read in all.
#[test]
fn a_recording_in_any_version_is_read() {
    let newest = at_once(&messages());
    let shown = replay("--fast --output bin", recording(&newest)).out();
    for version in 1..=FILE_VERSION + 1 {
        assert_eq!(replay("--fast --output bin", recording_in(version, &newest)).out(), shown, "version {version}");
    }
    // One in which streams in R^d may be stays so.
    let mixed = recording_in(SPACE_FILE_VERSION, &newest);
    assert_eq!(replay("--fast --output bin", &mixed).out(), mixed);
}

#[test]
fn the_pace_can_be_changed() {
    let times = [0, 0, 600].map(Duration::from_millis);
    let bytes = recording(&times.into_iter().zip(messages()).collect::<Vec<_>>());
    let took = |arguments: &str| {
        let begun = Instant::now();
        replay(arguments, &bytes).out();
        begun.elapsed()
    };
    assert!(took("") >= Duration::from_millis(600));
    assert!(took("--speed 3") >= Duration::from_millis(200));
    // Times that go back or are huge must not cause a panic.
    let mut odd =
        recording(&[(Duration::from_nanos(u64::MAX), messages()[0].clone()), (AT_ONCE, messages()[1].clone())]);
    assert_eq!(replay("--fast --output bin", &odd).out(), odd);
    let mut running = hopes("replay - --speed 1e-300").start();
    odd.truncate(odd.len() - 1);
    running.say(&odd);
    running.until_log("the next frame is due in");
    running.signal(Signal::INT);
    assert_eq!(running.finish().code, Some(0));
}

#[test]
fn a_recording_that_is_cut_off_is_replayed_up_to_the_cut() {
    let mut scene = GrowingStream::new(1);
    let parts = [scene.opened("s", 1), scene.snapshot(Cause::Start), scene.diff()];
    let bytes = recording(&at_once(&parts));
    let ends: Vec<usize> = (1..=parts.len()).map(|count| recording(&at_once(&parts[..count])).len()).collect();
    let elapsed = ends[0] - frames(&parts[..1]).len();
    for length in 0..=bytes.len() {
        let (lines, finished) = played(&bytes[..length]);
        assert_eq!(lines, ends[1..].iter().filter(|&&end| end <= length).count(), "{length}");
        assert_eq!(finished.code, Some(0), "{length}: {}", finished.err);
        let starts = [Banner::LENGTH].iter().chain(&ends).flat_map(|&end| [end, end + elapsed]);
        let is_whole = starts.clone().any(|start| start == length);
        assert_eq!(finished.err.contains("has no end after"), is_whole, "{length}: {}", finished.err);
        assert_eq!(finished.err.lines().count(), 1, "{length}: {}", finished.err);
        let begun = starts.filter(|&start| start <= length).max().unwrap_or(0);
        assert!(is_whole || finished.err.contains(&format!("cut off at byte {begun}:")), "{length}: {}", finished.err);
    }
}

#[test]
fn a_damaged_recording_says_where() {
    let bytes = recording(&at_once(&messages()[..3]));
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        let (lines, finished) = played(&damaged);
        assert!(lines <= 2 && finished.code == Some(1), "byte {at}: {}", finished.err);
        let place = if at < Banner::LENGTH { "not written by hopes" } else { "damaged at byte " };
        assert!(finished.err.contains(place), "byte {at}: {}", finished.err);
    }
}

#[test]
fn files_that_are_not_recordings_are_refused() {
    let banner = |lowest, highest| Banner { lowest, highest }.encode();
    replay("", b"points,in,a,table\n1,2,3,4\n").fails(1, &["not written by hopes", "-: "]);
    replay("", banner(5, 9)).fails(1, &["too new or too old", "speaks protocol versions 5 to 9"]);
    hopes("replay /nowhere/at.all").runs().fails(1, &["cannot open /nowhere/at.all"]);
    let frame = |kind, length| [&banner(1, 1)[..], &header(1, kind, 1, length)].concat();
    replay("", frame(0x0206, u32::MAX)).fails(1, &["damaged at byte 20", "4294967295 bytes"]);
    // The largest allowed length without a body: nothing is allocated, and nothing is waited for.
    let finished = replay("", frame(0x0206, LARGEST_FRAME));
    assert!(finished.code == Some(0) && finished.err.contains("cut off at byte 20"), "{}", finished.err);
    let other_version = [&banner(1, 1)[..], &encode(2, 0, &Ping { token: 1 }.into()).unwrap()].concat();
    replay("", other_version).fails(1, &["damaged at byte 20", "version 2"]);
    replay("", frames(&[Commit { sequence: 1, time: None }.into()])).fails(1, &["byte 20", "hopes feed --input bin"]);
    replay("", frames(&[Ping { token: 1 }.into()])).fails(1, &["at byte 20", "no place"]);
    replay("", frames(&[GrowingStream::new(1).dots()])).fails(1, &["at byte 20", "no stream number 1"]);
}

#[test]
fn announced_lengths_take_no_memory() {
    // A snapshot that announces 2^60 vertices.
    let Message::Snapshot(snapshot) = GrowingStream::new(1).snapshot(Cause::Start) else {
        panic!("the scene has changed")
    };
    let mut opened = frames(&[GrowingStream::new(1).opened("s", 1)]);
    let whole = encode(VERSION, 1, &Snapshot { vertices: Vec::new(), ..snapshot }.into()).unwrap();
    let body = &whole[HEADER..whole.len() - 4];
    // The three empty lists, and a checksum of nine bytes.
    let lists = body.len() - 9 - 3;
    let mut body = body[..lists].to_vec();
    body.extend([253, 0, 0, 0, 0, 0, 0, 0, 16]);
    let place = format!("damaged at byte {}", opened.len());
    opened.extend(header(VERSION, 0x0206, 1, body.len() as u32));
    opened.extend(&body);
    opened.extend(crc32c(&body).to_le_bytes());
    replay("", opened).fails(1, &[&place]);
}

/// A reference implementation, bit by bit.
fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0x82F6_3B78 } else { crc >> 1 })
    })
}

#[test]
fn a_recording_with_a_gap_is_damaged() {
    let mut scene = GrowingStream::new(1);
    let mut messages = vec![scene.opened("s", 1), scene.snapshot(Cause::Start)];
    scene.diff();
    messages.push(scene.diff());
    let finished = replay("--fast", frames(&messages));
    assert_eq!(finished.code, Some(1));
    let place = format!("at byte {}", frames(&messages[..2]).len());
    for words in ["frame 3 starts from frame 2, but the mirror holds frame 1", "stream s", &place] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
}

#[test]
fn a_signal_ends_a_replay_that_waits_for_more() {
    let mut running = hopes("replay -").start();
    running.say(recording(&at_once(&messages()[..2])));
    assert!(running.line().is_some());
    running.signal(Signal::TERM);
    running.until_log("SIGTERM: stopped after 1 frames");
    assert_eq!(running.ends().code, Some(0));
}
