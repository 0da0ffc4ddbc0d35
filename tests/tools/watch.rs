//! `hopes watch` and `hopes record`: frames, gaps, signals, timeouts, lost connections.

use std::time::Duration;

use hopes_protocol::*;
use rustix::process::Signal;
use serde_json::{Value, json};

use crate::common::fake_daemon::{FakeDaemon, Peer, welcome};
use crate::common::growing_stream::{GrowingStream, VIEW, recording};
use crate::common::process::{Hopes, Running, hopes, settled};
use crate::replay::{at_once, json_lines, messages, replay};

fn watch(daemon: &FakeDaemon, arguments: &str) -> Hopes {
    hopes("watch --from").with(daemon.address()).and(arguments)
}

#[test]
fn options_become_a_subscription() {
    for (arguments, pattern, view, dots) in [
        ("", "default", VIEW, DotsWanted::No),
        ("--stream c*m -k 2 -l 3 --dots 4", "c*m", View { cut: Cut::Derived(2, 3), ..VIEW }, DotsWanted::Top(4)),
        (
            "--alpha 0.5 --simplify --dots all",
            "default",
            View { cut: Cut::Reduced(0.5), simplify: Simplify::AtScale },
            DotsWanted::All,
        ),
        ("--full --simplify=2", "default", View { cut: Cut::Full, simplify: Simplify::Below(2.0) }, DotsWanted::No),
    ] {
        let daemon = FakeDaemon::new();
        let client = watch(&daemon, arguments).start();
        let mut peer = daemon.greet();
        let (_, subscribe) = peer.expect_subscribe();
        assert_eq!(subscribe, Subscribe { pattern: pattern.to_owned(), view, dots, resume: None });
        peer.goodbye(&[]);
        assert_eq!(client.finish().text(), "");
    }
}

#[test]
fn frames_are_shown_until_the_daemon_ends() {
    let daemon = FakeDaemon::new();
    let mut client = watch(&daemon, "--stream cam --output jsonl").start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    peer.send(channel, scene.opened("cam", 7));
    peer.send(channel, scene.snapshot(Cause::Start));
    let line = |line: Option<String>| serde_json::from_str::<Value>(&line.expect("a line is due")).unwrap();
    assert_eq!(line(client.line())["from"], 0);
    peer.ping_and_wait(77);
    peer.send(channel, Lagged { stream: 3, first: 2, last: 2 });
    peer.send(channel, scene.diff());
    assert_eq!(line(client.line()), json!({"stream": "cam", "lagged": [2, 2]}));
    assert_eq!(line(client.line())["frame"], 2);
    peer.send(channel, Heartbeat { stream: 3, frame: 2 });
    peer.goodbye(&[("cam", 2)]);
    let finished = client.finish();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    assert!(finished.err.contains("says goodbye: going home"), "{}", finished.err);
    assert!(finished.err.contains("stream cam: the last frame is 2"), "{}", finished.err);
}

