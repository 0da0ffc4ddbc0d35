//! The points of a scene, in the forms that `serve` and `feed` read.
//!
//! In: frames.
//! Out: whole clouds as text, or changes as JSON lines or messages of the protocol.
//! Invariants: the points that go are written before those that come.
//! Must not know: scenes, truth, how points are written.

use std::io::{self, Write};

use hopes::scene::Frame;

use crate::formats::point_writer::{Point, PointForm, PointWriter};

/// Writes points.
pub struct ScenePoints<W> {
    writer: PointWriter<W>,
    /// Whether a frame has only what changes; text has no way to take points back.
    has_changes: bool,
}

impl<W: Write> ScenePoints<W> {
    /// Nothing is written yet.
    pub fn new(form: PointForm, sink: W) -> Self {
        Self { writer: PointWriter::new(form, sink), has_changes: form != PointForm::Text }
    }

    /// Writes a frame, and closes it.
    pub fn write<P: Point<f64>, H>(&mut self, frame: &Frame<P, H>) -> io::Result<()> {
        if self.has_changes {
            self.writer.retract(&frame.gone)?;
            self.writer.add(&frame.come)?;
        } else {
            self.writer.add(&frame.points)?;
        }
        self.writer.commit(Some(frame.time))
    }

    /// Flushes all that was written.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.finish()
    }
}
