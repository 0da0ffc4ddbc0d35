//! Bytes that must give an error if version 3 was agreed on: the samples of `vectors/v3/bad`.
//!
//! In: nothing. Out: bytes with the class of their error. Invariants and what it must not know: as in `bad`, whose
//! samples, except those about versions, are wrong in version 3 too.

use hopes_protocol::{Message, Ping, encode};

use super::bad::{BODY, Bad, VERSION, bad, frame_of, long};

/// All samples.
pub fn all() -> Vec<Bad> {
    [versions(), ends(), hostile_lengths(), numbers(), texts()].into_iter().flatten().collect()
}

/// A peer without place and software whose numbers are all 1.
const PEER: [u8; 11] = [1, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1];

/// Peers: how many there are said to be, and their bytes.
fn peers(parts: &[&[u8]]) -> Vec<u8> {
    frame_of(3, 0x0302, &parts.concat())
}

/// Memory of 1 byte each, and the rest of its body.
fn memory(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(3, 0x0308, &[&[1, 1, 1], &rest.concat()[..]].concat())
}

fn versions() -> Vec<Bad> {
    let ping = |version| encode(version, 0, &Message::from(Ping { token: 65_536 })).expect("it is short");
    vec![
        bad("version_1", VERSION, "version 1, where 3 was agreed on", ping(1)),
        bad("version_2", VERSION, "version 2, where 3 was agreed on", ping(2)),
        bad("version_4", VERSION, "version 4, where 3 was agreed on", ping(4)),
        bad("version_769", VERSION, "version 769, whose high byte is 3", ping(769)),
    ]
}

fn ends() -> Vec<Bad> {
    vec![
        bad("unknown_type", BODY, "type 0x0309, which no message has", frame_of(3, 0x0309, &[])),
        bad("unknown_type_0300", BODY, "type 0x0300, which no message has", frame_of(3, 0x0300, &[])),
        bad("trailing_list", BODY, "ListPeers has no fields, but a byte comes", frame_of(3, 0x0301, &[0])),
        bad("trailing_peers", BODY, "Peers, and a byte after its last field", peers(&[&[1], &PEER, &[0]])),
        bad("short_peer", BODY, "Peers that end within a peer", peers(&[&[1], &PEER[..10]])),
        bad("short_peers", BODY, "Peers that say two and have one", peers(&[&[2], &PEER])),
        bad("empty_stop", BODY, "StopStream without its name", frame_of(3, 0x0303, &[])),
        bad("trailing_stop", BODY, "StopStream, and a byte after its name", frame_of(3, 0x0303, b"\x01ab")),
        bad("no_frame", BODY, "StreamStopped without its frame", frame_of(3, 0x0304, b"\x01a")),
        bad("empty_disconnect", BODY, "Disconnect without its peer", frame_of(3, 0x0305, &[])),
        bad("trailing_disconnected", BODY, "Disconnected, and a byte after its peer", frame_of(3, 0x0306, &[1, 0])),
        bad("trailing_get_memory", BODY, "GetMemory has no fields, but a byte comes", frame_of(3, 0x0307, &[0])),
        bad("no_streams", BODY, "Memory without its streams", memory(&[])),
        bad("short_stream", BODY, "Memory that ends within a stream", memory(&[&[1], b"\x01a", &[1, 1]])),
    ]
}

fn hostile_lengths() -> Vec<Bad> {
    let huge = long(1 << 60);
    vec![
        bad("huge_peers", BODY, "Peers with 2^60 peers", peers(&[&huge, &PEER])),
        bad("huge_place", BODY, "Peers with a place of 2^60 bytes", peers(&[&[1, 1], &huge, &[b'a'; 16]])),
        bad("huge_software", BODY, "Peers with a software of 2^60 bytes", peers(&[&[1, 1, 0], &huge, &[b'a'; 16]])),
        bad("huge_name", BODY, "StopStream with a name of 2^60 bytes", frame_of(3, 0x0303, &huge)),
        bad("huge_streams", BODY, "Memory with 2^60 streams", memory(&[&huge, &[0; 64]])),
    ]
}

fn numbers() -> Vec<Bad> {
    let mark = [&[254][..], &[0; 16]].concat();
    let producers = [&[1, 1, 0, 0, 1, 1][..], &long(1), &[1; 5]].concat();
    vec![
        bad("number_mark_254", BODY, "Disconnect whose peer has the mark 254", frame_of(3, 0x0305, &mark)),
        bad(
            "number_u32_small_in_8_bytes",
            BODY,
            "Peers with a peer whose producers, an u32, are 1 with the mark of 8 bytes",
            frame_of(3, 0x0302, &producers),
        ),
    ]
}

fn texts() -> Vec<Bad> {
    vec![
        bad("text_invalid", BODY, "StopStream whose name has bytes that UTF-8 never has", {
            frame_of(3, 0x0303, b"\x02\xff\xfe")
        }),
        bad("text_cut", BODY, "StreamStopped whose name ends within a character", {
            frame_of(3, 0x0304, b"\x02\xe2\x82\x01")
        }),
    ]
}
