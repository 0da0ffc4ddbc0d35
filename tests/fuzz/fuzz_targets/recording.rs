//! Recordings, and points in the bytes of the protocol: however the bytes are cut, the same messages are read. Each of
//! them is written in every form, and what was written for programs can be read.
//!
//! The input: a byte for options, four lengths of pieces, the file.
#![no_main]

use std::io::Read;
use std::time::Duration;

use hopes_fuzz::formats::messages::{MessageForm, MessageWriter};
use hopes_fuzz::formats::recording::{Frames, Next, RecordingError};
use hopes_fuzz::pieces::Pieces;
use hopes_fuzz::view::snapshot::Format;
use hopes_fuzz::wire::mended;
use hopes_protocol::{Elapsed, FILE_VERSION, Message};
use libfuzzer_sys::fuzz_target;
use serde::de::IgnoredAny;

/// A message, where it began, and its channel.
type Placed = (u64, u32, Message);

fuzz_target!(|data: &[u8]| {
    let Some((options, data)) = data.split_first() else { return };
    let Some((pieces, bytes)) = Pieces::of(data) else { return };
    let bytes = if options & 1 == 0 { mended(bytes) } else { bytes.to_vec() };
    let (mut messages, end) = read(&bytes[..]);
    let (in_pieces, its_end) = read(pieces.over(&bytes));
    // Not the messages: NaN differs from itself.
    assert_eq!((format!("{messages:?}"), &end), (format!("{in_pieces:?}"), &its_end));
    // Administration is later than the version of files, and has no place in one.
    messages.retain(|(.., message)| message.since() <= FILE_VERSION);
    write_text(&messages);
    write_json(&messages);
    write_recording(&messages);
});

/// All messages, and how the file ends.
fn read(source: impl Read) -> (Vec<Placed>, String) {
    let (mut frames, mut messages) = (Frames::new(source), Vec::new());
    loop {
        match frames.next() {
            Ok(Next::Message { offset, channel, message, .. }) => messages.push((offset, channel, message)),
            Ok(end @ (Next::CutOff { .. } | Next::End)) => return (messages, format!("{end:?} {}", frames.offset())),
            Err(RecordingError::Io { source, .. }) => panic!("the source does not fail: {source}"),
            Err(error) => return (messages, format!("{error:?}")),
        }
    }
}

fn written(form: MessageForm, messages: &[Placed]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = MessageWriter::new(form, &mut bytes);
    // A recording is held until its first frame, if it may not be mixed.
    if !messages.iter().any(|(.., message)| message.frame().is_some()) {
        writer.set_mixed();
    }
    for (_, channel, message) in messages {
        writer.write("cam", Duration::from_nanos(7), *channel, message).expect("memory takes it");
    }
    drop(writer);
    bytes
}

/// What a peer has named is printable.
fn write_text(messages: &[Placed]) {
    for form in [MessageForm::Text, MessageForm::Events] {
        let text = String::from_utf8(written(form, messages)).expect("it is text");
        assert!(text.chars().all(|character| character == '\n' || !character.is_control()), "{text:?}");
    }
}

fn write_json(messages: &[Placed]) {
    let lines = written(MessageForm::Jsonl, messages);
    for line in lines.split_inclusive(|&byte| byte == b'\n') {
        serde_json::from_slice::<IgnoredAny>(line).expect("a line is JSON");
    }
    for (.., message) in messages {
        if !matches!(message, Message::Snapshot(_)) {
            continue;
        }
        let [json, geojson, svg] = [Format::Json, Format::GeoJson, Format::Svg].map(|format| {
            assert!(!format.media_type().is_empty());
            format.write("a <b>&\"'", message).expect("it has a form for everything")
        });
        serde_json::from_slice::<IgnoredAny>(&json).expect("it is JSON");
        serde_json::from_slice::<IgnoredAny>(&geojson).expect("it is JSON");
        assert!(svg.starts_with(b"<svg") && svg.is_ascii(), "{}", String::from_utf8_lossy(&svg));
    }
}

/// A recording of the messages is read as the same, each behind its time.
fn write_recording(messages: &[Placed]) {
    if messages.is_empty() {
        // The banner comes with the first message.
        return;
    }
    let (again, end) = read(&written(MessageForm::Bin, messages)[..]);
    assert!(end.starts_with("End"), "{end}");
    let told = |messages: &mut dyn Iterator<Item = &Placed>| -> Vec<String> {
        messages.map(|(_, channel, message)| format!("{channel} {message:?}")).collect()
    };
    let times = again.iter().step_by(2).all(|(.., message)| *message == Elapsed { nanoseconds: 7 }.into());
    assert!(times && told(&mut again.iter().skip(1).step_by(2)) == told(&mut messages.iter()), "{again:?}");
}
