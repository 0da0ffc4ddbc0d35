//! Clients that are slow, numerous, do not read, or send noise: all others are served.

use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use hopes_protocol::*;

use super::page::{HttpClient, Page};
use crate::common::client::{Socket, bytes, hello};
use crate::common::peers::{Consumer, FULL, Producer, ProducerAndConsumer, held, open, points, subscribe};
use crate::common::process::eventually;
use crate::common::random::Random;

#[test]
fn a_thousand_idle_connections_are_harmless() {
    let page = Page::start("");
    let mut pair = ProducerAndConsumer::new(&page.daemon, "cam");
    let address = format!("127.0.0.1:{}", page.port());
    let mut idle: Vec<TcpStream> = (0..1000).map(|_| TcpStream::connect(&address).unwrap()).collect();
    // One sends part of a request, which changes nothing.
    idle[0].write_all(b"GET / HT").unwrap();
    pair.step();
    let mut late = Consumer::subscribe(page.daemon.client(), subscribe("cam", FULL));
    late.expect_snapshot(Cause::Start);
    assert_eq!(late.mirror.number(), pair.consumer.mirror.number());
    // Clients above the limit are refused, and the others are disconnected in time.
    let refused = idle.split_off(300);
    // Also one that had a place to ask for the daemon's health, and asked nothing.
    HttpClient(idle.remove(257)).reply().unwrap().is_refused(503, "256 clients");
    for stream in refused.into_iter().step_by(50) {
        HttpClient(stream).reply().unwrap().is_refused(503, "256 clients");
    }
    for _ in 0..10 {
        pair.step();
    }
    let begun = Instant::now();
    eventually("there is room again", || (page.try_get("/healthz")?.status == 200).then_some(()));
    assert!(begun.elapsed() < Duration::from_secs(60));
    pair.step();
    drop(idle);
    page.daemon.stop();
}

#[test]
fn clients_without_a_complete_head_are_disconnected() {
    // The time for a head is the daemon's timeout, if that is less than ten seconds.
    let page = Page::start("--timeout 2s");
    let (mut silent, mut slow) = (page.client(), page.client());
    let begun = Instant::now();
    let mut sent = 0;
    for byte in format!("GET / HTTP/1.1\r\nHost: {}\r\nX-Long: {}", page.host, "a".repeat(10_000)).bytes() {
        // Each byte comes long before a timeout for a single read.
        if slow.0.write_all(&[byte]).is_err() || begun.elapsed() > Duration::from_secs(30) {
            break;
        }
        sent += 1;
        std::thread::sleep(Duration::from_millis(10));
        if sent % 20 == 0 && is_answered(&slow.0) {
            break;
        }
    }
    assert!(begun.elapsed() > Duration::from_millis(1900), "after {:?}", begun.elapsed());
    assert!(begun.elapsed() < Duration::from_secs(30));
    slow.reply().unwrap().is_refused(408, "must be complete in time");
    assert_eq!(silent.reply(), None);
    page.daemon.stop();
}

fn is_answered(stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let is_answered = stream.peek(&mut [0]).is_ok();
    stream.set_nonblocking(false).unwrap();
    is_answered
}

#[test]
fn clients_that_do_not_read_a_response_are_disconnected() {
    let page = Page::start("--timeout 6s --heartbeat 200ms");
    let mut random = Random::new(3);
    let mut producer = Producer::open(page.daemon.client(), open("cam"));
    for _ in 0..3 {
        let batch = producer.batch(&points(&mut random, 60_000));
        producer.is_accepted(batch, 60_000);
    }
    let commit = producer.commit();
    producer.is_committed(commit);
    // An idle producer would time out.
    drop(producer);
    let request = format!("GET /api/streams/cam/snapshot?full HTTP/1.1\r\nHost: {}\r\n\r\n", page.host);
    let stuck: Vec<HttpClient> = (0..4)
        .map(|_| {
            let mut client = page.client();
            client.send(request.as_bytes());
            client
        })
        .collect();
    eventually("all responses have begun", || stuck.iter().all(|client| is_answered(&client.0)).then_some(()));
    // They keep nobody from another one.
    page.get("/api/streams/cam/snapshot").ok();
    page.get("/healthz").ok();
    // The daemon has given them up by then.
    std::thread::sleep(Duration::from_secs(6));
    for mut client in stuck {
        let got = client.rest();
        assert!(got.starts_with(b"HTTP/1.1 ") && !got.ends_with(b"}\n"), "{} bytes", got.len());
    }
    page.daemon.stop();
}

#[test]
fn a_websocket_that_never_reads_is_disconnected_and_delays_nothing() {
    let page = Page::start("--timeout 4s --heartbeat 500ms");
    let mut silent = page.websocket();
    silent.send(1, subscribe("cam", FULL));
    let mut random = Random::new(5);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let mut beside = page.websocket_consumer("cam");
    let begun = Instant::now();
    let mut frame = 0;
    while page.daemon.stream("cam").info.consumers == 2 || frame == 0 {
        frame = producer.frame(&points(&mut random, 12_000));
        // A consumer that reads gets every frame, the first one as a snapshot.
        beside.follow_to(frame);
        assert!(
            begun.elapsed() < Duration::from_secs(90),
            "the one that does not read is still connected after frame {frame}"
        );
    }
    frame = producer.frame(&points(&mut random, 10));
    beside.follow_to(frame);
    drop(silent);
    page.daemon.stop();
}

