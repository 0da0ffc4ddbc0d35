//! `hopes status`: how a daemon is, and its streams.
//!
//! In: an address.
//! Out: a table, or JSON.
//! Must not know: how the daemon is asked, how it comes to its numbers.

use std::io::{self, Write};
use std::time::Duration;

use anyhow::Context;
use clap::Args;
use hopes_protocol::{Status as Numbers, StreamStatus};
use indicatif::{HumanBytes, HumanCount};

use super::args::From;
use super::{Failure, files};
use crate::client::status::ask;
use crate::formats::aligned::{self, Column, numbers, words};

/// Show a daemon's streams: who feeds and follows them, points, memory, what was refused, dropped or merged.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  hopes status --from unix:/tmp/hopes.sock
  hopes status --from tcp:127.0.0.1:7878 --json | jq '.streams[].info.name'")]
pub struct Status {
    #[command(flatten)]
    from: From,
    /// As one line of JSON, with the names of protocol/SPEC.md.
    #[arg(long)]
    json: bool,
}

impl Status {
    pub fn run(self) -> Result<(), Failure> {
        let mut stdout = files::stdout()?;
        let status = ask(&self.from.from)?;
        let mut text = Vec::new();
        if self.json {
            serde_json::to_writer(&mut text, &status).context("cannot write JSON")?;
            text.push(b'\n');
        } else {
            write_table(&mut text, &status).context("cannot write the table")?;
        }
        Ok(stdout.write_all(&text).context(files::CANNOT_WRITE_TO_STDOUT)?)
    }
}

const COLUMNS: [Column; 14] = [
    words("stream"),
    numbers("frame"),
    numbers("points"),
    numbers("distinct"),
    numbers("producers"),
    numbers("consumers"),
    numbers("memory"),
    numbers("computed"),
    numbers("accepted"),
    numbers("refused"),
    numbers("dropped"),
    numbers("waiting"),
    numbers("lagged"),
    words("window"),
];

fn write_table(out: &mut impl Write, status: &Numbers) -> io::Result<()> {
    let &Numbers { uptime_ms, connections, refused_messages, memory, memory_limit, .. } = status;
    let uptime = humantime::format_duration(Duration::from_secs(uptime_ms / 1000));
    let limit = if memory_limit == 0 { "no limit".to_owned() } else { format!("of {}", HumanBytes(memory_limit)) };
    let software = printable(&status.software);
    let memory = HumanBytes(memory);
    writeln!(
        out,
        "{software}, up {uptime}, {connections} connections, {refused_messages} messages refused, \
         memory {memory} ({limit})",
    )?;
    if status.streams.is_empty() {
        return writeln!(out, "no streams");
    }
    aligned::write(out, &COLUMNS, status.streams.iter().map(row))
}

fn row(stream: &StreamStatus) -> Vec<String> {
    let StreamStatus { info, computed, accepted, refused, dropped, waiting, lagged, memory } = stream;
    let count = |number: u64| HumanCount(number).to_string();
    vec![
        printable(&info.name),
        count(info.frame),
        count(info.points),
        count(info.vertices),
        info.producers.to_string(),
        info.consumers.to_string(),
        HumanBytes(*memory).to_string(),
        count(*computed),
        count(*accepted),
        count(*refused),
        count(*dropped),
        count(*waiting),
        count(*lagged),
        window(info),
    ]
}

/// As on the command line.
fn window(info: &hopes_protocol::StreamInfo) -> String {
    use hopes_protocol::Window;
    let window = match info.window {
        Window::All => "all".to_owned(),
        Window::Points(number) => format!("points:{number}"),
        Window::Frames(number) => format!("frames:{number}"),
        Window::Time(length) => format!("time:{length}"),
    };
    info.resolution.map_or(window.clone(), |step| format!("{window} on a grid of {step}"))
}

/// Without what could play tricks with a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|character| if character.is_control() { '\u{fffd}' } else { character }).collect()
}
