//! Administration: who is connected, what the memory is used for, and how streams and connections are ended.

use hopes_protocol::*;

use crate::common::client::{Client, hello};
use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, open, points, subscribe};
use crate::common::process::{eventually, hopes};
use crate::common::random::Random;
use crate::slow::{lagging, lags};

/// The channel of requests.
const CHANNEL: u32 = 77;

fn peers_of(client: &mut Client) -> Vec<Peer> {
    match client.ask(CHANNEL, ListPeers {}) {
        Message::Peers(Peers { peers }) => peers,
        other => panic!("Peers is due, not {other:?}"),
    }
}

fn memory_of(client: &mut Client) -> Memory {
    match client.ask(CHANNEL, GetMemory {}) {
        Message::Memory(memory) => memory,
        other => panic!("Memory is due, not {other:?}"),
    }
}

/// The only peer that this is true of.
fn the_one(peers: &[Peer], is: impl Fn(&Peer) -> bool) -> Peer {
    let found: Vec<&Peer> = peers.iter().filter(|peer| is(peer)).collect();
    assert_eq!(found.len(), 1, "{peers:?}");
    found[0].clone()
}

/// A client with a name of its own.
fn named(daemon: &Daemon, software: &str) -> Client {
    let mut client = Client::new(&daemon.address);
    let greeting = Hello { software: software.to_owned(), ..hello() };
    assert!(matches!(client.ask(0, greeting), Message::Welcome(_)));
    client
}

fn stop(name: &str) -> StopStream {
    StopStream { name: name.to_owned() }
}

// ---- peers

#[test]
fn peers_are_listed_with_what_they_do() {
    let daemon = Daemon::start("");
    let mut producer = named(&daemon, "sensor");
    for channel in [1, 2] {
        assert!(matches!(producer.ask(channel, open("cam")), Message::Opened(_)));
    }
    let mut consumer = named(&daemon, "screen");
    assert!(matches!(consumer.ask(1, subscribe("cam", FULL)), Message::StreamOpened(_)));
    let silent = Client::without_banner(&daemon.address);
    let mut admin = named(&daemon, "admin");
    let peers = eventually("the silent peer is listed", || {
        let peers = peers_of(&mut admin);
        (peers.len() == 4).then_some(peers)
    });
    assert!(peers.is_sorted_by(|one, next| one.peer < next.peer), "{peers:?}");
    assert!(peers.iter().all(|peer| peer.place == daemon.address), "{peers:?} came to {}", daemon.address);
    let counts = |software: &str| {
        let peer = the_one(&peers, |peer| peer.software == software);
        (peer.producers, peer.consumers)
    };
    assert_eq!((counts("sensor"), counts("screen"), counts("admin"), counts("")), ((2, 0), (0, 1), (0, 0), (0, 0)));
    for peer in &peers {
        assert!(peer.silent_ms <= peer.connected_ms, "{peer:?}");
        let has_spoken = !peer.software.is_empty();
        assert_eq!(peer.received >= Banner::LENGTH as u64, has_spoken, "{peer:?}");
        assert!(!has_spoken || peer.sent > Banner::LENGTH as u64, "{peer:?}");
    }
    drop(silent);
    daemon.stop();
}

#[test]
fn bytes_are_counted_and_numbers_are_not_given_twice() {
    let daemon = Daemon::over_tcp("");
    let mut admin = named(&daemon, "admin");
    let own = |peers: &[Peer]| the_one(peers, |peer| peer.software == "admin");
    let first = own(&peers_of(&mut admin));
    assert_eq!(first.place, daemon.address);
    for _ in 0..100 {
        admin.ping();
    }
    let second = own(&peers_of(&mut admin));
    // A ping and a pong have a header, a token and a CRC.
    let least = 100 * (HEADER as u64 + 5);
    assert_eq!(second.peer, first.peer);
    assert!(second.received >= first.received + least && second.sent >= first.sent + least, "{first:?} {second:?}");

    let mut numbers = vec![first.peer];
    for _ in 0..3 {
        let mut guest = named(&daemon, "guest");
        let number = the_one(&peers_of(&mut admin), |peer| peer.software == "guest").peer;
        assert!(!numbers.contains(&number), "{number} in {numbers:?}");
        numbers.push(number);
        guest.ping();
        guest.part();
        eventually("the guest is gone", || (peers_of(&mut admin).len() == 1).then_some(()));
    }
    daemon.stop();
}

#[test]
fn merged_frames_are_counted_for_the_peer_that_lagged() {
    let daemon = Daemon::start("");
    let (mut slow, _moving, fast) = lagging(&daemon);
    lags(&mut slow, fast.number());
    let peers = peers_of(&mut daemon.client());
    let lagged = the_one(&peers, |peer| peer.lagged > 0);
    assert_eq!((lagged.lagged, lagged.consumers), (daemon.stream("cam").lagged, 1));
    daemon.stop();
}

