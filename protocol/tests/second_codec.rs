//! A second implementation of the protocol that shares no code with the crate: its own types, another codec, frames by
//! hand.
//!
//! In: the vectors of all versions. Out: whether JSON to bytes and bytes to JSON both give the vectors.
//!
//! Invariants: definitions follow SPEC.md. The crate's types are used only for numbers that JSON does not have. So this
//! test shows mistakes of the crate that its own tests repeat.

mod samples;

use std::fmt::Debug;
use std::path::PathBuf;

use hopes_protocol::{HEADER, Message};
use samples::VERSIONS;
use samples::bad::{self, crc32c, frame, long};
use samples::files::{self, bad_folder, folder};
use samples::json::{Entry, pretty};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use wincode::config::{Configuration, DefaultConfig, deserialize_exact, serialize};
use wincode::int_encoding::{LittleEndian, VarInt};
use wincode::len::BincodeLen;
use wincode::{SchemaRead, SchemaWrite};

type Varint =
    Configuration<true, { wincode::config::DEFAULT_PREALLOCATION_SIZE_LIMIT }, BincodeLen, LittleEndian, VarInt>;

const VARINT: Varint = DefaultConfig::default().with_varint_encoding();

/// A type that both codecs of this file support.
trait Body: Debug + Serialize + DeserializeOwned {
    fn to_bytes(&self) -> Vec<u8>;
    fn from_bytes(bytes: &[u8]) -> Result<Self, String>;
}

/// Defines wire types.
macro_rules! wire {
    ($($definition:item)*) => {
        $(
            #[derive(Debug, Serialize, Deserialize, SchemaRead, SchemaWrite)]
            $definition
        )*
    };
}

/// Maps types of messages to bodies.
macro_rules! bodies {
    ($($name:ident $number:literal $body:ident,)*) => {
        $(
            impl Body for $body {
                fn to_bytes(&self) -> Vec<u8> {
                    serialize(self, VARINT).expect("it is short")
                }

                fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
                    deserialize_exact(bytes, VARINT).map_err(|error| error.to_string())
                }
            }
        )*

        const NUMBERS: &[(u16, &str)] = &[$(($number, stringify!($name)),)*];

        /// Reads a body and writes the JSON of its message.
        fn to_json(number: u16, channel: u32, body: &[u8]) -> Result<String, String> {
            match number {
                $($number => json_of::<$body>(stringify!($name), number, channel, body),)*
                _ => Err(format!("{number} is not known")),
            }
        }

        /// Reads the JSON of a message and writes the bytes of its body.
        fn to_bytes(name: &str, text: &str) -> Vec<u8> {
            match name {
                $(stringify!($name) => bytes_of::<$body>(text),)*
                _ => panic!("{name} is not known"),
            }
        }
    };
}

fn json_of<T: Body>(name: &str, number: u16, channel: u32, body: &[u8]) -> Result<String, String> {
    let body = T::from_bytes(body)?;
    Ok(pretty(&Entry { name: name.into(), number, channel, body }))
}

fn bytes_of<T: Body>(text: &str) -> Vec<u8> {
    serde_json::from_str::<Entry<T>>(text).expect("it is JSON of this type").body.to_bytes()
}

bodies! {
    Hello 0x0001 Hello,
    Welcome 0x0002 Welcome,
    Ping 0x0003 Ping,
    Pong 0x0004 Pong,
    Goodbye 0x0005 Goodbye,
    Error 0x0006 Error,
    ListStreams 0x0007 ListStreams,
    Streams 0x0008 Streams,
    GetStatus 0x0009 GetStatus,
    Status 0x000A Status,
    Open 0x0101 Open,
    Opened 0x0102 Opened,
    Batch 0x0103 Batch,
    Retract 0x0104 Retract,
    Commit 0x0105 Commit,
    Close 0x0106 Close,
    Closed 0x0107 Closed,
    Accepted 0x0108 Accepted,
    Refused 0x0109 Refused,
    Committed 0x010A Committed,
    Overloaded 0x010B Overloaded,
    Subscribe 0x0201 Subscribe,
    ChangeView 0x0202 ChangeView,
    Unsubscribe 0x0203 Unsubscribe,
    StreamOpened 0x0204 StreamOpened,
    StreamClosed 0x0205 StreamClosed,
    Snapshot 0x0206 Snapshot,
    Diff 0x0207 Diff,
    Dots 0x0208 Dots,
    Heartbeat 0x0209 Heartbeat,
    Lagged 0x020A Lagged,
    Resumed 0x020B Resumed,
    Unsubscribed 0x020C Unsubscribed,
    WantTracks 0x020D WantTracks,
    Tracks 0x020E Tracks,
    ListPeers 0x0301 ListPeers,
    Peers 0x0302 Peers,
    StopStream 0x0303 StopStream,
    StreamStopped 0x0304 StreamStopped,
    Disconnect 0x0305 Disconnect,
    Disconnected 0x0306 Disconnected,
    GetMemory 0x0307 GetMemory,
    Memory 0x0308 Memory,
    Elapsed 0x0F01 Elapsed,
}

