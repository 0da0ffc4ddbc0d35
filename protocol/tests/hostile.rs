//! Hostile and corrupt bytes: the decoder returns the right error, does not panic, and does not allocate memory that is
//! only announced.
//!
//! In: random bytes, and samples with flipped bits, cuts, splices and wrong lengths, in frames of the newest version,
//! which has all messages. Out: whether errors are of the right class.
//!
//! Invariants: random values are the same in every run.
//!
//! Must not know: how bodies are written, except that 253 marks a number of eight bytes.

mod samples;

use std::collections::BTreeSet;

use hopes_protocol::{
    Banner, BodyError, Decoder, Frame, FrameError, HEADER, LARGEST_FRAME, Message, VERSION, encode, header,
};
use samples::bad::{self, frame_of, long};
use samples::random::Random;

/// A decoder of the newest version.
fn newest(largest: u32) -> Decoder {
    let mut decoder = Decoder::new(largest);
    decoder.set_version(VERSION);
    decoder
}

/// The result of a decoder that is given all bytes at once.
fn read(bytes: &[u8]) -> Result<Option<Frame>, FrameError> {
    let mut decoder = newest(LARGEST_FRAME);
    decoder.push(bytes);
    decoder.frame()
}

/// A frame of the newest version with a correct header and CRC around any body.
fn sealed(kind: u16, body: &[u8]) -> Vec<u8> {
    frame_of(VERSION, kind, body)
}

/// All samples as whole frames.
fn frames() -> Vec<Vec<u8>> {
    let encoded = |sample: samples::Sample| encode(VERSION, sample.channel, &sample.message).expect("it is short");
    samples::all().into_iter().map(encoded).collect()
}

/// All samples as types and bodies.
fn bodies() -> Vec<(u16, Vec<u8>)> {
    let read = |bytes: Vec<u8>| read(&bytes).expect("it is right").expect("it is whole");
    frames().into_iter().map(read).map(|frame| (frame.kind, frame.body)).collect()
}

/// All bad samples, each with the version in which it is wrong.
fn all_bad() -> Vec<(u16, bad::Bad)> {
    let of = |version| bad::of(version).into_iter().map(move |bad| (version, bad));
    samples::VERSIONS.into_iter().flat_map(of).collect()
}

/// Reads any body. If it can be read, then writing and reading it again gives the same. If not, the error is of the
/// right class.
fn read_body(kind: u16, body: &[u8]) -> bool {
    match Message::decode(VERSION, kind, body) {
        Ok(message) => {
            let written = encode(VERSION, 7, &message).expect("it is short");
            let again = read(&written).expect("it is right").expect("it is whole").message().expect("it can be read");
            // The bytes are compared, since NaN differs from itself.
            assert_eq!(encode(VERSION, 7, &again).expect("it is short"), written);
            assert!(written.len() <= HEADER + body.len() + 4, "{kind:#06x} {body:?}");
            true
        }
        Err(BodyError::Malformed { kind: found, reason }) => {
            assert!(found == kind && !reason.is_empty());
            false
        }
        Err(BodyError::TrailingBytes { kind: found, extra }) => {
            assert!(found == kind && (1..=body.len()).contains(&extra));
            Message::decode(VERSION, kind, &body[..body.len() - extra]).expect("the bytes before are a body");
            false
        }
        Err(error) => panic!("{kind:#06x} is known, and its body short: {error}"),
    }
}

#[test]
fn random_bytes_are_no_frames() {
    let mut random = Random::new(1);
    for round in 0..200_000 {
        let count = random.below(64);
        let bytes = random.bytes(count);
        let is_refused = matches!(read(&bytes), Err(FrameError::Malformed(_)));
        assert_eq!(is_refused, count >= HEADER, "round {round}: {bytes:?}");
        let is_banner_begun = b"HOPES\r\n\x1a".starts_with(&bytes);
        let decoded = Banner::decode(&bytes);
        assert_eq!(matches!(decoded, Err(FrameError::Incomplete { .. })), is_banner_begun, "round {round}: {bytes:?}");
        assert!(decoded.is_err(), "round {round}: {bytes:?}");
    }
}

#[test]
fn random_bodies_are_read_or_refused() {
    let mut random = Random::new(2);
    let mut readable = 0;
    for _ in 0..600_000 {
        let &(kind, _) = random.pick(Message::KINDS);
        let count = random.below(80);
        readable += usize::from(read_body(kind, &random.bytes(count)));
    }
    assert!(readable > 100, "only {readable} were readable: random bodies test nothing else");
}

