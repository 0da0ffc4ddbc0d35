//! Points of any dimension, series and distances as `compute --metric` takes them: whatever the bytes, what is read of
//! them is a space, or the reason why not, and the same however the source cuts its bytes.
//!
//! The input: a byte for what is read, a byte for its form, four lengths of pieces, the bytes.
#![no_main]

use std::io::Read;
use std::path::Path;

use hopes_fuzz::formats::input::Format;
use hopes_fuzz::formats::input::space::{
    Coordinates, DistanceForm, Embedding, Notice, PointSettings, Space, SpaceColumns, read_distances, read_points,
};
use hopes_fuzz::pieces::Pieces;
use libfuzzer_sys::fuzz_target;

/// The most points.
const MOST: usize = 300;

fuzz_target!(|data: &[u8]| {
    let Some((&[what, form], data)) = data.split_first_chunk() else { return };
    let Some((pieces, bytes)) = Pieces::of(data) else { return };
    let in_pieces = read(what, form, pieces.over(bytes));
    let at_once = read(what, form, bytes);
    // How much of a damaged piece the decoder of gzip gives depends on where the piece ends.
    assert!(bytes.starts_with(b"\x1f\x8b") || at_once == in_pieces, "{at_once:?}\n{in_pieces:?}");
});

/// What is read, or why it is not, and all that is told.
fn read(what: u8, form: u8, source: impl Read) -> (Result<Space, String>, Vec<Notice>) {
    let mut told = Vec::new();
    let mut notice = |notice| told.push(notice);
    let path = (what & 128 != 0).then_some(Path::new("matrix.bin"));
    let space = match what % 4 {
        0 => read_distances(path, source, distances(form), MOST, &mut notice),
        kind => {
            let columns =
                if form & 8 == 0 { SpaceColumns::default() } else { "2,1".parse().expect("these are columns") };
            let settings = PointSettings {
                format: [None, Some(Format::Text), Some(Format::JsonLines)][usize::from(form % 3)],
                coordinates: if kind == 2 {
                    Coordinates::Degrees(Default::default())
                } else {
                    Coordinates::Any(columns)
                },
                wants_times: form & 16 != 0,
                embedding: (kind == 3).then(|| Embedding::new(3, 2).expect("this is an embedding")),
            };
            read_points(path, source, &settings, MOST, &mut notice).map(|read| read.space)
        }
    };
    if let Ok(space) = &space {
        check(space);
    }
    (space.map_err(|error| error.to_string()), told)
}

fn distances(form: u8) -> Option<DistanceForm> {
    [
        None,
        Some(DistanceForm::Full),
        Some(DistanceForm::Lower),
        Some(DistanceForm::Upper),
        Some(DistanceForm::Condensed),
        Some(DistanceForm::Sparse),
        Some(DistanceForm::Binary),
    ][usize::from(form % 7)]
}

fn check(space: &Space) {
    match space {
        Space::Points { dimension, coordinates } => {
            assert!(
                coordinates.is_empty() || coordinates.len() % dimension == 0 && coordinates.len() / dimension <= MOST
            );
            assert!(coordinates.iter().all(|value| value.is_finite()));
        }
        Space::Lower { count, distances } => {
            assert!(*count <= MOST && distances.len() == count * count.saturating_sub(1) / 2);
            assert!(distances.iter().all(|&distance| distance >= 0.0));
        }
        Space::Sparse { count, edges } => {
            assert!(
                *count <= MOST
                    && edges.iter().all(|&(i, j, distance)| i < j && (j as usize) < *count && distance >= 0.0)
            );
        }
    }
}
