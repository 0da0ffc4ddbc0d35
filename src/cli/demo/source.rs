//! What a demo plays: a scene, or the edges of a film that comes with the program.
//!
//! In: its name.
//! Out: how it is to be played, and [`Input`]s, from a thread of its own.
//! Invariants: every frame is closed. Without a number of frames there is no end. The thread ends when its inputs
//! are no longer received.
//! Must not know: sockets, pages.

use std::io;
use std::num::NonZeroU64;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

use hopes::scene::{FRAMES_A_SECOND, Kind, Options, Scene};
use hopes::topology::Window;

use crate::daemon::{Batch, Input, Positions};
use crate::formats::input::{Columns, Format};
use crate::formats::points::{Form, Origin, PointSource};

/// Edges of "Big Buck Bunny", (c) 2008 Blender Foundation, CC BY 3.0.
const FILM: &[u8] = include_bytes!("../../../tests/data/bunny.jsonl");
/// Frames of it in a second.
const FILM_RATE: f64 = 5.0;
/// The least persistence of holes in it that are tracked, in pixels.
const FILM_ABOVE: f64 = 8.0;

/// Inputs that may wait to be sent.
const WAITING: usize = 4;

/// What is played.
#[derive(Clone, Copy, Debug)]
pub enum DemoSource {
    /// Points whose true holes are known.
    Scene(Kind),
    /// Points of a real film.
    Film,
}

impl DemoSource {
    /// In a few words.
    pub fn about(self) -> String {
        match self {
            Self::Scene(kind) => format!("scene {}: {}", kind.name(), kind.about()),
            Self::Film => "edges of 26 frames of \"Big Buck Bunny\", (c) Blender Foundation, CC BY 3.0".to_owned(),
        }
    }

    /// Frames in a second, unless another rate is given.
    pub fn rate(self) -> f64 {
        match self {
            Self::Scene(_) => FRAMES_A_SECOND,
            Self::Film => FILM_RATE,
        }
    }

    /// Which points stay. A scene takes its points back itself.
    pub fn window(self) -> Window {
        match self {
            Self::Scene(_) => Window::All,
            Self::Film => Window::Frames(NonZeroU64::MIN),
        }
    }

    /// The least persistence of holes that are tracked.
    pub fn above(self) -> f64 {
        match self {
            Self::Scene(kind) => scene(kind).above(),
            Self::Film => FILM_ABOVE,
        }
    }

    /// Starts the thread that plays. Batches have at most `batch` points; after `frames` frames, if given, it ends.
    pub fn play(self, frames: Option<u64>, batch: usize) -> io::Result<Receiver<Input>> {
        let (sender, inputs) = sync_channel(WAITING);
        let mut left = frames.unwrap_or(u64::MAX);
        let mut send = move |input: Input| {
            left -= u64::from(matches!(input, Input::Commit(_)));
            sender.send(input).is_ok() && left > 0
        };
        let play = move || match self {
            Self::Scene(kind) => play_scene(scene(kind), batch, &mut send),
            Self::Film => play_film(batch, &mut send),
        };
        thread::Builder::new().name("source".to_owned()).spawn(play)?;
        Ok(inputs)
    }
}

fn scene(kind: Kind) -> Scene {
    Scene::new(kind, Options::default()).expect("the options that are the default are in range")
}

fn play_scene(mut scene: Scene, batch: usize, send: &mut impl FnMut(Input) -> bool) {
    loop {
        let frame = scene.next_frame();
        let gone = batches(&frame.gone, batch).map(Input::Retract);
        let come = batches(&frame.come, batch).map(Input::Points);
        if !gone.chain(come).chain([Input::Commit(Some(frame.time))]).all(&mut *send) {
            return;
        }
    }
}

fn batches(points: &[[f64; 2]], batch: usize) -> impl Iterator<Item = Batch> {
    points.chunks(batch).map(|points| {
        let positions = points.iter().map(|&[x, y]| (x, y)).collect();
        Batch { positions: Positions::Plane(positions), ..Batch::default() }
    })
}

fn play_film(batch: usize, send: &mut impl FnMut(Input) -> bool) {
    let form = Form::Lines(Some(Format::JsonLines), Columns::default());
    let origin = Origin::Opened(|| Box::new(FILM));
    let (frame_points, is_projected) = (None, false);
    let film = PointSource { origin, form, frame_points, closes_last: true, loops: true, batch, is_projected };
    if let Err(error) = film.read(send, &|_| ()) {
        send(Input::Failed(format!("{:#}", anyhow::Error::from(error))));
    }
}