#[test]
fn unknown_types_are_refused_whatever_their_body() {
    let mut random = Random::new(3);
    for kind in 0..=u16::MAX {
        if Message::KINDS.iter().all(|&(known, _)| known != kind) {
            let count = random.below(16);
            assert_eq!(Message::decode(VERSION, kind, &random.bytes(count)), Err(BodyError::UnknownType { kind }));
        }
    }
}

/// Messages that version 1 does not have, and the first version of each.
const LATER: [(u16, u16); 20] = [
    (0x000B, 4),
    (0x000C, 4),
    (0x010D, 4),
    (0x010E, 4),
    (0x010F, 4),
    (0x0110, 4),
    (0x020D, 2),
    (0x020E, 2),
    (0x0210, 4),
    (0x0211, 4),
    (0x0212, 4),
    (0x0213, 4),
    (0x0301, 3),
    (0x0302, 3),
    (0x0303, 3),
    (0x0304, 3),
    (0x0305, 3),
    (0x0306, 3),
    (0x0307, 3),
    (0x0308, 3),
];

#[test]
fn a_version_neither_reads_nor_writes_messages_of_a_later_one() {
    let mut refused = BTreeSet::new();
    for sample in samples::all() {
        let kind = sample.message.kind();
        let unknown = BodyError::UnknownType { kind };
        let Frame { body, .. } = read(&encode(VERSION, 7, &sample.message).expect("it is short"))
            .expect("it is right")
            .expect("it is whole");
        let later = LATER.into_iter().find(|(later, _)| *later == kind);
        assert_eq!(sample.message.since(), later.map_or(1, |(_, since)| since), "{}", sample.name);
        for version in 0..=VERSION + 1 {
            let is_known = version >= sample.message.since();
            let expected = if is_known { Ok(sample.message.clone()) } else { Err(unknown.clone()) };
            assert_eq!(Message::decode(version, kind, &body), expected, "{} in version {version}", sample.name);
            let written = if is_known { Ok(frame_of(version, kind, &body)) } else { Err(unknown.clone()) };
            assert_eq!(encode(version, 7, &sample.message), written, "{} in version {version}", sample.name);
        }
        // The frame is correct. Only its type is unknown.
        for version in samples::VERSIONS {
            let mut decoder = Decoder::new(LARGEST_FRAME);
            decoder.set_version(version);
            decoder.push(&frame_of(version, kind, &body));
            let frame = decoder.frame().expect("the frame is right").expect("it is whole");
            let is_unknown = later.is_some_and(|(_, since)| version < since);
            assert_eq!(frame.message().err(), is_unknown.then(|| unknown.clone()), "{}", sample.name);
        }
        refused.extend(later);
    }
    assert_eq!(refused, BTreeSet::from(LATER), "all of them were tried");
}

#[test]
fn a_frame_says_in_which_version_it_came() {
    for agreed in samples::VERSIONS {
        for found in samples::VERSIONS {
            let mut decoder = Decoder::new(LARGEST_FRAME);
            decoder.set_version(agreed);
            decoder.push(&frame_of(found, 0x0003, &[7]));
            let right = Frame { version: found, channel: 7, kind: 0x0003, body: vec![7] };
            let wrong = FrameError::UnsupportedVersion { found, agreed };
            assert_eq!(decoder.frame(), if found == agreed { Ok(Some(right)) } else { Err(wrong) });
        }
    }
}

/// A daemon refuses a client in version 1 if it has not read the client's banner (SPEC.md, section 1).
#[test]
fn all_supported_versions_are_read_until_one_is_agreed_on() {
    let mut decoder = Decoder::new(LARGEST_FRAME);
    decoder.push(&[frame_of(1, 0x0006, &[13, 0, 0]), frame_of(2, 0x0003, &[7]), frame_of(1, 0x0003, &[7])].concat());
    let mut next = || decoder.frame().map(|frame| frame.expect("it is whole"));
    let refused = hopes_protocol::Report { code: 13, answers: 0, text: String::new() };
    let first = next().expect("it is right");
    assert_eq!((first.version, first.message()), (1, Ok(refused.into())));
    assert_eq!(next().map(|frame| frame.version), Ok(2));
    decoder.set_version(2);
    assert_eq!(decoder.frame(), Err(FrameError::UnsupportedVersion { found: 1, agreed: 2 }));
    for found in [0, VERSION + 1, u16::MAX] {
        let mut decoder = Decoder::new(LARGEST_FRAME);
        decoder.push(&frame_of(found, 0x0003, &[7]));
        assert_eq!(decoder.frame(), Err(FrameError::UnsupportedVersion { found, agreed: VERSION }));
    }
}

