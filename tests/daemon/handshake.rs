//! The handshake and invalid messages: which are answered and which end the connection.

use hopes_protocol::*;

use crate::common::client::{Client, bytes, hello};
use crate::common::peers::Daemon;

/// A frame written by hand: a correct header around any body.
fn frame(kind: u16, channel: u32, body: &[u8]) -> Vec<u8> {
    let crc = crc32c(body).to_le_bytes();
    [&header(VERSION, kind, channel, body.len() as u32)[..], body, &crc].concat()
}

/// The CRC-32C of SPEC.md, bit by bit.
pub fn crc32c(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(!0, |crc: u32, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0x82F6_3B78 * (crc & 1))))
}

#[test]
fn a_client_is_accepted() {
    let daemon = Daemon::start("--heartbeat 3s --timeout 40s --max-batch 1234");
    let mut client = Client::new(&daemon.address);
    let welcome = client.hello();
    assert!(welcome.software.starts_with("hopes "), "{}", welcome.software);
    assert_eq!((welcome.heartbeat_ms, welcome.timeout_ms, welcome.largest_batch), (3000, 40_000, 1234));
    assert_eq!(welcome.capabilities, [""; 0]);
    assert_eq!(client.status().epoch, welcome.epoch);
    let rest = client.part();
    assert!(matches!(&rest[..], [(0, Message::Goodbye(_))]), "{rest:?}");
    daemon.stop();
}

#[test]
fn a_peer_without_a_common_version_gets_the_daemons_range() {
    let daemon = Daemon::start("");
    for (lowest, highest) in [(5, 9), (0, 0), (9, 3)] {
        let mut client = Client::without_banner(&daemon.address);
        assert_eq!(client.banner(), Banner::OURS, "the banner comes before anything was said");
        client.write(&Banner { lowest, highest }.encode());
        assert_eq!(client.rest(), [], "nothing would be understood");
    }
    let mut newer = Client::without_banner(&daemon.address);
    newer.write(&Banner { lowest: 0, highest: 7 }.encode());
    assert_eq!(newer.banner(), Banner::OURS);
    newer.hello();
    daemon.stop();
}

#[test]
fn a_peer_without_a_banner_is_disconnected() {
    let daemon = Daemon::start("");
    let mut stranger = Client::without_banner(&daemon.address);
    stranger.write(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    stranger.banner();
    stranger.expect_disconnect(ErrorCode::BadFrame as u16);
    assert_eq!(daemon.status().refused_messages, 1);
    daemon.stop();
}

#[test]
fn the_first_message_is_hello() {
    let daemon = Daemon::start("");
    let mut client = Client::new(&daemon.address);
    for message in [Message::from(StatusWanted {}), Ping { token: 1 }.into(), Close { end: true }.into()] {
        assert_eq!(client.is_refused(5, message), ErrorCode::Unexpected as u16);
    }
    assert_eq!(client.is_refused(5, hello()), ErrorCode::Unexpected as u16, "hello belongs on channel 0");
    client.hello();
    assert_eq!(client.is_refused(0, hello()), ErrorCode::Unexpected as u16, "once is enough");
    assert_eq!(client.status().refused_messages, 5);
    daemon.stop();
}

#[test]
fn unknown_and_invalid_messages_are_answered_with_errors() {
    let daemon = Daemon::start("");
    let mut client = daemon.client();
    let mut refused = 0;
    let mut is_refused = |client: &mut Client, kind: u16, body: &[u8], code: ErrorCode| {
        client.write(&frame(kind, 9, body));
        let report = client.expect_error_on(9);
        assert_eq!((report.code, report.answers), (code as u16, kind), "{report:?}");
        refused += 1;
    };
    for kind in [0x0000, 0x0FFF, 0x0F02, 0xFFFF] {
        is_refused(&mut client, kind, b"whatever", ErrorCode::Unexpected);
    }
    // A body that ends too soon, has trailing bytes, or contains an impossible length.
    let open = bytes(9, Open { name: "cam".to_owned(), window: None, resolution: None });
    let body = &open[HEADER..open.len() - 4];
    is_refused(&mut client, 0x0101, &body[..body.len() - 1], ErrorCode::Unreadable);
    is_refused(&mut client, 0x0101, &[body, &[0]].concat(), ErrorCode::Unreadable);
    is_refused(&mut client, 0x0101, &[253, 255, 255, 255, 255, 255, 255, 255, 255], ErrorCode::Unreadable);
    is_refused(&mut client, 0x0101, &[4, 0xFF, 0xFE, 0xFD, 0xFC, 0, 0], ErrorCode::Unreadable);
    // Messages that only a daemon sends, and the one that occurs only in recordings.
    for message in [Message::from(Closed { frame: 1 }), Unsubscribed {}.into(), Elapsed { nanoseconds: 1 }.into()] {
        let whole = bytes(9, message.clone());
        is_refused(&mut client, message.kind(), &whole[HEADER..whole.len() - 4], ErrorCode::Unexpected);
    }
    assert!(matches!(
        client.ask(9, Open { name: "cam".to_owned(), window: None, resolution: None }),
        Message::Opened(_)
    ));
    assert_eq!(client.status().refused_messages, refused);
    daemon.stop();
}

#[test]
fn a_corrupt_frame_ends_the_connection() {
    let daemon = Daemon::start("");
    let ping = bytes(0, Ping { token: 7 });
    let broken = |at: usize| {
        let mut bytes = ping.clone();
        bytes[at] ^= 0x10;
        bytes
    };
    let of_another_version = [&header(1, 3, 0, 1)[..], &[7], &crc32c(&[7]).to_le_bytes()].concat();
    for bytes in [broken(0), broken(9), broken(17), broken(HEADER), broken(ping.len() - 1), of_another_version] {
        let mut client = daemon.client();
        client.write(&bytes);
        client.expect_disconnect(ErrorCode::BadFrame as u16);
    }
    daemon.stop();
}

#[test]
fn a_frame_that_is_too_large_is_refused_before_it_arrives() {
    let daemon = Daemon::start("");
    let mut client = Client::new(&daemon.address);
    let largest = client.hello().largest_frame;
    client.write(&header(VERSION, 0x0103, 1, largest + 1));
    client.expect_disconnect(ErrorCode::BadFrame as u16);
    let mut client = daemon.client();
    client.write(&header(VERSION, 0x0103, 1, u32::MAX));
    client.expect_disconnect(ErrorCode::BadFrame as u16);
    // A frame of the largest size is accepted, whatever it contains.
    let mut client = daemon.client();
    client.write(&frame(0x0103, 1, &vec![0xFF; largest as usize]));
    assert_eq!(client.expect_error_on(1).code, ErrorCode::Unreadable as u16);
    client.ping();
    daemon.stop();
}

#[test]
fn pings_are_answered_and_goodbye_after_everything_else() {
    let daemon = Daemon::over_tcp("");
    let mut producer = daemon.producer("cam");
    producer.client.ping();
    let sequences: Vec<u64> = (0..50).map(|at| producer.batch(&[(f64::from(at), 0.0)])).collect();
    producer.commit();
    let rest = producer.client.part();
    let answers = rest.iter().filter(|(channel, _)| *channel == 1).count();
    assert_eq!(answers, sequences.len() + 1);
    let Some((0, Message::Goodbye(_))) = rest.last() else { panic!("{rest:?}") };
    daemon.stop();
}