// ---- types shared by messages

type Vertex = (u64, f64, f64);
type Edge = (u64, u64);
type Critical = (u64, u64, f64, f64);

wire! {
    enum Window {
        All,
        Points(u64),
        Frames(u64),
        Time(f64),
    }

    enum Cut {
        Full,
        Reduced(f64),
        Derived(u32, u32),
    }

    enum Simplify {
        No,
        AtScale,
        Below(f64),
    }

    struct View {
        cut: Cut,
        simplify: Simplify,
    }

    enum DotsWanted {
        No,
        Top(u32),
        All,
    }

    struct Frame {
        number: u64,
        time: Option<f64>,
        points: u64,
        vertices: u64,
        rejected: u64,
        view: View,
        ds: Option<f64>,
        vs: Option<f64>,
        components: u64,
        cycles: u64,
    }
}

// ---- messages of the connection

wire! {
    struct Hello {
        software: String,
        capabilities: Vec<String>,
    }

    struct Welcome {
        software: String,
        capabilities: Vec<String>,
        epoch: u64,
        largest_frame: u32,
        largest_batch: u32,
        heartbeat_ms: u32,
        timeout_ms: u32,
    }

    struct Ping {
        token: u64,
    }

    struct Pong {
        token: u64,
    }

    struct Goodbye {
        reason: String,
        streams: Vec<(String, u64)>,
    }

    struct Error {
        code: u16,
        answers: u16,
        text: String,
    }

    struct ListStreams {
        pattern: String,
    }

    struct Streams {
        streams: Vec<StreamInfo>,
    }

    struct GetStatus {}

    struct Status {
        software: String,
        uptime_ms: u64,
        epoch: u64,
        connections: u32,
        refused_messages: u64,
        memory: u64,
        memory_limit: u64,
        streams: Vec<StreamStatus>,
    }

    struct StreamInfo {
        stream: u32,
        name: String,
        epoch: u64,
        window: Window,
        resolution: Option<f64>,
        frame: u64,
        points: u64,
        vertices: u64,
        producers: u32,
        consumers: u32,
    }

    struct StreamStatus {
        info: StreamInfo,
        computed: u64,
        accepted: u64,
        refused: u64,
        dropped: u64,
        waiting: u64,
        lagged: u64,
        memory: u64,
    }

    struct Elapsed {
        nanoseconds: u64,
    }
}

// ---- producers

wire! {
    struct Open {
        name: String,
        window: Option<Window>,
        resolution: Option<f64>,
    }

    struct Opened {
        stream: u32,
        epoch: u64,
        created: bool,
        window: Window,
        resolution: Option<f64>,
        frame: u64,
        largest_batch: u32,
    }

    struct Batch {
        sequence: u64,
        points: Vec<(f64, f64)>,
        times: Vec<f64>,
        tags: Vec<u64>,
    }

    struct Retract {
        sequence: u64,
        points: Vec<(f64, f64)>,
    }

    struct Commit {
        sequence: u64,
        time: Option<f64>,
    }

    struct Close {
        end: bool,
    }

    struct Closed {
        frame: u64,
    }

    struct Accepted {
        sequence: u64,
        points: u32,
        placed: Vec<(u64, u64)>,
    }

    struct Refused {
        sequence: u64,
        accepted: u32,
        refused: u32,
        reasons: Vec<Refusal>,
        placed: Vec<(u64, u64)>,
    }

    struct Refusal {
        index: u32,
        code: u16,
        text: String,
    }

    struct Committed {
        sequence: u64,
        frame: u64,
    }

    struct Overloaded {
        sequence: u64,
        points: u32,
        total: u64,
        policy: Policy,
    }

    enum Policy {
        DropOldest,
        DropNewest,
    }
}

// ---- consumers

