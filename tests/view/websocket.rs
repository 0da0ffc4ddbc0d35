//! The protocol by the page's WebSocket: the same conversation as on a socket, for readers.

use hopes_protocol::*;

use super::page::Page;
use crate::common::client::Socket;
use crate::common::random::Random;
use crate::common::roles::{Consumer, DERIVED, FULL, Producer, held, open, points, subscribe};

#[test]
fn a_page_mirrors_a_stream_as_a_consumer_on_a_socket_does() {
    let page = Page::start("");
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(2)), ..open("cam") });
    let mut random = Random::new(1);
    producer.frame(&points(&mut random, 500));
    let mut here = page.daemon.consumer("cam", FULL);
    let mut there = page.guest_consumer("cam");
    assert_eq!((here.is_shown(Cause::Start), there.is_shown(Cause::Start)), (1, 1));
    for _ in 0..30 {
        let frame = producer.frame(&points(&mut random, 400));
        here.is_told_of(frame);
        there.is_told_of(frame);
        assert_eq!(held(&there.mirror), held(&here.mirror));
    }
    let derived = ChangeView { view: DERIVED, dots: DotsWanted::No };
    there.client.send(Consumer::CHANNEL, derived);
    assert_eq!(there.is_shown(Cause::ViewChanged), 31);
    page.daemon.stop();
}

#[test]
fn large_snapshots_come_whole() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&points(&mut Random::new(2), 20_000));
    let mut there = page.guest_consumer("cam");
    there.is_shown(Cause::Start);
    assert_eq!((there.mirror.vertices().len(), there.mirror.edges().len()), (20_000, 19_999));
    page.daemon.stop();
}

#[test]
fn nobody_feeds_a_stream_by_the_page() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0)]);
    let mut guest = page.guest();
    let messages: [Message; 5] = [
        open("cam").into(),
        Batch { sequence: 1, points: vec![(1.0, 1.0)], times: vec![], tags: vec![] }.into(),
        Retract { sequence: 2, points: vec![(0.0, 0.0)] }.into(),
        Commit { sequence: 3, time: None }.into(),
        Close { end: true }.into(),
    ];
    for message in messages {
        guest.send(5, message.clone());
        let report = guest.error_on(5);
        assert_eq!((report.code, report.answers), (ErrorCode::Unexpected as u16, message.kind()));
        assert!(report.text.contains("read-only"), "{report:?}");
    }
    // It is an ordinary peer for all the rest.
    assert_eq!(guest.list("*").len(), 1);
    let status = guest.status();
    assert_eq!((status.refused_messages, status.streams[0].info.frame, status.streams[0].info.points), (5, 1, 1));
    guest.send(7, subscribe("cam", FULL));
    assert!(matches!(guest.hear_on(7), Message::StreamOpened(_)));
    page.daemon.stop();
}

#[test]
fn pings_of_the_websocket_are_answered_among_frames() {
    let page = Page::start("");
    let mut guest = page.guest();
    let Socket::Web(web) = &mut guest.socket else { panic!("a guest comes by WebSocket") };
    web.socket.send(tungstenite::Message::Ping(b"there?".to_vec().into())).unwrap();
    let answer = web.socket.read().unwrap();
    assert_eq!(answer, tungstenite::Message::Pong(b"there?".to_vec().into()));
    guest.ping();
    page.daemon.stop();
}

#[test]
fn a_goodbye_is_answered_and_the_websocket_closed() {
    let page = Page::start("");
    let mut guest = page.guest();
    guest.send(0, Goodbye { reason: "done".to_owned(), streams: vec![] });
    let rest = guest.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let Socket::Web(web) = &guest.socket else { panic!("a guest comes by WebSocket") };
    assert_eq!(web.closed, Some(1000));
    page.daemon.stop();
}

#[test]
fn a_tab_that_is_closed_leaves_its_place() {
    let page = Page::start("");
    page.daemon.producer("cam").frame(&[(0.0, 0.0)]);
    let mut there = page.guest_consumer("cam");
    there.is_shown(Cause::Start);
    let Socket::Web(web) = &mut there.client.socket else { panic!("a guest comes by WebSocket") };
    web.socket.close(None).unwrap();
    let rest = there.client.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    let gone = || (page.daemon.stream("cam").info.consumers == 0).then_some(());
    crate::common::process::eventually("its place is free", gone);
    page.daemon.stop();
}
