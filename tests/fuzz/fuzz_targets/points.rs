//! Points as `serve` and `feed` take them, in every form: the same points, frames and errors come out however the
//! source cuts its bytes, and however many points a batch takes.
//!
//! The input: a byte for the form, a byte for frames and batches, four lengths of pieces, the bytes.
#![no_main]

use std::cell::RefCell;
use std::io::{Cursor, Read};

use hopes_fuzz::daemon::{Batch, Input};
use hopes_fuzz::formats::input::{Columns, Format};
use hopes_fuzz::formats::points::{Form, Origin, PointSource};
use hopes_fuzz::pieces::Pieces;
use hopes_fuzz::wire::mended;
use libfuzzer_sys::fuzz_target;

thread_local! {
    /// What the next source reads, in pieces.
    static SOURCE: RefCell<Vec<Vec<u8>>> = const { RefCell::new(Vec::new()) };
}

fuzz_target!(|data: &[u8]| {
    let Some((&[form, options], data)) = data.split_first_chunk() else { return };
    let Some((pieces, bytes)) = Pieces::of(data) else { return };
    let columns: Columns = if form & 4 == 0 { "1,2" } else { "2,1,3" }.parse().expect("these are columns");
    let form = match form % 4 {
        0 => Form::Lines(Some(Format::Text), columns),
        1 => Form::Lines(Some(Format::JsonLines), columns),
        2 => Form::Lines(None, columns),
        _ => Form::Binary,
    };
    let bytes = if matches!(form, Form::Binary) { mended(bytes) } else { bytes.to_vec() };
    let source = PointSource {
        origin: Origin::Opened(|| Box::new(Parts(SOURCE.take().into_iter().map(Cursor::new).collect()))),
        form,
        frame_points: (options & 1 != 0).then_some(u64::from(options >> 4) + 1),
        closes_last: options & 2 != 0,
        loops: false,
        batch: usize::from(options >> 2 & 3),
        is_projected: false,
    };
    // How much of a damaged piece the decoder of gzip gives depends on where the piece ends.
    let is_gzip = !matches!(source.form, Form::Binary) && bytes.starts_with(b"\x1f\x8b");
    let in_pieces = read(&source, pieces.over(&bytes).map(<[u8]>::to_vec).collect());
    let at_once = read(&PointSource { batch: 4096, ..source }, vec![bytes]);
    assert!(is_gzip || at_once == in_pieces, "{at_once:?}\n{in_pieces:?}");
});

/// A source of parts.
struct Parts(Vec<Cursor<Vec<u8>>>);

impl Read for Parts {
    fn read(&mut self, room: &mut [u8]) -> std::io::Result<usize> {
        for part in &mut self.0 {
            let count = part.read(room)?;
            if count > 0 {
                return Ok(count);
            }
        }
        Ok(0)
    }
}

/// Every point, frame and error in order, and how it ends.
fn read(source: &PointSource, parts: Vec<Vec<u8>>) -> Vec<String> {
    SOURCE.set(parts);
    let mut said = Vec::new();
    let ended = source.read(
        &mut |input| {
            match input {
                Input::Points(batch) => say(&mut said, "+", &batch, source.batch),
                Input::Retract(batch) => say(&mut said, "-", &batch, source.batch),
                input => said.push(format!("{input:?}")),
            }
            true
        },
        &|_| (),
    );
    said.push(ended.err().map_or_else(String::new, |error| format!("{error:?}")));
    said
}

fn say(said: &mut Vec<String>, what: &str, batch: &Batch, most: usize) {
    let Batch { positions, times, tags, lines, .. } = batch;
    assert!((1..=most.max(1)).contains(&positions.len()) && tags.is_empty() && lines.len() == positions.len());
    assert!(times.is_empty() || times.len() == positions.len());
    for (index, line) in lines.iter().enumerate() {
        said.push(format!("{what}{:?} {:?} {line}", positions.get(index), times.get(index)));
    }
}
