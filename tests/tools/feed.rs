//! `hopes feed`: what it sends, and how it handles answers and daemons that do not answer.

use std::io::Write;
use std::time::{Duration, Instant};

use hopes_protocol::*;
use rustix::process::Signal;
use serde_json::json;

use crate::common::fake_daemon::{FakeDaemon, Peer, welcome};
use crate::common::growing_stream::{frames, recording};
use crate::common::process::{Hopes, hopes};
use crate::replay::{at_once, messages};

fn feed(daemon: &FakeDaemon, arguments: &str) -> Hopes {
    hopes("feed - --to").with(daemon.address()).and(arguments)
}

/// Accepts everything that a producer sends. Returns the messages.
fn take_all(peer: &mut Peer, channel: u32) -> Vec<Message> {
    let (mut taken, mut frame) = (Vec::new(), 0);
    loop {
        let (on, message) = peer.next().expect("a producer closes before it goes");
        assert_eq!(on, channel);
        match message.clone() {
            Message::Batch(Batch { sequence, points, .. }) | Message::Retract(Retract { sequence, points }) => {
                peer.send(channel, Accepted { sequence, points: points.len() as u32, placed: Vec::new() });
            }
            Message::Commit(Commit { sequence, .. }) => {
                frame += 1;
                peer.send(channel, Committed { sequence, frame });
            }
            Message::Close(Close { end: false }) => {
                peer.send(channel, Closed { frame });
                assert_eq!(peer.expect_goodbye(), "that is all");
                return taken;
            }
            other => panic!("{other:?}"),
        }
        taken.push(message);
    }
}

/// Messages without their sequence numbers, which are checked to count from 0.
fn contents(messages: Vec<Message>) -> Vec<String> {
    let mut next = 0;
    let mut numbered = |sequence| {
        assert_eq!(sequence, next);
        next += 1;
    };
    messages
        .into_iter()
        .map(|message| match message {
            Message::Batch(Batch { sequence, points, times, tags }) => {
                numbered(sequence);
                assert!(tags.is_empty());
                format!("add {points:?} {times:?}")
            }
            Message::Retract(Retract { sequence, points }) => {
                numbered(sequence);
                format!("retract {points:?}")
            }
            Message::Commit(Commit { sequence, time }) => {
                numbered(sequence);
                format!("commit {time:?}")
            }
            other => panic!("{other:?}"),
        })
        .collect()
}

/// The messages that a feed with these arguments sends for an input, and its log.
fn fed(arguments: &str, input: &[u8]) -> (Vec<String>, String) {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, arguments).start();
    client.take_stdin().write_all(input).unwrap();
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    let sent = contents(take_all(&mut peer, channel));
    let finished = client.finish();
    assert_eq!((finished.code, finished.out.len()), (Some(0), 0), "{}", finished.err);
    (sent, finished.err)
}

#[test]
fn lines_are_sent_as_messages() {
    let (sent, log) = fed("", b"0,1\n2,3\n\nnan,5\n\n\n7,8");
    let expected = [
        "add [(0.0, 1.0), (2.0, 3.0)] []",
        "commit None",
        "add [(NaN, 5.0)] []",
        "commit None",
        "commit None",
        "add [(7.0, 8.0)] []",
        "commit None",
    ];
    assert_eq!(sent, expected);
    assert!(log.contains("4 points accepted, 0 refused, 0 dropped; 4 frames, the last is 4"), "{log}");
    let lines = b"[1,2]\n[3,4,5]\nnonsense\n{\"retract\":[[1,2]]}\n{\"commit\":true,\"time\":6}\n";
    let (sent, log) = fed("--input jsonl", lines);
    assert_eq!(sent, ["add [(1.0, 2.0)] []", "add [(3.0, 4.0)] [5.0]", "retract [(1.0, 2.0)]", "commit Some(6.0)"]);
    assert!(log.contains("line 3") && log.contains("2 points accepted, 1 taken back, 1 refused"), "{log}");
    let (sent, _) = fed("--frame-points 2 --columns 2,1", b"0,1\n2,3\n4,5\n");
    assert_eq!(sent, ["add [(1.0, 0.0), (3.0, 2.0)] []", "commit None", "add [(5.0, 4.0)] []", "commit None"]);
    assert_eq!(fed("", b"").0, [""; 0]);
}