#[test]
fn a_body_cut_off_anywhere_is_refused() {
    for (kind, body) in bodies() {
        for length in 0..body.len() {
            let read = Message::decode(VERSION, kind, &body[..length]);
            assert!(matches!(read, Err(BodyError::Malformed { .. })), "{kind:#06x} cut after {length}: {read:?}");
        }
    }
}

#[test]
fn a_body_with_trailing_bytes_is_refused() {
    let mut random = Random::new(4);
    for (kind, body) in bodies() {
        for extra in 1..20 {
            let longer = [body.clone(), random.bytes(extra)].concat();
            assert_eq!(Message::decode(VERSION, kind, &longer), Err(BodyError::TrailingBytes { kind, extra }));
        }
    }
}

/// A body with an error, or by chance another valid body.
fn mutated(random: &mut Random, bodies: &[(u16, Vec<u8>)]) -> (u16, Vec<u8>) {
    let (kind, mut body) = random.pick(bodies).clone();
    for _ in 0..=random.below(3) {
        let at = random.below(body.len() + 1);
        match random.below(5) {
            0 if at < body.len() => body[at] ^= 1 << random.below(8),
            1 => body.truncate(at),
            2 => {
                let (_, other) = random.pick(bodies);
                body.truncate(at);
                body.extend(&other[random.below(other.len() + 1)..]);
            }
            3 => drop(body.splice(at..at, long(1 << random.below(64)))),
            _ => {
                let count = random.below(4);
                let end = (at + random.below(4)).min(body.len());
                drop(body.splice(at..end, random.bytes(count)));
            }
        }
    }
    (kind, body)
}

#[test]
fn mutated_bodies_are_read_or_refused() {
    let (mut random, bodies) = (Random::new(5), bodies());
    let mut readable = 0;
    for _ in 0..400_000 {
        let (kind, body) = mutated(&mut random, &bodies);
        readable += usize::from(read_body(kind, &body));
    }
    assert!((10_000..390_000).contains(&readable), "{readable} were readable: mutations are too weak, or too strong");
}

/// In frames of this size CRC-32C detects any three wrong bits.
#[test]
fn every_flipped_bit_is_detected() {
    let mut random = Random::new(6);
    for frame in frames().into_iter().filter(|frame| frame.len() < 600) {
        for bit in 0..frame.len() * 8 {
            let mut broken = frame.clone();
            for bit in [bit, bit + 1 + random.below(9), random.below(frame.len() * 8)].iter().take(1 + random.below(3))
            {
                broken[(bit / 8) % frame.len()] ^= 1 << (bit % 8);
            }
            if broken != frame {
                assert!(matches!(read(&broken), Err(FrameError::Malformed(_))), "bit {bit} of {frame:?}");
            }
        }
    }
}

#[test]
fn a_frame_cut_off_anywhere_is_incomplete() {
    for bytes in frames() {
        let whole = read(&bytes);
        for length in 0..bytes.len() {
            let mut decoder = newest(LARGEST_FRAME);
            decoder.push(&bytes[..length]);
            assert_eq!((decoder.frame(), decoder.is_within_frame()), (Ok(None), length > 0));
            decoder.push(&bytes[length..]);
            assert_eq!((decoder.frame(), decoder.is_within_frame()), (whole.clone(), false));
        }
    }
}

/// The CRC of a body does not cover the header. So a splice exactly between them is a valid frame, with the header of
/// one frame and the body of the other.
#[test]
fn spliced_frames_are_refused() {
    let (mut random, frames) = (Random::new(7), frames());
    let mut refused = 0;
    for _ in 0..200_000 {
        let (first, second) = (random.pick(&frames), random.pick(&frames));
        let (cut, rest) = (random.below(first.len()), random.below(second.len()));
        let spliced = [&first[..cut], &second[rest..]].concat();
        match read(&spliced) {
            Ok(None) => {
                assert!(spliced.len() < HEADER || spliced[..HEADER] == first[..HEADER], "it waits for the first")
            }
            Ok(Some(frame)) => assert_of_either(&frame, first, second),
            Err(FrameError::Malformed(_)) => refused += 1,
            Err(error) => panic!("the CRC comes first: {error}"),
        }
    }
    assert!(refused > 100_000, "only {refused} were refused");
}

