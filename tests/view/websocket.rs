//! The wire protocol in the page's WebSocket: for consumers the same dialogue as on a socket.

use hopes_protocol::*;

use super::page::Page;
use crate::common::client::Socket;
use crate::common::peers::{Consumer, DERIVED, FULL, Producer, held, open, points, subscribe};
use crate::common::random::Random;

#[test]
fn a_page_mirrors_a_stream_as_a_consumer_on_a_socket_does() {
    let page = Page::start("");
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(2)), ..open("cam") });
    let mut random = Random::new(1);
    producer.frame(&points(&mut random, 500));
    let mut here = page.daemon.consumer("cam", FULL);
    let mut there = page.web_consumer("cam");
    assert_eq!((here.expect_snapshot(Cause::Start), there.expect_snapshot(Cause::Start)), (1, 1));
    for _ in 0..30 {
        let frame = producer.frame(&points(&mut random, 400));
        here.expect_diff(frame);
        there.expect_diff(frame);
        assert_eq!(held(&there.mirror), held(&here.mirror));
    }
    let derived = ChangeView { view: DERIVED, dots: DotsWanted::No };
    there.client.send(Consumer::CHANNEL, derived);
    assert_eq!(there.expect_snapshot(Cause::ViewChanged), 31);
    page.daemon.stop();
}

#[test]
fn large_snapshots_come_whole() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&points(&mut Random::new(2), 20_000));
    let mut there = page.web_consumer("cam");
    there.expect_snapshot(Cause::Start);
    assert_eq!((there.mirror.vertices().len(), there.mirror.edges().len()), (20_000, 19_999));
    page.daemon.stop();
}

#[test]
fn producers_are_refused_on_the_page() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0)]);
    let mut web_client = page.web_client();
    let messages: [Message; 5] = [
        open("cam").into(),
        Batch { sequence: 1, points: vec![(1.0, 1.0)], times: vec![], tags: vec![] }.into(),
        Retract { sequence: 2, points: vec![(0.0, 0.0)] }.into(),
        Commit { sequence: 3, time: None }.into(),
        Close { end: true }.into(),
    ];
    for message in messages {
        web_client.send(5, message.clone());
        let report = web_client.expect_error_on(5);
        assert_eq!((report.code, report.answers), (ErrorCode::Unexpected as u16, message.kind()));
        assert!(report.text.contains("read-only"), "{report:?}");
    }
    // Everything else works as for any peer.
    assert_eq!(web_client.list("*").len(), 1);
    let status = web_client.status();
    assert_eq!((status.refused_messages, status.streams[0].info.frame, status.streams[0].info.points), (5, 1, 1));
    web_client.send(7, subscribe("cam", FULL));
    assert!(matches!(web_client.receive_on(7), Message::StreamOpened(_)));
    page.daemon.stop();
}

#[test]
fn websocket_pings_are_answered_among_frames() {
    let page = Page::start("");
    let mut web_client = page.web_client();
    let Socket::Web(web) = &mut web_client.socket else { panic!("a web_client comes by WebSocket") };
    web.socket.send(tungstenite::Message::Ping(b"there?".to_vec().into())).unwrap();
    let answer = web.socket.read().unwrap();
    assert_eq!(answer, tungstenite::Message::Pong(b"there?".to_vec().into()));
    web_client.ping();
    page.daemon.stop();
}

#[test]
fn a_goodbye_is_answered_and_the_websocket_closed() {
    let page = Page::start("");
    let mut web_client = page.web_client();
    web_client.send(0, Goodbye { reason: "done".to_owned(), streams: vec![] });
    let rest = web_client.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let Socket::Web(web) = &web_client.socket else { panic!("a web_client comes by WebSocket") };
    assert_eq!(web.closed, Some(1000));
    page.daemon.stop();
}

#[test]
fn a_closed_websocket_frees_its_slot() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let mut there = page.web_consumer("cam");
    there.expect_snapshot(Cause::Start);
    let Socket::Web(web) = &mut there.client.socket else { panic!("a web_client comes by WebSocket") };
    web.socket.close(None).unwrap();
    let rest = there.client.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let gone = || (page.daemon.stream("cam").info.consumers == 0).then_some(());
    crate::common::process::eventually("its place is free", gone);
    page.daemon.stop();
}
