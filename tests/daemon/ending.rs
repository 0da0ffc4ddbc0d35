//! The shutdown of the daemon: committed points are delivered, every peer is notified, and nothing is left
//! behind.

use hopes_protocol::*;
use rustix::process::Signal;

use crate::common::client::Client;
use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, Producer, assert_clean_exit, open, points, subscribe};
use crate::common::random::Random;

/// The `Goodbye` of a connection: all streams with their last frames.
fn goodbye(message: Option<&(u32, Message)>) -> &[(String, u64)] {
    match message {
        Some((0, Message::Goodbye(goodbye))) => &goodbye.streams,
        other => panic!("goodbye comes last, not {other:?}"),
    }
}

#[test]
fn a_signal_ends_the_daemon_cleanly() {
    for signal in [Signal::TERM, Signal::INT] {
        let daemon = Daemon::start("--listen tcp:127.0.0.1:0");
        let mut producer = daemon.producer("cam");
        let mut consumer = daemon.consumer("cam", FULL);
        let mut idle = daemon.client();
        let mut silent = Client::without_banner(&daemon.address);
        silent.banner();
        producer.frame(&[(0.0, 0.0)]);
        consumer.expect_snapshot(Cause::Start);
        // Accepted, and not committed.
        let batch = producer.batch(&[(1.0, 0.0)]);
        producer.is_accepted(batch, 1);
        daemon.running.signal(signal);
        // Nobody has closed a frame with it, so it is in none.
        assert!(matches!(consumer.next(), Message::StreamClosed(closed) if closed.frame == 1));
        let streams = [("cam".to_owned(), 1)];
        assert_eq!(goodbye(consumer.client.rest().last()), streams);
        let rest = producer.client.rest();
        assert_eq!(rest[0], (Producer::CHANNEL, Closed { frame: 1 }.into()));
        assert_eq!(goodbye(rest.last()), streams);
        for other in [&mut idle, &mut silent] {
            assert_eq!(goodbye(other.rest().last()), streams);
        }
        let (socket, finished) = (daemon.socket(), assert_clean_exit(daemon.running.ends()));
        assert!(!socket.exists(), "the socket is removed");
        let word = if signal == Signal::TERM { "SIGTERM" } else { "SIGINT" };
        assert!(
            finished.err.contains("stream \"cam\": 1 points after the last frame are left out"),
            "{}",
            finished.err
        );
        assert!(finished.err.contains(&format!("{word}: stream \"cam\" stopped after frame 1")), "{}", finished.err);
    }
}

#[test]
fn committed_points_are_delivered() {
    let daemon = Daemon::start("");
    let mut random = Random::new(60);
    let mut producer = Producer::open(daemon.client(), Open { window: Some(Window::Points(3000)), ..open("cam") });
    let dots = DotsWanted::Top(2);
    let mut consumer = Consumer::subscribe(daemon.client(), Subscribe { dots, ..subscribe("cam", DERIVED) });
    let mut full = daemon.consumer("cam", FULL);
    for _ in 0..20 {
        producer.batch(&points(&mut random, 2000));
        producer.commit();
    }
    producer.batch(&points(&mut random, 10));
    // The stream has accepted all of it, and most of it is still to be computed.
    producer.client.ping();
    daemon.running.signal(Signal::TERM);
    for consumer in [&mut consumer, &mut full] {
        consumer.follow_to(20);
        let last = loop {
            match consumer.next() {
                Message::Dots(_) => {}
                Message::StreamClosed(closed) => break closed.frame,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(last, 20);
    }
    assert_eq!(consumer.dots.map(|dots| dots.frame), Some(20));
    let answers: Vec<Message> = producer.client.rest().into_iter().map(|(_, message)| message).collect();
    let committed = answers.iter().filter(|answer| matches!(answer, Message::Committed(_))).count();
    let accepted = answers.iter().filter(|answer| matches!(answer, Message::Accepted(_))).count();
    assert_eq!((committed, accepted), (20, 21));
    assert_clean_exit(daemon.running.ends());
}

#[test]
fn a_consumer_that_is_behind_still_gets_the_last_frame() {
    for history in ["32MiB", "64KiB"] {
        let mut daemon = Daemon::start(&format!("--consumer-queue 64KiB --history {history}"));
        let mut random = Random::new(61);
        let mut producer = Producer::open(daemon.client(), Open { window: Some(Window::Points(3000)), ..open("cam") });
        let mut slow = daemon.consumer("cam", FULL);
        for _ in 0..15 {
            producer.frame(&points(&mut random, 1500));
        }
        daemon.running.signal(Signal::TERM);
        // The stream has ended before the consumer reads on.
        daemon.running.until_log("stopped after frame 15");
        let last = loop {
            if let Message::StreamClosed(closed) = slow.next() {
                break closed.frame;
            }
        };
        assert_eq!((last, slow.mirror.number()), (15, 15), "with a history of {history}");
        assert_eq!(goodbye(slow.client.rest().last()), [("cam".to_owned(), 15)]);
        assert_clean_exit(daemon.running.ends());
    }
}

/// A daemon with a consumer that does not read. More is sent to it than sockets hold.
fn with_a_consumer_that_does_not_read() -> (Daemon, Consumer) {
    let daemon = Daemon::start("");
    let mut random = Random::new(62);
    let mut producer = Producer::open(daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let stubborn = daemon.consumer("cam", FULL);
    for _ in 0..10 {
        producer.frame(&points(&mut random, 3000));
    }
    (daemon, stubborn)
}

#[test]
fn a_second_signal_ends_the_daemon_at_once() {
    for (first, second, code) in [(Signal::TERM, Signal::TERM, 143), (Signal::TERM, Signal::INT, 130)] {
        let (mut daemon, _stubborn) = with_a_consumer_that_does_not_read();
        daemon.running.signal(first);
        daemon.running.until_log("SIGTERM: stream \"cam\" stopped after frame 10");
        daemon.running.signal(second);
        assert_eq!(daemon.running.ends().code, Some(code));
    }
}

#[test]
fn a_peer_that_does_not_read_does_not_delay_the_end_for_ever() {
    let (daemon, _stubborn) = with_a_consumer_that_does_not_read();
    let client = daemon.client();
    daemon.stop();
    drop(client);
}
