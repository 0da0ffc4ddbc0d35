//! The writer thread: frames to the sink.
//!
//! In: a channel of [`TapFrame`]s. Out: JSON lines, or frames of the protocol. Invariants: every frame is flushed before the next is waited for; the first error
//! ends the thread, and with it whoever sends. Must not know: how frames come about.

use std::io::{self, BufWriter, Write};

use crossbeam_channel::Receiver;
use hopes_protocol::{Banner, Message, VERSION, encode};

use super::DEFAULT_STREAM;
use super::engine::TapFrame;
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
pub fn run(frames: &Receiver<TapFrame>, form: OutputForm, lists_tracks: bool, sink: impl Write) -> io::Result<()> {
    let mut sink = BufWriter::with_capacity(1 << 16, sink);
    if form == OutputForm::Binary {
        sink.write_all(&Banner { lowest: VERSION, highest: VERSION }.encode())?;
    }
    let mut told = 0;
    for TapFrame { diff, tracks } in frames {
        match form {
            OutputForm::Lines => {
                let mut line = FrameLine::new(DEFAULT_STREAM, &diff);
                if let Some(tracks) = &tracks {
                    line.add_tracks(&tracks.events, lists_tracks.then(|| tracks.alive()));
                }
                serde_json::to_writer(&mut sink, &line)?;
                sink.write_all(b"\n")?;
            }
            OutputForm::Binary => {
                let stream = diff.stream;
                put(&mut sink, &Message::Diff(diff))?;
                if let Some(tracks) = &tracks {
                    put(&mut sink, &Message::Tracks(tracks.message(stream, told, lists_tracks)))?;
                    told = tracks.frame;
                }
            }
        }
        sink.flush()?;
    }
    Ok(())
}

fn put(sink: &mut impl Write, message: &Message) -> io::Result<()> {
    sink.write_all(&encode(VERSION, CHANNEL, message).map_err(io::Error::other)?)
}
