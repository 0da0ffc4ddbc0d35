//! The daemon's numbers for Prometheus (text format 0.0.4).
//!
//! In: how the daemon is. Out: one family after another, with a line a stream. Invariants: names of streams, which are
//! anybody's, are escaped. Must not know: how the numbers come about.

use std::fmt::{Display, Write};

use hopes_protocol::{Status, StreamStatus};

/// The kind of the answer.
pub const KIND: &str = "text/plain; version=0.0.4; charset=utf-8";

/// A number of a stream: its name, what kind of number it is, what it says, how to get it.
type Family = (&'static str, &'static str, &'static str, fn(&StreamStatus) -> u64);

const FAMILIES: [Family; 12] = [
    ("frames_total", "counter", "Frames closed.", |stream| stream.info.frame),
    ("points", "gauge", "Points in the window.", |stream| stream.info.points),
    ("vertices", "gauge", "Distinct positions.", |stream| stream.info.vertices),
    ("producers", "gauge", "Channels that feed it.", |stream| stream.info.producers.into()),
    ("consumers", "gauge", "Channels that follow it.", |stream| stream.info.consumers.into()),
    ("computed_total", "counter", "Skeletons computed.", |stream| stream.computed),
    ("accepted_points_total", "counter", "Points accepted.", |stream| stream.accepted),
    ("refused_points_total", "counter", "Points refused.", |stream| stream.refused),
    ("dropped_points_total", "counter", "Points dropped by overload.", |stream| stream.dropped),
    ("waiting_points", "gauge", "Points that wait for the engine.", |stream| stream.waiting),
    ("lagged_frames_total", "counter", "Frames that consumers were not sent singly.", |stream| stream.lagged),
    ("memory_bytes", "gauge", "Estimate of the memory held.", |stream| stream.memory),
];

/// All numbers.
pub fn write(status: &Status) -> String {
    let mut out = String::new();
    single(&mut out, "uptime_seconds", "gauge", "How long it runs.", status.uptime_ms as f64 / 1000.0);
    single(&mut out, "connections", "gauge", "Peers that are connected.", status.connections);
    let text = "Messages that could not be read or were not expected.";
    single(&mut out, "refused_messages_total", "counter", text, status.refused_messages);
    single(&mut out, "memory_bytes", "gauge", "Estimate of the memory held for all streams.", status.memory);
    single(&mut out, "streams", "gauge", "Streams.", status.streams.len());
    for (name, kind, text, number) in FAMILIES {
        let name = format!("hopes_stream_{name}");
        begin(&mut out, &name, kind, text);
        for stream in &status.streams {
            // Writing into a string does not fail.
            let _ = writeln!(out, "{name}{{stream=\"{}\"}} {}", escaped(&stream.info.name), number(stream));
        }
    }
    out
}

fn single(out: &mut String, name: &str, kind: &str, text: &str, number: impl Display) {
    let name = format!("hopes_{name}");
    begin(out, &name, kind, text);
    let _ = writeln!(out, "{name} {number}");
}

fn begin(out: &mut String, name: &str, kind: &str, text: &str) {
    let _ = writeln!(out, "# HELP {name} {text}\n# TYPE {name} {kind}");
}

fn escaped(name: &str) -> String {
    name.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_pretend_to_be_something_else() {
        assert_eq!(escaped("a\"} 1\nb\\"), "a\\\"} 1\\nb\\\\");
    }
}
