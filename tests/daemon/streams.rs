//! Streams by name: who may join, which subscriptions follow, and how streams end.

use hopes_protocol::*;

use crate::common::client::Client;
use crate::common::peers::{Consumer, DERIVED, Daemon, FULL, Producer, open, points, subscribe};

#[test]
fn two_producers_feed_one_stream() {
    let daemon = Daemon::start("");
    let mut consumer = Consumer::subscribe(daemon.client(), {
        // The stream must exist.
        daemon.producer("cam");
        subscribe("cam", FULL)
    });
    let (mut one, mut other) = (daemon.producer("cam"), daemon.producer("cam"));
    assert_eq!((one.opened.stream, one.opened.epoch), (other.opened.stream, other.opened.epoch));
    assert!(!one.opened.created && !other.opened.created);
    let batch = one.batch(&[(0.0, 0.0), (1.0, 0.0)]);
    one.is_accepted(batch, 2);
    // A commit closes the frame with what its own producer has sent.
    assert_eq!(other.frame(&[(1.0, 1.0), (0.0, 1.0)]), 1);
    assert_eq!(one.frame(&[(5.0, 5.0)]), 2);
    assert_eq!(consumer.expect_snapshot(Cause::Start), 1);
    assert_eq!((consumer.mirror.vertices().len(), consumer.mirror.critical().len()), (2, 0));
    consumer.expect_diff(2);
    assert_eq!((consumer.mirror.vertices().len(), consumer.mirror.critical().len()), (5, 1));
    daemon.stop();
}

#[test]
fn a_connection_feeds_many_streams() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    let names = ["a", "b", "c"];
    let open_on = |client: &mut Client, channel: u32, name: &str| match client.ask(channel, open(name)) {
        Message::Opened(opened) => opened.stream,
        other => panic!("{other:?}"),
    };
    let numbers: Vec<u32> = (1..4).map(|channel| open_on(&mut client, channel, names[channel as usize - 1])).collect();
    assert!(numbers.is_sorted() && numbers[0] != numbers[2], "{numbers:?}");
    for round in 0..10 {
        for channel in 1..4 {
            let points = vec![(f64::from(round), f64::from(channel))];
            client.send(channel, Batch { sequence: 2 * round as u64, points, times: vec![], tags: vec![] });
            client.send(channel, Commit { sequence: 2 * round as u64 + 1, time: Some(f64::from(round)) });
        }
    }
    for channel in 1..4 {
        for round in 0..10 {
            let Message::Accepted(accepted) = client.receive_on(channel) else { panic!("Accepted is due") };
            let Message::Committed(committed) = client.receive_on(channel) else { panic!("Committed is due") };
            assert_eq!((accepted.sequence, committed.sequence, committed.frame), (2 * round, 2 * round + 1, round + 1));
        }
    }
    let listed: Vec<(String, u64, u64)> =
        client.list("*").into_iter().map(|info| (info.name, info.frame, info.points)).collect();
    assert_eq!(listed, names.map(|name| (name.to_owned(), 10, 10)));
    assert_eq!(client.list("b").len(), 1);
    assert_eq!(client.list("x*").len(), 0);
    daemon.stop();
}

#[test]
fn other_options_are_refused_and_no_options_match_any() {
    let daemon = Daemon::start("--stream ready:window=frames:2,resolution=0.5");
    let with = |window, resolution| Open { name: "cam".to_owned(), window, resolution };
    let mut first = daemon.client();
    let refused = |open: Open| daemon.client().is_refused(1, open);
    assert!(matches!(first.ask(1, with(Some(Window::Points(10)), Some(0.25))), Message::Opened(_)));
    for other in [
        with(Some(Window::Points(11)), None),
        with(Some(Window::All), None),
        with(Some(Window::Frames(10)), Some(0.25)),
        with(Some(Window::Points(10)), Some(0.5)),
        with(None, Some(1.0)),
    ] {
        assert_eq!(refused(other), ErrorCode::OtherOptions as u16);
    }
    for same in [with(None, None), with(Some(Window::Points(10)), None), with(None, Some(0.25))] {
        let Message::Opened(opened) = daemon.client().ask(1, same) else { panic!("it is the same") };
        assert_eq!((opened.created, opened.window, opened.resolution), (false, Window::Points(10), Some(0.25)));
    }
    let Message::Opened(ready) = daemon.client().ask(1, open("ready")) else { panic!("it is there") };
    assert_eq!((ready.created, ready.window, ready.resolution), (false, Window::Frames(2), Some(0.5)));
    let new = |window, resolution| Open { name: "new".to_owned(), window, resolution };
    for senseless in [
        new(Some(Window::Points(0)), None),
        new(Some(Window::Frames(0)), None),
        new(Some(Window::Time(0.0)), None),
        new(Some(Window::Time(f64::NAN)), None),
        new(Some(Window::Time(f64::INFINITY)), None),
        new(None, Some(0.0)),
        new(None, Some(-1.0)),
        new(None, Some(f64::NAN)),
    ] {
        assert_eq!(refused(senseless), ErrorCode::BadOptions as u16);
    }
    daemon.stop();
}

