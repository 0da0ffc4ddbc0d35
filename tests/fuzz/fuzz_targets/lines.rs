//! Points as text and as JSON lines, and lines of tracks: however the source cuts its bytes, the same is read and the
//! same is refused, and every line and byte is counted.
//!
//! The input: a byte for the format, columns and the limit of a line; four lengths of pieces; the text.
#![no_main]

use std::io::Read;

use hopes_fuzz::formats::input::{Columns, Format, Limits, Reader, Record};
use hopes_fuzz::formats::tracks::reader::TrackLines;
use hopes_fuzz::pieces::Pieces;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Some((options, data)) = data.split_first() else { return };
    let Some((pieces, text)) = Pieces::of(data) else { return };
    match options % 3 {
        0 => points(*options, pieces, text, Format::Text),
        1 => points(*options, pieces, text, Format::JsonLines),
        _ => tracks(pieces, text),
    }
});

fn points(options: u8, pieces: Pieces<'_>, text: &[u8], format: Format) {
    let columns = ["", "1,2", "2,1,3", "x,y", "lon,lat,1"][usize::from(options / 3 % 5)];
    let columns = match columns {
        "" => Columns::default().with_times(true),
        chosen => chosen.parse().expect("these are columns"),
    };
    let limits = if options < 128 { Limits::default() } else { Limits { line_bytes: 16 } };
    let reads = pieces.reads();
    let at_once = trace(Reader::new(text, format, columns.clone(), limits), text, || 0);
    let in_pieces = trace(Reader::new(pieces, format, columns, limits), text, || reads.get());
    assert_eq!(at_once, in_pieces);
}

/// All that a reader says.
fn trace(mut reader: Reader<impl Read>, text: &[u8], reads: impl Fn() -> usize) -> Vec<String> {
    let mut said = Vec::new();
    loop {
        let (is_ready, before, line) = (reader.is_ready(), reads(), reader.next_line());
        let record = reader.next_record();
        let record = match record {
            Ok(Some(record)) => say(&record),
            Ok(None) => break,
            Err(error) => {
                said.push(error.to_string());
                return said;
            }
        };
        assert!(!is_ready || reads() == before, "a line that has arrived is not held back");
        said.push(format!("{line} to byte {}: {record}", reader.bytes_read()));
    }
    assert_eq!((reader.next_line(), reader.bytes_read()), (1 + lines(text), text.len() as u64));
    said
}

/// Lines that end with `\n`, `\r\n`, `\r` or the text.
fn lines(text: &[u8]) -> u64 {
    let is_end = |&byte: &u8| matches!(byte, b'\n' | b'\r');
    let pairs = text.windows(2).filter(|pair| *pair == b"\r\n").count();
    let open = text.last().is_some_and(|last| !is_end(last));
    (text.iter().filter(|byte| is_end(byte)).count() - pairs + usize::from(open)) as u64
}

fn say(record: &Record<'_>) -> String {
    match record {
        Record::Bad(bad) => {
            let bad = bad.to_string();
            assert!(bad.chars().count() < 300 && !bad.chars().any(char::is_control), "{bad:?}");
            bad
        }
        record => format!("{record:?}"),
    }
}

fn tracks(pieces: Pieces<'_>, text: &[u8]) {
    assert_eq!(track_lines(text), track_lines(pieces));
}

fn track_lines(source: impl Read) -> Vec<String> {
    let (mut lines, mut said) = (TrackLines::new(source), Vec::new());
    while let Some(line) = lines.next().expect("the source does not fail") {
        said.push(match line.content {
            Ok(content) => format!("{}: {content:?}", line.number),
            Err(fault) => {
                let fault = fault.to_string();
                assert!(fault.chars().count() < 300 && !fault.chars().any(char::is_control), "{fault:?}");
                fault
            }
        });
    }
    said
}
