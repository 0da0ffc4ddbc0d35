//! The subcommands for the administration of a daemon: how it is, the end of a stream, the end of a connection.
//!
//! In: an address, and what is asked.
//! Out: the daemon's answers, as tables or as JSON.
//! Invariants: nothing is asked if there is no stdout. Nothing is written before all answers are there.
//! Must not know: how the daemon is asked.

pub mod disconnect;
pub mod status;
pub mod stop_stream;
mod tables;

use std::fs::File;
use std::io::Write;

use anyhow::Context;
use serde::Serialize;

use super::{Failure, files};

/// Writes an answer as one line of JSON.
fn write_line(out: &mut Vec<u8>, answer: &impl Serialize) -> Result<(), Failure> {
    serde_json::to_writer(&mut *out, answer).context("cannot write JSON")?;
    out.push(b'\n');
    Ok(())
}

/// Writes an answer to stdout: as one line of JSON, or as it is said to people.
fn show(out: File, is_json: bool, answer: &impl Serialize, words: &str) -> Result<(), Failure> {
    let mut text = Vec::new();
    if is_json {
        write_line(&mut text, answer)?;
    } else {
        text.extend(format!("{words}\n").into_bytes());
    }
    write_out(out, &text)
}

fn write_out(mut out: File, text: &[u8]) -> Result<(), Failure> {
    Ok(out.write_all(text).context(files::CANNOT_WRITE_TO_STDOUT)?)
}