#[test]
fn names_and_patterns_have_rules() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    let bad = ["".to_owned(), "a*".to_owned(), "a\n".to_owned(), "\u{7f}".to_owned(), "x".repeat(201)];
    for name in &bad {
        assert_eq!(client.is_refused(1, open(name)), ErrorCode::BadName as u16, "{name:?}");
    }
    for name in bad.iter().filter(|name| !name.contains('*')) {
        assert_eq!(client.is_refused(1, subscribe(name, FULL)), ErrorCode::BadName as u16, "{name:?}");
        assert_eq!(client.is_refused(1, ListStreams { pattern: name.clone() }), ErrorCode::BadName as u16);
    }
    let resume = Some(Resume { epoch: 1, frame: 1 });
    let of_many = Subscribe { resume, ..subscribe("a*", FULL) };
    assert_eq!(client.is_refused(1, of_many), ErrorCode::BadName as u16, "many cannot be resumed");
    for (channel, name) in (1..).zip(["x".repeat(200).as_str(), "Wärme?[1]", " ", "../../etc"]) {
        assert!(matches!(client.ask(channel, open(name)), Message::Opened(_)), "{name:?}");
    }
    assert_eq!(client.list("Wärme?[1]").len(), 1);
    daemon.stop();
}

#[test]
fn a_pattern_follows_later_streams() {
    let daemon = Daemon::start("");
    daemon.producer("cam-1").frame(&[(0.0, 0.0)]);
    let mut consumer = Consumer::subscribe(daemon.client(), subscribe("cam-*", FULL));
    assert_eq!((consumer.opened.name.as_str(), consumer.opened.frame), ("cam-1", 1));
    assert_eq!(consumer.expect_snapshot(Cause::Start), 1);
    daemon.producer("other").frame(&[(0.0, 0.0)]);
    let mut second = daemon.producer("cam-2");
    let opened = match consumer.next() {
        Message::StreamOpened(opened) => opened,
        other => panic!("{other:?}"),
    };
    assert_eq!((opened.name.as_str(), opened.stream, opened.frame), ("cam-2", second.opened.stream, 0));
    second.frame(&[(1.0, 1.0), (2.0, 2.0)]);
    match consumer.next() {
        Message::Snapshot(snapshot) => {
            assert_eq!((snapshot.stream, snapshot.cause, snapshot.vertices.len()), (opened.stream, Cause::Start, 2));
        }
        other => panic!("{other:?}"),
    }
    // A subscription matches only its own pattern.
    let mut early = daemon.client();
    early.send(4, subscribe("late", DERIVED));
    assert_eq!(early.drain(), []);
    daemon.producer("late").frame(&[(0.0, 0.0)]);
    assert!(matches!(early.receive_on(4), Message::StreamOpened(opened) if opened.name == "late"));
    assert!(matches!(early.receive_on(4), Message::Snapshot(snapshot) if snapshot.frame.number == 1));
    daemon.stop();
}