wire! {
    struct Subscribe {
        pattern: String,
        view: View,
        dots: DotsWanted,
        resume: Option<Resume>,
    }

    struct Resume {
        epoch: u64,
        frame: u64,
    }

    struct ChangeView {
        view: View,
        dots: DotsWanted,
    }

    struct Unsubscribe {}

    struct Unsubscribed {}

    struct StreamOpened {
        stream: u32,
        name: String,
        epoch: u64,
        window: Window,
        resolution: Option<f64>,
        frame: u64,
    }

    struct StreamClosed {
        stream: u32,
        frame: u64,
        reason: String,
    }

    enum Cause {
        Start,
        ViewChanged,
        Lagged,
        CannotResume,
    }

    struct Snapshot {
        stream: u32,
        cause: Cause,
        frame: Frame,
        vertices: Vec<Vertex>,
        edges: Vec<Edge>,
        critical: Vec<Critical>,
        checksum: u64,
    }

    struct Diff {
        stream: u32,
        from: u64,
        frame: Frame,
        vertices_added: Vec<Vertex>,
        vertices_removed: Vec<u64>,
        edges_added: Vec<Edge>,
        edges_removed: Vec<Edge>,
        critical_set: Vec<Critical>,
        critical_removed: Vec<Edge>,
        checksum: u64,
    }

    struct Dots {
        stream: u32,
        frame: u64,
        total: u64,
        dots: Vec<Dot>,
    }

    struct Dot {
        edge: Edge,
        birth: f64,
        death: f64,
        center: (f64, f64),
        radius: f64,
    }

    struct Heartbeat {
        stream: u32,
        frame: u64,
    }

    struct Lagged {
        stream: u32,
        first: u64,
        last: u64,
    }

    struct Resumed {
        stream: u32,
        frame: u64,
    }
}

// ---- tracks

wire! {
    enum TracksWanted {
        No,
        Events,
        Alive,
        Cycles,
    }

    struct WantTracks {
        tracks: TracksWanted,
    }

    struct Track {
        id: u64,
        age: u64,
        birth: f64,
        death: f64,
        center: (f64, f64),
        radius: f64,
        area: f64,
        velocity: (f64, f64),
        selected: bool,
    }

    struct TrackChanges {
        center: bool,
        birth: bool,
        death: bool,
    }

    enum Happening {
        Born,
        Split(u64),
        Updated(TrackChanges),
        Unselected,
        Reselected,
        Merged(u64),
        Died,
    }

    struct TrackEvent {
        frame: u64,
        time: Option<f64>,
        happening: Happening,
        track: Track,
    }

    struct TrackCycle {
        id: u64,
        walks: Vec<Vec<u64>>,
    }

    struct Tracks {
        stream: u32,
        from: u64,
        frame: u64,
        time: Option<f64>,
        events: Vec<TrackEvent>,
        alive: Option<Vec<Track>>,
        cycles: Vec<TrackCycle>,
    }
}

// ---- administration

wire! {
    struct ListPeers {}

    struct Peers {
        peers: Vec<Peer>,
    }

    struct Peer {
        peer: u64,
        place: String,
        software: String,
        connected_ms: u64,
        silent_ms: u64,
        producers: u32,
        consumers: u32,
        held: u64,
        received: u64,
        sent: u64,
        lagged: u64,
    }

    struct StopStream {
        name: String,
    }

    struct StreamStopped {
        name: String,
        frame: u64,
    }

    struct Disconnect {
        peer: u64,
    }

    struct Disconnected {
        peer: u64,
    }

    struct GetMemory {}

    struct Memory {
        limit: u64,
        held: u64,
        peers: u64,
        streams: Vec<StreamMemory>,
    }

    struct StreamMemory {
        name: String,
        points: u64,
        views: u64,
        queue: u64,
    }
}

// ---- frames by hand

/// Type, channel and body of a whole frame.
fn parts(version: u16, bytes: &[u8]) -> (u16, u32, &[u8]) {
    let short = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().expect("two bytes"));
    let long = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let head = (&b"hopF"[..], version, crc32c(&bytes[..16]));
    assert_eq!((&bytes[..4], short(4), long(16)), head, "magic, version and CRC");
    let end = 20 + long(12) as usize;
    assert_eq!((bytes.len(), long(end)), (end + 4, crc32c(&bytes[20..end])), "length and CRC of the body");
    (short(6), long(8), &bytes[20..end])
}

