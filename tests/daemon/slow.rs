//! Peers that do not read: frames are merged for them or replaced by snapshots, and no other peer waits.

use std::time::Duration;

use hopes_protocol::*;

use crate::common::client::{brief, bytes};
use crate::common::peers::{Consumer, Daemon, FULL, Point, Producer, ProducerAndConsumer, held, open, points};
use crate::common::process::{eventually, settled};
use crate::common::random::Random;

/// Points that stay, and points that are replaced in each frame. A diff has some 100 KiB, a snapshot has more.
const STAY: usize = 6000;
const MOVE: usize = 1000;

/// More frames than sockets hold.
const FRAMES: u64 = 20;

/// A stream in which some points move in each frame.
pub struct Moving {
    producer: Producer,
    random: Random,
    moving: Vec<Point>,
}

impl Moving {
    fn new(daemon: &Daemon) -> Self {
        let mut random = Random::new(40);
        let mut producer = daemon.producer("cam");
        let moving = points(&mut random, MOVE);
        let stay = points(&mut random, STAY);
        producer.frame(&[&moving[..], &stay].concat());
        Self { producer, random, moving }
    }

    fn step(&mut self) -> u64 {
        let retraction = self.producer.retract(&self.moving);
        self.producer.is_accepted(retraction, MOVE);
        self.moving = points(&mut self.random, MOVE);
        self.producer.frame(&self.moving)
    }
}

/// A consumer that reads nothing while many frames are sent. Another consumer reads each of them.
pub fn lagging(daemon: &Daemon) -> (Consumer, Moving, Mirror) {
    let mut moving = Moving::new(daemon);
    let (mut slow, mut fast) = (daemon.consumer("cam", FULL), daemon.consumer("cam", FULL));
    slow.expect_snapshot(Cause::Start);
    fast.expect_snapshot(Cause::Start);
    for _ in 0..FRAMES {
        let frame = moving.step();
        fast.expect_diff(frame);
    }
    (slow, moving, fast.mirror)
}

/// Every frame is either sent or covered by a `Lagged`, whose range ends at the frame that follows it. Returns those
/// messages.
pub fn lags(slow: &mut Consumer, last: u64) -> Vec<Message> {
    let mut after_lag = Vec::new();
    while slow.mirror.number() < last {
        let had = slow.mirror.number();
        match slow.next() {
            Message::Lagged(lagged) => {
                assert_eq!(lagged.first, had + 1);
                let next = slow.next();
                assert_eq!(slow.mirror.number(), lagged.last + 1);
                after_lag.push(next);
            }
            Message::Diff(diff) => assert_eq!((diff.from, diff.frame.number), (had, had + 1)),
            // A snapshot of the next frame skips nothing.
            Message::Snapshot(shown) => assert_eq!((shown.cause, shown.frame.number), (Cause::Lagged, had + 1)),
            other => panic!("{}", brief(&other)),
        }
    }
    after_lag
}

#[test]
fn frames_are_merged_for_a_consumer_that_does_not_read() {
    let daemon = Daemon::start("--consumer-queue 64KiB");
    let (mut slow, mut moving, fast) = lagging(&daemon);
    let merged = lags(&mut slow, FRAMES + 1);
    let [Message::Diff(diff)] = &merged[..] else { panic!("{} times", merged.len()) };
    assert!(diff.frame.number - diff.from > FRAMES / 2, "{} to {}", diff.from, diff.frame.number);
    assert_eq!(held(&slow.mirror), held(&fast));
    assert_eq!(daemon.stream("cam").lagged, diff.frame.number - diff.from - 1);
    let next = moving.step();
    slow.expect_diff(next);
    daemon.stop();
}

#[test]
fn a_snapshot_replaces_frames_that_the_log_no_longer_has() {
    let daemon = Daemon::start("--consumer-queue 64KiB --history 64KiB");
    let (mut slow, mut moving, fast) = lagging(&daemon);
    let replaced = lags(&mut slow, FRAMES + 1);
    let [Message::Snapshot(snapshot)] = &replaced[..] else { panic!("{} times", replaced.len()) };
    assert_eq!((snapshot.cause, snapshot.frame.number), (Cause::Lagged, FRAMES + 1));
    assert_eq!(held(&slow.mirror), held(&fast));
    let next = moving.step();
    slow.expect_diff(next);
    daemon.stop();
}

