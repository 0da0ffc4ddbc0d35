//! The shutdown of a daemon with a page.

use hopes_protocol::*;
use rustix::process::Signal;

use super::page::Page;
use crate::common::client::Socket;
use crate::common::peers::{Consumer, assert_clean_exit};

#[test]
fn websocket_consumers_get_the_last_frame_and_a_goodbye() {
    let page = Page::start("");
    let mut producer = page.daemon.producer("cam");
    producer.frame(&[(0.0, 0.0), (1.0, 0.0)]);
    let mut there = page.websocket_consumer("cam");
    there.expect_snapshot(Cause::Start);
    // The frame is committed, but may not be computed yet.
    let batch = producer.batch(&[(0.0, 2.0)]);
    producer.is_accepted(batch, 1);
    let commit = producer.commit();
    producer.is_committed(commit);
    let mut idle = page.client();
    page.daemon.running.signal(Signal::TERM);
    let Message::Diff(last) = there.next() else { panic!("the last frame is due") };
    assert_eq!((last.frame.number, last.frame.vertices), (2, 3));
    let rest = there.client.rest();
    let [(Consumer::CHANNEL, Message::StreamClosed(closed)), (0, Message::Goodbye(goodbye))] = &rest[..] else {
        panic!("{rest:?}")
    };
    assert_eq!((closed.frame, &goodbye.streams[..]), (2, &[("cam".to_owned(), 2)][..]));
    let Socket::Web(web) = &there.client.socket else { panic!("it is connected by WebSocket") };
    assert_eq!(web.closed, Some(1001));
    assert_eq!(idle.reply(), None);
    assert_clean_exit(page.daemon.running.ends());
    assert!(std::net::TcpStream::connect(&page.host).is_err(), "the port is closed");
}

/// Nobody comes after it: the listener still has it on its list.
#[test]
fn the_newest_client_gets_its_goodbye_too() {
    let page = Page::start("");
    let mut newest = page.websocket();
    page.daemon.running.signal(Signal::TERM);
    let rest = newest.rest();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    assert_clean_exit(page.daemon.running.ends());
}
