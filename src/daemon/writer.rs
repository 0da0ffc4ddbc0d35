//! The writer thread: frame lines to the sink.
//!
//! In: a channel of [`FrameLine`]s. Out: JSON lines. Invariants: every line is flushed before the next is waited for; the first error
//! ends the thread, and with it whoever sends. Must not know: frames.

use std::io::{self, BufWriter, Write};

use crossbeam_channel::Receiver;

use super::frame_line::FrameLine;

/// Writes lines until there are no more.
pub fn run(lines: &Receiver<FrameLine>, sink: impl Write) -> io::Result<()> {
    let mut sink = BufWriter::with_capacity(1 << 16, sink);
    for line in lines {
        serde_json::to_writer(&mut sink, &line)?;
        sink.write_all(b"\n")?;
        sink.flush()?;
    }
    Ok(())
}