fn assert_of_either(frame: &Frame, first: &[u8], second: &[u8]) {
    let either = [first, second].map(|bytes| read(bytes).expect("it is right").expect("it is whole"));
    let has_header = |of: &Frame| (of.channel, of.kind) == (frame.channel, frame.kind);
    assert!(either.iter().any(has_header), "{frame:?}");
    // Four zero bytes anywhere are the CRC of an empty body, and four bytes of 255 are their own.
    assert!(
        frame.body.is_empty() || frame.body == [255; 4] || either.iter().any(|of| of.body == frame.body),
        "{frame:?}"
    );
}

/// The banner and the frames that a decoder finds in a stream, with their offsets.
fn stream(pieces: &mut dyn Iterator<Item = &[u8]>) -> (Option<Banner>, Vec<(u64, Frame)>) {
    let mut decoder = newest(LARGEST_FRAME);
    let (mut banner, mut frames) = (None, Vec::new());
    for piece in pieces {
        decoder.push(piece);
        if banner.is_none() {
            banner = decoder.banner().expect("it is right");
        }
        let mut at = decoder.offset();
        while let Some(frame) = banner.and_then(|_| decoder.frame().expect("it is right")) {
            frames.push((at, frame));
            at = decoder.offset();
        }
    }
    assert!(!decoder.is_within_frame());
    (banner, frames)
}

/// Cuts a stream into pieces of random sizes up to a largest one.
fn pieces<'a>(bytes: &'a [u8], largest: usize, random: &mut Random) -> Vec<&'a [u8]> {
    let (mut pieces, mut rest) = (Vec::new(), bytes);
    while !rest.is_empty() {
        let (piece, after) = rest.split_at((1 + random.below(largest)).min(rest.len()));
        pieces.push(piece);
        rest = after;
    }
    pieces
}

#[test]
fn pieces_of_any_size_give_the_same_frames() {
    let frames = frames();
    let bytes = [Banner::OURS.encode().to_vec(), frames.concat()].concat();
    let at_once = stream(&mut [&bytes[..]].into_iter());
    let mut offset = Banner::LENGTH;
    for (frame, (at, found)) in frames.iter().zip(&at_once.1) {
        assert_eq!((read(frame), *at), (Ok(Some(found.clone())), offset as u64));
        offset += frame.len();
    }
    assert_eq!((at_once.0, at_once.1.len()), (Some(Banner::OURS), frames.len()));
    assert_eq!(stream(&mut bytes.chunks(1)), at_once, "byte by byte");
    let mut random = Random::new(8);
    for round in 0..120 {
        let largest = 1 << (1 + round % 12);
        let pieces = pieces(&bytes, largest, &mut random);
        assert_eq!(stream(&mut pieces.into_iter()), at_once, "in pieces of up to {largest}");
    }
}

#[test]
fn lengths_are_checked_before_the_body_arrives() {
    let mut random = Random::new(9);
    for _ in 0..100_000 {
        let (length, largest) = (random.word() as u32 >> random.below(32), random.word() as u32 >> random.below(32));
        let mut decoder = newest(largest);
        decoder.push(&header(VERSION, 0x0103, 7, length));
        let expected = if length > largest { Err(FrameError::TooLarge { length, largest }) } else { Ok(None) };
        assert_eq!(decoder.frame(), expected);
    }
}

#[test]
fn frames_of_the_largest_size_are_accepted() {
    let bytes = sealed(0x0103, &[7; 1000]);
    for (largest, is_taken) in [(999, false), (1000, true), (1001, true)] {
        let mut decoder = newest(largest);
        decoder.push(&bytes);
        assert_eq!(matches!(decoder.frame(), Ok(Some(_))), is_taken, "{largest}");
    }
}

#[test]
fn other_versions_are_refused_whatever_their_length() {
    for agreed in [1, 2, 3, 4, 513] {
        for found in (0..1_000).chain([0xFF00, u16::MAX]) {
            let mut decoder = Decoder::new(16);
            decoder.set_version(agreed);
            decoder.push(&header(found, 0x0103, 7, u32::from(found)));
            let version = Err(FrameError::UnsupportedVersion { found, agreed });
            let length = u32::from(found);
            let right = if length > 16 { Err(FrameError::TooLarge { length, largest: 16 }) } else { Ok(None) };
            assert_eq!(decoder.frame(), if found == agreed { right } else { version });
        }
    }
}

#[test]
fn after_an_error_nothing_more_is_read() {
    let is_fatal = |bad: &bad::Bad| ![bad::BODY, bad::INCOMPLETE].contains(&bad.refusal.error.as_str());
    for (version, bad) in all_bad().into_iter().filter(|(_, bad)| is_fatal(bad)) {
        let good = frame_of(version, 0x0003, &[7]);
        let mut decoder = Decoder::new(LARGEST_FRAME);
        decoder.set_version(version);
        decoder.push(&good);
        decoder.push(&bad.bytes);
        assert!(matches!(decoder.frame(), Ok(Some(_))), "what came before is good");
        let error = decoder.frame().expect_err(bad.name);
        decoder.push(&good);
        assert_eq!((decoder.frame(), decoder.offset()), (Err(error), good.len() as u64), "{}", bad.name);
    }
}

