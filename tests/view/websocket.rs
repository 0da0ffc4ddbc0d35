//! The protocol in the page's WebSocket: the same as on a socket, but read-only.

use hopes_protocol::*;

use super::page::Page;
use crate::common::client::Socket;
use crate::common::peers::{Consumer, DERIVED, FULL, Producer, held, open, points, subscribe};
use crate::common::random::Random;

#[test]
fn a_websocket_consumer_mirrors_a_stream_as_a_socket_consumer_does() {
    let page = Page::start("");
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(2)), ..open("cam") });
    let mut random = Random::new(1);
    producer.frame(&points(&mut random, 500));
    let mut socket = page.daemon.consumer("cam", FULL);
    let mut websocket = page.websocket_consumer("cam");
    assert_eq!((socket.expect_snapshot(Cause::Start), websocket.expect_snapshot(Cause::Start)), (1, 1));
    for _ in 0..30 {
        let frame = producer.frame(&points(&mut random, 400));
        socket.expect_diff(frame);
        websocket.expect_diff(frame);
        assert_eq!(held(&websocket.mirror), held(&socket.mirror));
    }
    let derived = ChangeView { view: DERIVED, dots: DotsWanted::No };
    websocket.client.send(Consumer::CHANNEL, derived);
    assert_eq!(websocket.expect_snapshot(Cause::ViewChanged), 31);
    page.daemon.stop();
}

#[test]
fn large_snapshots_are_complete() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&points(&mut Random::new(2), 20_000));
    let mut consumer = page.websocket_consumer("cam");
    consumer.expect_snapshot(Cause::Start);
    assert_eq!((consumer.mirror.vertices().len(), consumer.mirror.edges().len()), (20_000, 19_999));
    page.daemon.stop();
}

#[test]
fn a_websocket_is_read_only() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0)]);
    let mut websocket = page.websocket();
    let messages: [Message; 7] = [
        open("cam").into(),
        Batch { sequence: 1, points: vec![(1.0, 1.0)], times: vec![], tags: vec![] }.into(),
        Retract { sequence: 2, points: vec![(0.0, 0.0)] }.into(),
        Commit { sequence: 3, time: None }.into(),
        Close { end: true }.into(),
        StopStream { name: "cam".to_owned() }.into(),
        Disconnect { peer: 1 }.into(),
    ];
    for message in messages {
        websocket.send(5, message.clone());
        let report = websocket.expect_error_on(5);
        assert_eq!((report.code, report.answers), (ErrorCode::Unexpected as u16, message.kind()));
        assert!(report.text.contains("read-only"), "{report:?}");
    }
    // All other messages are answered.
    assert_eq!(websocket.list("*").len(), 1);
    let status = websocket.status();
    assert_eq!((status.refused_messages, status.streams[0].info.frame, status.streams[0].info.points), (7, 1, 1));
    websocket.send(7, subscribe("cam", FULL));
    assert!(matches!(websocket.receive_on(7), Message::StreamOpened(_)));
    page.daemon.stop();
}

#[test]
fn pings_of_the_websocket_are_answered_among_frames() {
    let page = Page::start("");
    let mut websocket = page.websocket();
    let Socket::Web(web) = &mut websocket.socket else { panic!("it is connected by WebSocket") };
    web.socket.send(tungstenite::Message::Ping(b"there?".to_vec().into())).unwrap();
    let answer = web.socket.read().unwrap();
    assert_eq!(answer, tungstenite::Message::Pong(b"there?".to_vec().into()));
    websocket.ping();
    page.daemon.stop();
}

#[test]
fn a_goodbye_is_answered_and_the_websocket_closed() {
    let page = Page::start("");
    let mut websocket = page.websocket();
    websocket.send(0, Goodbye { reason: "done".to_owned(), streams: vec![] });
    let rest = websocket.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let Socket::Web(web) = &websocket.socket else { panic!("it is connected by WebSocket") };
    assert_eq!(web.closed, Some(1000));
    page.daemon.stop();
}

#[test]
fn a_closed_websocket_ends_its_subscription() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let mut consumer = page.websocket_consumer("cam");
    consumer.expect_snapshot(Cause::Start);
    let Socket::Web(web) = &mut consumer.client.socket else { panic!("it is connected by WebSocket") };
    web.socket.close(None).unwrap();
    let rest = consumer.client.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let gone = || (page.daemon.stream("cam").info.consumers == 0).then_some(());
    crate::common::process::eventually("the consumer is gone", gone);
    page.daemon.stop();
}
