//! A second implementation of the protocol that shares no code with the crate: its own types, another codec, frames by
//! hand.
//!
//! In: the vectors of all versions. Out: whether JSON to bytes and bytes to JSON both give the vectors.
//!
//! Invariants: definitions follow SPEC.md. The crate's types are used only for numbers that JSON does not have. So this
//! test shows mistakes of the crate that its own tests repeat.

mod samples;
#[macro_use]
mod second;

use std::path::PathBuf;

use hopes_protocol::{HEADER, Message};
use samples::VERSIONS;
use samples::bad::{self, crc32c, frame, long};
use samples::files::{self, bad_folder, folder};
use samples::json::{Entry, pretty};
use second::*;

/// Maps messages to JSON and back.
macro_rules! json {
    ($($name:ident $number:literal $body:ident,)*) => {
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

each_body!(json);

fn json_of<T: Body>(name: &str, number: u16, channel: u32, body: &[u8]) -> Result<String, String> {
    let body = T::from_bytes(body)?;
    Ok(pretty(&Entry { name: name.into(), number, channel, body }))
}

fn bytes_of<T: Body>(text: &str) -> Vec<u8> {
    serde_json::from_str::<Entry<T>>(text).expect("it is JSON of this type").body.to_bytes()
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
    for (version, at_least) in VERSIONS.into_iter().zip([30, 20, 15, 20]) {
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

/// The death of a cycle that is never filled is infinite, which JSON does not have either.
#[test]
fn both_codecs_carry_infinite_deaths_and_odd_coordinates() {
    let odd = [f64::NAN, f64::from_bits(0x7FF0_0000_0000_0001), f64::INFINITY, f64::NEG_INFINITY];
    let coordinates = odd.to_vec();
    let first = hopes_protocol::SpaceRetract { sequence: 1, dimension: 2, coordinates: coordinates.clone() };
    let body = SpaceRetract { sequence: 1, dimension: 2, coordinates }.to_bytes();
    let frame_4 = |kind, body: &[u8]| bad::frame_of(4, kind, body);
    assert_eq!(hopes_protocol::encode(4, 7, &first.into()).expect("it is short"), frame_4(0x0110, &body));
    let Ok(Message::SpaceRetract(read)) = Message::decode(4, 0x0110, &body) else { panic!("the first codec reads it") };
    assert_eq!(read.coordinates.iter().map(|number| number.to_bits()).collect::<Vec<_>>(), odd.map(f64::to_bits));

    let read = decoded_diff("space_diff");
    let first = hopes_protocol::SpaceDiff { critical_set: vec![(1, 2, 0.5, f64::INFINITY)], ..read };
    let sent = hopes_protocol::encode(4, 7, &first.clone().into()).expect("it is short");
    let (number, _, body) = parts(4, &sent);
    assert_eq!(Message::decode(4, number, body), Ok(first.into()));
    assert_eq!(again(number, body), Ok(body.to_vec()), "the second codec reads and writes it");
    assert_eq!(SpaceDiff::from_bytes(body).expect("it reads it").critical_set, [(1, 2, 0.5, f64::INFINITY)]);
}

fn decoded_diff(name: &str) -> hopes_protocol::SpaceDiff {
    let bytes = files::bytes(&folder(4), name);
    let (number, _, body) = parts(4, &bytes);
    let Ok(Message::SpaceDiff(diff)) = Message::decode(4, number, body) else { panic!("{name} is a diff") };
    diff
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
        assert_eq!(again(0x0003, &body), Ok(vec![7]), "read, and written in the shortest form");
    }
}

#[test]
fn the_header_has_the_length_of_the_hand_written_one() {
    assert_eq!(whole(2, 1, 2, &[]).len(), HEADER + 4);
}
