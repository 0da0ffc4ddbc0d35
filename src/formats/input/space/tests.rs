//! Spaces from bytes: every form, whole, damaged and hostile, and however it is cut.
//!
//! In: texts and files. Out: what is read of them, in few characters.
//! Must not know: how it is read.

use std::io::{self, Read, Write};
use std::path::Path;

use super::*;

mod cut;
mod distances;
mod points;
mod series;

/// How points are read in a test.
fn chosen(columns: &str) -> PointSettings {
    PointSettings {
        coordinates: Coordinates::Any(columns.parse::<SpaceColumns>().unwrap()),
        ..PointSettings::default()
    }
}

fn degrees() -> PointSettings {
    PointSettings { coordinates: Coordinates::Degrees(Default::default()), ..PointSettings::default() }
}

/// What is read: `2: 1 2, 3 4` (the dimension, and points), or why nothing is; then all that is told.
fn read_with(settings: &PointSettings, bytes: impl AsRef<[u8]>) -> Vec<String> {
    let mut told = Vec::new();
    let read = read_points(None, bytes.as_ref(), settings, 1000, &mut |notice| told.push(notice));
    let refusals = told.iter().filter(|notice| matches!(notice, Notice::Refused(_))).count() as u64;
    let first = match read {
        Ok(PointsRead { space, rejected, .. }) => {
            assert_eq!(rejected, refusals);
            shown(&space)
        }
        Err(error) => error.to_string(),
    };
    let told = told.into_iter().filter_map(|notice| match notice {
        Notice::Refused(reason) => Some(reason),
        Notice::Taken(_) => None,
    });
    std::iter::once(first).chain(told).collect()
}

fn read(bytes: impl AsRef<[u8]>) -> Vec<String> {
    read_with(&PointSettings::default(), bytes)
}

fn shown(space: &Space) -> String {
    let numbers = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    match space {
        Space::Points { dimension, coordinates } => {
            let points: Vec<String> = coordinates.chunks((*dimension).max(1)).map(numbers).collect();
            format!("{dimension}: {}", points.join(", "))
        }
        Space::Lower { count, distances } => {
            let mut rest = &distances[..];
            let rows = (1..*count).map(|row| rest.split_off(..row).map_or_else(String::new, numbers));
            format!("{count}: {}", rows.collect::<Vec<_>>().join(", "))
        }
        Space::Sparse { count, edges } => {
            let edges: Vec<String> = edges.iter().map(|(i, j, distance)| format!("{i}-{j} {distance}")).collect();
            format!("{count}: {}", edges.join(", "))
        }
    }
}

/// What was taken for what.
fn taken(settings: &PointSettings, bytes: impl AsRef<[u8]>) -> Vec<String> {
    let mut told = Vec::new();
    let read = read_points(None, bytes.as_ref(), settings, 1000, &mut |notice| {
        told.extend(match notice {
            Notice::Taken(text) => Some(text),
            Notice::Refused(_) => None,
        });
    });
    assert!(read.is_ok());
    told
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// An NPY file of version 1.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(header.len() + 1).unwrap().to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, header.as_bytes(), b"\n", data].concat()
}

fn array(shape: &str, is_fortran: bool, values: &[f64]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    npy(&format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}"), &data)
}

/// Hands out pieces of the given lengths, over and over.
struct Pieces<'a> {
    bytes: &'a [u8],
    lengths: std::iter::Cycle<std::slice::Iter<'a, usize>>,
}

impl<'a> Pieces<'a> {
    fn new(bytes: &'a [u8], lengths: &'a [usize]) -> Self {
        Self { bytes, lengths: lengths.iter().cycle() }
    }
}

impl Read for Pieces<'_> {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        let length = (*self.lengths.next().unwrap()).clamp(1, room.len());
        self.bytes.read(&mut room[..length])
    }
}