#[test]
fn input_in_the_wire_protocol_is_forwarded() {
    let input = frames(&[
        Batch { sequence: 9, points: vec![(1.0, 2.0), (3.0, 4.0)], times: vec![5.0, 6.0], tags: vec![7, 8] }.into(),
        Retract { sequence: 9, points: vec![(1.0, 2.0)] }.into(),
        Commit { sequence: 9, time: Some(1.0) }.into(),
        Batch { sequence: 9, points: vec![(1.0, 2.0), (3.0, 4.0)], times: vec![5.0], tags: vec![] }.into(),
        Batch { sequence: 9, points: vec![(9.0, 9.0)], times: vec![], tags: vec![] }.into(),
    ]);
    let expected = [
        "add [(1.0, 2.0), (3.0, 4.0)] [5.0, 6.0]",
        "retract [(1.0, 2.0)]",
        "commit Some(1.0)",
        "add [(9.0, 9.0)] []",
        "commit None",
    ];
    let (sent, log) = fed("--input bin", &input);
    assert_eq!(sent, expected);
    assert!(log.contains("2 points with 1 times"), "{log}");
    let (sent, log) = fed("--input bin", &input[..input.len() - 1]);
    assert_eq!(sent, expected[..3]);
    assert!(log.contains("the input is cut off at byte"), "{log}");
}

#[test]
fn input_that_cannot_be_read_fails() {
    let fails = |arguments: &str, input: &[u8], words: &[&str]| {
        let daemon = FakeDaemon::new();
        let mut client = feed(&daemon, arguments).start();
        client.take_stdin().write_all(input).unwrap();
        let mut peer = daemon.greet();
        peer.open(5000);
        peer.expect_goodbye();
        client.finish().fails(1, words);
    };
    fails("--input bin", b"1,2\n", &["cannot read the input", "not written by hopes"]);
    fails("--input bin", &recording(&at_once(&messages())), &["this is a recording, see hopes replay"]);
    fails("--columns lon,lat", b"x,y\n1,2\n", &["lon"]);
    let daemon = FakeDaemon::new();
    hopes("feed /nowhere/at.all --to").with(daemon.address()).runs().fails(1, &["cannot open /nowhere/at.all"]);
}

#[test]
fn a_stream_is_opened_as_asked_or_not_at_all() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "--stream cam --window points:7 --resolution 0.5").start();
    drop(client.take_stdin());
    let mut peer = daemon.greet();
    let (channel, open) = peer.open(5000);
    assert_eq!(open, Open { name: "cam".to_owned(), window: Some(Window::Points(7)), resolution: Some(0.5) });
    take_all(&mut peer, channel);
    client.finish().text();
    let client = feed(&daemon, "").start();
    let mut peer = daemon.greet();
    let (channel, message) = peer.next().unwrap();
    assert_eq!(message, Open { name: "default".to_owned(), window: None, resolution: None }.into());
    peer.send(channel, Report { code: 6, answers: 0x0101, text: "it has other options".to_owned() });
    client.finish().fails(1, &["does not open stream default: it has other options"]);
}

#[test]
fn refusals_are_reported_with_their_line() {
    let refuse = |arguments: &str| {
        let daemon = FakeDaemon::new();
        let client = feed(&daemon, arguments).start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.open(5000);
        (client, peer, channel)
    };
    let answer = |peer: &mut Peer, channel: u32| {
        let Some((_, Message::Batch(batch))) = peer.next() else { panic!("points come first") };
        assert_eq!(batch.points.len(), 3);
        let text = "is too far away".to_owned();
        let reasons = vec![Refusal { index: 1, code: 1, text: text.clone() }, Refusal { index: 99, code: 1, text }];
        peer.send(channel, Refused { sequence: 0, accepted: 0, refused: 3, reasons, placed: Vec::new() });
    };
    let (mut client, mut peer, channel) = refuse("");
    client.say("# two\n\n1,2\n3,4\n5,6\n");
    drop(client.take_stdin());
    assert!(matches!(peer.next(), Some((_, Message::Commit(Commit { sequence: 0, .. })))));
    let Some((_, Message::Batch(batch))) = peer.next() else { panic!("points come next") };
    assert_eq!(batch.sequence, 1);
    let reasons = vec![
        Refusal { index: 1, code: 1, text: "is too far away".to_owned() },
        Refusal { index: 99, code: 1, text: "is nowhere".to_owned() },
    ];
    peer.send(channel, Committed { sequence: 0, frame: 11 });
    peer.send(channel, Refused { sequence: 1, accepted: 0, refused: 3, reasons, placed: Vec::new() });
    assert!(matches!(peer.next(), Some((_, Message::Commit(Commit { sequence: 2, .. })))));
    peer.send(channel, Overloaded { sequence: 2, points: 0, total: 0, policy: Policy::DropNewest });
    assert!(matches!(peer.next(), Some((_, Message::Close(_)))));
    peer.send(channel, Closed { frame: 12 });
    peer.expect_goodbye();
    let finished = client.finish();
    assert_eq!(finished.code, Some(1), "no point was accepted");
    for words in [
        "nothing of the input could be used",
        "line 4, point (3, 4): is too far away",
        "a point: is nowhere",
        "1 more points between line 3 and line 5",
        "3 refused",
    ] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
    let (mut client, mut peer, channel) = refuse("--strict");
    client.say("1,2\n3,4\n5,6\n");
    answer(&mut peer, channel);
    peer.expect_goodbye();
    client.ends().fails(3, &["line 2, point (3, 4): is too far away (--strict stops here)"]);
    let (mut client, mut peer, _) = refuse("--strict");
    client.say("1,x\n");
    peer.expect_goodbye();
    client.ends().fails(3, &["line 1", "--strict stops here"]);
}

