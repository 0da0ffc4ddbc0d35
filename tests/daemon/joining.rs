//! Consumers that join late, change their view, leave, and resume: no frame is missing, and none is sent twice.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use hopes_protocol::*;

use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, Producer, held, open, points, subscribe};
use crate::common::random::Random;

/// Runs something while a producer commits frame after frame. Returns the number of the last frame.
fn while_frames_come(producer: &mut Producer, run: impl FnOnce()) -> u64 {
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let frames = scope.spawn(|| {
            let mut random = Random::new(30);
            loop {
                let frame = producer.frame(&points(&mut random, 10));
                if is_over.load(Ordering::Relaxed) {
                    return frame;
                }
            }
        });
        // The producer ends even if `run` panics.
        let over = SetOnDrop(&is_over);
        run();
        drop(over);
        frames.join().unwrap()
    })
}

struct SetOnDrop<'a>(&'a AtomicBool);

impl Drop for SetOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn windowed(daemon: &Daemon) -> Producer {
    Producer::open(daemon.client(), Open { window: Some(Window::Points(300)), ..open("cam") })
}

fn resume(daemon: &Daemon, view: View, resume: Resume) -> Consumer {
    Consumer::subscribe(daemon.client(), Subscribe { resume: Some(resume), ..subscribe("cam", view) })
}

/// A consumer whose connection is lost: its resume position and its mirror.
fn lost(consumer: Consumer) -> (Resume, Mirror) {
    (Resume { epoch: consumer.opened.epoch, frame: consumer.mirror.number() }, consumer.mirror)
}

#[test]
fn a_late_consumer_gets_a_snapshot_and_then_every_frame() {
    let daemon = Daemon::start("");
    let mut producer = windowed(&daemon);
    producer.frame(&[(0.0, 0.0)]);
    let mut consumers = Vec::new();
    let last = while_frames_come(&mut producer, || {
        for number in 0..24 {
            let mut consumer = daemon.consumer("cam", [FULL, DERIVED][number % 2]);
            let start = consumer.expect_snapshot(Cause::Start);
            consumer.expect_diffs_to(start + 5);
            consumers.push(consumer);
        }
    });
    for consumer in &mut consumers {
        consumer.expect_diffs_to(last);
        let first = daemon.consumer("cam", consumer.mirror.frame().unwrap().view).snapshot();
        assert_eq!(held(&consumer.mirror), held(&first));
    }
    assert!(last > 25, "{last}");
    daemon.stop();
}

impl Consumer {
    /// The first snapshot.
    fn snapshot(mut self) -> Mirror {
        self.expect_snapshot(Cause::Start);
        self.mirror
    }
}

#[test]
fn after_a_change_of_view_a_snapshot_comes_and_nothing_of_the_old_view() {
    let daemon = Daemon::start("");
    let mut producer = windowed(&daemon);
    producer.frame(&[(0.0, 0.0)]);
    let mut consumer = daemon.consumer("cam", FULL);
    consumer.expect_snapshot(Cause::Start);
    let last = while_frames_come(&mut producer, || {
        let mut before = FULL;
        for view in [DERIVED, FULL, View { simplify: Simplify::Below(0.1), ..FULL }, DERIVED, DERIVED] {
            consumer.client.send(Consumer::CHANNEL, ChangeView { view, dots: DotsWanted::No });
            let shown = loop {
                match consumer.next() {
                    Message::Diff(diff) => assert_eq!(diff.frame.view, before),
                    Message::Snapshot(snapshot) => break snapshot,
                    other => panic!("{other:?}"),
                }
            };
            assert_eq!((shown.cause, shown.frame.view), (Cause::ViewChanged, view));
            for number in 1..5 {
                assert_eq!(consumer.expect_diff(shown.frame.number + number).frame.view, view);
            }
            before = view;
        }
    });
    consumer.expect_diffs_to(last);
    assert_eq!(held(&consumer.mirror), held(&daemon.consumer("cam", DERIVED).snapshot()));
    // The view of all streams of a subscription changes, and streams that open later have the new view too.
    let mut many = daemon.consumer("*", FULL);
    many.expect_snapshot(Cause::Start);
    many.client.send(Consumer::CHANNEL, ChangeView { view: DERIVED, dots: DotsWanted::No });
    many.expect_snapshot(Cause::ViewChanged);
    daemon.producer("new").frame(&[(0.0, 0.0)]);
    assert!(matches!(many.next(), Message::StreamOpened(_)));
    assert!(matches!(many.next(), Message::Snapshot(snapshot) if snapshot.frame.view == DERIVED));
    daemon.stop();
}

