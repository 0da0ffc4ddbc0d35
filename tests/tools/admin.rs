//! `hopes status --peers --memory`, `stop-stream` and `disconnect` against a scripted daemon: what they ask, what they
//! print, how they fail.

use hopes_protocol::*;
use serde_json::{Value, json};

use crate::common::fake_daemon::{FakeDaemon, Peer, welcome};
use crate::common::process::{Finished, hopes};

/// Runs a client. `daemon` answers it, and waits for its goodbye.
fn served(arguments: &str, play: impl FnOnce(&mut Peer)) -> Finished {
    let daemon = FakeDaemon::new();
    let client = hopes(arguments).and("--connect").with(daemon.address()).start();
    let mut peer = daemon.greet();
    play(&mut peer);
    peer.expect_goodbye();
    client.finish()
}

/// Answers the next request, which must be this one.
fn answer(peer: &mut Peer, request: impl Into<Message>, answer: impl Into<Message>) {
    let (channel, message) = peer.next().expect("a request is due");
    assert_eq!(message, request.into());
    assert_ne!(channel, 0, "it is not about the connection");
    // Messages on other channels and pings in between are not the answer.
    peer.send(channel + 1, Heartbeat { stream: 1, frame: 1 });
    peer.send(0, Ping { token: 5 });
    peer.send(channel, answer);
    let pong = Message::from(Pong { token: 5 });
    assert_eq!(peer.next(), Some((0, pong)));
}

fn status() -> Status {
    Status {
        software: "fake".to_owned(),
        uptime_ms: 61_000,
        epoch: 42,
        connections: 2,
        refused_messages: 0,
        memory: 0,
        memory_limit: 0,
        streams: vec![],
    }
}

fn peers() -> Peers {
    let first = hopes_protocol::Peer {
        peer: 3,
        place: "unix:/tmp/a\u{1b}.sock".to_owned(),
        software: "sensor\u{7} 1".to_owned(),
        connected_ms: 3_723_456,
        silent_ms: 1_250,
        producers: 1,
        consumers: 0,
        held: 1 << 20,
        received: 12_345,
        sent: 1 << 30,
        lagged: 0,
    };
    let second = hopes_protocol::Peer {
        peer: 12,
        place: "tcp:127.0.0.1:7878".to_owned(),
        software: String::new(),
        connected_ms: 40,
        lagged: 1_000,
        ..first.clone()
    };
    Peers { peers: vec![first, second] }
}

fn memory() -> Memory {
    let stream = StreamMemory { name: "cam\u{7}".to_owned(), points: 1 << 20, views: 2 << 20, queue: 3 << 10 };
    Memory { limit: 1 << 30, held: 4 << 20, peers: 1 << 10, streams: vec![stream] }
}

#[test]
fn peers_and_memory_are_shown_when_asked_for() {
    let everything = |arguments| {
        served(arguments, |peer| {
            answer(peer, StatusWanted {}, status());
            answer(peer, ListPeers {}, peers());
            answer(peer, GetMemory {}, memory());
        })
        .text()
    };
    let expected = "\
fake, up 1m 1s, 2 connections, 0 messages refused, memory 0 B (no limit)
no streams

peer  came to             software   connected  silent  producers  consumers      held   received      sent  lagged
   3  unix:/tmp/a\u{fffd}.sock   sensor\u{fffd} 1   1h 2m 3s    1.2s          1          0  1.00 MiB  12.06 KiB  1.00 GiB       0
  12  tcp:127.0.0.1:7878                  0.0s    1.2s          1          0  1.00 MiB  12.06 KiB  1.00 GiB   1,000

memory 4.00 MiB (of 1.00 GiB), 1.00 KiB of it for peers
stream    points     views     queue
cam\u{fffd}    1.00 MiB  2.00 MiB  3.00 KiB
";
    assert_eq!(everything("status --memory --peers"), expected);
    let lines = everything("status --peers --memory --json");
    let values: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(values.len(), 3, "{lines}");
    assert_eq!((&values[0]["software"], &values[0]["streams"]), (&json!("fake"), &json!([])));
    assert_eq!(values[1], serde_json::to_value(peers()).unwrap());
    assert_eq!(values[2], serde_json::to_value(memory()).unwrap());
}

#[test]
fn nothing_more_is_asked_than_is_shown() {
    let only_peers = served("status --peers", |peer| {
        answer(peer, StatusWanted {}, status());
        answer(peer, ListPeers {}, Peers { peers: vec![] });
    });
    assert!(only_peers.text().ends_with(
        "no streams\n\npeer  came to  software  connected  silent  producers  consumers  held  received  sent  lagged\n"
    ));
    let only_memory = served("status --memory", |peer| {
        answer(peer, StatusWanted {}, status());
        answer(peer, GetMemory {}, memory());
    });
    assert!(only_memory.text().contains("no streams\n\nmemory 4.00 MiB"));
}

