//! Samples of the messages of the connection (SPEC.md, section 5), and of the one that occurs only in recordings
//! (section 8).
//!
//! In: nothing. Out: samples. Invariants and what it must not know: as in the parent module.

use hopes_protocol::{
    Elapsed, ErrorCode, Goodbye, Hello, ListStreams, Ping, Pong, Report, Status, StatusWanted, StreamInfo,
    StreamStatus, Streams, Welcome, Window,
};

use super::{Sample, sample};

pub fn samples() -> Vec<Sample> {
    [greetings(), pings(), errors(), lists(), statuses(), recordings()].concat()
}

fn greetings() -> Vec<Sample> {
    let words = ["", "später", "z"].map(String::from).to_vec();
    let bare = Welcome {
        software: "hopes 0.1.0".into(),
        capabilities: vec![],
        epoch: u64::MAX,
        largest_frame: 16_777_216,
        largest_batch: 65_536,
        heartbeat_ms: 250,
        timeout_ms: 65_535,
    };
    let capable = Welcome {
        software: String::new(),
        capabilities: words.clone(),
        epoch: 0x1_0000_0000,
        largest_frame: u32::MAX,
        largest_batch: 251,
        heartbeat_ms: 0,
        timeout_ms: 65_536,
    };
    let streams = vec![("scan".into(), 7), ("größe/2 µm".into(), 0x1_0000_0000), ("日本".into(), 0)];
    vec![
        sample("hello", 0, Hello { software: "hopes-client 1.2.3".into(), capabilities: vec![] }),
        sample("hello_capabilities", 0, Hello { software: String::new(), capabilities: words }),
        sample("welcome", 0, bare),
        sample("welcome_capabilities", 0, capable),
        sample("goodbye", 0, Goodbye { reason: "done".into(), streams: vec![] }),
        sample("goodbye_streams", 0, Goodbye { reason: "the daemon was told to stop".into(), streams }),
    ]
}

fn pings() -> Vec<Sample> {
    vec![
        sample("ping", 0, Ping { token: 0 }),
        sample("ping_250", 0, Ping { token: 250 }),
        sample("ping_251", 0, Ping { token: 251 }),
        sample("ping_65535", 0, Ping { token: 65_535 }),
        sample("ping_65536", 0, Ping { token: 65_536 }),
        sample("ping_4294967295", 0, Ping { token: 0xFFFF_FFFF }),
        sample("ping_4294967296", 0, Ping { token: 0x1_0000_0000 }),
        sample("ping_18446744073709551615", 0, Ping { token: u64::MAX }),
        sample("pong", 0, Pong { token: 0x0123_4567_89AB_CDEF }),
    ]
}

fn errors() -> Vec<Sample> {
    let report = |code, answers, text: String| Report { code, answers, text };
    vec![
        sample("error", 7, report(ErrorCode::NoChannel as u16, 0x0103, "channel 7 is not open: open it first".into())),
        sample("error_of_nothing", 0, report(ErrorCode::TooSlow as u16, 0, String::new())),
        sample("error_250", u32::MAX, report(250, 251, "x".repeat(250))),
        sample("error_251", 0xFFFF_FFFE, report(251, u16::MAX, "x".repeat(251))),
    ]
}

fn lists() -> Vec<Sample> {
    vec![
        sample("list_streams", 3, ListStreams { pattern: "*".into() }),
        sample("list_streams_pattern", 4, ListStreams { pattern: "größe/*\u{1F980}*".into() }),
        sample("streams", 3, Streams { streams: infos() }),
        sample("streams_none", 4, Streams { streams: vec![] }),
    ]
}

/// One stream with each kind of window.
fn infos() -> Vec<StreamInfo> {
    let first = StreamInfo {
        stream: 1,
        name: "a".into(),
        epoch: 1_700_000_000_000_000_000,
        window: Window::All,
        resolution: None,
        frame: 12,
        points: 3_000,
        vertices: 2_999,
        producers: 2,
        consumers: 5,
    };
    let others = [
        ("b", Window::Points(1_000_000), Some(0.25)),
        ("c", Window::Frames(251), None),
        ("d e", Window::Time(0.5), Some(1e-9)),
    ];
    let other = |(stream, (name, window, resolution)): (u32, (&str, Window, Option<f64>))| StreamInfo {
        stream,
        name: name.into(),
        window,
        resolution,
        ..first.clone()
    };
    std::iter::once(first.clone()).chain((2..).zip(others).map(other)).collect()
}

fn statuses() -> Vec<Sample> {
    let idle = Status {
        software: "hopes 0.1.0".into(),
        uptime_ms: 86_400_000,
        epoch: 0xFFFF_FFFF_FFFF,
        connections: 1,
        refused_messages: 17,
        memory: 65_536,
        memory_limit: 0,
        streams: vec![],
    };
    let streams =
        infos().into_iter().zip([1_000, 65_530, u64::MAX - 6]).map(|(info, first)| busy(info, first)).collect();
    let busy = Status { connections: u32::MAX, memory_limit: 8_589_934_592, streams, ..idle.clone() };
    vec![sample("get_status", 9, StatusWanted {}), sample("status", 9, idle), sample("status_streams", 10, busy)]
}

fn busy(info: StreamInfo, first: u64) -> StreamStatus {
    StreamStatus {
        info,
        computed: first,
        accepted: first + 1,
        refused: first + 2,
        dropped: first + 3,
        waiting: first + 4,
        lagged: first + 5,
        memory: first + 6,
    }
}

fn recordings() -> Vec<Sample> {
    vec![
        sample("elapsed", 0, Elapsed { nanoseconds: 1_500_000_000 }),
        sample("elapsed_0", 0, Elapsed { nanoseconds: 0 }),
        sample("elapsed_18446744073709551615", 0, Elapsed { nanoseconds: u64::MAX }),
    ]
}