#[test]
fn the_end_of_a_stream_reaches_all_producers_and_consumers() {
    let daemon = Daemon::start("");
    let (mut one, mut other) = (daemon.producer("cam"), daemon.producer("cam"));
    let mut consumer = daemon.consumer("cam", FULL);
    one.frame(&[(0.0, 0.0)]);
    // The snapshot is read before more is sent: a consumer that is served later gets one of a later frame.
    assert_eq!(consumer.expect_snapshot(Cause::Start), 1);
    for (producer, x) in [(&mut one, 1.0), (&mut other, 2.0)] {
        let batch = producer.batch(&[(x, 0.0)]);
        producer.is_accepted(batch, 1);
    }
    // Points of the producer that ends the stream make a last frame; those of others, uncommitted, are left out.
    assert_eq!(one.close(true), 2);
    assert_eq!(other.answer(), Message::Closed(Closed { frame: 2 }));
    consumer.expect_diff(2);
    assert_eq!(consumer.mirror.vertices().len(), 2);
    match consumer.next() {
        Message::StreamClosed(closed) => assert_eq!((closed.stream, closed.frame), (consumer.opened.stream, 2)),
        last => panic!("{last:?}"),
    }
    other.batch(&[(2.0, 0.0)]);
    assert_eq!(other.client.expect_error_on(Producer::CHANNEL).code, ErrorCode::NoChannel as u16);
    // Immediately afterwards the same name is a new stream.
    let again = Producer::open(one.client, open("cam"));
    assert!(again.opened.created && again.opened.frame == 0);
    assert!(again.opened.epoch != one.opened.epoch && again.opened.stream != one.opened.stream);
    match consumer.next() {
        Message::StreamOpened(opened) => assert_eq!(opened.epoch, again.opened.epoch, "the pattern matches it too"),
        last => panic!("{last:?}"),
    }
    daemon.stop();
}

#[test]
fn a_stream_can_end_and_begin_repeatedly() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    let mut consumer = daemon.client();
    consumer.send(Consumer::CHANNEL, Subscribe { dots: DotsWanted::All, ..subscribe("cam", FULL) });
    // The subscription exists before any stream.
    consumer.ping();
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    for _ in 0..50 {
        let mut producer = Producer::open(client, open("cam"));
        assert!(producer.opened.created, "nobody joins a stream that has ended");
        let batch = producer.batch(&square);
        assert_eq!(producer.client.ask(Producer::CHANNEL, Close { end: true }), accepted(batch, 4));
        assert_eq!(producer.answer(), Message::Closed(Closed { frame: 1 }));
        client = producer.client;
        let mut heard = Vec::new();
        while !matches!(heard.last(), Some(Message::StreamClosed(_))) {
            heard.push(consumer.receive_on(Consumer::CHANNEL));
        }
        let [Message::StreamOpened(_), Message::Snapshot(snapshot), Message::Dots(dots), Message::StreamClosed(closed)] =
            &heard[..]
        else {
            panic!("{heard:?}")
        };
        assert_eq!((snapshot.critical.len(), dots.dots.len(), closed.frame), (1, 1, 1));
    }
    daemon.stop();
}

fn accepted(sequence: u64, points: u32) -> Message {
    Accepted { sequence, points, placed: Vec::new() }.into()
}

#[test]
fn a_stream_stays_when_its_producers_leave() {
    let daemon = Daemon::start("");
    let mut producer = daemon.producer("cam");
    let mut random = crate::common::random::Random::new(3);
    producer.frame(&points(&mut random, 20));
    assert_eq!(producer.close(false), 1);
    // The channel is free again. Messages on it without `Open` are refused.
    producer.batch(&[(0.0, 0.0)]);
    assert_eq!(producer.client.expect_error_on(1).code, ErrorCode::NoChannel as u16);
    assert_eq!(daemon.stream("cam").info.producers, 0);
    let again = Producer::open(producer.client, open("cam"));
    assert_eq!((again.opened.created, again.opened.frame), (false, 1));
    drop(again);
    assert_eq!(daemon.consumer("cam", FULL).expect_snapshot(Cause::Start), 1);
    daemon.stop();
}

#[test]
fn messages_on_a_closed_channel_are_refused() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    let batch = Batch { sequence: 1, points: vec![(0.0, 0.0)], times: vec![], tags: vec![] };
    let change = ChangeView { view: FULL, dots: DotsWanted::No };
    for message in [
        Message::from(batch.clone()),
        Retract { sequence: 1, points: vec![] }.into(),
        Commit { sequence: 1, time: None }.into(),
        Close { end: true }.into(),
        change.into(),
        Unsubscribe {}.into(),
    ] {
        assert_eq!(client.is_refused(3, message), ErrorCode::NoChannel as u16);
    }
    client.ask(3, open("cam"));
    assert_eq!(client.is_refused(3, change), ErrorCode::NoChannel as u16, "a producer has no view");
    client.ask(4, subscribe("cam", FULL));
    assert_eq!(client.is_refused(4, batch), ErrorCode::NoChannel as u16, "a consumer has no points");
    daemon.stop();
}