#[test]
fn the_end_of_a_stream_is_told_with_its_last_frame() {
    let stopped = |arguments| {
        let scan = || "scan".to_owned();
        served(arguments, |peer| {
            answer(peer, StopStream { name: scan() }, StreamStopped { name: scan(), frame: 12 });
        })
        .text()
    };
    assert_eq!(stopped("stop-stream scan"), "stream scan has ended after frame 12\n");
    assert_eq!(stopped("stop-stream scan --json"), "{\"name\":\"scan\",\"frame\":12}\n");
}

#[test]
fn the_end_of_a_connection_is_told() {
    let disconnected = |arguments| {
        served(arguments, |peer| answer(peer, Disconnect { peer: u64::MAX }, Disconnected { peer: u64::MAX })).text()
    };
    assert_eq!(disconnected("disconnect 18446744073709551615"), "peer 18446744073709551615 is disconnected\n");
    assert_eq!(disconnected("disconnect 18446744073709551615 --json"), "{\"peer\":18446744073709551615}\n");
}

/// The address has the same name as for other consumers, too.
#[test]
fn from_is_another_word_for_connect() {
    let daemon = FakeDaemon::over_tcp();
    let client = hopes("disconnect 3 --from").with(daemon.address()).start();
    let mut peer = daemon.greet();
    answer(&mut peer, Disconnect { peer: 3 }, Disconnected { peer: 3 });
    peer.expect_goodbye();
    assert_eq!(client.finish().text(), "peer 3 is disconnected\n");
}

#[test]
fn what_is_refused_is_told_with_the_daemons_reason() {
    let requests = [
        ("stop-stream scan", ErrorCode::NoStream, "no stream is called scan"),
        ("disconnect 3", ErrorCode::NoPeer, "there is no peer 3"),
        ("status --peers", ErrorCode::Unexpected, "not on this connection"),
    ];
    for (arguments, code, reason) in requests {
        let daemon = FakeDaemon::new();
        let client = hopes(arguments).and("--connect").with(daemon.address()).start();
        let mut peer = daemon.greet();
        let (channel, request) = peer.next().expect("a request is due");
        peer.send(channel, Report { code: code as u16, answers: request.kind(), text: reason.to_owned() });
        client.finish().fails(1, &[reason, &daemon.address()]);
    }
}

#[test]
fn a_daemon_that_answers_something_else_or_goes_gives_an_error() {
    let failed = |play: &dyn Fn(&mut Peer, u32), words: &[&str]| {
        let daemon = FakeDaemon::new();
        let client = hopes("stop-stream scan --connect").with(daemon.address()).start();
        let mut peer = daemon.greet();
        let (channel, _) = peer.next().expect("a request is due");
        play(&mut peer, channel);
        drop(peer);
        client.finish().fails(1, &[words, &[daemon.address().as_str()]].concat());
    };
    failed(&|peer, channel| peer.send(channel, Disconnected { peer: 1 }), &["type 0x0306", "update the older"]);
    failed(&|_, _| (), &["closed the connection instead of answering"]);
    let goodbye = Goodbye { reason: "going home".to_owned(), streams: vec![] };
    failed(&|peer, _| peer.send(0, goodbye.clone()), &["says goodbye instead: going home"]);
}

/// A daemon of version 2 is not sent what it does not know. It is told apart from one that refuses.
#[test]
fn an_older_daemon_is_told_as_such() {
    for (arguments, requests) in
        [("stop-stream scan", 0), ("disconnect 3", 0), ("status --peers", 1), ("status --memory", 1)]
    {
        let daemon = FakeDaemon::new();
        let client = hopes(arguments).and("--connect").with(daemon.address()).start();
        let mut peer = daemon.accept();
        peer.banner();
        peer.write(&Banner { lowest: 1, highest: 2 }.encode());
        assert!(matches!(peer.next(), Some((0, Message::Hello(_)))));
        peer.write(&encode(2, 0, &welcome().into()).unwrap());
        for _ in 0..requests {
            let Some((channel, Message::GetStatus(_))) = peer.next() else { panic!("GetStatus is due") };
            peer.write(&encode(2, channel, &status().into()).unwrap());
        }
        assert_eq!(peer.next(), None, "{arguments}: nothing more is sent");
        let finished = client.finish();
        finished.fails(1, &["speaks protocol version 2, and this needs version 3: update it", &daemon.address()]);
    }
}

/// Without what version 3 has, an older daemon serves as before.
#[test]
fn the_status_of_an_older_daemon_is_shown() {
    let daemon = FakeDaemon::new();
    let client = hopes("status --from").with(daemon.address()).start();
    let mut peer = daemon.accept();
    peer.banner();
    peer.write(&Banner { lowest: 1, highest: 1 }.encode());
    assert!(matches!(peer.next(), Some((0, Message::Hello(_)))));
    peer.write(&encode(1, 0, &welcome().into()).unwrap());
    let Some((channel, Message::GetStatus(_))) = peer.next() else { panic!("GetStatus is due") };
    peer.write(&encode(1, channel, &status().into()).unwrap());
    assert!(client.finish().text().starts_with("fake, up 1m 1s"));
}
