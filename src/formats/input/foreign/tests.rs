//! Every format that is read, whole, cut short, with more behind it and damaged; and bytes that mean nothing.

use std::io::{self, Read};

use proptest::prelude::*;

use super::*;
use crate::formats::input::{Columns, Format, Limits, Reader, Record, opened};

mod files;
mod hostile;
mod signatures;

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
        let length = (*self.lengths.next().unwrap()).max(1).min(room.len());
        self.bytes.read(&mut room[..length])
    }
}

/// All that is read: `(1,2)`, `(1,2)@3`, `commit`, or a message; and why it ends, if that is a failure.
fn read_from(source: impl Read, path: Option<&str>, columns: &str) -> Vec<String> {
    let columns = if columns.is_empty() { Columns::default() } else { columns.parse().unwrap() };
    let limits = Limits { line_bytes: 1 << 20 };
    let (format, source) = match opened(path.map(std::path::Path::new), None, source) {
        Ok(opened) => opened,
        Err(error) => return vec![error.to_string()],
    };
    let mut reader = Reader::new(source, format, columns.with_times(true), limits);
    let mut said = Vec::new();
    loop {
        match reader.next_record() {
            Ok(None) => return said,
            Ok(Some(record)) => say(&record, &mut said),
            Err(error) => {
                said.push(error.to_string());
                return said;
            }
        }
    }
}

fn say(record: &Record<'_>, said: &mut Vec<String>) {
    match record {
        Record::Points { points, time } => {
            let time = time.map_or_else(String::new, |time| format!("@{time}"));
            said.extend(points.iter().map(|[x, y]| format!("({x},{y}){time}")));
        }
        Record::Retract { points } => said.extend(points.iter().map(|[x, y]| format!("-({x},{y})"))),
        Record::Commit { .. } => said.push("commit".to_owned()),
        Record::Bad(bad) => said.push(bad.to_string()),
        Record::Missed(reason) => said.push(reason.clone()),
        Record::Blank | Record::Nothing => {}
    }
}

fn read(bytes: impl AsRef<[u8]>) -> Vec<String> {
    read_from(bytes.as_ref(), None, "")
}

/// The same, however it is cut.
fn read_cut(bytes: &[u8]) -> Vec<String> {
    let whole = read(bytes);
    for lengths in [&[1][..], &[2], &[7, 1], &[64, 3]] {
        assert_eq!(read_from(Pieces::new(bytes, lengths), None, ""), whole, "{lengths:?}");
    }
    whole
}

/// An NPY file of version 1.
fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(header.len() + 1).unwrap().to_le_bytes();
    [&b"\x93NUMPY\x01\x00"[..], &length, header.as_bytes(), b"\n", data].concat()
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
