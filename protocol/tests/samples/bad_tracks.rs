//! Bytes that must give an error if version 2 was agreed on: the samples of `vectors/v2/bad`.
//!
//! In: nothing. Out: bytes with the class of their error. Invariants and what it must not know: as in `bad`, whose
//! samples, except those about versions, are wrong in version 2 too.

use hopes_protocol::{Message, Ping, encode};

use super::bad::{BODY, Bad, VERSION, bad, frame_of, long};

/// All samples.
pub fn all() -> Vec<Bad> {
    [versions(), ends(), hostile_lengths(), cases(), numbers()].into_iter().flatten().collect()
}

fn want(body: &[u8]) -> Vec<u8> {
    frame_of(2, 0x020D, body)
}

/// Tracks of stream 4 from frame 11 to frame 12, which has no time.
fn tracks(rest: &[&[u8]]) -> Vec<u8> {
    frame_of(2, 0x020E, &[&[4, 11, 12, 0], &rest.concat()[..]].concat())
}

/// A track of zeros, and whether it is selected.
fn track(selected: u8) -> Vec<u8> {
    [&[1, 1][..], &[0; 64], &[selected]].concat()
}

/// The end of a message with one event of frame 12: no list of living tracks, and no cycles.
const NOTHING_MORE: &[u8] = &[0, 0];

fn versions() -> Vec<Bad> {
    let ping = |version| encode(version, 0, &Message::from(Ping { token: 65_536 })).expect("it is short");
    vec![
        bad("version_1", VERSION, "version 1, where 2 was agreed on", ping(1)),
        bad("version_3", VERSION, "version 3, where 2 was agreed on", ping(3)),
        bad("version_513", VERSION, "version 513, whose high byte is 2", ping(513)),
    ]
}

fn ends() -> Vec<Bad> {
    let track = track(1);
    vec![
        bad("unknown_type", BODY, "type 0x020F, which no message has", frame_of(2, 0x020F, &[])),
        bad("empty_want", BODY, "WantTracks without its choice", want(&[])),
        bad("trailing_byte", BODY, "WantTracks, and a byte after its last field", want(&[1, 0])),
        bad("trailing_tracks", BODY, "Tracks, and a byte after its last field", tracks(&[&[0], NOTHING_MORE, &[0]])),
        bad("no_cycles", BODY, "Tracks that end before their cycles", tracks(&[&[0, 0]])),
        bad(
            "short_track",
            BODY,
            "Tracks that end within the track of an event",
            tracks(&[&[1, 12, 0, 0], &track[..track.len() - 1]]),
        ),
        bad("short_list", BODY, "Tracks that say two living tracks and have one", tracks(&[&[0, 1, 2], &track, &[0]])),
        bad(
            "short_walk",
            BODY,
            "Tracks with a walk that says 3 vertices and has 2",
            tracks(&[&[0, 0, 1, 7, 1, 3, 1, 2]]),
        ),
    ]
}

fn hostile_lengths() -> Vec<Bad> {
    let huge = long(1 << 60);
    vec![
        bad("huge_events", BODY, "Tracks with 2^60 events", tracks(&[&huge])),
        bad("huge_alive", BODY, "Tracks with 2^60 living tracks", tracks(&[&[0, 1], &huge])),
        bad("huge_cycles", BODY, "Tracks with 2^60 cycles", tracks(&[&[0, 0], &huge])),
        bad("huge_walks", BODY, "Tracks with a cycle of 2^60 walks", tracks(&[&[0, 0, 1, 7], &huge])),
        bad(
            "huge_walks_of_nothing",
            BODY,
            "Tracks with a cycle of 2^60 walks, the first of which are empty",
            tracks(&[&[0, 0, 1, 7], &huge, &[0; 64]]),
        ),
        bad("huge_walk", BODY, "Tracks with a walk of 2^60 vertices", tracks(&[&[0, 0, 1, 7, 1], &huge, &[1; 64]])),
    ]
}

fn cases() -> Vec<Bad> {
    let event = |happening: &[u8], selected| tracks(&[&[1, 12, 0], happening, &track(selected), NOTHING_MORE]);
    vec![
        bad("unknown_tracks", BODY, "WantTracks with case 4 of TracksWanted", want(&[4])),
        bad("unknown_tracks_256", BODY, "WantTracks with case 256 of TracksWanted", want(&[251, 0, 1])),
        bad("unknown_happening", BODY, "Tracks with case 7 of Happening", event(&[7], 1)),
        bad(
            "bool_2_of_changes",
            BODY,
            "Tracks with a track whose death has changed by a bool of 2",
            event(&[2, 0, 1, 2], 1),
        ),
        bad("bool_2_of_track", BODY, "Tracks with a track whose `selected` is 2", event(&[0], 2)),
        bad("option_2", BODY, "Tracks whose option of living tracks is 2", tracks(&[&[0, 2, 0, 0]])),
    ]
}

fn numbers() -> Vec<Bad> {
    let mark = |case: u8| [&[case, 254][..], &[0; 16], &track(1), NOTHING_MORE].concat();
    vec![
        bad("number_mark_254", BODY, "Tracks split from a number with the mark 254", tracks(&[&[1, 12, 0], &mark(1)])),
        bad("merged_mark_254", BODY, "Tracks merged into a number with the mark 254", tracks(&[&[1, 12, 0], &mark(5)])),
        bad(
            "number_u32_small_in_8_bytes",
            BODY,
            "Tracks whose stream, an u32, is 4 with the mark of 8 bytes",
            frame_of(2, 0x020E, &[&long(4)[..], &[11, 12, 0, 0, 0, 0]].concat()),
        ),
    ]
}
