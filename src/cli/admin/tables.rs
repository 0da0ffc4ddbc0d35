//! A daemon's answers as tables for people.
//!
//! In: the bodies of the answers.
//! Out: lines.
//! Invariants: what a peer has named is printable.
//! Must not know: how the daemon is asked.

use std::io::{self, Write};
use std::time::Duration;

use hopes_protocol::{Memory, Peer, Peers, SpaceInfo, Spaces, Status, StreamInfo, StreamMemory, StreamStatus, Window};
use indicatif::{HumanBytes, HumanCount};

use crate::formats::aligned::{self, Column, numbers, words};

const OF_STREAMS: [Column; 14] = [
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

const OF_PEERS: [Column; 11] = [
    numbers("peer"),
    words("came to"),
    words("software"),
    numbers("connected"),
    numbers("silent"),
    numbers("producers"),
    numbers("consumers"),
    numbers("held"),
    numbers("received"),
    numbers("sent"),
    numbers("lagged"),
];

const OF_MEMORY: [Column; 4] = [words("stream"), numbers("points"), numbers("views"), numbers("queue")];

const OF_SPACES: [Column; 3] = [words("stream"), words("metric"), numbers("dimension")];

/// A line about the daemon, and a row a stream.
pub fn write_streams(out: &mut impl Write, status: &Status) -> io::Result<()> {
    let &Status { uptime_ms, connections, refused_messages, memory, memory_limit, .. } = status;
    let uptime = humantime::format_duration(Duration::from_secs(uptime_ms / 1000));
    let software = printable(&status.software);
    let (memory, limit) = (HumanBytes(memory), limit(memory_limit));
    writeln!(
        out,
        "{software}, up {uptime}, {connections} connections, {refused_messages} messages refused, \
         memory {memory} ({limit})",
    )?;
    if status.streams.is_empty() {
        return writeln!(out, "no streams");
    }
    aligned::write(out, &OF_STREAMS, status.streams.iter().map(stream))
}

/// A row a peer.
pub fn write_peers(out: &mut impl Write, peers: &Peers) -> io::Result<()> {
    aligned::write(out, &OF_PEERS, peers.peers.iter().map(peer))
}

/// A line about all memory, and a row a stream.
pub fn write_memory(out: &mut impl Write, memory: &Memory) -> io::Result<()> {
    let &Memory { limit: most, held, peers, ref streams } = memory;
    writeln!(out, "memory {} ({}), {} of it for peers", HumanBytes(held), limit(most), HumanBytes(peers))?;
    if streams.is_empty() {
        return writeln!(out, "no streams");
    }
    aligned::write(out, &OF_MEMORY, streams.iter().map(share))
}

/// A row for each stream of points in R^d, by the names of the status.
pub fn write_spaces(out: &mut impl Write, spaces: &Spaces, status: &Status) -> io::Result<()> {
    if spaces.streams.is_empty() {
        return writeln!(out, "all streams are of the plane");
    }
    // One that has come or gone between the answers has no name here.
    let name = |number: u32| {
        let stream = status.streams.iter().find(|stream| stream.info.stream == number);
        stream.map_or_else(|| format!("number {number}"), |stream| printable(&stream.info.name))
    };
    let dimension = |dimension: Option<u32>| dimension.map_or("-".to_owned(), |dimension| dimension.to_string());
    let row = |space: &SpaceInfo| vec![name(space.stream), space.metric.name().to_owned(), dimension(space.dimension)];
    aligned::write(out, &OF_SPACES, spaces.streams.iter().map(row))
}

fn stream(stream: &StreamStatus) -> Vec<String> {
    let StreamStatus { info, computed, accepted, refused, dropped, waiting, lagged, memory } = stream;
    vec![
        printable(&info.name),
        count(info.frame),
        count(info.points),
        count(info.vertices),
        info.producers.to_string(),
        info.consumers.to_string(),
        bytes(*memory),
        count(*computed),
        count(*accepted),
        count(*refused),
        count(*dropped),
        count(*waiting),
        count(*lagged),
        window(info),
    ]
}

fn peer(peer: &Peer) -> Vec<String> {
    vec![
        peer.peer.to_string(),
        printable(&peer.place),
        printable(&peer.software),
        since(peer.connected_ms),
        since(peer.silent_ms),
        peer.producers.to_string(),
        peer.consumers.to_string(),
        bytes(peer.held),
        bytes(peer.received),
        bytes(peer.sent),
        count(peer.lagged),
    ]
}

fn share(stream: &StreamMemory) -> Vec<String> {
    vec![printable(&stream.name), bytes(stream.points), bytes(stream.views), bytes(stream.queue)]
}

fn count(number: u64) -> String {
    HumanCount(number).to_string()
}

fn bytes(number: u64) -> String {
    HumanBytes(number).to_string()
}

fn limit(most: u64) -> String {
    if most == 0 { "no limit".to_owned() } else { format!("of {}", HumanBytes(most)) }
}

/// A span of time; below a minute in tenths of a second.
fn since(milliseconds: u64) -> String {
    if milliseconds < 60_000 {
        format!("{}.{}s", milliseconds / 1000, milliseconds % 1000 / 100)
    } else {
        humantime::format_duration(Duration::from_secs(milliseconds / 1000)).to_string()
    }
}

/// As on the command line.
fn window(info: &StreamInfo) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_time_are_short() {
        let spans = [0, 99, 100, 59_999, 60_000, 3_723_456].map(since);
        assert_eq!(spans, ["0.0s", "0.0s", "0.1s", "59.9s", "1m", "1h 2m 3s"]);
    }

    #[test]
    fn memory_without_streams_and_without_a_limit_is_told_as_such() {
        let mut out = Vec::new();
        write_memory(&mut out, &Memory { limit: 0, held: 2048, peers: 1024, streams: vec![] }).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "memory 2.00 KiB (no limit), 1.00 KiB of it for peers\nno streams\n"
        );
    }
}
