//! The limits of the daemon, and the errors beyond them.

use hopes_protocol::*;

use crate::common::client::{Client, bytes, hello};
use crate::common::peers::{Daemon, FULL, Producer, open, points, subscribe};
use crate::common::process::eventually;
use crate::common::random::Random;

/// The codes of a batch's refusals, each once, and the number of accepted points.
fn codes(answer: Message) -> (u32, Vec<u16>) {
    match answer {
        Message::Accepted(accepted) => (accepted.points, Vec::new()),
        Message::Refused(refused) => {
            let mut codes: Vec<u16> = refused.reasons.iter().map(|reason| reason.code).collect();
            codes.dedup();
            (refused.accepted, codes)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_number_of_streams_is_limited() {
    let daemon = Daemon::start("--max-streams 3 --stream ready");
    let mut one = daemon.producer("one");
    daemon.producer("two");
    let mut client = daemon.client();
    assert_eq!(client.is_refused(1, open("three")), ErrorCode::TooManyStreams as u16);
    assert!(matches!(client.ask(2, open("two")), Message::Opened(_)), "what is there may be joined");
    one.close(true);
    assert!(matches!(client.ask(1, open("three")), Message::Opened(_)), "there is room again");
    daemon.stop();
}

#[test]
fn the_number_of_connections_is_limited() {
    for daemon in [Daemon::start("--max-connections 3"), Daemon::over_tcp("--max-connections 3")] {
        let mut first = daemon.client();
        let _others = [daemon.client(), Client::new(&daemon.address)];
        // One connection more is for administration: it may ask, and follows and feeds nothing.
        let mut administrator = Client::with_hello(&daemon.address);
        assert_eq!(administrator.status().connections, 4);
        let mut late = Client::without_banner(&daemon.address);
        assert_eq!(late.banner(), Banner::OURS);
        match &late.rest()[..] {
            [(0, Message::Error(report))] => assert_eq!(report.code, ErrorCode::TooManyConnections as u16),
            other => panic!("{other:?}"),
        }
        administrator.send(1, subscribe("cam", FULL));
        match &administrator.rest()[..] {
            [(0, Message::Error(report)), (0, Message::Goodbye(_))] => {
                assert_eq!(report.code, ErrorCode::TooManyConnections as u16);
            }
            other => panic!("{other:?}"),
        }
        eventually("its place is free", || (first.status().connections == 3).then_some(()));
        first.part();
        let mut again = eventually("there is room again", || {
            let mut client = Client::without_banner(&daemon.address);
            client.banner();
            client.try_write(&Banner::OURS.encode()).ok()?;
            client.try_write(&bytes(0, hello())).ok()?;
            matches!(client.receive(), Some((0, Message::Welcome(_)))).then_some(client)
        });
        again.ping();
        daemon.stop();
    }
}

#[test]
fn the_number_of_channels_is_limited() {
    let daemon = Daemon::start("--stream cam");
    let mut client = daemon.client();
    for channel in 1..=128 {
        assert!(matches!(client.ask(channel, open("cam")), Message::Opened(_)));
        assert!(matches!(client.ask(1000 + channel, subscribe("cam", FULL)), Message::StreamOpened(_)));
    }
    assert_eq!(client.is_refused(999, open("cam")), ErrorCode::TooManyChannels as u16);
    assert_eq!(client.is_refused(999, subscribe("cam", FULL)), ErrorCode::TooManyChannels as u16);
    eventually("all are seated", || (client.status().streams[0].info.consumers == 128).then_some(()));
    assert_eq!(client.ask(1001, Unsubscribe {}), Message::Unsubscribed(Unsubscribed {}));
    assert!(matches!(client.ask(999, open("cam")), Message::Opened(_)), "there is room again");
    daemon.stop();
}

#[test]
fn a_channel_in_use_cannot_be_opened() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    client.ask(7, open("cam"));
    client.ask(8, subscribe("cam", FULL));
    for channel in [0, 7, 8] {
        for message in [
            Message::from(open("other")),
            subscribe("cam", FULL).into(),
            ListStreams { pattern: "*".to_owned() }.into(),
            StatusWanted {}.into(),
        ] {
            assert_eq!(client.is_refused(channel, message), ErrorCode::ChannelInUse as u16);
        }
    }
    assert_eq!(client.list("other").len(), 0, "what was refused has done nothing");
    assert!(matches!(client.ask(7, Close { end: false }), Message::Closed(_)));
    assert!(matches!(client.ask(7, subscribe("cam", FULL)), Message::StreamOpened(_)));
    daemon.stop();
}

#[test]
fn the_number_of_points_is_limited() {
    let daemon = Daemon::start("--max-points 10");
    let mut random = Random::new(10);
    let mut producer = daemon.producer("cam");
    producer.batch(&points(&mut random, 12));
    assert_eq!(codes(producer.answer()), (10, vec![RefusalCode::StreamFull as u16]));
    // A window of at most that many points always has room.
    let window = |points| Open { window: Some(Window::Points(points)), ..open(&format!("of {points}")) };
    let mut within = Producer::open(daemon.client(), window(10));
    within.frame(&points(&mut random, 25));
    let mut beyond = Producer::open(daemon.client(), window(11));
    beyond.batch(&points(&mut random, 25));
    assert_eq!(codes(beyond.answer()), (10, vec![RefusalCode::StreamFull as u16]));
    daemon.stop();
}

#[test]
fn the_number_of_distinct_positions_is_limited() {
    let daemon = Daemon::start("--max-vertices 10");
    let mut random = Random::new(11);
    let mut producer = daemon.producer("cam");
    let first = points(&mut random, 12);
    producer.frame(&first);
    producer.batch(&first);
    assert_eq!(codes(producer.answer()), (0, vec![RefusalCode::StreamFull as u16]));
    let retraction = producer.retract(&first[..5]);
    producer.is_accepted(retraction, 5);
    producer.frame(&[]);
    let batch = producer.batch(&first[..2]);
    producer.is_accepted(batch, 2);
    daemon.stop();
}

#[test]
fn the_number_of_points_in_a_message_is_limited() {
    let daemon = Daemon::start("--max-batch 100");
    let mut random = Random::new(12);
    let mut producer = daemon.producer("cam");
    assert_eq!(producer.opened.largest_batch, 100);
    producer.frame(&points(&mut random, 100));
    for _ in 0..2 {
        producer.batch(&points(&mut random, 101));
        let report = producer.client.expect_error_on(Producer::CHANNEL);
        assert_eq!((report.code, report.answers), (ErrorCode::TooLarge as u16, 0x0103));
        producer.retract(&points(&mut random, 101));
        let report = producer.client.expect_error_on(Producer::CHANNEL);
        assert_eq!((report.code, report.answers), (ErrorCode::TooLarge as u16, 0x0104));
    }
    assert_eq!(producer.frame(&points(&mut random, 1)), 2);
    assert_eq!(daemon.stream("cam").info.points, 101);
    daemon.stop();
}

#[test]
fn memory_is_limited() {
    let daemon = Daemon::start("--max-memory 1MiB");
    let mut random = Random::new(13);
    let mut producer = daemon.producer("cam");
    producer.frame(&points(&mut random, 20_000));
    let status = daemon.status();
    assert_eq!(status.memory_limit, 1 << 20);
    assert!(status.memory >= status.memory_limit, "{status:?}");
    // The memory limit is shared by all streams.
    let mut other = daemon.producer("other");
    for producer in [&mut producer, &mut other] {
        producer.batch(&points(&mut random, 1));
        assert_eq!(codes(producer.answer()), (0, vec![RefusalCode::DaemonFull as u16]));
    }
    producer.close(true);
    let of_streams = || daemon.status().streams.iter().map(|stream| stream.memory).sum::<u64>();
    eventually("the memory is given back", || (of_streams() == 0).then_some(()));
    other.frame(&points(&mut random, 1));
    daemon.stop();
}
