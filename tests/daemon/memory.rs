//! What the daemon says of its memory, beside what the operating system says.
#![cfg(target_os = "linux")]

use std::time::Duration;

use hopes_protocol::*;

use crate::common::peers::{DERIVED, Daemon, Point, Producer, ProducerAndConsumer, open, points};
use crate::common::random::Random;

/// What is said of the memory of all streams is right within a quarter.
fn assert_is_right(daemon: &Daemon, before: u64, what: &str) {
    // Threads of the computation give memory back when they go idle.
    std::thread::sleep(Duration::from_millis(300));
    let taken = daemon.running.own_memory() - before;
    let said: u64 = daemon.status().streams.iter().map(|stream| stream.memory).sum();
    assert!(said.abs_diff(taken) <= taken / 4, "{what}: {said} bytes are said to be held, {taken} are");
}

#[test]
fn memory_is_estimated_in_every_form() {
    let clouds =
        [("random", points(&mut Random::new(21), 250_000)), ("lattice", lattice(500)), ("repeated", repeated())];
    for (name, cloud) in clouds {
        let window = Window::Points(cloud.len() as u64);
        for window in [Window::All, window] {
            let daemon = Daemon::start("");
            // What connections and threads take is not that of a stream.
            let mut warm = ProducerAndConsumer::new(&daemon, "warm");
            (0..20).for_each(|_| warm.step());
            let before = daemon.running.own_memory();
            let mut producer = Producer::open(daemon.client(), Open { window: Some(window), ..open("cam") });
            for some in cloud.chunks(10_000) {
                let batch = producer.batch(some);
                producer.is_accepted(batch, some.len());
            }
            let commit = producer.commit();
            producer.is_committed(commit);
            assert_is_right(&daemon, before, &format!("{name}, {window:?}, nobody follows"));
            let mut consumer = daemon.consumer("cam", DERIVED);
            consumer.expect_snapshot(Cause::Start);
            assert_is_right(&daemon, before, &format!("{name}, {window:?}, computed in one pass"));
            for _ in 0..10 {
                let frame = producer.frame(&points(&mut Random::new(22), 20));
                consumer.follow_to(frame);
            }
            assert_is_right(&daemon, before, &format!("{name}, {window:?}, followed in steps"));
            daemon.stop();
        }
    }
}

fn lattice(side: u32) -> Vec<Point> {
    (0..side * side).map(|at| (f64::from(at % side), f64::from(at / side))).collect()
}

/// Few positions, with many points at each.
fn repeated() -> Vec<Point> {
    let few = points(&mut Random::new(23), 50_000);
    few.iter().cycle().take(400_000).copied().collect()
}
