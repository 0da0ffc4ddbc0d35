//! Every format that is read, whole, cut short, with more behind it and damaged; and bytes that mean nothing.

use std::io::{self, Read};

use proptest::prelude::*;

use super::*;
use crate::formats::input::testing::{Pieces, doubles, npy};
use crate::formats::input::{Columns, Format, Limits, Reader, Record, opened};

mod files;
mod hostile;
mod signatures;

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