#[test]
fn a_frame_with_a_wrong_checksum_is_not_shown_and_requested_again() {
    let daemon = FakeDaemon::new();
    let mut client = watch(&daemon, "--output jsonl").start();
    let mut peer = daemon.greet();
    let (first, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    peer.send(first, scene.opened("default", 7));
    peer.send(first, scene.snapshot(Cause::Start));
    peer.send(first, scene.wrong_diff());
    assert_eq!(peer.next(), Some((first, Unsubscribe {}.into())));
    let (second, subscribe) = peer.expect_subscribe();
    assert!(second != first && subscribe.resume.is_none());
    // Messages in flight on the old channel are ignored.
    peer.send(first, scene.clone().diff());
    peer.send(first, Unsubscribed {});
    peer.send(second, scene.opened("default", 7));
    peer.send(second, scene.snapshot(Cause::Start));
    peer.send(second, scene.diff());
    let shown: Vec<Value> =
        (0..3).map(|_| serde_json::from_str::<Value>(&client.line().unwrap()).unwrap()["frame"].take()).collect();
    assert_eq!(shown, [1, 2, 3]);
    peer.goodbye(&[("default", 4)]);
    let finished = client.finish();
    assert_eq!(finished.code, Some(0), "{}", finished.err);
    for words in ["frame 2 has checksum", "subscribing again", "the last frame here is 3, the daemon's is 4"] {
        assert!(finished.err.contains(words), "{words}: {}", finished.err);
    }
}

#[test]
fn repeated_wrong_checksums_are_an_error() {
    let daemon = FakeDaemon::new();
    let client = watch(&daemon, "").start();
    let mut peer = daemon.greet();
    for _ in 0..6 {
        let (channel, _) = peer.expect_subscribe();
        let mut scene = GrowingStream::new(1);
        peer.send(channel, scene.opened("default", 7));
        peer.send(channel, scene.diff());
        let _ = peer.next_within(Duration::from_millis(500));
    }
    client.finish().fails(1, &["the daemon is wrong", "frame 2 starts from frame 1"]);
}

#[test]
fn check_stops_at_a_gap_and_at_a_frame_that_is_wrong() {
    let ends = |say: &dyn Fn(&mut Peer, u32, &mut GrowingStream)| {
        let daemon = FakeDaemon::new();
        let client = watch(&daemon, "--check --full").start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.expect_subscribe();
        let mut scene = GrowingStream::new(3);
        peer.send(channel, scene.opened("default", 7));
        peer.send(channel, scene.snapshot(Cause::Start));
        say(&mut peer, channel, &mut scene);
        let finished = client.finish();
        (finished.code, finished.err)
    };
    let (code, err) = ends(&|peer, channel, scene| peer.send(channel, scene.wrong_diff()));
    assert!(code == Some(1) && err.contains("frame 2 has checksum"), "{err}");
    // The checksum is right, but the edges are not those of the vertices.
    let (code, err) = ends(&|peer, channel, scene| match scene.diff() {
        Message::Diff(diff) => {
            let mut checksum = Checksum(diff.checksum);
            checksum.remove((0, 1));
            peer.send(channel, Diff { edges_added: Vec::new(), checksum: checksum.0, ..diff });
        }
        other => panic!("{other:?}"),
    });
    assert!(code == Some(1) && err.contains("frame 2 has other tree edges than its 2 vertices give"), "{err}");
    let (code, err) = ends(&|peer, channel, scene| {
        for _ in 0..20 {
            peer.send(channel, scene.diff());
        }
        peer.send(0, Goodbye { reason: "done".to_owned(), streams: Vec::new() });
    });
    assert!(code == Some(0) && err.contains("the last frame is 21"), "{err}");
}

#[test]
fn a_number_of_frames_or_a_signal_ends_a_watch() {
    let daemon = FakeDaemon::new();
    let client = watch(&daemon, "--frames 2 --dots 1 --output jsonl").start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    let messages = [scene.opened("default", 7), scene.snapshot(Cause::Start), scene.diff(), scene.dots()];
    messages.into_iter().for_each(|message| peer.send(channel, message));
    assert!(peer.expect_goodbye().contains("wanted frames"));
    let lines = json_lines(&client.finish().text());
    assert_eq!((lines.len(), &lines[2]["total"]), (3, &json!(7)), "the dots of the last frame too");

    let mut client = watch(&daemon, "").start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    peer.send(channel, GrowingStream::new(1).opened("default", 7));
    peer.send(channel, GrowingStream::new(1).snapshot(Cause::Start));
    assert!(client.line().is_some());
    client.signal(Signal::TERM);
    assert_eq!(peer.expect_goodbye(), "SIGTERM");
    assert_eq!(client.finish().code, Some(0));
}

#[test]
fn a_silent_daemon_is_pinged_and_then_disconnected() {
    let daemon = FakeDaemon::new();
    let client = watch(&daemon, "").start();
    let mut peer = daemon.greet_as(Welcome { timeout_ms: 900, ..welcome() });
    peer.expect_subscribe();
    for _ in 0..2 {
        let Some((0, Message::Ping(Ping { token }))) = peer.next() else { panic!("a ping is due") };
        peer.send(0, Pong { token });
    }
    assert!(matches!(peer.next(), Some((0, Message::Ping(_)))));
    assert_eq!(peer.next(), None);
    client.finish().fails(1, &["has been silent for 0.9 s", &daemon.address()]);
}

#[test]
fn a_connection_that_breaks_is_an_error() {
    let ended = |say: &dyn Fn(&mut Peer, u32), words: &[&str]| {
        let daemon = FakeDaemon::new();
        let client = watch(&daemon, "").start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.expect_subscribe();
        say(&mut peer, channel);
        drop(peer);
        client.finish().fails(1, words);
    };
    ended(&|_, _| (), &["closed the connection without a goodbye"]);
    let part = encode(VERSION, 1, &GrowingStream::new(1).opened("default", 1)).unwrap();
    ended(&|peer, _| peer.write(&part[..part.len() - 1]), &["closed the connection within a message"]);
    ended(&|peer, _| peer.write(&[0; 20]), &["sent what cannot be read"]);
    ended(&|peer, _| peer.write(&header(VERSION, 0x0206, 1, u32::MAX)), &["sent what cannot be read", "4294967295"]);
    let unknown = [&header(VERSION, 0x7777, 1, 0)[..], &[0; 4]].concat();
    ended(&|peer, _| peer.write(&unknown), &["sent what cannot be understood", "0x7777"]);
    ended(&|peer, channel| peer.send(channel, GrowingStream::new(1).opened("a\nb", 1)), &["which none may have"]);
    ended(&|peer, channel| peer.send(channel, GrowingStream::new(9).snapshot(Cause::Start)), &["no stream number 9"]);
    let report = Report { code: 9, answers: 0x0201, text: "no such view".to_owned() };
    ended(&|peer, channel| peer.send(channel, report.clone()), &["no such view"]);
}

/// Of several streams one is left out, and the others are followed. Without others that is an error.
#[test]
fn a_stream_with_too_many_views_is_left_out() {
    let report = || Report { code: ErrorCode::TooManyViews as u16, answers: 0x0201, text: "views of cam".to_owned() };
    let refused = |pattern: &str| {
        let daemon = FakeDaemon::new();
        let client = watch(&daemon, "--stream").with(pattern).start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.expect_subscribe();
        peer.send(channel, GrowingStream::new(1).opened("cam", 7));
        peer.send(channel, report());
        (client, peer, channel)
    };
    let (client, mut peer, channel) = refused("cam*");
    peer.send(channel, StreamClosed { stream: 1, frame: 0, reason: "too many views".to_owned() });
    let other = GrowingStream::new(2);
    peer.send(channel, other.opened("camera", 7));
    peer.send(channel, other.snapshot(Cause::Start));
    peer.goodbye(&[("camera", 1)]);
    let finished = client.finish();
    assert!(finished.err.contains("views of cam"), "{}", finished.err);
    assert!(finished.text().contains("camera  frame 1"));
    let (client, _peer, _) = refused("cam");
    client.finish().fails(1, &["views of cam"]);
}

#[test]
fn a_closed_pipe_ends_a_watch() {
    let daemon = FakeDaemon::new();
    let mut client = watch(&daemon, "").start();
    drop(client.take_stdout());
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    peer.send(channel, GrowingStream::new(1).opened("default", 7));
    peer.send(channel, GrowingStream::new(1).snapshot(Cause::Start));
    assert_eq!(client.finish().code, Some(0));
}

#[test]
fn a_lost_connection_is_resumed() {
    let daemon = FakeDaemon::new();
    let mut client = watch(&daemon, "--reconnect --output jsonl").start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    peer.send(channel, scene.opened("default", 7));
    peer.send(channel, scene.snapshot(Cause::Start));
    assert!(client.line().is_some());
    drop(peer);

    let mut peer = daemon.greet();
    let (channel, subscribe) = peer.expect_subscribe();
    assert_eq!(subscribe.resume, Some(Resume { epoch: 7, frame: 1 }));
    scene.stream = 8;
    peer.send(channel, scene.opened("default", 7));
    peer.send(channel, Resumed { stream: 8, frame: 1 });
    peer.send(channel, scene.diff());
    assert!(client.line().unwrap().contains("\"from\":1"));
    peer.goodbye(&[("default", 2)]);

    let mut peer = daemon.greet();
    let (channel, subscribe) = peer.expect_subscribe();
    assert_eq!(subscribe.resume, Some(Resume { epoch: 7, frame: 2 }));
    peer.send(channel, scene.opened("default", 8));
    peer.send(channel, scene.snapshot(Cause::CannotResume));
    assert!(client.line().unwrap().contains("\"from\":0"));
    client.signal(Signal::INT);
    assert_eq!(peer.expect_goodbye(), "SIGINT");
    assert_eq!(client.finish().code, Some(0));
}

#[test]
fn a_signal_ends_a_client_whose_output_nobody_reads() {
    let mut scene = GrowingStream::new(3);
    let all: Vec<Message> = [scene.opened("default", 7), scene.snapshot(Cause::Start)]
        .into_iter()
        .chain((0..1000).map(|_| scene.diff()))
        .collect();
    let blocked = |mut client: Running| {
        let stdout = client.take_stdout();
        // What was sent is more than a pipe holds.
        settled(Duration::from_millis(700), || Some(rustix::io::ioctl_fionread(&stdout).unwrap()).filter(|&n| n > 0));
        client.signal(Signal::TERM);
        let finished = client.ends();
        assert_eq!(finished.code, Some(1), "{}", finished.err);
        assert!(finished.err.contains("SIGTERM: stopped after "), "{}", finished.err);
        assert!(finished.err.contains("frames; the rest is lost: nobody reads the output"), "{}", finished.err);
    };
    for program in ["watch --output jsonl", "record -o -"] {
        let daemon = FakeDaemon::new();
        let client = hopes(program).and("--from").with(daemon.address()).start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.expect_subscribe();
        let bytes: Vec<Vec<u8>> = all.iter().map(|message| encode(VERSION, channel, message).unwrap()).collect();
        peer.write(&bytes.concat());
        blocked(client);
    }
    let mut replaying = hopes("replay - --fast --output jsonl").start();
    let (mut stdin, bytes) = (replaying.take_stdin(), recording(&at_once(&all)));
    let feeder = std::thread::spawn(move || drop(std::io::Write::write_all(&mut stdin, &bytes)));
    blocked(replaying);
    feeder.join().unwrap();
}

// ---- record

#[test]
fn a_recording_has_the_bytes_that_were_sent() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a recording");
    let daemon = FakeDaemon::new();
    let client = hopes("record --stream cam --from").with(daemon.address()).and("-o").with(&file).start();
    let mut peer = daemon.greet();
    let (channel, _) = peer.expect_subscribe();
    messages().into_iter().for_each(|message| peer.send(channel, message));
    peer.goodbye(&[]);
    let finished = client.finish();
    assert!(finished.code == Some(0) && finished.err.contains("4 frames recorded"), "{}", finished.err);
    let bytes = std::fs::read(&file).unwrap();
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.push(&bytes);
    assert_eq!(decoder.banner(), Ok(Some(Banner { lowest: FILE_VERSION, highest: FILE_VERSION })));
    let (mut recorded, mut last) = (Vec::new(), 0);
    while let Some(frame) = decoder.frame().unwrap() {
        match frame.message().unwrap() {
            Message::Elapsed(Elapsed { nanoseconds }) => {
                assert!(nanoseconds >= last && frame.channel == 0);
                last = nanoseconds;
            }
            message => recorded.push(message),
        }
    }
    let end = Goodbye { reason: "the daemon says goodbye: going home".to_owned(), streams: Vec::new() };
    assert_eq!(recorded.pop(), Some(end.into()));
    assert_eq!(recorded, messages());
    let shown = |bytes: Vec<u8>| replay("--fast --output jsonl", bytes).text();
    assert_eq!(shown(bytes), shown(recording(&at_once(&messages()))));
    hopes("record -o /nowhere/at.all --from").with(daemon.address()).runs().fails(1, &["cannot write /nowhere/at.all"]);
}

#[test]
fn a_gap_leaves_a_recording_that_can_be_played() {
    let daemon = FakeDaemon::new();
    let client = hopes("record --frames 3 -o - --from").with(daemon.address()).start();
    let mut peer = daemon.greet();
    let (first, _) = peer.expect_subscribe();
    let mut scene = GrowingStream::new(3);
    peer.send(first, scene.opened("default", 7));
    peer.send(first, scene.snapshot(Cause::Start));
    peer.send(first, scene.wrong_diff());
    assert_eq!(peer.next(), Some((first, Unsubscribe {}.into())));
    let (second, _) = peer.expect_subscribe();
    peer.send(second, scene.opened("default", 7));
    peer.send(second, scene.snapshot(Cause::Start));
    peer.send(second, scene.diff());
    peer.expect_goodbye();
    assert_eq!(replay("--fast", client.finish().out()).text().lines().count(), 3);
}
