//! The points of a scene, in the forms that `serve` and `feed` read.
//!
//! In: frames. Out: whole clouds as text, or changes as JSON lines or messages of the protocol. Invariants: what goes
//! is said before what comes. Must not know: scenes, truth, how points are written.

use std::io::{self, Write};

use hopes::scene::Frame;

use super::Format;
use crate::formats::point_writer::{PointForm, PointWriter};

/// Writes points.
pub struct Points<W> {
    writer: PointWriter<W>,
    /// Whether a frame tells only what changes.
    tells_changes: bool,
}

impl<W: Write> Points<W> {
    /// Begins.
    pub fn new(format: Format, sink: W) -> io::Result<Self> {
        let form = match format {
            Format::Text => PointForm::Text,
            Format::Jsonl => PointForm::Jsonl,
            Format::Bin => PointForm::Bin,
        };
        Ok(Self { writer: PointWriter::new(form, sink)?, tells_changes: format != Format::Text })
    }

    /// Writes a frame, and closes it.
    pub fn frame(&mut self, frame: &Frame) -> io::Result<()> {
        if self.tells_changes {
            self.writer.retract(&frame.gone)?;
            self.writer.add(&frame.come)?;
        } else {
            self.writer.add(&frame.points)?;
        }
        self.writer.commit(Some(frame.time))
    }

    /// Ends.
    pub fn finish(mut self) -> anyhow::Result<()> {
        Ok(self.writer.flush()?)
    }
}
