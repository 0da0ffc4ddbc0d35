//! The writer thread: frames to the sink.
//!
//! In: a channel of [`Diff`]s. Out: JSON lines, or frames of the protocol. Invariants: every frame is flushed before the next is waited for; the first error
//! ends the thread, and with it whoever sends. Must not know: how frames come about.

use std::io::{self, BufWriter, Write};

use crossbeam_channel::Receiver;
use hopes_protocol::{Banner, Diff, Message, VERSION, encode};

use super::DEFAULT_STREAM;
use super::frame_line::FrameLine;

/// How frames are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputForm {
    /// One JSON line a frame.
    Lines,
    /// A recording, as the protocol has it.
    Binary,
}

/// The channel of frames in a recording.
const CHANNEL: u32 = 1;

/// Writes frames until there are no more.
pub fn run(frames: &Receiver<Diff>, form: OutputForm, sink: impl Write) -> io::Result<()> {
    let mut sink = BufWriter::with_capacity(1 << 16, sink);
    if form == OutputForm::Binary {
        sink.write_all(&Banner { lowest: VERSION, highest: VERSION }.encode())?;
    }
    for diff in frames {
        match form {
            OutputForm::Lines => {
                serde_json::to_writer(&mut sink, &FrameLine::new(DEFAULT_STREAM, &diff))?;
                sink.write_all(b"\n")?;
            }
            OutputForm::Binary => {
                let frame = encode(VERSION, CHANNEL, &Message::Diff(diff)).map_err(io::Error::other)?;
                sink.write_all(&frame)?;
            }
        }
        sink.flush()?;
    }
    Ok(())
}