#[test]
fn a_peer_is_disconnected() {
    let daemon = Daemon::start("");
    let (mut victim, mut witness) = (named(&daemon, "victim"), named(&daemon, "witness"));
    assert!(matches!(victim.ask(1, open("cam")), Message::Opened(_)));
    let mut admin = named(&daemon, "admin");
    let number = the_one(&peers_of(&mut admin), |peer| peer.software == "victim").peer;
    let answer = admin.ask(CHANNEL, Disconnect { peer: number });
    assert_eq!(answer, Disconnected { peer: number }.into());
    victim.rest();
    eventually("it is not listed any more", || {
        peers_of(&mut admin).iter().all(|peer| peer.software != "victim").then_some(())
    });
    assert_eq!(admin.is_refused(CHANNEL, Disconnect { peer: number }), ErrorCode::NoPeer as u16, "only once");
    assert_eq!(admin.is_refused(CHANNEL, Disconnect { peer: u64::MAX }), ErrorCode::NoPeer as u16);
    witness.ping();
    assert_eq!(witness.list("cam")[0].producers, 0, "the stream stays, without its producer");
    daemon.stop();
}

/// A peer that has stopped halfway through a message, or has said nothing at all, goes too.
#[test]
fn a_peer_that_says_nothing_is_disconnected() {
    let daemon = Daemon::start("");
    let mut admin = named(&daemon, "admin");
    let mut halfway = named(&daemon, "halfway");
    halfway.write(&header(VERSION, 0x0103, 1, 1 << 16));
    let mut mute = Client::without_banner(&daemon.address);
    let peers = eventually("both are listed", || {
        let peers = peers_of(&mut admin);
        (peers.len() == 3).then_some(peers)
    });
    for peer in peers.iter().filter(|peer| peer.software != "admin") {
        let answer = admin.ask(CHANNEL, Disconnect { peer: peer.peer });
        assert_eq!(answer, Disconnected { peer: peer.peer }.into());
    }
    halfway.rest();
    while mute.try_banner().is_some() {}
    eventually("they are gone", || (peers_of(&mut admin).len() == 1).then_some(()));
    daemon.stop();
}

// ---- streams

#[test]
fn a_stream_is_stopped_for_all_its_peers() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", DERIVED);
    let mut other = daemon.producer("other");
    assert_eq!(producer.frame(&[(0.0, 0.0), (1.0, 0.0)]), 1);
    assert_eq!(producer.frame(&[(1.0, 1.0)]), 2);
    consumer.follow_to(2);
    let mut admin = daemon.client();
    let answer = admin.ask(CHANNEL, stop("cam"));
    assert_eq!(answer, StreamStopped { name: "cam".to_owned(), frame: 2 }.into());
    assert_eq!(producer.answer(), Closed { frame: 2 }.into());
    let closed = consumer.client.receive_on(Consumer::CHANNEL);
    assert!(matches!(&closed, Message::StreamClosed(closed) if closed.frame == 2), "{closed:?}");
    let names = |admin: &mut Client| admin.list("*").into_iter().map(|info| info.name).collect::<Vec<_>>();
    assert_eq!(names(&mut admin), ["other"]);
    assert_eq!(admin.is_refused(CHANNEL, stop("cam")), ErrorCode::NoStream as u16, "only once");
    assert_eq!(other.frame(&[(0.0, 0.0)]), 1, "other streams go on");
    // A new stream of that name has another epoch.
    let again = daemon.producer("cam");
    assert!(again.opened.created && again.opened.epoch != producer.opened.epoch, "{:?}", again.opened);
    daemon.stop();
}

#[test]
fn a_stream_without_frames_or_peers_is_stopped() {
    let daemon = Daemon::start("--stream ready");
    let mut admin = daemon.client();
    let answer = admin.ask(CHANNEL, stop("ready"));
    assert_eq!(answer, StreamStopped { name: "ready".to_owned(), frame: 0 }.into());
    assert_eq!(admin.list("*").len(), 0);
    daemon.stop();
}

#[test]
fn requests_that_make_no_sense_are_refused() {
    let daemon = Daemon::start("--stream ready");
    let mut admin = daemon.client();
    assert_eq!(admin.is_refused(CHANNEL, stop("none")), ErrorCode::NoStream as u16);
    for name in ["", "a*", "a\n", &"a".repeat(201)] {
        assert_eq!(admin.is_refused(CHANNEL, stop(name)), ErrorCode::BadName as u16, "{name:?}");
    }
    // Channel 0, and one that is in use, are not free.
    assert!(matches!(admin.ask(1, open("cam")), Message::Opened(_)));
    let requests: [Message; 4] =
        [ListPeers {}.into(), GetMemory {}.into(), stop("ready").into(), Disconnect { peer: 1 }.into()];
    for request in requests {
        for channel in [0, 1] {
            let code = admin.is_refused(channel, request.clone());
            assert_eq!(code, ErrorCode::ChannelInUse as u16, "{request:?} on channel {channel}");
        }
    }
    // What only a daemon sends.
    let answers: [Message; 4] = [
        Peers { peers: vec![] }.into(),
        StreamStopped { name: "ready".to_owned(), frame: 1 }.into(),
        Disconnected { peer: 1 }.into(),
        Memory { limit: 0, held: 0, peers: 0, streams: vec![] }.into(),
    ];
    for answer in answers {
        assert_eq!(admin.is_refused(CHANNEL, answer), ErrorCode::Unexpected as u16);
    }
    assert_eq!(admin.list("*").len(), 2, "nothing has been stopped");
    daemon.stop();
}