#[test]
fn a_snapshot_replaces_merged_frames_where_it_is_smaller() {
    let daemon = Daemon::start("--consumer-queue 1KiB");
    let mut producer = Producer::open(daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let mut random = Random::new(41);
    producer.frame(&points(&mut random, 2500));
    let mut slow = daemon.consumer("cam", FULL);
    slow.expect_snapshot(Cause::Start);
    for _ in 0..FRAMES {
        producer.frame(&points(&mut random, 2500));
    }
    let replaced = lags(&mut slow, FRAMES + 1);
    assert!(replaced.iter().any(|message| matches!(message, Message::Snapshot(shown) if shown.cause == Cause::Lagged)));
    assert_eq!(slow.mirror.number(), FRAMES + 1);
    daemon.stop();
}

#[test]
#[cfg(target_os = "linux")]
fn many_consumers_that_do_not_read_take_no_memory() {
    let daemon = Daemon::start("--consumer-queue 64KiB --history 1MiB");
    let mut moving = Moving::new(&daemon);
    let consumers: Vec<Consumer> = (0..20).map(|_| daemon.consumer("cam", FULL)).collect();
    for _ in 0..5 {
        moving.step();
    }
    let before = daemon.running.peak_memory();
    for _ in 0..FRAMES {
        moving.step();
    }
    // The unread data of all of them has more than 40 MB.
    let grown = daemon.running.peak_memory() - before;
    assert!(grown < 16 << 20, "{grown} bytes");
    drop(consumers);
    daemon.stop();
}

#[test]
fn a_producer_that_does_not_read_its_answers_stops_only_itself() {
    for daemon in [Daemon::start(""), Daemon::over_tcp("")] {
        let mut pair = ProducerAndConsumer::new(&daemon, "cam");
        let mut stubborn = daemon.producer("cam");
        // On the same stream and with the same limits, as fast as possible.
        let batch = |sequence| {
            let points = vec![(sequence as f64 * 1e-6, 0.25)];
            bytes(Producer::CHANNEL, Batch { sequence, points, times: vec![], tags: vec![sequence] })
        };
        let (mut sequence, mut rest) = (0, Vec::new());
        let mut written = 0;
        settled(Duration::from_millis(300), || {
            loop {
                if rest.is_empty() {
                    sequence += 1;
                    rest = batch(sequence);
                }
                let taken = stubborn.client.socket.write_nonblocking(&rest).unwrap();
                rest.drain(..taken);
                written += taken;
                if taken == 0 {
                    return Some(written);
                }
            }
        });
        for _ in 0..20 {
            pair.step();
        }
        // Once it reads, all messages are answered in order.
        std::thread::scope(|scope| {
            let socket = stubborn.client.socket.try_clone().unwrap();
            scope.spawn(move || std::io::Write::write_all(&mut { socket }, &rest).unwrap());
            for expected in 1..=sequence {
                match stubborn.client.receive_on(Producer::CHANNEL) {
                    Message::Accepted(accepted) => assert_eq!((accepted.sequence, accepted.points), (expected, 1)),
                    other => panic!("{other:?}"),
                }
            }
        });
        pair.step();
        daemon.stop();
    }
}

#[test]
fn messages_of_a_vanished_producer_are_processed() {
    let daemon = Daemon::start("");
    let mut random = Random::new(42);
    for round in 1..=10 {
        let mut producer = daemon.producer("cam");
        // Everything in one write, so that it has arrived when the connection ends. The half frame at the end is
        // ignored.
        let mut all = Vec::new();
        for sequence in 0..400 {
            let points = points(&mut random, 10);
            all.extend(bytes(Producer::CHANNEL, Batch { sequence, points, times: vec![], tags: vec![] }));
        }
        all.extend(bytes(Producer::CHANNEL, Commit { sequence: 400, time: None }));
        let half =
            bytes(Producer::CHANNEL, Batch { sequence: 401, points: vec![(9.0, 9.0)], times: vec![], tags: vec![] });
        producer.client.write(&[&all[..], &half[..half.len() - 1]].concat());
        drop(producer);
        let info = eventually("the frame is closed", || {
            let info = daemon.stream("cam").info;
            (info.frame == round).then_some(info)
        });
        assert_eq!(info.points, 4000 * round);
    }
    daemon.stop();
}
