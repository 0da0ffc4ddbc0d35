//! Bytes that must give an error: the samples of `vectors/v1/bad` and of the `bad` folders of later versions.
//!
//! In: a version. Out: bytes with the class of their error.
//!
//! Invariants: each sample has one error, unless its text says otherwise. It is read with this version agreed on and a
//! limit of [`LARGEST_FRAME`](hopes_protocol::LARGEST_FRAME).
//!
//! Must not know: how they are read.

use hopes_protocol::{Banner, HEADER, LARGEST_FRAME, Message, Ping, encode, header};
use serde::{Deserialize, Serialize};

/// The content of the JSON file of a bad vector.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    pub error: String,
    pub why: String,
}

pub struct Bad {
    pub name: &'static str,
    pub refusal: Refusal,
    pub bytes: Vec<u8>,
}

pub const MALFORMED: &str = "malformed";
pub const VERSION: &str = "unsupported version";
pub const TOO_LARGE: &str = "too large";
pub const INCOMPLETE: &str = "incomplete";
pub const BODY: &str = "body";

/// The samples that are wrong in a version.
pub fn of(version: u16) -> Vec<Bad> {
    match version {
        1 => [malformed(), versions(), lengths(), incomplete(), ends(), hostile_lengths(), cases(), numbers(), texts()]
            .into_iter()
            .flatten()
            .collect(),
        2 => super::bad_tracks::all(),
        3 => super::bad_admin::all(),
        4 => super::bad_spaces::all(),
        version => panic!("version {version} has no samples"),
    }
}

pub fn bad(name: &'static str, error: &str, why: &str, bytes: Vec<u8>) -> Bad {
    Bad { name, refusal: Refusal { error: error.into(), why: why.into() }, bytes }
}

/// A frame of version 1 with a correct header and CRC around any body.
pub fn frame(kind: u16, body: &[u8]) -> Vec<u8> {
    frame_of(1, kind, body)
}

/// The same in another version.
pub fn frame_of(version: u16, kind: u16, body: &[u8]) -> Vec<u8> {
    let header = header(version, kind, 7, u32::try_from(body.len()).expect("it is short"));
    [&header, body, &crc32c(body).to_le_bytes()].concat()
}

