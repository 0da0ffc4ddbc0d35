//! Samples of the messages for administration (SPEC.md, section 12), all of version 3, and one message of an older
//! version in a frame of version 3.
//!
//! In: nothing. Out: samples. Invariants and what it must not know: as in the parent module.

use hopes_protocol::{
    Disconnect, Disconnected, ErrorCode, GetMemory, ListPeers, Memory, Peer, Peers, Report, StopStream, StreamMemory,
    StreamStopped,
};

use super::{BORDERS, Sample, sample};

pub fn samples() -> Vec<Sample> {
    [peers(), stopped(), disconnected(), memory(), older()].concat()
}

/// A consumer over TCP. All its fields differ.
fn consumer() -> Peer {
    Peer {
        peer: 3,
        place: "tcp://127.0.0.1:7070".into(),
        software: "hopes 0.1.0".into(),
        connected_ms: 86_400_000,
        silent_ms: 12_500,
        producers: 0,
        consumers: 2,
        held: 1_048_576,
        received: 251,
        sent: 0x1_0000_0000,
        lagged: 17,
    }
}

fn peers() -> Vec<Sample> {
    let silent = Peer { peer: 4, place: "pipe".into(), software: String::new(), producers: 65_536, ..consumer() };
    let page = Peer { peer: 250, place: "größe/日本".into(), software: "später".into(), ..consumer() };
    vec![
        sample("list_peers", 21, ListPeers {}),
        sample("peers", 21, Peers { peers: vec![consumer(), silent, page] }),
        sample("peers_none", 22, Peers { peers: vec![] }),
        sample("peers_borders", 23, Peers { peers: BORDERS.map(at_a_border).to_vec() }),
    ]
}

/// A peer whose numbers are all the same, cut to their types.
fn at_a_border(number: u64) -> Peer {
    Peer {
        peer: number,
        connected_ms: number,
        silent_ms: number,
        producers: u32::try_from(number).unwrap_or(u32::MAX),
        consumers: u32::try_from(number).unwrap_or(u32::MAX),
        held: number,
        received: number,
        sent: number,
        lagged: number,
        ..consumer()
    }
}

fn stopped() -> Vec<Sample> {
    vec![
        sample("stop_stream", 24, StopStream { name: "scan".into() }),
        sample("stop_stream_longest", 25, StopStream { name: "é".repeat(100) }),
        sample("stream_stopped", 24, StreamStopped { name: "scan".into(), frame: 512 }),
        sample("stream_stopped_0", 25, StreamStopped { name: "größe/2 µm".into(), frame: 0 }),
    ]
}

fn disconnected() -> Vec<Sample> {
    vec![
        sample("disconnect", 26, Disconnect { peer: 3 }),
        sample("disconnect_18446744073709551615", 27, Disconnect { peer: u64::MAX }),
        sample("disconnected", 26, Disconnected { peer: 3 }),
        sample("disconnected_18446744073709551615", 27, Disconnected { peer: u64::MAX }),
    ]
}

fn memory() -> Vec<Sample> {
    let stream = |name: &str, points, views, queue| StreamMemory { name: name.into(), points, views, queue };
    let streams = vec![
        stream("a", 2_819_060, 65_535, 250),
        stream("d e", 0, 0, 0),
        stream("größe/2 µm", u64::MAX, 0xFFFF_FFFF, 251),
    ];
    let busy = Memory { limit: 8_589_934_592, held: 4_000_000_000, peers: 1_000_000, streams };
    let idle = Memory { limit: 0, held: 65_536, peers: 251, streams: vec![] };
    vec![sample("get_memory", 28, GetMemory {}), sample("memory", 28, busy), sample("memory_no_streams", 29, idle)]
}

/// The codes that were added with version 3 come in the message that every version has.
fn older() -> Vec<Sample> {
    let text = "no stream is called scan: hopes status lists those that there are";
    let report = Report { code: ErrorCode::NoStream as u16, answers: 0x0303, text: text.into() };
    vec![Sample { version: 3, ..sample("error", 24, report) }]
}