// ---- memory

#[test]
fn memory_is_told_apart_by_what_it_is_for() {
    let daemon = Daemon::start("--max-memory 1GiB --stream empty");
    let mut admin = daemon.client();
    let before = memory_of(&mut admin);
    assert_eq!((before.limit, before.streams.len()), (1 << 30, 1));
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    producer.frame(&points(&mut Random::new(3), 5_000));
    consumer.follow_to(1);
    producer.frame(&points(&mut Random::new(4), 5_000));
    consumer.follow_to(2);
    let after = memory_of(&mut admin);
    let names: Vec<&str> = after.streams.iter().map(|stream| stream.name.as_str()).collect();
    assert_eq!(names, ["cam", "empty"], "sorted by name");
    let [cam, empty] = &after.streams[..] else { panic!("{after:?}") };
    // A point alone has two coordinates.
    assert!(cam.points >= 10_000 * 16 && cam.views > 0, "{cam:?}");
    assert!(cam.points > empty.points, "{empty:?}");
    let parts = |memory: &Memory| {
        let streams = memory.streams.iter().map(|stream| stream.points + stream.views + stream.queue);
        streams.sum::<u64>() + memory.peers
    };
    assert!(after.held >= before.held + 10_000 * 16, "{before:?} {after:?}");
    assert!(after.held >= parts(&after), "{after:?}");
    let answer = admin.ask(CHANNEL, stop("cam"));
    assert!(matches!(answer, Message::StreamStopped(_)), "{answer:?}");
    eventually("its memory is free", || (memory_of(&mut admin).held < before.held + 10_000 * 16).then_some(()));
    daemon.stop();
}

/// Half a message costs memory, which is told where it is held.
#[test]
fn half_messages_count_as_memory_of_their_peer() {
    let daemon = Daemon::start("");
    let mut admin = named(&daemon, "admin");
    let before = memory_of(&mut admin);
    assert_eq!(before.limit, 0, "there is none");
    let mut halfway = named(&daemon, "halfway");
    let half = vec![0; 1 << 20];
    halfway.write(&[&header(VERSION, 0x0103, 1, 1 << 21)[..], &half].concat());
    eventually("half of the message is held", || {
        let peer = the_one(&peers_of(&mut admin), |peer| peer.software == "halfway");
        let memory = memory_of(&mut admin);
        let is_told = peer.held >= 1 << 20 && memory.peers >= before.peers + (1 << 20) && memory.held >= memory.peers;
        is_told.then_some(())
    });
    daemon.stop();
}

// ---- the tools

#[test]
fn the_tools_list_stop_and_disconnect() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut victim = named(&daemon, "victim");
    let run = |arguments: &str| hopes(arguments).and("--connect").with(&daemon.address).runs();
    let tables = run("status --peers --memory").text();
    for words in ["victim", "came to", "of it for peers", "cam", "(no limit)"] {
        assert!(tables.contains(words), "{words}: {tables}");
    }
    let lines = run("status --peers --memory --json").text();
    let values: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let peers = values[1]["peers"].as_array().expect("a list");
    let number = peers.iter().find(|peer| peer["software"] == "victim").expect("it is listed")["peer"].clone();
    assert_eq!(values[2]["streams"][0]["name"], "cam");

    assert_eq!(run(&format!("disconnect {number}")).text(), format!("peer {number} is disconnected\n"));
    victim.rest();
    run(&format!("disconnect {number}")).fails(1, &[&number.to_string(), &daemon.address]);
    assert_eq!(run("stop-stream cam --json").text(), "{\"name\":\"cam\",\"frame\":1}\n");
    assert_eq!(producer.answer(), Closed { frame: 1 }.into());
    run("stop-stream cam").fails(1, &["cam", &daemon.address]);
    daemon.stop();
}

/// A consumer that waits for frames is told that the stream has ended, and not left alone.
#[test]
fn a_tool_that_follows_a_stopped_stream_says_so() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut watch = hopes("watch --stream cam --from").with(&daemon.address).start();
    assert!(watch.line().expect("a frame").contains("frame 1"));
    let stopped = daemon.client().ask(CHANNEL, stop("cam"));
    assert!(matches!(stopped, Message::StreamStopped(StreamStopped { frame: 1, .. })), "{stopped:?}");
    let line = watch.line().expect("the end of the stream");
    assert!(line.contains("cam") && line.contains("ended"), "{line}");
    daemon.stop();
    watch.finish();
}
