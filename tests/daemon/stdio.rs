//! Stdin and stdout beside sockets, and the wire protocol in pipes.

use std::io::Write;

use hopes_protocol::*;

use crate::common::growing_stream::frames;
use crate::common::mirror::{FrameLine, Mirror as LineMirror};
use crate::common::peers::{Daemon, FULL, Point, points};
use crate::common::process::hopes;
use crate::common::random::Random;

#[test]
fn stdin_feeds_the_default_stream_and_the_daemon_goes_on_after_it() {
    let mut daemon = Daemon::start("--input jsonl --window points:3");
    let mut consumer = daemon.consumer("default", FULL);
    assert_eq!(consumer.opened.window, Window::Points(3));
    daemon.running.say("{\"points\":[[0,0],[1,0]],\"t\":2.5}\n{\"commit\":true}\n");
    assert_eq!(consumer.expect_snapshot(Cause::Start), 1);
    assert_eq!(consumer.mirror.frame().unwrap().time, Some(2.5));
    // A producer feeds the same stream.
    let mut producer = daemon.producer("default");
    assert_eq!(producer.frame(&[(2.0, 0.0)]), 2);
    consumer.expect_diff(2);
    daemon.running.say("bad\n{\"points\":[[3,0]]}\n");
    drop(daemon.running.take_stdin());
    // The last points make a frame too. After that only sockets are left.
    let diff = consumer.expect_diff(3);
    assert_eq!((diff.frame.points, diff.frame.rejected), (3, 1));
    assert_eq!(producer.frame(&[(4.0, 0.0)]), 4);
    consumer.expect_diff(4);
    let finished = daemon.stop();
    assert!(finished.err.contains("line 3"), "{}", finished.err);
}

#[test]
fn stdout_shows_what_producers_send() {
    let mut daemon = Daemon::start("--output jsonl --full");
    let mut producer = daemon.producer("default");
    let mut consumer = daemon.consumer("default", FULL);
    let mut random = Random::new(70);
    let mut mirror = LineMirror::default();
    for frame in 1..=5 {
        assert_eq!(producer.frame(&points(&mut random, 20)), frame);
        consumer.follow_to(frame);
        let line = FrameLine::of(&daemon.running.line().expect("a line for each frame"));
        assert_eq!((line.frame, line.stream.as_str()), (frame, "default"));
        mirror.follow(&line);
        assert_eq!(mirror.checksum(), format!("{:016x}", consumer.mirror.checksum()));
    }
    daemon.producer("other").frame(&[(0.0, 0.0)]);
    let batch = producer.batch(&[(9.0, 9.0)]);
    producer.is_accepted(batch, 1);
    daemon.running.signal(rustix::process::Signal::TERM);
    assert_eq!(daemon.running.line(), None, "neither other streams nor points without a commit are shown");
    crate::common::peers::assert_clean_exit(daemon.running.ends());
}

#[test]
fn a_closed_stdout_does_not_stop_the_sockets() {
    let mut daemon = Daemon::start("--output jsonl");
    drop(daemon.running.take_stdout());
    let mut producer = daemon.producer("default");
    for frame in 1..=20 {
        assert_eq!(producer.frame(&[(frame as f64, 0.0)]), frame);
    }
    let mut consumer = daemon.consumer("default", FULL);
    assert_eq!(consumer.expect_snapshot(Cause::Start), 20);
    daemon.running.signal(rustix::process::Signal::TERM);
    assert_eq!(daemon.running.ends().code, Some(0));
}

/// Some frames in the wire protocol and as JSON lines.
fn both_forms() -> (Vec<u8>, String) {
    let mut random = Random::new(71);
    let (mut messages, mut lines) = (Vec::new(), String::new());
    for sequence in 0..6 {
        let batch: Vec<Point> = points(&mut random, 30);
        let written: Vec<String> = batch.iter().map(|(x, y)| format!("[{x:?},{y:?}]")).collect();
        lines += &format!("{{\"points\":[{}]}}\n", written.join(","));
        let (x, y) = batch[0];
        messages.push(Batch { sequence, points: batch, times: vec![], tags: vec![] }.into());
        messages.push(Retract { sequence, points: vec![(x, y)] }.into());
        messages.push(Commit { sequence, time: Some(sequence as f64) }.into());
        lines += &format!("{{\"retract\":[[{x:?},{y:?}]]}}\n{{\"commit\":true,\"time\":{sequence}}}\n");
    }
    (frames(&messages), lines)
}

#[test]
fn the_wire_protocol_gives_the_same_as_lines() {
    let (bytes, lines) = both_forms();
    let serve = |arguments: &str, input: &[u8]| hopes("serve --full").and(arguments).reads(input).out();
    let expected = serve("--input jsonl --output jsonl", lines.as_bytes());
    assert_eq!(LineMirror::of(std::str::from_utf8(&expected).unwrap()).picture().vertices.len(), 6 * 29);
    let same = |other: &[u8]| assert_eq!(String::from_utf8_lossy(other), String::from_utf8_lossy(&expected));
    same(&serve("--input bin", &bytes));
    for (input, form) in [(&bytes[..], "bin"), (lines.as_bytes(), "jsonl")] {
        let recording = serve(&format!("--input {form} --output bin"), input);
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(&recording).unwrap();
        same(&hopes("replay --output jsonl").with(file.path()).runs().out());
    }
}

#[test]
fn a_cut_off_input_is_reported_and_whole_messages_are_processed() {
    let (bytes, _) = both_forms();
    let finished = hopes("serve --input bin").reads(&bytes[..bytes.len() - 1]);
    assert!(finished.err.contains("the input is cut off at byte"), "{}", finished.err);
    assert_eq!(finished.text().lines().count(), 6, "the last one has no commit");
    let strict = hopes("serve --input bin --strict").reads(&bytes[..bytes.len() - 1]);
    assert_eq!(strict.code, Some(3), "{}", strict.err);
}

#[test]
fn bytes_feed_a_daemon_that_listens() {
    let (bytes, _) = both_forms();
    let mut daemon = Daemon::start("--input bin");
    let mut consumer = daemon.consumer("default", FULL);
    let mut stdin = daemon.running.take_stdin();
    stdin.write_all(&bytes).unwrap();
    consumer.follow_to(6);
    assert_eq!(consumer.mirror.vertices().len(), 6 * 29);
    drop(stdin);
    daemon.producer("cam").frame(&[(0.0, 0.0)]);
    daemon.stop();
}
