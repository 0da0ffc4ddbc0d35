//! Spaces from bytes: every form, whole, damaged and hostile, and however it is cut.
//!
//! In: texts and files. Out: what is read of them, in few characters.
//! Must not know: how it is read.

use std::io::{self, Read};
use std::path::Path;

use super::super::testing::{Pieces, compressed, doubles, npy};
use super::points::{PointReader, PointRecord};
use super::whole::PointsRead;
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

fn array(shape: &str, is_fortran: bool, values: &[f64]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    npy(&format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': {shape}, }}"), &doubles(values))
}
