//! `hopes demo`, `replay`, `record`, `watch`, `feed`, `scene`, `status`, `stop-stream`, `disconnect` and `tracks` as
//! processes. Where the daemon must send what a real one never sends, it is a scripted one.

#[path = "tools/addresses.rs"]
mod addresses;
#[path = "tools/admin.rs"]
mod admin;
mod common;
#[path = "tools/endings.rs"]
mod endings;
#[path = "tools/feed.rs"]
mod feed;
#[path = "tools/manual.rs"]
mod manual;
#[path = "tools/messages.rs"]
mod messages;
#[path = "tools/outputs.rs"]
mod outputs;
#[path = "tools/replay.rs"]
mod replay;
#[path = "tools/scene.rs"]
mod scene;
#[path = "tools/spaces.rs"]
mod spaces;
#[path = "tools/stopped.rs"]
mod stopped;
#[path = "tools/tracked.rs"]
mod tracked;
#[path = "tools/tracks.rs"]
mod tracks;
#[path = "tools/watch.rs"]
mod watch;

use common::fake_daemon::{FakeDaemon, Peer};
use common::process::{Hopes, hopes};
use hopes_protocol::*;
use serde_json::{Value, json};

// ---- connecting

/// Every client of a daemon, at this address.
fn clients(address: &str) -> [Hopes; 6] {
    let words = [
        "feed - --to",
        "watch --from",
        "status --from",
        "record -o - --from",
        "stop-stream scan --connect",
        "disconnect 7 --connect",
    ];
    words.map(|words| hopes(words).with(address))
}

#[test]
fn a_missing_daemon_gives_an_error_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("unix:{}/none", folder.path().display());
    for client in clients(&address) {
        let finished = client.runs();
        assert_eq!(finished.code, Some(1), "{}", finished.err);
        for words in ["cannot connect to ", &address, "No such file", "hopes serve --listen"] {
            assert!(finished.err.contains(words), "{words}: {}", finished.err);
        }
    }
    hopes("status --from tcp:127.0.0.1:1").runs().fails(1, &["cannot connect to tcp:127.0.0.1:1", "refused"]);
}

#[test]
fn invalid_arguments_are_wrong_usage() {
    for (arguments, words) in [
        ("watch --from nowhere", "is no address: write unix:PATH"),
        ("feed - --to unix:x --loop", "--loop needs a file"),
        ("feed - --to unix:x --stream a*b", "no control character, and no *"),
        ("feed - --to unix:x --rate 0", "above 0"),
        ("watch --from unix:x --full --simplify", "--simplify=RADIUS"),
        ("watch --from unix:x --check --simplify", "leave out --simplify"),
        ("watch --from unix:x --dots none", "nor all"),
        ("record --from unix:x --frames 0 -o -", "frames"),
        ("replay x --fast --speed 2", "cannot be used with"),
        ("stop-stream --connect unix:x", "<NAME>"),
        ("stop-stream a*b --connect unix:x", "no control character, and no *"),
        ("disconnect --connect unix:x", "<PEER>"),
        ("disconnect scan --connect unix:x", "\"scan\" is not a whole number"),
        ("disconnect 7 --connect nowhere", "is no address: write unix:PATH"),
    ] {
        hopes(arguments).runs().fails(2, &[words]);
    }
}

#[test]
fn an_unsupported_version_gives_an_error_with_both_ranges() {
    for number in 0..6 {
        let daemon = FakeDaemon::new();
        let client = clients(&daemon.address())[number].start();
        let mut peer = daemon.accept();
        assert_eq!(peer.banner(), Banner::OURS);
        peer.write(&Banner { lowest: 7, highest: 8 }.encode());
        assert_eq!(peer.next(), None, "the client closes");
        let finished = client.finish();
        assert_eq!(finished.code, Some(1), "{}", finished.err);
        for words in ["speaks protocol versions 7 to 8, this one 1 to 4", &daemon.address()] {
            assert!(finished.err.contains(words), "{words}: {}", finished.err);
        }
    }
}

#[test]
fn a_peer_that_is_no_daemon_or_refuses_gives_an_error() {
    let expect_error = |say: &dyn Fn(&mut Peer), words: &[&str]| {
        let daemon = FakeDaemon::new();
        let client = hopes("watch --from").with(daemon.address()).start();
        let mut peer = daemon.accept();
        peer.banner();
        say(&mut peer);
        drop(peer);
        client.finish().fails(1, &[words, &[daemon.address().as_str()]].concat());
    };
    expect_error(&|peer| peer.write(b"HTTP/1.1 400 Bad Request\r\n\r\n"), &["is no hopes daemon"]);
    expect_error(&|_| (), &["closed the connection before it had greeted"]);
    expect_error(&|peer| peer.write(&Banner::OURS.encode()[..9]), &["closed the connection within a message"]);
    let report = Report { code: 13, answers: 0, text: "too many connections".to_owned() };
    expect_error(
        &|peer| {
            peer.write(&Banner::OURS.encode());
            peer.send(0, report.clone());
        },
        &["refuses the connection: too many connections"],
    );
    expect_error(
        &|peer| {
            peer.write(&Banner::OURS.encode());
            peer.send(0, Pong { token: 1 });
        },
        &["answers Hello with something else"],
    );
}

// ---- status

#[test]
fn the_status_is_a_table_or_json() {
    let info = StreamInfo {
        stream: 1,
        name: "cam\u{7}".to_owned(),
        epoch: 7,
        window: Window::Points(1000),
        resolution: Some(0.5),
        frame: 12,
        points: 1000,
        vertices: 999,
        producers: 1,
        consumers: 2,
    };
    let stream = StreamStatus {
        info,
        computed: 11,
        accepted: 12_345,
        refused: 3,
        dropped: 4,
        waiting: 5,
        lagged: 6,
        memory: 1 << 20,
    };
    let status = Status {
        software: "fake".to_owned(),
        uptime_ms: 3_723_000,
        epoch: 42,
        connections: 3,
        refused_messages: 1,
        memory: 1 << 21,
        memory_limit: 0,
        streams: vec![stream],
    };
    let asked = |daemon: FakeDaemon, arguments: &str| {
        let client = hopes("status --from").with(daemon.address()).and(arguments).start();
        let mut peer = daemon.greet();
        let Some((channel, Message::GetStatus(_))) = peer.next() else { panic!("GetStatus is due") };
        peer.send(channel, status.clone());
        peer.expect_goodbye();
        client.finish().text()
    };
    let table = asked(FakeDaemon::new(), "");
    let expected = "\
fake, up 1h 2m 3s, 3 connections, 1 messages refused, memory 2.00 MiB (no limit)
stream  frame  points  distinct  producers  consumers    memory  computed  accepted  refused  dropped  waiting  lagged  window
cam\u{fffd}       12   1,000       999          1          2  1.00 MiB        11    12,345        3        4        5       6  points:1000 on a grid of 0.5
";
    assert_eq!(table, expected);
    let value: Value = serde_json::from_str(&asked(FakeDaemon::over_tcp(), "--json")).unwrap();
    assert_eq!(value["streams"][0]["info"]["window"], json!({"Points": 1000}));
    assert_eq!(value["streams"][0]["accepted"], 12_345);
}