#[test]
fn nothing_comes_after_unsubscribed() {
    let daemon = Daemon::start("");
    let mut producer = windowed(&daemon);
    producer.frame(&[(0.0, 0.0)]);
    let mut client = daemon.client();
    while_frames_come(&mut producer, || {
        for channel in 1..30 {
            client.send(channel, subscribe("*", FULL));
            assert!(matches!(client.receive_on(channel), Message::StreamOpened(_)));
            assert!(matches!(client.receive_on(channel), Message::Snapshot(_)));
            client.send(channel, Unsubscribe {});
            while !matches!(client.receive_on(channel), Message::Unsubscribed(_)) {}
        }
    });
    producer.frame(&[(1.0, 1.0)]);
    daemon.producer("new").frame(&[(0.0, 0.0)]);
    assert_eq!(client.drain(), []);
    assert_eq!(daemon.stream("cam").info.consumers, 0);
    daemon.stop();
}

#[test]
fn a_consumer_resumes_from_its_last_frame() {
    let daemon = Daemon::start("");
    let mut random = Random::new(31);
    let mut producer = windowed(&daemon);
    for view in [FULL, View { simplify: Simplify::Below(0.1), ..FULL }] {
        let mut consumer = daemon.consumer("cam", view);
        let frame = producer.frame(&points(&mut random, 50));
        consumer.follow_to(frame);
        for away in [1, 0, 7] {
            let (from, mirror) = lost(consumer);
            let last = (0..away).map(|_| producer.frame(&points(&mut random, 20))).last().unwrap_or(from.frame);
            consumer = resume(&daemon, view, from);
            consumer.mirror = mirror;
            assert!(matches!(consumer.next(), Message::Resumed(resumed) if resumed.frame == from.frame));
            consumer.expect_diffs_to(last);
            assert_eq!(consumer.client.drain(), [], "nothing comes while nothing happens");
            let frame = producer.frame(&points(&mut random, 20));
            consumer.expect_diff(frame);
            assert_eq!(held(&consumer.mirror), held(&daemon.consumer("cam", view).snapshot()));
        }
    }
    daemon.stop();
}

#[test]
fn a_consumer_that_cannot_resume_gets_a_snapshot() {
    let daemon = Daemon::start("--history 64KiB");
    let mut random = Random::new(32);
    let mut producer = windowed(&daemon);
    let mut consumer = daemon.consumer("cam", FULL);
    producer.frame(&points(&mut random, 50));
    consumer.expect_snapshot(Cause::Start);
    let (from, _) = lost(consumer);
    let gone = |view, from| {
        let mut consumer = resume(&daemon, view, from);
        consumer.expect_snapshot(Cause::CannotResume)
    };
    assert_eq!(gone(FULL, Resume { epoch: from.epoch + 1, ..from }), 1, "another stream");
    assert_eq!(gone(FULL, Resume { frame: 0, ..from }), 1, "no frame");
    assert_eq!(gone(FULL, Resume { frame: 2, ..from }), 1, "a frame that was not yet");
    let last = producer.frame(&points(&mut random, 10));
    assert_eq!(gone(DERIVED, from), last, "a view that nobody has looked at since");
    let mut back = resume(&daemon, FULL, from);
    assert!(matches!(back.next(), Message::Resumed(_)), "this one is known still");
    drop(back);
    // Each of these frames takes some 60 KiB.
    let last = (0..5).map(|_| producer.frame(&points(&mut random, 300))).last().unwrap();
    assert_eq!(gone(FULL, from), last, "too long ago");
    producer.close(true);
    windowed(&daemon).frame(&points(&mut random, 10));
    assert_eq!(gone(FULL, Resume { frame: 1, ..from }), 1, "another stream of that name");
    daemon.stop();
}