fn whole(version: u16, number: u16, channel: u32, body: &[u8]) -> Vec<u8> {
    let length = u32::try_from(body.len()).expect("it is short");
    let mut bytes = b"hopF".to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend(number.to_le_bytes());
    bytes.extend(channel.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(crc32c(&bytes).to_le_bytes());
    bytes.extend(body);
    bytes.extend(crc32c(body).to_le_bytes());
    bytes
}

/// Version, folder and name of every vector of a message.
fn messages() -> Vec<(u16, PathBuf, String)> {
    let of = |version| files::vectors(&folder(version)).into_iter().map(move |name| (version, folder(version), name));
    VERSIONS.into_iter().flat_map(of).filter(|(_, _, name)| name != "banner").collect()
}

#[test]
fn the_second_codec_knows_the_same_messages() {
    assert_eq!(NUMBERS, Message::KINDS);
}

#[test]
fn the_second_crc_is_castagnolis() {
    assert_eq!(crc32c(b"123456789"), 0xE306_9283);
    assert_eq!(crc32c(b""), 0);
}

#[test]
fn the_second_codec_reads_every_vector() {
    for (version, folder, name) in messages() {
        let bytes = files::bytes(&folder, &name);
        let (number, channel, body) = parts(version, &bytes);
        let read = to_json(number, channel, body).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(read, files::read(&folder, &format!("{name}.json")), "{name}");
    }
}

#[test]
fn the_second_codec_writes_every_vector() {
    for (version, folder, name) in messages() {
        let text = files::read(&folder, &format!("{name}.json"));
        let head: Entry<serde_json::Value> = serde_json::from_str(&text).expect("it is JSON");
        let written = whole(version, head.number, head.channel, &to_bytes(&head.name, &text));
        assert_eq!(files::hex(&written), files::read(&folder, &format!("{name}.hex")), "{name}");
    }
}

/// All vectors of bodies that cannot be read, except those of unknown types, which have no reader here.
#[test]
fn the_second_codec_refuses_the_same_bodies() {
    for (version, at_least) in VERSIONS.into_iter().zip([30, 20, 15]) {
        let (folder, mut refused) = (bad_folder(version), 0);
        for name in files::vectors(&folder) {
            let text = files::read(&folder, &format!("{name}.json"));
            let refusal: bad::Refusal = serde_json::from_str(&text).expect("it is JSON");
            if refusal.error == bad::BODY {
                let bytes = files::bytes(&folder, &name);
                let (number, channel, body) = parts(version, &bytes);
                assert!(to_json(number, channel, body).is_err(), "{name}: {}", refusal.why);
                refused += 1;
            }
        }
        assert!(refused > at_least, "only {refused} of version {version} were there");
    }
}

/// JSON does not have such numbers, but a producer may send them.
#[test]
fn both_codecs_carry_nan_and_infinities() {
    let odd = [f64::NAN, f64::from_bits(0x7FF0_0000_0000_0001), -f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let bits = odd.map(f64::to_bits);
    let points: Vec<(f64, f64)> = odd.iter().map(|&x| (x, -x)).collect();
    let first = hopes_protocol::Batch { sequence: 1, points: points.clone(), times: odd.to_vec(), tags: vec![] };
    let second = Batch { sequence: 1, points, times: odd.to_vec(), tags: vec![] };
    let bytes = second.to_bytes();
    assert_eq!(hopes_protocol::encode(1, 7, &first.into()).expect("it is short"), frame(0x0103, &bytes));
    let Ok(Message::Batch(read)) = Message::decode(1, 0x0103, &bytes) else { panic!("the first codec reads it") };
    let read_again = Batch::from_bytes(&bytes).expect("the second codec reads it");
    for times in [read.times, read_again.times] {
        assert_eq!(times.into_iter().map(f64::to_bits).collect::<Vec<_>>(), bits);
    }
}

/// Lists and texts whose lengths take five bytes. They are too large for vectors.
#[test]
fn both_codecs_write_long_lists_alike() {
    for length in [250, 251, 65_535, 65_536, 70_000] {
        let tags: Vec<u64> = (0..length).collect();
        let first = hopes_protocol::Batch { sequence: 9, points: vec![], times: vec![], tags: tags.clone() };
        let body = Batch { sequence: 9, points: vec![], times: vec![], tags }.to_bytes();
        assert_eq!(hopes_protocol::encode(1, 7, &first.clone().into()).expect("it is short"), frame(0x0103, &body));
        assert_eq!(Message::decode(1, 0x0103, &body), Ok(first.into()));

        let pattern = "é".repeat(length as usize);
        let first = hopes_protocol::ListStreams { pattern: pattern.clone() };
        let body = ListStreams { pattern }.to_bytes();
        assert_eq!(hopes_protocol::encode(1, 7, &first.clone().into()).expect("it is short"), frame(0x0007, &body));
        assert_eq!(Message::decode(1, 0x0007, &body), Ok(first.into()));
    }
}

/// Writers write the shortest form of a number. Readers accept the longer forms too, and both codecs agree on them.
#[test]
fn both_codecs_read_numbers_in_longer_forms() {
    for body in [long(7), vec![252, 7, 0, 0, 0], vec![251, 7, 0], vec![7]] {
        assert_eq!(Message::decode(1, 0x0003, &body), Ok(hopes_protocol::Ping { token: 7 }.into()));
        assert_eq!(Ping::from_bytes(&body).expect("it is read").token, 7);
    }
}

#[test]
fn the_header_has_the_length_of_the_hand_written_one() {
    assert_eq!(whole(2, 1, 2, &[]).len(), HEADER + 4);
}