#[test]
fn a_websocket_that_paused_reading_gets_lagged_and_continues() {
    let page = Page::start("--consumer-queue 64KiB");
    let mut random = Random::new(6);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let mut last = producer.frame(&points(&mut random, 12_000));
    let (mut paused, mut reading) = (page.websocket_consumer("cam"), page.websocket_consumer("cam"));
    paused.expect_snapshot(Cause::Start);
    reading.expect_snapshot(Cause::Start);
    // More than the buffers of sockets hold.
    for _ in 0..40 {
        last = producer.frame(&points(&mut random, 12_000));
        reading.follow_to(last);
    }
    let missed: u64 = paused
        .follow_to(last)
        .iter()
        .map(|message| if let Message::Lagged(lagged) = message { lagged.last - lagged.first + 1 } else { 0 })
        .sum();
    assert!(missed > 0);
    assert_eq!(page.daemon.stream("cam").lagged, missed);
    assert_eq!(held(&paused.mirror), held(&reading.mirror));
    last = producer.frame(&points(&mut random, 100));
    paused.follow_to(last);
    page.daemon.stop();
}

#[test]
fn noise_in_a_websocket_ends_only_that_connection() {
    let page = Page::start("");
    let mut pair = ProducerAndConsumer::new(&page.daemon, "cam");
    let mut random = Random::new(11);
    for round in 0..40 {
        let websocket = page.websocket();
        let Socket::Web(mut web) = websocket.socket else { panic!("it is connected by WebSocket") };
        let noise: Vec<u8> = (0..300).map(|_| random.below(256) as u8).collect();
        let below = web.socket.get_mut();
        // The daemon may close the connection in the middle of it.
        let _ = below.write_all(&noise);
        let _ = below.shutdown(Shutdown::Write);
        while std::io::Read::read(&mut web, &mut [0; 4096]).is_ok_and(|length| length > 0) {}
        if round % 10 == 0 {
            pair.step();
        }
    }
    pair.step();
    page.daemon.stop();
}

#[test]
fn invalid_frames_end_the_connection_with_the_reason() {
    let page = Page::start("");
    for (frame, code, words) in [
        (&[0x81, 0x81, 0, 0, 0, 0, b'x'][..], 1003, "text"),
        (&[0x82, 0x01, b'x'], 1002, "not masked"),
        (&[0x80, 0x80, 0, 0, 0, 0], 1002, "out of order"),
    ] {
        let mut websocket = page.websocket();
        let Socket::Web(web) = &mut websocket.socket else { panic!("it is connected by WebSocket") };
        web.socket.get_mut().write_all(frame).unwrap();
        let rest = websocket.rest();
        let [(0, Message::Error(report)), (0, Message::Goodbye(_))] = &rest[..] else { panic!("{rest:?}") };
        assert_eq!(report.code, ErrorCode::BadFrame as u16);
        assert!(report.text.contains(words), "{report:?}");
        let Socket::Web(web) = &websocket.socket else { panic!("it still does") };
        assert_eq!(web.closed, Some(code));
    }
    page.daemon.stop();
}

#[test]
fn a_websocket_above_the_limit_is_refused_with_an_error() {
    let page = Page::start("--max-connections 2");
    let (_first, _second) = (page.websocket(), page.websocket());
    let mut third = crate::common::client::Client::without_banner(&format!("ws:{}", page.host));
    assert_eq!(third.banner(), Banner::OURS);
    let rest = third.rest();
    let [(0, Message::Error(report))] = &rest[..] else { panic!("{rest:?}") };
    assert_eq!(report.code, ErrorCode::TooManyConnections as u16);
    // Other requests have a limit of their own.
    page.get("/healthz").ok();
    page.daemon.stop();
}

#[test]
fn messages_may_come_together_with_the_upgrade() {
    let page = Page::start("");
    let mut client = page.client();
    let mut request = format!(
        "GET /ws HTTP/1.1\r\nHost: {0}\r\nOrigin: http://{0}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        page.host
    )
    .into_bytes();
    let messages =
        [&Banner::OURS.encode()[..], &bytes(0, hello()), &bytes(0, Goodbye { reason: "done".into(), streams: vec![] })];
    // A mask of zeros changes nothing.
    for piece in messages {
        assert!(piece.len() < 126);
        request.extend([0x82, 0x80 | piece.len() as u8, 0, 0, 0, 0]);
        request.extend(piece);
    }
    client.send(&request);
    let answer = client.rest();
    let end = answer.windows(4).position(|window| window == b"\r\n\r\n").unwrap() + 4;
    let head = String::from_utf8_lossy(&answer[..end]).into_owned();
    assert!(head.starts_with("HTTP/1.1 101 "), "{head}");
    // The key and its answer are those of RFC 6455.
    assert!(head.contains("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), "{head}");
    assert!(!head.contains("Sec-WebSocket-Protocol"), "{head}");
    // The banner is a binary message, and the last frame is a normal closure.
    assert_eq!(answer[end..end + 2], [0x82, Banner::LENGTH as u8]);
    assert!(answer.ends_with(&[0x88, 2, 3, 232]), "{answer:?}");
    page.daemon.stop();
}
