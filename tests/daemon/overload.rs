//! Producers that are faster than the engine: they wait, or batches are dropped. In both cases a producer gets an
//! answer for every point.

use std::collections::BTreeMap;

use hopes_protocol::*;

use crate::common::client::brief;
use crate::common::peers::{Daemon, FULL, Point, Producer, open, points};
use crate::common::process::eventually;
use crate::common::random::Random;

/// Points in a batch. Some thirteen batches fill the queue.
const SIZE: usize = 5000;

/// Batches between two commits.
const BATCHES: u64 = 20;

#[derive(Default)]
struct Tally {
    accepted: u64,
    dropped: u64,
    committed: u64,
    /// Sequence numbers in the order in which the engine handled them.
    in_order: Vec<u64>,
}

/// Reads the answers to all these messages. There must be one for each.
fn tally(producer: &mut Producer, mut owed: BTreeMap<u64, usize>) -> Tally {
    let mut tally = Tally::default();
    let mut total = None;
    while !owed.is_empty() {
        let (sequence, points) = match producer.answer() {
            Message::Accepted(accepted) => {
                tally.accepted += u64::from(accepted.points);
                tally.in_order.push(accepted.sequence);
                (accepted.sequence, accepted.points)
            }
            Message::Overloaded(overloaded) => {
                tally.dropped += u64::from(overloaded.points);
                assert!(total.replace(overloaded.total) < Some(overloaded.total), "the total grows");
                (overloaded.sequence, overloaded.points)
            }
            Message::Committed(committed) => {
                tally.committed += 1;
                tally.in_order.push(committed.sequence);
                (committed.sequence, 0)
            }
            other => panic!("{}", brief(&other)),
        };
        assert_eq!(owed.remove(&sequence), Some(points as usize), "{sequence} is answered once");
    }
    tally
}

/// A large frame that keeps the engine busy, and directly after it more than fits into the queue.
fn burst(producer: &mut Producer, batch: &[Point]) -> BTreeMap<u64, usize> {
    let mut owed = BTreeMap::new();
    for _ in 0..3 {
        owed.insert(producer.commit(), 0);
        owed.extend((0..BATCHES).map(|_| (producer.batch(batch), batch.len())));
    }
    owed.insert(producer.commit(), 0);
    owed
}

/// Sends bursts under a policy until something was dropped, and counts.
fn overloads(policy: &str) -> Vec<u64> {
    let daemon = Daemon::start(&format!("--overload {policy} --consumer-queue 64KiB --stream cam:window=points:20000"));
    let mut random = Random::new(50);
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let batch = points(&mut random, SIZE);
    let (mut sent, mut accepted, mut dropped, mut committed, mut in_order) = (0, 0, 0, 0, Vec::new());
    while dropped == 0 {
        // Different points each time, so that there is something to compute.
        let moved: Vec<Point> = batch.iter().map(|(x, y)| (x + sent as f64, *y)).collect();
        let owed = burst(&mut producer, &moved);
        sent += owed.values().sum::<usize>() as u64;
        let tally = tally(&mut producer, owed);
        assert_eq!(tally.committed, 4, "no commit is dropped");
        accepted += tally.accepted;
        dropped += tally.dropped;
        committed += tally.committed;
        in_order.extend(tally.in_order);
        consumer.follow_to(committed);
    }
    assert_eq!(accepted + dropped, sent);
    let stream = daemon.stream("cam");
    assert_eq!((stream.accepted, stream.dropped, stream.refused, stream.waiting), (accepted, dropped, 0, 0));
    assert_eq!(stream.info.frame, committed);
    daemon.stop();
    in_order
}

#[test]
fn the_oldest_batches_are_dropped_and_reported() {
    let in_order = overloads("drop-oldest");
    assert!(in_order.is_sorted(), "what is taken is taken in order");
}

#[test]
fn the_newest_batches_are_dropped_and_reported() {
    let in_order = overloads("drop-newest");
    assert!(in_order.is_sorted(), "what is taken is taken in order");
}

#[test]
fn by_default_a_producer_waits_and_nothing_is_dropped() {
    let daemon = Daemon::start("--stream cam:window=points:20000 --consumer-queue 64KiB");
    let mut random = Random::new(51);
    let mut producer = daemon.producer("cam");
    let mut consumer = daemon.consumer("cam", FULL);
    let batch = points(&mut random, SIZE);
    let owed = burst(&mut producer, &batch);
    let sent: usize = owed.values().sum();
    let sequences: Vec<u64> = owed.keys().copied().collect();
    let tally = tally(&mut producer, owed);
    assert_eq!((tally.accepted, tally.dropped, tally.in_order), (sent as u64, 0, sequences));
    consumer.follow_to(4);
    assert_eq!(daemon.stream("cam").dropped, 0);
    daemon.stop();
}

#[test]
fn a_busy_stream_does_not_delay_other_streams() {
    let daemon = Daemon::start("--stream cam:window=points:20000");
    let mut random = Random::new(52);
    let mut busy = daemon.producer("cam");
    let _consumer = daemon.consumer("cam", FULL);
    let owed = burst(&mut busy, &points(&mut random, SIZE));
    let mut other = daemon.producer("other");
    let mut status = daemon.client();
    for frame in 1..=50 {
        assert_eq!(other.frame(&points(&mut random, 10)), frame);
        status.status();
    }
    tally(&mut busy, owed);
    daemon.stop();
}

#[test]
fn messages_after_the_end_of_a_stream_do_not_block_their_producer() {
    let daemon = Daemon::start("");
    let mut random = Random::new(53);
    let (mut one, mut other) = (daemon.producer("cam"), daemon.producer("cam"));
    let _consumer = daemon.consumer("cam", FULL);
    one.batch(&points(&mut random, 30_000));
    one.commit();
    one.client.send(Producer::CHANNEL, Close { end: true });
    // From here on the end is in progress, behind a frame that takes time.
    one.client.ping();
    for _ in 0..300 {
        other.batch(&points(&mut random, 1));
    }
    other.client.ping();
    eventually("the stream is gone", || daemon.status().streams.is_empty().then_some(()));
    while !matches!(other.answer(), Message::Closed(_)) {}
    assert!(matches!(other.client.ask(5, open("cam")), Message::Opened(opened) if opened.created));
    daemon.stop();
}
