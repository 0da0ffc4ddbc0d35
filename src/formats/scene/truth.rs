//! The truth of a scene, as JSON lines.
//!
//! In: a scene's options, and frames.
//! Out: a line with the scene and its options, then a line a frame: its holes by id, and its events.
//! Invariants: there is one line more than frames.
//! Must not know: points.

use std::io::{self, Write};

use hopes::scene::signal::{SignalKind, SignalOptions, TrueRun};
use hopes::scene::space::{SpaceKind, SpaceOptions, SpaceScene, TrueCycle};
use hopes::scene::{Frame, Kind, Options, Scene, TrueEvent, TrueHole};
use serde::Serialize;

/// Writes the truth.
pub struct Truth<W> {
    sink: W,
    /// Whether the scene has stray points.
    has_clutter: bool,
}

/// The first line.
#[derive(Serialize)]
pub struct Header {
    scene: String,
    seed: u64,
    frames: u64,
    noise: f64,
    #[serde(flatten)]
    family: Family,
}

/// What only the scenes of one family have.
#[derive(Serialize)]
#[serde(untagged)]
enum Family {
    Plane {
        churn: f64,
        points_per_radius: u32,
        above: f64,
        smallest_radius: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        camera: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        clutter: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        clumps: Option<bool>,
    },
    Space {
        churn: f64,
        points: u32,
        dimension: usize,
        above: Option<f64>,
        smallest_radius: Option<f64>,
    },
    Signal {
        samples: u32,
    },
}

impl Header {
    /// Of a scene in the plane.
    pub fn of_plane(kind: Kind, options: &Options, frames: u64, scene: &Scene) -> Self {
        let &Options { seed, points_per_radius, noise, churn, camera, clutter, clumps, .. } = options;
        let (above, smallest_radius) = (scene.above(), scene.smallest_radius());
        let camera = camera.map(|camera| camera.to_string());
        let clutter = Some(clutter).filter(|&share| share > 0.0);
        let clumps = clumps.then_some(true);
        let family = Family::Plane { churn, points_per_radius, above, smallest_radius, camera, clutter, clumps };
        Self { scene: kind.name().to_owned(), seed, frames, noise, family }
    }

    /// Of a scene in R^d.
    pub fn of_space(kind: SpaceKind, options: &SpaceOptions, frames: u64, scene: &SpaceScene) -> Self {
        let &SpaceOptions { seed, points, noise, churn, .. } = options;
        let (above, smallest_radius) = (scene.above(), scene.smallest_radius());
        let family = Family::Space { churn, points, dimension: kind.dimension(), above, smallest_radius };
        Self { scene: kind.name(), seed, frames, noise, family }
    }

    /// Of a signal.
    pub fn of_signal(kind: SignalKind, options: &SignalOptions, frames: u64) -> Self {
        let &SignalOptions { seed, samples, noise } = options;
        Self { scene: kind.name().to_owned(), seed, frames, noise, family: Family::Signal { samples } }
    }
}

#[derive(Serialize)]
struct Line<H> {
    frame: u64,
    holes: Vec<H>,
    events: Vec<Event>,
    /// How many of the frame's last points are stray points.
    #[serde(skip_serializing_if = "Option::is_none")]
    clutter: Option<usize>,
}

/// A true hole that has a form as JSON.
pub trait WrittenHole {
    /// What is written of it.
    type Form<'a>: Serialize
    where
        Self: 'a;

    /// The hole in that form.
    fn form(&self) -> Self::Form<'_>;
}

/// A hole in the plane.
#[derive(Serialize)]
pub struct PlaneHole {
    id: u64,
    x: f64,
    y: f64,
    radius: f64,
    orbit: f64,
    /// Of a slender hole only.
    #[serde(skip_serializing_if = "Option::is_none")]
    ridge: Option<[f64; 2]>,
}

/// A hole in R^d.
#[derive(Serialize)]
pub struct SpaceHole<'a> {
    id: u64,
    center: &'a [f64],
    radius: f64,
    orbit: f64,
    length: f64,
}

/// A run of a signal.
#[derive(Serialize)]
pub struct Run {
    id: u64,
    period: u32,
    since: u64,
}

#[derive(Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event {
    Born {
        id: u64,
        #[serde(skip_serializing_if = "Option::is_none")]
        was: Option<u64>,
    },
    Split {
        id: u64,
        from: u64,
    },
    Merged {
        id: u64,
        into: u64,
    },
    Died {
        id: u64,
    },
}

impl<W: Write> Truth<W> {
    /// Nothing is written yet.
    pub fn new(sink: W) -> Self {
        Self { sink, has_clutter: false }
    }

    /// The first line.
    pub fn header(&mut self, header: &Header) -> io::Result<()> {
        self.has_clutter = matches!(header.family, Family::Plane { clutter: Some(_), .. });
        self.line(header)
    }

    /// A frame's line.
    pub fn write<P, H: WrittenHole>(&mut self, frame: &Frame<P, H>) -> io::Result<()> {
        let holes = frame.holes.iter().map(H::form).collect();
        let events = frame.events.iter().map(event).collect();
        let clutter = self.has_clutter.then_some(frame.clutter);
        self.line(&Line { frame: frame.number, holes, events, clutter })
    }

    /// Flushes all that was written.
    pub fn finish(mut self) -> io::Result<()> {
        self.sink.flush()
    }

    fn line(&mut self, line: &impl Serialize) -> io::Result<()> {
        serde_json::to_writer(&mut self.sink, line)?;
        writeln!(self.sink)
    }
}

impl WrittenHole for TrueHole {
    type Form<'a> = PlaneHole;

    fn form(&self) -> PlaneHole {
        let &Self { id, center: [x, y], radius, orbit, ridge } = self;
        PlaneHole { id, x, y, radius, orbit, ridge: Some(ridge).filter(|&ridge| ridge != [0.0; 2]) }
    }
}

impl WrittenHole for TrueCycle {
    type Form<'a> = SpaceHole<'a>;

    fn form(&self) -> SpaceHole<'_> {
        let &Self { id, ref center, radius, orbit, length, .. } = self;
        SpaceHole { id, center, radius, orbit, length }
    }
}

impl WrittenHole for TrueRun {
    type Form<'a> = Run;

    fn form(&self) -> Run {
        let &Self { id, period, since } = self;
        Run { id, period, since }
    }
}

fn event(event: &TrueEvent) -> Event {
    match *event {
        TrueEvent::Born { id, was } => Event::Born { id, was },
        TrueEvent::Split { id, from } => Event::Split { id, from },
        TrueEvent::Merged { id, into } => Event::Merged { id, into },
        TrueEvent::Died { id } => Event::Died { id },
    }
}
