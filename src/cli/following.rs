//! Messages of followed streams on their way to stdout or a file.
//!
//! In: proved messages.
//! Out: text or bytes, and how many of them.
//! Must not know: how streams are followed, how messages are written.

use std::io::{self, Write};
use std::time::Duration;

use hopes_protocol::Message;
use indicatif::{HumanBytes, ProgressBar};

use crate::client::follow::MessageSink;
use crate::formats::messages::MessageWriter;

/// Writes messages, and shows how many there were.
pub struct Shown<W> {
    /// Writes.
    pub writer: MessageWriter<W>,
    /// Shows.
    pub progress: ProgressBar,
}

impl<W: Write> MessageSink for Shown<W> {
    fn write(&mut self, name: &str, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        self.writer.write(name, elapsed, channel, message)
    }

    fn announces(&self, message: &Message) -> bool {
        self.writer.announces(message)
    }

    fn progress(&self, frames: u64) {
        self.progress.set_message(format!("{frames} frames, {}", HumanBytes(self.writer.bytes_written())));
    }
}
