//! The truth of a scene, as JSON lines.
//!
//! In: a scene's options, and frames.
//! Out: a line with the scene and its options, then a line a frame: its holes by id, and its events.
//! Invariants: there is one line more than frames.
//! Must not know: points.

use std::io::{self, Write};

use hopes::scene::{Frame, Kind, Options, Scene, TrueEvent, TrueHole};
use serde::Serialize;

/// Writes the truth.
pub struct Truth<W>(W);

#[derive(Serialize)]
struct Header {
    scene: &'static str,
    seed: u64,
    frames: u64,
    noise: f64,
    churn: f64,
    points_per_radius: u32,
    above: f64,
    smallest_radius: f64,
}

#[derive(Serialize)]
struct Line {
    frame: u64,
    holes: Vec<Hole>,
    events: Vec<Event>,
}

#[derive(Serialize)]
struct Hole {
    id: u64,
    x: f64,
    y: f64,
    radius: f64,
    orbit: f64,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event {
    Born { id: u64 },
    Split { id: u64, from: u64 },
    Merged { id: u64, into: u64 },
    Died { id: u64 },
}

impl<W: Write> Truth<W> {
    /// Nothing is written yet.
    pub fn new(sink: W) -> Self {
        Self(sink)
    }

    /// The first line.
    pub fn header(&mut self, kind: Kind, options: &Options, frames: u64, scene: &Scene) -> io::Result<()> {
        self.line(&Header {
            scene: kind.name(),
            seed: options.seed,
            frames,
            noise: options.noise,
            churn: options.churn,
            points_per_radius: options.points_per_radius,
            above: scene.above(),
            smallest_radius: scene.smallest_radius(),
        })
    }

    /// A frame's line.
    pub fn write(&mut self, frame: &Frame) -> io::Result<()> {
        let holes = frame.holes.iter().map(hole).collect();
        let events = frame.events.iter().map(event).collect();
        self.line(&Line { frame: frame.number, holes, events })
    }

    /// Flushes all that was written.
    pub fn finish(mut self) -> io::Result<()> {
        self.0.flush()
    }

    fn line(&mut self, line: &impl Serialize) -> io::Result<()> {
        serde_json::to_writer(&mut self.0, line)?;
        writeln!(self.0)
    }
}

fn hole(&TrueHole { id, center: [x, y], radius, orbit }: &TrueHole) -> Hole {
    Hole { id, x, y, radius, orbit }
}

fn event(event: &TrueEvent) -> Event {
    match *event {
        TrueEvent::Born { id } => Event::Born { id },
        TrueEvent::Split { id, from } => Event::Split { id, from },
        TrueEvent::Merged { id, into } => Event::Merged { id, into },
        TrueEvent::Died { id } => Event::Died { id },
    }
}