#[test]
fn dropped_points_are_counted() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "--input jsonl").start();
    client.say("{\"points\":[[0,0],[1,1]]}\n");
    drop(client.take_stdin());
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    assert!(matches!(peer.next(), Some((_, Message::Batch(_)))));
    assert!(matches!(peer.next(), Some((_, Message::Commit(_)))));
    peer.send(channel, Committed { sequence: 1, frame: 1 });
    peer.send(channel, Overloaded { sequence: 0, points: 2, total: 2, policy: Policy::DropOldest });
    assert!(matches!(peer.next(), Some((_, Message::Close(_)))));
    peer.send(channel, Closed { frame: 1 });
    peer.expect_goodbye();
    let finished = client.finish();
    assert!(finished.code == Some(0) && finished.err.contains("drops the oldest points"), "{}", finished.err);
    assert!(finished.err.contains("0 points accepted, 0 refused, 2 dropped; 1 frames"), "{}", finished.err);
}

#[test]
fn the_number_of_unanswered_messages_is_limited() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "").start();
    let mut stdin = client.take_stdin();
    let feeder = std::thread::spawn(move || stdin.write_all(&b"1,1\n\n".repeat(1000)).unwrap());
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    let mut waiting = Vec::new();
    while let Some((_, message)) = peer.next_within(Duration::from_millis(400)) {
        waiting.push(message);
    }
    assert_eq!(waiting.len(), 64);
    peer.ping_and_wait(5);
    for (sequence, message) in (0..).zip(&waiting) {
        match message {
            Message::Batch(_) => peer.send(channel, Accepted { sequence, points: 1, placed: Vec::new() }),
            _ => peer.send(channel, Committed { sequence, frame: 1 }),
        }
    }
    let sent = take_all(&mut peer, channel);
    assert_eq!(sent.len() + waiting.len(), 2000);
    feeder.join().unwrap();
    assert!(client.finish().err.contains("1000 points accepted"));
}

#[test]
fn batches_have_the_size_that_the_daemon_accepts() {
    let sizes = |welcome: Welcome, largest_batch: u32| -> Vec<usize> {
        let daemon = FakeDaemon::new();
        let mut client = feed(&daemon, "--input jsonl").start();
        let points = vec![[0.5, 0.5]; 9000];
        let mut stdin = client.take_stdin();
        let feeder = std::thread::spawn(move || stdin.write_all(json!({"points": points}).to_string().as_bytes()));
        let mut peer = daemon.greet_as(welcome);
        let (channel, _) = peer.open(largest_batch);
        let sent = take_all(&mut peer, channel);
        feeder.join().unwrap().unwrap();
        client.finish().text();
        sent.iter()
            .filter_map(|sent| if let Message::Batch(sent) = sent { Some(sent.points.len()) } else { None })
            .collect()
    };
    assert_eq!(sizes(welcome(), 100_000), [4096, 4096, 808]);
    assert_eq!(sizes(welcome(), 3000), [3000; 3]);
    assert_eq!(sizes(Welcome { largest_batch: 4500, largest_frame: 24_100, ..welcome() }, 5000), [1000; 9]);
    let odd = Welcome { largest_batch: 0, largest_frame: 0, timeout_ms: 60_000, ..welcome() };
    assert_eq!(sizes(odd, 0).len(), 9000, "one by one, if it must be");
}

