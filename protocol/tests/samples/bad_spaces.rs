//! Bytes that must give an error if version 4 was agreed on: the samples of `vectors/v4/bad`.
//!
//! In: nothing. Out: bytes with the class of their error. Invariants and what it must not know: as in `bad`, whose
//! samples, except those about versions, are wrong in version 4 too.

use hopes_protocol::{Message, Ping, encode};

use super::bad::{BODY, Bad, VERSION, bad, frame_of, long};

/// All samples.
pub fn all() -> Vec<Bad> {
    [versions(), ends(), hostile_lengths(), cases(), numbers()].into_iter().flatten().collect()
}

/// A frame's fields with small numbers, and no option.
const FRAME: [u8; 11] = [12, 0, 8, 5, 0, 0, 0, 0, 0, 1, 1];

/// Batch 1 of points with 3 coordinates.
fn batch(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(4, 0x010F, &[&[1, 3], &rest.concat()[..]].concat())
}

/// A snapshot in R^3 of a metric, up to its dimension.
fn snapshot(metric: &[u8], rest: &[&[u8]]) -> Vec<u8> {
    frame_of(4, 0x0210, &[&[4, 0], &FRAME[..], metric, &[3], &rest.concat()].concat())
}

/// A diff in R^3 from frame 11.
fn diff(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(4, 0x0211, &[&[4, 11], &FRAME[..], &[3], &rest.concat()].concat())
}

/// Dots of frame 12, one in all.
fn dots(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(4, 0x0212, &[&[4, 12, 1], &rest.concat()[..]].concat())
}

/// Tracks from frame 11 to frame 12, which has no time.
fn tracks(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(4, 0x0213, &[&[4, 11, 12, 0], &rest.concat()[..]].concat())
}

fn versions() -> Vec<Bad> {
    let ping = |version| encode(version, 0, &Message::from(Ping { token: 65_536 })).expect("it is short");
    vec![
        bad("version_1", VERSION, "version 1, where 4 was agreed on", ping(1)),
        bad("version_2", VERSION, "version 2, where 4 was agreed on", ping(2)),
        bad("version_3", VERSION, "version 3, where 4 was agreed on", ping(3)),
        bad("version_5", VERSION, "version 5, where 4 was agreed on", ping(5)),
        bad("version_1025", VERSION, "version 1025, whose high byte is 4", ping(1025)),
    ]
}

fn ends() -> Vec<Bad> {
    vec![
        bad("unknown_type", BODY, "type 0x0309, which no message has", frame_of(4, 0x0309, &[])),
        bad("unknown_type_010c", BODY, "type 0x010C, which no message has", frame_of(4, 0x010C, &[])),
        bad("unknown_type_020f", BODY, "type 0x020F, which no message has", frame_of(4, 0x020F, &[])),
        bad("trailing_list", BODY, "ListSpaces has no fields, but a byte comes", frame_of(4, 0x000B, &[0])),
        bad("short_spaces", BODY, "Spaces that say two streams and have one", frame_of(4, 0x000C, &[2, 4, 0, 0])),
        bad("no_dimension", BODY, "OpenSpace without its dimension", frame_of(4, 0x010D, b"\x01a\0\0\0")),
        bad("no_room", BODY, "SpaceOpened without its largest number of positions", {
            frame_of(4, 0x010E, &[4, 7, 1, 0, 0, 0, 9, 0, 0])
        }),
        bad("short_coordinates", BODY, "SpaceBatch that says two coordinates and has one", {
            batch(&[&[2], &[0; 8], &[0, 0]])
        }),
        bad("no_tags", BODY, "SpaceBatch that ends before its tags", batch(&[&[0, 0]])),
        bad("trailing_batch", BODY, "SpaceBatch, and a byte after its last field", batch(&[&[0, 0, 0, 0]])),
        bad("no_coordinates", BODY, "SpaceRetract without its coordinates", frame_of(4, 0x0110, &[1, 3])),
        bad("short_snapshot", BODY, "SpaceSnapshot without its checksum", snapshot(&[0], &[&[0, 0, 0, 0]])),
        bad("short_diff", BODY, "SpaceDiff without its checksum", diff(&[&[0; 7]])),
        bad("short_dot", BODY, "SpaceDots that end within a dot", dots(&[&[1, 1, 2], &[0; 8], &[0]])),
        bad("short_center", BODY, "SpaceTracks whose track ends within its centre", {
            tracks(&[&[0, 1, 1, 1, 1], &[0; 8], &[0, 3], &[0; 16]])
        }),
    ]
}

