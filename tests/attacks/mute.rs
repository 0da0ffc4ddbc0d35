//! Peers that read nothing of what they ask for.

use std::thread;
use std::time::Duration;

use hopes_protocol::*;

use super::scene::{assert_ends_well, follow, stream_of, view};
use crate::common::client::{Client, bytes};
use crate::common::peers::{Daemon, ProducerAndConsumer, points};
use crate::common::process::eventually;
use crate::common::random::Random;

const LIMIT: u64 = 512 << 20;

fn memory(daemon: &Daemon) -> Memory {
    match daemon.client().ask(9, GetMemory {}) {
        Message::Memory(memory) => memory,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_mute_peer_with_many_subscriptions_holds_one_snapshot() {
    let daemon = Daemon::start("--max-memory 512MiB --timeout 30s");
    let (mut producer, _) = stream_of(&daemon, "cam", 100_000);
    let mut mute = daemon.client();
    for channel in 1..=200 {
        follow(&mut mute, channel, "cam", view(channel % 10));
        // Each in another frame, so that each would hold a snapshot of its own.
        if channel % 20 == 0 {
            producer.frame(&points(&mut Random::new(channel.into()), 10));
        }
    }
    thread::sleep(Duration::from_millis(500));
    let held = memory(&daemon);
    assert!(held.held < LIMIT && held.limit == LIMIT, "{held:?}");
    // The producer is served all the while.
    for _ in 0..10 {
        producer.frame(&points(&mut Random::new(1), 10));
    }
    ProducerAndConsumer::new(&daemon, "beside").step();
    assert_ends_well(daemon, Some(LIMIT));
}

#[test]
fn many_mute_peers_are_cut_off_before_points_are_refused() {
    const SMALL: u64 = 200 << 20;
    let daemon = Daemon::start("--max-memory 200MiB --timeout 30s --history 64MiB");
    let (mut producer, _) = stream_of(&daemon, "cam", 60_000);
    let mut mutes: Vec<Client> = Vec::new();
    let mut random = Random::new(5);
    for frame in 2..=60 {
        let mut client = daemon.client();
        follow(&mut client, 1, "cam", View { cut: Cut::Full, simplify: Simplify::No });
        mutes.push(client);
        // Every point is taken, whatever the readers hold.
        assert_eq!(producer.frame(&points(&mut random, 100)), frame);
    }
    let held = memory(&daemon);
    assert!(held.held < SMALL + (16 << 20), "{held:?}");
    assert_ends_well(daemon, Some(SMALL));
}

#[test]
fn half_read_messages_are_counted() {
    let daemon = Daemon::start("");
    let batch = Batch { sequence: 1, points: vec![(0.5, 0.5); 60_000], times: Vec::new(), tags: Vec::new() };
    let message = bytes(1, batch);
    let before = memory(&daemon).peers;
    let mut half: Vec<Client> = (0..10).map(|_| daemon.client()).collect();
    for client in &mut half {
        client.write(&message[..message.len() / 2]);
    }
    let expected = before + 10 * (message.len() / 2) as u64;
    eventually("it is counted", || (memory(&daemon).peers >= expected).then_some(()));
    let peers = match daemon.client().ask(9, ListPeers {}) {
        Message::Peers(peers) => peers.peers,
        other => panic!("{other:?}"),
    };
    let many = peers.iter().filter(|peer| peer.held >= (message.len() / 2) as u64).count();
    assert_eq!(many, 10, "{peers:?}");
    drop(half);
    eventually("it is given back", || (memory(&daemon).peers < expected / 2).then_some(()));
    assert_ends_well(daemon, None);
}

#[test]
fn a_producer_that_reads_no_answers_is_read_no_further() {
    let daemon = Daemon::start("--max-memory 256MiB");
    let mut producer = daemon.producer("cam");
    let mut random = Random::new(2);
    // Each tag is answered with a vertex.
    let tags: Vec<u64> = (0..20_000).collect();
    let mut sent = 0;
    loop {
        let some = points(&mut random, tags.len());
        let batch = Batch { sequence: sent, points: some, times: Vec::new(), tags: tags.clone() };
        if !producer.client.writes_within(&bytes(1, batch), Duration::from_secs(2)) {
            break;
        }
        sent += 1;
        assert!(sent < 500, "it is read on and on");
    }
    assert!(memory(&daemon).peers < 20 << 20, "{:?}", memory(&daemon));
    ProducerAndConsumer::new(&daemon, "beside").step();
    assert_ends_well(daemon, Some(256 << 20));
}