#[test]
fn a_feed_that_loses_its_daemon_fails() {
    let ended = |say: &dyn Fn(&mut Peer, u32), words: &[&str]| {
        let daemon = FakeDaemon::new();
        let mut client = feed(&daemon, "").start();
        client.say("1,2\n");
        let mut peer = daemon.greet();
        let (channel, _) = peer.open(5000);
        assert!(matches!(peer.next(), Some((_, Message::Batch(_)))));
        say(&mut peer, channel);
        drop(peer);
        client.ends().fails(1, words);
    };
    let goodbye = Goodbye { reason: "going home".to_owned(), streams: Vec::new() };
    ended(&|peer, _| peer.send(0, goodbye.clone()), &["says goodbye: going home; 1 messages are not answered"]);
    ended(&|_, _| (), &["before it had answered everything"]);
    ended(
        &|peer, channel| peer.send(channel, Closed { frame: 3 }),
        &["another producer has ended the stream, after frame 3"],
    );
    ended(&|peer, channel| peer.send(channel, Committed { sequence: 0, frame: 1 }), &["Committed to something else"]);
    ended(
        &|peer, channel| peer.send(channel, Committed { sequence: 8, frame: 1 }),
        &["answers message 8, which does not wait"],
    );
    let report = Report { code: 11, answers: 0x0103, text: "the stream has failed".to_owned() };
    ended(&|peer, channel| peer.send(channel, report.clone()), &["refuses: the stream has failed"]);
}

#[test]
fn a_signal_finishes_the_current_frame() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "").start();
    client.say("1,2\n");
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    let Some((_, Message::Batch(_))) = peer.next() else { panic!("points come first") };
    client.signal(Signal::INT);
    assert!(matches!(peer.next(), Some((_, Message::Commit(_)))));
    peer.send(channel, Accepted { sequence: 0, points: 1, placed: Vec::new() });
    peer.send(channel, Committed { sequence: 1, frame: 5 });
    assert_eq!(peer.next(), Some((channel, Close { end: false }.into())));
    peer.send(channel, Closed { frame: 5 });
    peer.expect_goodbye();
    let finished = client.ends();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    assert!(finished.err.contains("1 points accepted, 0 refused, 0 dropped; 1 frames, the last is 5"));
    assert!(finished.err.contains("; 1 points were read, 1 sent, 0 not answered"), "{}", finished.err);
}

#[test]
fn all_points_are_accounted_for() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "--input jsonl").start();
    let points = |count: usize| format!("{{\"points\":{:?}}}\n", vec![[0.5, 0.5]; count]);
    let commit = "{\"commit\":true}\n";
    client.say(points(1) + "nonsense\n" + &points(2) + commit + &points(4) + commit + &points(8));
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    let (mut batches, mut frame) = (Vec::new(), 0);
    while batches.iter().sum::<usize>() < 15 {
        match peer.next() {
            Some((_, Message::Batch(Batch { sequence, points, .. }))) => {
                match batches.len() {
                    0 => peer.send(channel, Accepted { sequence, points: 1, placed: Vec::new() }),
                    1 => {
                        let reasons = vec![Refusal { index: 0, code: 1, text: "is too far away".to_owned() }];
                        peer.send(channel, Refused { sequence, accepted: 1, refused: 1, reasons, placed: Vec::new() });
                    }
                    2 => peer.send(channel, Overloaded { sequence, points: 4, total: 4, policy: Policy::DropOldest }),
                    _ => {}
                }
                batches.push(points.len());
            }
            Some((_, Message::Commit(Commit { sequence, .. }))) => {
                frame += 1;
                peer.send(channel, Committed { sequence, frame });
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(batches, [1, 2, 4, 8]);
    // The last batch is never answered, and nothing more is read. The daemon is there all the same.
    client.signal(Signal::TERM);
    let begun = Instant::now();
    while client.is_alive() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it ends within seconds");
        drop(peer.next_within(Duration::from_millis(100)));
    }
    let finished = client.ends();
    assert_eq!(finished.code, Some(1), "{}", finished.err);
    for words in [
        "SIGTERM: finishing the open frame",
        "2 points accepted, 2 refused, 4 dropped; 2 frames, the last is 2",
        "15 points were read, 1 times what could not be used, 15 sent, 8 not answered",
        "has not answered within 5 s after the signal: 8 points may not be in the stream",
    ] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
}

#[test]
fn a_signal_ends_a_feed_whose_daemon_does_not_read() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "--input jsonl").start();
    let line = json!({"points": vec![[0.25, 0.5]; 4096]}).to_string() + "\n";
    let mut stdin = client.take_stdin();
    let feeder = std::thread::spawn(move || drop(stdin.write_all(line.repeat(200).as_bytes())));
    let mut peer = daemon.greet();
    peer.open(5000);
    std::thread::sleep(Duration::from_millis(500));
    client.signal(Signal::TERM);
    let begun = Instant::now();
    let finished = client.ends();
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
    assert_eq!(finished.code, Some(1), "{}", finished.err);
    assert!(finished.err.contains("has not answered within 5 s after the signal"), "{}", finished.err);
    let summary = finished.err.lines().find(|line| line.contains("points were read")).expect("it sums up");
    assert!(summary.contains("0 points accepted") && !summary.contains(" 0 not answered"), "{summary}");
    feeder.join().unwrap();
}

