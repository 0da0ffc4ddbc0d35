//! Messages of followed streams on their way to stdout or a file.
//!
//! In: proved messages, and how following ended.
//! Out: text or bytes, and how many of them.
//! Must not know: how streams are followed, how messages are written.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use hopes_protocol::Message;
use indicatif::{HumanBytes, ProgressBar};

use super::files;
use crate::client::Chain;
use crate::client::follow::{FollowError, Followed, MessageSink};
use crate::formats::messages::MessageWriter;

/// Writes messages, and shows how many there were.
pub struct Shown<W> {
    writer: MessageWriter<W>,
    progress: ProgressBar,
    /// When the first message came.
    begun: Option<Instant>,
    frames: Arc<AtomicU64>,
}

impl<W: Write> Shown<W> {
    /// Nothing has come yet.
    pub fn new(writer: MessageWriter<W>, progress: ProgressBar) -> Self {
        Self { writer, progress, begun: None, frames: Arc::default() }
    }

    /// Ends the output with the reason why following ended, unless it could not be written or never began.
    pub fn finish(&mut self, ended: &Result<Followed, FollowError>) -> io::Result<()> {
        let reason = match ended {
            Err(FollowError::Write(_)) => return Ok(()),
            Err(_) if self.begun.is_none() => return Ok(()),
            Err(error) => Chain(error).to_string(),
            Ok(followed) => followed.reason.clone(),
        };
        let elapsed = self.begun.map_or(Duration::ZERO, |begun| begun.elapsed());
        self.writer.finish(elapsed, &reason)
    }

    /// Frames so far.
    pub fn frames(&self) -> u64 {
        self.frames.load(Relaxed)
    }

    /// Bytes of the recording so far.
    pub fn bytes_written(&self) -> u64 {
        self.writer.bytes_written()
    }
}

impl<W: Write> MessageSink for Shown<W> {
    fn write(&mut self, name: &str, elapsed: Duration, channel: u32, message: &Message) -> io::Result<()> {
        if self.begun.is_none() {
            self.begun = Some(Instant::now());
            files::end_in_time(Arc::clone(&self.frames))?;
        }
        self.writer.write(name, elapsed, channel, message)?;
        self.frames.fetch_add(u64::from(message.frame().is_some()), Relaxed);
        Ok(())
    }

    fn announces(&self, message: &Message) -> bool {
        self.writer.announces(message)
    }

    fn progress(&self, frames: u64) {
        self.progress.set_message(format!("{frames} frames, {}", HumanBytes(self.writer.bytes_written())));
    }
}
