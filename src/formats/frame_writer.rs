//! Frames of one stream, written as they come: JSON lines, or a recording.
//!
//! In: [`OutputFrame`]s, in order.
//! Out: bytes on a sink.
//! Invariants: every frame is flushed before `write` returns.
//! Must not know: how frames are computed, threads.

use std::io::{self, BufWriter, Write};

use hopes_protocol::{Banner, FILE_VERSION, Message, SPACE_FILE_VERSION, encode};

use super::frame_line::FrameLine;
use super::recording;
use crate::daemon::{DEFAULT_STREAM, OutputFrame};

/// How frames are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameForm {
    /// One JSON line per frame.
    Lines,
    /// A recording in frames of the protocol (protocol/SPEC.md, section 8).
    Binary,
}

/// The channel of frames in a recording.
const CHANNEL: u32 = 1;

/// Writes frames to a sink.
#[derive(Debug)]
pub struct FrameWriter<W: Write> {
    sink: BufWriter<W>,
    form: FrameForm,
    /// Whether every frame lists all living tracks.
    lists_tracks: bool,
    /// The frame up to which the recording has tracks; 0 for none.
    recorded: u64,
    /// The last frame.
    last: Option<u64>,
    /// The version of the recording.
    version: u16,
}

impl<W: Write> FrameWriter<W> {
    /// Nothing is written yet: the banner of a recording comes with the first frame, or with the end.
    pub fn new(form: FrameForm, lists_tracks: bool, sink: W) -> Self {
        let sink = BufWriter::with_capacity(1 << 16, sink);
        Self { sink, form, lists_tracks, recorded: 0, last: None, version: FILE_VERSION }
    }

    /// Writes frames of a space, which recordings for older readers cannot have.
    #[must_use]
    pub fn of_space(self) -> Self {
        Self { version: SPACE_FILE_VERSION, ..self }
    }

    /// Writes a frame, and flushes it.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn write(&mut self, frame: OutputFrame) -> io::Result<()> {
        match self.form {
            FrameForm::Lines => self.write_line(&frame)?,
            FrameForm::Binary => self.record(frame)?,
        }
        self.sink.flush()
    }

    /// Whether there was a frame.
    pub fn has_begun(&self) -> bool {
        self.last.is_some()
    }

    /// Writes the end; only a recording says so, and why.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(&mut self, reason: &str) -> io::Result<()> {
        if self.form == FrameForm::Binary {
            self.begin()?;
            let streams = self.last.map(|frame| (DEFAULT_STREAM.to_owned(), frame)).into_iter().collect();
            self.put(0, &recording::end(reason, &streams))?;
        }
        self.sink.flush()
    }

    fn write_line(&mut self, OutputFrame { stream, diff, tracks, .. }: &OutputFrame) -> io::Result<()> {
        let tracks = tracks.as_ref().map(|tracks| tracks.changes(*stream, self.lists_tracks));
        let Some(mut line) = FrameLine::new(DEFAULT_STREAM, diff) else { return Ok(()) };
        if let Some(tracks) = &tracks {
            line.add_tracks(tracks);
        }
        serde_json::to_writer(&mut self.sink, &line)?;
        self.sink.write_all(b"\n")
    }

    fn record(&mut self, OutputFrame { stream, number, diff, tracks }: OutputFrame) -> io::Result<()> {
        self.begin()?;
        self.last = Some(number);
        self.put(CHANNEL, &diff)?;
        if let Some(tracks) = tracks {
            self.put(CHANNEL, &tracks.message(stream, self.recorded, self.lists_tracks))?;
            self.recorded = tracks.frame();
        }
        Ok(())
    }

    fn begin(&mut self) -> io::Result<()> {
        if self.last.is_some() {
            return Ok(());
        }
        self.sink.write_all(&Banner { lowest: self.version, highest: self.version }.encode())
    }

    fn put(&mut self, channel: u32, message: &Message) -> io::Result<()> {
        self.sink.write_all(&encode(self.version, channel, message).map_err(io::Error::other)?)
    }
}
