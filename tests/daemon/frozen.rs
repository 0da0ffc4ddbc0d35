//! A client of version 1 that is made only of frozen vectors, whatever other versions the daemon supports. The same of
//! version 2.
//!
//! In: the vectors of the protocol. Out: a dialogue. Invariants: every body that the client sends is a frozen one.
//! Every frame that it receives is of its version.

use std::path::Path;

use hopes_protocol::{Cause, ErrorCode, Message, header};

use crate::common::client::Client;
use crate::common::peers::Daemon;

/// The bytes of a vector of version 1.
fn frozen(name: &str) -> Vec<u8> {
    frozen_of(1, name)
}

/// The bytes of a vector.
fn frozen_of(version: u16, name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("protocol/vectors/v{version}"));
    let path = folder.join(name).with_extension("hex");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(byte).collect()
}

/// The same on another channel. Each vector has a channel of its own.
fn frozen_on(channel: u32, name: &str) -> Vec<u8> {
    in_version(1, channel, &frozen(name))
}

/// The same in another version and on another channel: the body stays as it is.
fn in_version(version: u16, channel: u32, frame: &[u8]) -> Vec<u8> {
    let kind = u16::from_le_bytes([frame[6], frame[7]]);
    let length = u32::from_le_bytes([frame[12], frame[13], frame[14], frame[15]]);
    [&header(version, kind, channel, length), &frame[20..]].concat()
}

#[test]
fn a_client_of_version_1_is_served() {
    let daemon = Daemon::start("");
    let mut client = Client::without_banner(&daemon.address);
    client.write(&frozen("banner"));
    let banner = client.banner();
    assert!((banner.lowest..=banner.highest).contains(&1), "{banner:?}");
    client.set_version(1);

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

/// Its messages are those of version 1 in its own frames, and those about tracks.
#[test]
fn a_client_of_version_2_is_served() {
    let daemon = Daemon::start("--track view");
    let mut client = Client::without_banner(&daemon.address);
    client.write(&frozen_of(2, "banner"));
    let banner = client.banner();
    assert!((banner.lowest..=banner.highest).contains(&2), "{banner:?}");
    client.set_version(2);

    let write_on = |client: &mut Client, channel, name: &str| client.write(&in_version(2, channel, &frozen(name)));
    write_on(&mut client, 0, "hello");
    assert!(matches!(client.receive_on(0), Message::Welcome(_)));
    client.write(&frozen_of(2, "ping"));
    assert!(matches!(client.receive_on(0), Message::Pong(_)));
    write_on(&mut client, 1, "open");
    assert!(matches!(client.receive_on(1), Message::Opened(opened) if opened.created));
    write_on(&mut client, 11, "subscribe");
    assert!(matches!(client.receive_on(11), Message::StreamOpened(opened) if opened.name == "scan"));
    client.write(&frozen_of(2, "want_tracks"));
    write_on(&mut client, 1, "batch");
    assert!(matches!(client.receive_on(1), Message::Refused(refused) if refused.accepted == 2));
    write_on(&mut client, 1, "commit");
    assert!(matches!(client.receive_on(1), Message::Committed(committed) if committed.frame == 1));
    assert!(matches!(client.receive_on(11), Message::Snapshot(snapshot) if snapshot.frame.number == 1));
    assert!(matches!(client.receive_on(11), Message::Tracks(tracks) if (tracks.from, tracks.frame) == (0, 1)));
    write_on(&mut client, 9, "get_status");
    assert!(matches!(client.receive_on(9), Message::Status(status) if status.streams.len() == 1));
    write_on(&mut client, 0, "goodbye");
    assert!(matches!(client.rest().last(), Some((0, Message::Goodbye(_)))));
    daemon.stop();
}

/// The requests of version 3 are unknown types to a client that speaks an older one, and change nothing.
#[test]
fn in_older_versions_there_is_no_administration() {
    let daemon = Daemon::start("--stream scan");
    for version in [1, 2] {
        let mut client = Client::without_banner(&daemon.address);
        client.write(&frozen_of(version, "banner"));
        client.banner();
        client.set_version(version);
        client.write(&in_version(version, 0, &frozen("hello")));
        assert!(matches!(client.receive_on(0), Message::Welcome(_)));
        for (name, kind) in
            [("list_peers", 0x0301), ("stop_stream", 0x0303), ("disconnect", 0x0305), ("get_memory", 0x0307)]
        {
            client.write(&in_version(version, 5, &frozen_of(3, name)));
            let report = client.expect_error_on(5);
            assert_eq!((report.code, report.answers), (ErrorCode::Unexpected as u16, kind), "{}", report.text);
        }
        client.write(&in_version(version, 3, &frozen("list_streams")));
        assert!(matches!(client.receive_on(3), Message::Streams(streams) if streams.streams[0].name == "scan"));
    }
    daemon.stop();
}