#[test]
fn after_an_invalid_body_the_next_frame_is_read() {
    for (version, bad) in all_bad().into_iter().filter(|(_, bad)| bad.refusal.error == bad::BODY) {
        let good = frame_of(version, 0x0003, &[7]);
        let mut decoder = Decoder::new(LARGEST_FRAME);
        decoder.set_version(version);
        decoder.push(&[bad.bytes, good.clone()].concat());
        let frame = decoder.frame().expect("the frame is right").expect("it is whole");
        assert!(frame.message().is_err(), "{}", bad.name);
        let next = decoder.frame().expect("the next is right").expect("it is there");
        assert_eq!(next.message(), Ok(hopes_protocol::Ping { token: 7 }.into()), "{}", bad.name);
    }
}

/// Memory is measured in a process of its own that runs one test, with an allocator that takes large blocks from the
/// system and returns them at once. A counting allocator would need `unsafe`, which this workspace forbids.
#[cfg(target_os = "linux")]
mod memory {
    use std::hint::black_box;
    use std::process::Command;

    use super::*;

    /// The memory allowed for bodies of 1 KiB, in bytes.
    const ALLOWED: usize = 512 << 10;

    #[test]
    fn memory_grows_with_received_bytes_not_with_announced_lengths() {
        let output = Command::new(std::env::current_exe().expect("tests know where they are"))
            .args(["--exact", "memory::peak", "--ignored", "--nocapture", "--test-threads=1"])
            .envs([("MALLOC_MMAP_THRESHOLD_", "65536"), ("MALLOC_ARENA_MAX", "1")])
            .output()
            .expect("it can be run");
        let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.contains("1 passed"), "{said}");
    }

    #[test]
    #[ignore = "run by memory_grows_with_received_bytes_not_with_announced_lengths"]
    fn peak() {
        let bodies = bodies();
        let hostile = hostile(&bodies);
        bodies.iter().for_each(|(kind, body)| assert!(read_body(*kind, body)));
        let before = peak_of_memory();
        for (kind, body) in &hostile {
            let _ = black_box(Message::decode(VERSION, *kind, body));
        }
        for length in [0, 1 << 20, LARGEST_FRAME, u32::MAX] {
            let mut decoder = newest(u32::MAX);
            decoder.push(&header(VERSION, 0x0103, 7, length));
            assert_eq!(black_box(&mut decoder).frame(), Ok(None));
        }
        let grown = peak_of_memory() - before;
        assert!(grown <= ALLOWED, "{grown} bytes for bodies of 1 KiB");
        for (kind, before) in [(0x0007, &[][..]), (0x0103, &[1])] {
            let mut body = [before, &long(1 << 36)].concat();
            body.resize(16 << 20, 7);
            let before = peak_of_memory();
            assert!(black_box(Message::decode(VERSION, kind, &body)).is_err());
            let grown = peak_of_memory() - before;
            assert!(grown <= ALLOWED, "{grown} bytes for a body of 16 MiB that announces 64 GiB");
        }
        let before = peak_of_memory();
        drop(black_box(Vec::<u8>::with_capacity(64 << 20)));
        let seen = peak_of_memory() - before;
        assert!(seen >= 32 << 20, "what is taken must be seen, but only {seen} bytes were");
    }

    /// Bodies of 1 KiB with a huge length at every position.
    fn hostile(bodies: &[(u16, Vec<u8>)]) -> Vec<(u16, Vec<u8>)> {
        let mut hostile = Vec::new();
        for (kind, body) in bodies {
            for at in 0..=body.len().min(200) {
                for length in [1 << 60, u64::MAX, u64::MAX / 16 + 2, 1 << 32, 1 << 24, 100_000, 60_000] {
                    let mut bytes = [&body[..at], &long(length), &[0; 1024]].concat();
                    bytes.truncate(1024);
                    hostile.push((*kind, bytes));
                }
            }
        }
        hostile
    }

    /// The peak of this process's virtual memory in bytes.
    fn peak_of_memory() -> usize {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux has it");
        let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:")).expect("it has this line");
        line.trim().trim_end_matches(" kB").parse::<usize>().expect("a number of KiB") * 1024
    }
}
