//! Visitors who take their time, come in crowds, or do not read: everybody else is served.

use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use hopes_protocol::*;

use super::page::{Page, Visitor};
use crate::common::client::{Socket, bytes, hello};
use crate::common::process::eventually;
use crate::common::random::Random;
use crate::common::roles::{Consumer, FULL, Pair, Producer, held, open, points, subscribe};

#[test]
fn a_thousand_idle_connections_are_harmless() {
    let page = Page::start("");
    let mut pair = Pair::new(&page.daemon, "cam");
    let address = format!("127.0.0.1:{}", page.port());
    let mut idle: Vec<TcpStream> = (0..1000).map(|_| TcpStream::connect(&address).unwrap()).collect();
    // One says a little, which is worth no more.
    idle[0].write_all(b"GET / HT").unwrap();
    pair.step();
    let mut late = Consumer::subscribe(page.daemon.client(), subscribe("cam", FULL));
    late.is_shown(Cause::Start);
    assert_eq!(late.mirror.number(), pair.consumer.mirror.number());
    // Who is one too many is told so, and the others are sent away in time.
    let turned_away = idle.split_off(300);
    for stream in turned_away.into_iter().step_by(50) {
        Visitor(stream).reply().unwrap().is_refused(503, "256 clients");
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
fn who_does_not_come_to_the_point_is_sent_away() {
    // The time for a head is the daemon's for anything, if that is less than ten seconds.
    let page = Page::start("--timeout 2s");
    let (mut silent, mut slow) = (page.visitor(), page.visitor());
    let begun = Instant::now();
    let mut said = 0;
    for byte in format!("GET / HTTP/1.1\r\nHost: {}\r\nX-Long: {}", page.host, "a".repeat(10_000)).bytes() {
        // Each byte is sent long before anybody would give up waiting for one.
        if slow.0.write_all(&[byte]).is_err() || begun.elapsed() > Duration::from_secs(30) {
            break;
        }
        said += 1;
        page_pause();
        if said % 20 == 0 && is_answered(&slow.0) {
            break;
        }
    }
    assert!(begun.elapsed() > Duration::from_millis(1900), "after {:?}", begun.elapsed());
    assert!(begun.elapsed() < Duration::from_secs(30));
    slow.reply().unwrap().is_refused(408, "must be complete in time");
    assert_eq!(silent.reply(), None);
    page.daemon.stop();
}

fn page_pause() {
    std::thread::sleep(Duration::from_millis(10));
}

fn is_answered(stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let is_answered = stream.peek(&mut [0]).is_ok();
    stream.set_nonblocking(false).unwrap();
    is_answered
}

#[test]
fn who_does_not_read_an_answer_is_cut_off() {
    let page = Page::start("--timeout 6s --heartbeat 200ms");
    let mut random = Random::new(3);
    let mut producer = Producer::open(page.daemon.client(), open("cam"));
    for _ in 0..3 {
        let batch = producer.batch(&points(&mut random, 60_000));
        producer.is_accepted(batch, 60_000);
    }
    let commit = producer.commit();
    producer.is_committed(commit);
    // Whoever stays has to say something now and then.
    drop(producer);
    let request = format!("GET /api/streams/cam/snapshot?full HTTP/1.1\r\nHost: {}\r\n\r\n", page.host);
    let stuck: Vec<Visitor> = (0..4)
        .map(|_| {
            let mut visitor = page.visitor();
            visitor.say(request.as_bytes());
            visitor
        })
        .collect();
    eventually("all are being answered", || stuck.iter().all(|visitor| is_answered(&visitor.0)).then_some(()));
    // They have all turns that there are, until they are cut off.
    page.get("/api/streams/cam/snapshot").is_refused(503, "try again");
    page.get("/healthz").fine();
    eventually("there are turns again", || (page.get("/api/streams/cam/snapshot").status == 200).then_some(()));
    // One was cut off by now, and the others began to be answered before that.
    std::thread::sleep(Duration::from_secs(6));
    for mut visitor in stuck {
        let got = visitor.rest();
        assert!(got.starts_with(b"HTTP/1.1 ") && !got.ends_with(b"}\n"), "{} bytes", got.len());
    }
    page.daemon.stop();
}

#[test]
fn a_websocket_that_never_reads_is_cut_off_and_holds_nobody_up() {
    let page = Page::start("--timeout 4s --heartbeat 500ms");
    let mut silent = page.guest();
    silent.send(1, subscribe("cam", FULL));
    let mut random = Random::new(5);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let mut beside = page.guest_consumer("cam");
    let begun = Instant::now();
    let mut frame = 0;
    while page.daemon.stream("cam").info.consumers == 2 || frame == 0 {
        frame = producer.frame(&points(&mut random, 12_000));
        // Whoever reads is shown every frame, by a diff or, the first time, as a whole.
        beside.follow_to(frame);
        assert!(begun.elapsed() < Duration::from_secs(90), "the silent one is still there after frame {frame}");
    }
    frame = producer.frame(&points(&mut random, 10));
    beside.follow_to(frame);
    drop(silent);
    page.daemon.stop();
}

#[test]
fn a_tab_that_has_slept_is_told_what_it_missed_and_goes_on() {
    let page = Page::start("--consumer-queue 64KiB");
    let mut random = Random::new(6);
    let mut producer = Producer::open(page.daemon.client(), Open { window: Some(Window::Frames(1)), ..open("cam") });
    let mut last = producer.frame(&points(&mut random, 12_000));
    let (mut asleep, mut awake) = (page.guest_consumer("cam"), page.guest_consumer("cam"));
    asleep.is_shown(Cause::Start);
    awake.is_shown(Cause::Start);
    // More than sockets hold.
    for _ in 0..40 {
        last = producer.frame(&points(&mut random, 12_000));
        awake.follow_to(last);
    }
    let missed: u64 = asleep
        .follow_to(last)
        .iter()
        .map(|message| if let Message::Lagged(lagged) = message { lagged.last - lagged.first + 1 } else { 0 })
        .sum();
    assert!(missed > 0);
    assert_eq!(page.daemon.stream("cam").lagged, missed);
    assert_eq!(held(&asleep.mirror), held(&awake.mirror));
    last = producer.frame(&points(&mut random, 100));
    asleep.follow_to(last);
    page.daemon.stop();
}

#[test]
fn noise_in_a_websocket_ends_that_one_only() {
    let page = Page::start("");
    let mut pair = Pair::new(&page.daemon, "cam");
    let mut random = Random::new(11);
    for round in 0..40 {
        let guest = page.guest();
        let Socket::Web(mut web) = guest.socket else { panic!("a guest comes by WebSocket") };
        let noise: Vec<u8> = (0..300).map(|_| random.below(256) as u8).collect();
        let below = web.socket.get_mut();
        // The daemon may hang up in the middle of it.
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
fn frames_that_break_the_rules_end_with_the_reason() {
    let page = Page::start("");
    for (frame, code, words) in [
        (&[0x81, 0x81, 0, 0, 0, 0, b'x'][..], 1003, "text"),
        (&[0x82, 0x01, b'x'], 1002, "not masked"),
        (&[0x80, 0x80, 0, 0, 0, 0], 1002, "out of order"),
    ] {
        let mut guest = page.guest();
        let Socket::Web(web) = &mut guest.socket else { panic!("a guest comes by WebSocket") };
        web.socket.get_mut().write_all(frame).unwrap();
        let rest = guest.rest();
        let [(0, Message::Error(report)), (0, Message::Goodbye(_))] = &rest[..] else { panic!("{rest:?}") };
        assert_eq!(report.code, ErrorCode::BadFrame as u16);
        assert!(report.text.contains(words), "{report:?}");
        let Socket::Web(web) = &guest.socket else { panic!("it still does") };
        assert_eq!(web.closed, Some(code));
    }
    page.daemon.stop();
}

#[test]
fn who_is_one_peer_too_many_is_told_so() {
    let page = Page::start("--max-connections 2");
    let (_first, _second) = (page.guest(), page.guest());
    let mut third = crate::common::client::Client::silent(&format!("ws:{}", page.host));
    assert_eq!(third.banner(), Banner::OURS);
    let rest = third.rest();
    let [(0, Message::Error(report))] = &rest[..] else { panic!("{rest:?}") };
    assert_eq!(report.code, ErrorCode::TooManyConnections as u16);
    // Visitors have places of their own.
    page.get("/healthz").fine();
    page.daemon.stop();
}

#[test]
fn words_after_the_upgrade_may_come_with_it() {
    let page = Page::start("");
    let mut visitor = page.visitor();
    let mut request = format!(
        "GET /ws HTTP/1.1\r\nHost: {0}\r\nOrigin: http://{0}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
        page.host
    )
    .into_bytes();
    let said =
        [&Banner::OURS.encode()[..], &bytes(0, hello()), &bytes(0, Goodbye { reason: "done".into(), streams: vec![] })];
    // Masked with zeros, which changes nothing.
    for piece in said {
        assert!(piece.len() < 126);
        request.extend([0x82, 0x80 | piece.len() as u8, 0, 0, 0, 0]);
        request.extend(piece);
    }
    visitor.say(&request);
    let answer = visitor.rest();
    let end = answer.windows(4).position(|window| window == b"\r\n\r\n").unwrap() + 4;
    let head = String::from_utf8_lossy(&answer[..end]).into_owned();
    assert!(head.starts_with("HTTP/1.1 101 "), "{head}");
    // The answer that RFC 6455 gives for this key.
    assert!(head.contains("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), "{head}");
    assert!(!head.contains("Sec-WebSocket-Protocol"), "{head}");
    // The banner is a binary message, and the last frame closes for no special reason.
    assert_eq!(answer[end..end + 2], [0x82, Banner::LENGTH as u8]);
    assert!(answer.ends_with(&[0x88, 2, 3, 232]), "{answer:?}");
    page.daemon.stop();
}