fn hostile_lengths() -> Vec<Bad> {
    let huge = long(1 << 60);
    let track = [&[1, 1][..], &[0; 8], &[0]].concat();
    vec![
        bad("huge_spaces", BODY, "Spaces with 2^60 streams", frame_of(4, 0x000C, &huge)),
        bad("huge_batch", BODY, "SpaceBatch of 2^60 coordinates", batch(&[&huge, &[0; 64]])),
        bad("huge_batch_18446744073709551615", BODY, "SpaceBatch of 2^64 - 1 coordinates", batch(&[&long(u64::MAX)])),
        bad("huge_times", BODY, "SpaceBatch of 2^60 times", batch(&[&[0], &huge, &[0; 64]])),
        bad("huge_ids", BODY, "SpaceSnapshot of 2^60 ids", snapshot(&[0], &[&huge, &[1; 64]])),
        bad("huge_coordinates", BODY, "SpaceSnapshot of 2^60 coordinates", snapshot(&[0], &[&[0], &huge, &[0; 64]])),
        bad("huge_diff", BODY, "SpaceDiff of 2^60 coordinates", diff(&[&[0], &huge, &[0; 64]])),
        bad("huge_dots", BODY, "SpaceDots with 2^60 dots", dots(&[&huge, &[0; 64]])),
        bad("huge_center", BODY, "SpaceTracks with a centre of 2^60 coordinates", {
            tracks(&[&[0, 1, 1], &track, &huge, &[0; 64]])
        }),
        bad("huge_velocity", BODY, "SpaceTracks with a velocity of 2^60 coordinates", {
            tracks(&[&[0, 1, 1], &track, &[0], &[0; 8], &huge, &[0; 64]])
        }),
    ]
}

fn cases() -> Vec<Bad> {
    let empty = &[0; 5][..];
    vec![
        bad("unknown_metric", BODY, "SpaceSnapshot with case 5 of Metric", snapshot(&[5], &[empty])),
        bad("unknown_metric_256", BODY, "SpaceSnapshot with case 256 of Metric", snapshot(&[251, 0, 1], &[empty])),
        bad("unknown_metric_of_open", BODY, "OpenSpace with case 5 of Metric", {
            frame_of(4, 0x010D, b"\x01a\0\0\x01\x05\0")
        }),
        bad("option_2", BODY, "OpenSpace whose option of a dimension is 2", frame_of(4, 0x010D, b"\x01a\0\0\0\x02")),
        bad("option_2_of_dot", BODY, "SpaceDots whose dot has an option of a death of 2", {
            dots(&[&[1, 1, 2], &[0; 8], &[2, 0]])
        }),
        bad("bool_2_of_track", BODY, "SpaceTracks with a track whose `selected` is 2", {
            tracks(&[&[0, 1, 1, 1, 1], &[0; 8], &[0, 0], &[0; 8], &[0, 2, 0]])
        }),
    ]
}

fn numbers() -> Vec<Bad> {
    let small = long(3);
    vec![
        bad("number_mark_254", BODY, "SpaceBatch whose dimension has the mark 254", {
            frame_of(4, 0x010F, &[&[1, 254][..], &[0; 16], &[0, 0, 0]].concat())
        }),
        bad(
            "number_u32_small_in_8_bytes",
            BODY,
            "SpaceBatch whose dimension, an u32, is 3 with the mark of 8 bytes",
            frame_of(4, 0x010F, &[&[1][..], &small, &[0, 0, 0]].concat()),
        ),
    ]
}
