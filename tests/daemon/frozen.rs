//! A client of version 1 that is made only of frozen vectors, whatever other versions the daemon supports.
//!
//! In: `protocol/vectors/v1`. Out: a dialogue. Invariants: every body that the client sends is a frozen one. Every
//! frame that it receives is of version 1.

use std::path::Path;

use hopes_protocol::{Cause, Message, header};

use crate::common::client::Client;
use crate::common::peers::Daemon;

const VERSION: u16 = 1;

/// The bytes of a vector.
fn frozen(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("protocol/vectors/v1").join(name).with_extension("hex");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(byte).collect()
}

/// The same on another channel. Each vector has a channel of its own.
fn frozen_on(channel: u32, name: &str) -> Vec<u8> {
    let frame = frozen(name);
    let kind = u16::from_le_bytes([frame[6], frame[7]]);
    let length = u32::from_le_bytes([frame[12], frame[13], frame[14], frame[15]]);
    [&header(VERSION, kind, channel, length), &frame[20..]].concat()
}

#[test]
fn a_client_of_version_1_is_served() {
    let daemon = Daemon::start("");
    let mut client = Client::without_banner(&daemon.address);
    client.write(&frozen("banner"));
    let banner = client.banner();
    assert!((banner.lowest..=banner.highest).contains(&VERSION), "{banner:?}");
    client.set_version(VERSION);

    client.write(&frozen("hello"));
    assert!(matches!(client.receive_on(0), Message::Welcome(_)));
    client.write(&frozen("open"));
    assert!(matches!(client.receive_on(1), Message::Opened(opened) if opened.created));
    client.write(&frozen("subscribe"));
    assert!(matches!(client.receive_on(11), Message::StreamOpened(opened) if opened.name == "scan"));

    // The third point is out of range.
    client.write(&frozen_on(1, "batch"));
    assert!(matches!(client.receive_on(1), Message::Refused(refused) if (refused.accepted, refused.refused) == (2, 1)));
    client.write(&frozen_on(1, "commit"));
    assert!(
        matches!(client.receive_on(1), Message::Committed(committed) if (committed.sequence, committed.frame) == (251, 1))
    );
    let Message::Snapshot(snapshot) = client.receive_on(11) else { panic!("a snapshot is due") };
    assert_eq!((snapshot.cause, snapshot.frame.number, snapshot.frame.rejected), (Cause::Start, 1, 1));
    assert_eq!(snapshot.vertices, [(0, 0.0, 0.5), (1, 1.0, -2.0)]);
    assert_eq!(snapshot.edges, [(0, 1)]);
    assert!(matches!(client.receive_on(11), Message::Dots(dots) if dots.total == 0));

    client.write(&frozen_on(1, "retract"));
    assert!(matches!(client.receive_on(1), Message::Refused(refused) if (refused.accepted, refused.refused) == (2, 1)));
    client.write(&frozen_on(1, "commit_time"));
    assert!(matches!(client.receive_on(1), Message::Committed(committed) if committed.frame == 2));
    let Message::Diff(diff) = client.receive_on(11) else { panic!("a diff is due") };
    assert_eq!((diff.from, diff.frame.number, diff.vertices_removed), (1, 2, vec![0, 1]));

    client.write(&frozen("list_streams"));
    assert!(matches!(client.receive_on(3), Message::Streams(streams) if streams.streams.len() == 1));
    client.write(&frozen("get_status"));
    assert!(
        matches!(client.receive_on(9), Message::Status(status) if (status.streams[0].accepted, status.streams[0].refused) == (2, 2))
    );
    client.write(&frozen("ping_251"));
    assert!(matches!(client.receive_on(0), Message::Pong(pong) if pong.token == 251));
    client.write(&frozen("unsubscribe"));
    assert!(matches!(client.receive_on(11), Message::Unsubscribed(_)));
    client.write(&frozen_on(1, "close_end"));
    assert!(matches!(client.receive_on(1), Message::Closed(closed) if closed.frame == 2));
    client.write(&frozen("goodbye"));
    assert!(matches!(&client.rest()[..], [(0, Message::Goodbye(_))]));
    daemon.stop();
}