#[test]
fn a_file_is_fed_over_and_over_at_its_pace() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, "1,2\n\n3,4\n").unwrap();
    let daemon = FakeDaemon::new();
    let client = hopes("feed").with(&file).and("--loop --rate 20 --to").with(daemon.address()).start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.open(5000);
    let (mut frame, begun) = (0, Instant::now());
    while frame < 9 {
        match peer.next() {
            Some((_, Message::Batch(Batch { sequence, points, .. }))) => {
                assert_eq!(points, [if frame % 2 == 0 { (1.0, 2.0) } else { (3.0, 4.0) }]);
                peer.send(channel, Accepted { sequence, points: 1, placed: Vec::new() });
            }
            Some((_, Message::Commit(Commit { sequence, .. }))) => {
                frame += 1;
                peer.send(channel, Committed { sequence, frame });
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(begun.elapsed() >= Duration::from_millis(380), "{:?}", begun.elapsed());
    client.signal(Signal::TERM);
    take_all(&mut peer, channel);
    assert_eq!(client.ends().code, Some(0));
    std::fs::write(&file, "# nothing\n").unwrap();
    let client = hopes("feed").with(&file).and("--loop --to").with(daemon.address()).start();
    let mut peer = daemon.greet();
    peer.open(5000);
    peer.expect_goodbye();
    client.finish().fails(1, &["nothing to loop over"]);
}

#[test]
fn a_feed_waits_for_a_daemon_that_is_alive_and_does_not_read() {
    for daemon in [FakeDaemon::new(), FakeDaemon::over_tcp()] {
        let mut client = feed(&daemon, "--input jsonl").start();
        let line = json!({"points": vec![[0.25, 0.5]; 4096]}).to_string() + "\n";
        let mut stdin = client.take_stdin();
        // More than the sockets' buffers hold, so that the client is blocked within a message.
        let feeder = std::thread::spawn(move || drop(stdin.write_all(line.repeat(200).as_bytes())));
        let mut peer = daemon.greet_as(Welcome { timeout_ms: 600, ..welcome() });
        let (channel, _) = peer.open(5000);
        for token in 0..8 {
            std::thread::sleep(Duration::from_millis(200));
            peer.send(0, Ping { token });
        }
        assert!(client.is_alive());
        let (mut pongs, mut points) = (0, 0);
        while pongs < 8 || points < 200 * 4096 {
            match peer.next() {
                Some((0, Message::Pong(_))) => pongs += 1,
                Some((0, Message::Ping(Ping { token }))) => peer.send(0, Pong { token }),
                Some((_, Message::Batch(Batch { sequence, points: sent, .. }))) => {
                    points += sent.len();
                    peer.send(channel, Accepted { sequence, points: sent.len() as u32, placed: Vec::new() });
                }
                other => panic!("{other:?}"),
            }
        }
        feeder.join().unwrap();
        take_all(&mut peer, channel);
        assert!(client.finish().err.contains("819200 points accepted"));
    }
}

#[test]
fn a_daemon_that_neither_reads_nor_sends_times_out() {
    let daemon = FakeDaemon::new();
    let mut client = feed(&daemon, "--input jsonl").start();
    let line = json!({"points": vec![[0.25, 0.5]; 4096]}).to_string() + "\n";
    let mut stdin = client.take_stdin();
    let feeder = std::thread::spawn(move || drop(stdin.write_all(line.repeat(200).as_bytes())));
    let mut peer = daemon.greet_as(Welcome { timeout_ms: 400, ..welcome() });
    peer.open(5000);
    client.finish().fails(1, &["has been silent for 0.4 s"]);
    feeder.join().unwrap();
}