/// The CRC-32C by SPEC.md, bit by bit.
pub fn crc32c(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { (crc >> 1) ^ 0x82F6_3B78 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

/// A number with the mark of eight bytes.
pub fn long(number: u64) -> Vec<u8> {
    [&[253], &number.to_le_bytes()[..]].concat()
}

fn ping() -> Vec<u8> {
    encode(1, 0, &Message::from(Ping { token: 65_536 })).expect("it is short")
}

/// A ping with one byte of its header changed and the header's CRC corrected.
fn ping_with(at: usize, byte: u8) -> Vec<u8> {
    let mut bytes = ping();
    bytes[at] = byte;
    let crc = crc32c(&bytes[..16]);
    bytes[16..HEADER].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// A ping with one bit flipped.
fn ping_flipped(at: usize) -> Vec<u8> {
    let mut bytes = ping();
    bytes[at] ^= 0x10;
    bytes
}

fn malformed() -> Vec<Bad> {
    let banner = Banner { lowest: 1, highest: 1 }.encode().to_vec();
    let last = ping().len() - 1;
    vec![
        bad("wrong_magic", MALFORMED, "the magic is hopG, with a CRC that fits", ping_with(3, b'G')),
        bad("wrong_magic_case", MALFORMED, "the magic is hopf, with a CRC that fits", ping_with(3, b'f')),
        bad("second_banner", MALFORMED, "a banner where a frame is due", banner),
        bad("wrong_header_crc", MALFORMED, "a bit of the header's CRC is wrong", ping_flipped(16)),
        bad("wrong_type", MALFORMED, "a bit of the type is wrong, the header's CRC tells", ping_flipped(6)),
        bad("wrong_channel", MALFORMED, "a bit of the channel is wrong, the header's CRC tells", ping_flipped(8)),
        bad("wrong_length", MALFORMED, "a bit of the length is wrong, the header's CRC tells", ping_flipped(12)),
        bad("wrong_body", MALFORMED, "a bit of the body is wrong, its CRC tells", ping_flipped(HEADER)),
        bad("wrong_body_crc", MALFORMED, "a bit of the body's CRC is wrong", ping_flipped(last)),
        bad("zeros", MALFORMED, "a header of zeros: its CRC is not zero, and it has no magic", vec![0; 24]),
    ]
}

fn versions() -> Vec<Bad> {
    let header_alone = ping_with(4, 2)[..HEADER].to_vec();
    vec![
        bad("version_0", VERSION, "version 0, which there is not", ping_with(4, 0)),
        bad("version_2", VERSION, "version 2, where 1 was agreed on", ping_with(4, 2)),
        bad("version_257", VERSION, "version 257, whose low byte is 1", ping_with(5, 1)),
        bad("version_2_header", VERSION, "version 2: known from the header alone", header_alone),
    ]
}

fn lengths() -> Vec<Bad> {
    let announced = |length| header(1, 0x0103, 7, length).to_vec();
    vec![
        bad("too_large", TOO_LARGE, "a body of 2^30 + 1 bytes, the cap being 2^30", announced(LARGEST_FRAME + 1)),
        bad("too_large_4294967295", TOO_LARGE, "the longest body that a header can announce", announced(u32::MAX)),
    ]
}

fn incomplete() -> Vec<Bad> {
    let cut = |by: usize| ping()[..ping().len() - by].to_vec();
    let largest = header(1, 0x0103, 7, LARGEST_FRAME).to_vec();
    vec![
        bad("cut_magic", INCOMPLETE, "two bytes of the magic", ping()[..2].to_vec()),
        bad("cut_header", INCOMPLETE, "a byte of the header is missing", ping()[..HEADER - 1].to_vec()),
        bad("cut_after_header", INCOMPLETE, "the header alone", ping()[..HEADER].to_vec()),
        bad("cut_body", INCOMPLETE, "the body's last byte and its CRC are missing", cut(5)),
        bad("cut_before_crc", INCOMPLETE, "the body's CRC is missing", cut(4)),
        bad("cut_crc", INCOMPLETE, "the last byte is missing", cut(1)),
        bad("cut_largest", INCOMPLETE, "the header of a body of 2^30 bytes, which is the cap", largest),
    ]
}

fn ends() -> Vec<Bad> {
    let one_of_two = [&[1, 2][..], &[0; 16], &[0, 0]].concat();
    vec![
        bad("unknown_type_0", BODY, "type 0, which no message has", frame(0, &[])),
        bad("unknown_type", BODY, "type 0x010C, which no message has", frame(0x010C, &[])),
        bad("trailing_byte", BODY, "Ping, and a byte after its last field", frame(0x0003, &[1, 0])),
        bad("trailing_byte_of_nothing", BODY, "GetStatus has no fields, but a byte comes", frame(0x0009, &[0])),
        bad("empty_body", BODY, "Ping without its token", frame(0x0003, &[])),
        bad(
            "short_number",
            BODY,
            "Ping whose token has the mark of 8 bytes and 7 of them",
            frame(0x0003, &long(9)[..8]),
        ),
        bad(
            "short_list",
            BODY,
            "Batch that says two points and has one, and its other lists",
            frame(0x0103, &one_of_two),
        ),
        bad("short_float", BODY, "Commit whose time has 7 bytes", frame(0x0105, &[1, 1, 0, 0, 0, 0, 0, 0, 0])),
        bad("short_text", BODY, "ListStreams whose pattern says 3 bytes and has 2", frame(0x0007, b"\x03ab")),
    ]
}

fn hostile_lengths() -> Vec<Bad> {
    let batch = |length| frame(0x0103, &[&[1][..], &long(length), &[0; 64]].concat());
    let diff = [&[4, 11, 12, 0, 8, 5, 0, 0, 0, 0, 0, 1, 1][..], &long(1 << 60)].concat();
    vec![
        bad("huge_list", BODY, "Batch of 2^60 points", batch(1 << 60)),
        bad("huge_list_18446744073709551615", BODY, "Batch of 2^64 - 1 points", batch(u64::MAX)),
        bad(
            "huge_list_wraps",
            BODY,
            "Batch of 2^60 + 1 points: times 16 bytes that is 16, modulo 2^64",
            batch((1 << 60) + 1),
        ),
        bad("huge_list_of_diff", BODY, "Diff with 2^60 new vertices", frame(0x0207, &diff)),
        bad(
            "huge_list_of_texts",
            BODY,
            "Hello with 2^60 capabilities",
            frame(0x0001, &[&[0][..], &long(1 << 60)].concat()),
        ),
        bad("huge_text", BODY, "ListStreams whose pattern has 2^60 bytes", frame(0x0007, &long(1 << 60))),
        bad(
            "huge_text_4294967295",
            BODY,
            "ListStreams whose pattern has 2^32 - 1 bytes",
            frame(0x0007, &[252, 255, 255, 255, 255]),
        ),
    ]
}

fn cases() -> Vec<Bad> {
    vec![
        bad("unknown_window", BODY, "Open with case 4 of Window", frame(0x0101, &[1, b'a', 1, 4, 1, 0])),
        bad("unknown_cut", BODY, "ChangeView with case 3 of Cut", frame(0x0202, &[3, 0, 0])),
        bad("unknown_simplify", BODY, "ChangeView with case 3 of Simplify", frame(0x0202, &[0, 3, 0])),
        bad("unknown_dots", BODY, "ChangeView with case 3 of DotsWanted", frame(0x0202, &[0, 0, 3])),
        bad("unknown_policy", BODY, "Overloaded with case 2 of Policy", frame(0x010B, &[1, 2, 3, 2])),
        bad("unknown_policy_256", BODY, "Overloaded with case 256 of Policy", frame(0x010B, &[1, 2, 3, 251, 0, 1])),
        bad(
            "unknown_cause",
            BODY,
            "Snapshot with case 4 of Cause",
            frame(0x0206, &[4, 4, 11, 0, 8, 5, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0]),
        ),
        bad("bool_2", BODY, "Close whose bool is 2", frame(0x0106, &[2])),
        bad("option_2", BODY, "Commit whose option is 2", frame(0x0105, &[1, 2, 0, 0, 0, 0, 0, 0, 0, 0])),
    ]
}

fn numbers() -> Vec<Bad> {
    let batch_length_as_16_bytes = [&[1, 254][..], &[0; 16], &[0, 0]].concat();
    vec![
        bad(
            "number_mark_254",
            BODY,
            "Ping whose token has the mark 254, which version 1 has not",
            frame(0x0003, &[&[254][..], &[0; 16]].concat()),
        ),
        bad(
            "number_mark_255",
            BODY,
            "Ping whose token has the mark 255, which version 1 has not",
            frame(0x0003, &[&[255][..], &[0; 16]].concat()),
        ),
        bad(
            "length_mark_254",
            BODY,
            "Batch whose number of points has the mark 254",
            frame(0x0103, &batch_length_as_16_bytes),
        ),
        bad(
            "number_u32_in_8_bytes",
            BODY,
            "Heartbeat whose stream, an u32, has the mark of 8 bytes",
            frame(0x0209, &[long(1 << 32), vec![0]].concat()),
        ),
        bad(
            "number_u16_small_in_4_bytes",
            BODY,
            "Error whose code, an u16, is 7 with the mark of 4 bytes",
            frame(0x0006, &[252, 7, 0, 0, 0, 0, 0]),
        ),
        bad(
            "number_u32_small_in_8_bytes",
            BODY,
            "Heartbeat whose stream, an u32, is 7 with the mark of 8 bytes",
            frame(0x0209, &[long(7), vec![0]].concat()),
        ),
        bad(
            "number_u16_in_4_bytes",
            BODY,
            "Error whose code, an u16, has the mark of 4 bytes",
            frame(0x0006, &[252, 0, 0, 1, 0, 0, 0]),
        ),
    ]
}

fn texts() -> Vec<Bad> {
    let list = |text: &[u8]| frame(0x0007, &[&[text.len() as u8], text].concat());
    vec![
        bad("text_invalid", BODY, "ListStreams whose pattern has bytes that UTF-8 never has", list(b"\xff\xfe")),
        bad("text_overlong", BODY, "ListStreams whose pattern has a slash in two bytes", list(b"a\xc0\xafb")),
        bad("text_surrogate", BODY, "ListStreams whose pattern has half a surrogate pair", list(b"\xed\xa0\x80")),
        bad("text_cut", BODY, "ListStreams whose pattern ends within a character", list(b"ab\xe2\x82")),
    ]
}
