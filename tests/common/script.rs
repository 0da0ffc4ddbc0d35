//! A stream's life as a list of steps: run against the engine and the plain [`Model`] alike, and compared at every poll.
//!
//! A script prints itself as a test: what `{:?}` writes compiles where `use common::script::{Script, Step::*, run}` and
//! `use common::model::Kept` stand.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use hopes::topology::{Frame, Options, Pipeline, Refusal, VertexId};

use super::by_position::ByPosition;
use super::clouds::Point;
use super::model::{Kept, Model};
use super::skeleton_of;

/// What happens to a stream.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A batch of points of one event time comes, if it has one.
    Insert(Option<f64>, Vec<Point>),
    /// Points are taken back, one by one; some may not be there.
    Retract(Vec<Point>),
    /// Event time moves forward.
    Time(f64),
    /// A frame is closed.
    Commit,
    /// A frame is asked for.
    Poll,
}

use Step::*;

/// A stream's options and what happens to it.
#[derive(Clone, PartialEq)]
pub struct Script {
    pub kept: Kept,
    pub resolution: Option<f64>,
    pub steps: Vec<Step>,
}

impl Script {
    pub fn options(&self) -> Options {
        Options { window: self.kept.window(), resolution: self.resolution }
    }
}

/// Runs a script and gives the frames that were polled. Panics where the engine and the plain model differ.
pub fn run(script: &Script) -> Vec<Arc<Frame>> {
    let mut stage = Stage {
        pipeline: Pipeline::new(script.options()),
        model: Model::new(script.kept, script.resolution),
        times: Vec::new(),
        polled: 0,
        ids: BTreeMap::new(),
        frames: Vec::new(),
    };
    for step in &script.steps {
        stage.act(step);
        stage.pipeline.check_invariants();
    }
    stage.frames
}

/// An engine and its model, side by side.
struct Stage {
    pipeline: Pipeline,
    model: Model,
    /// Times that commits were given.
    times: Vec<Option<f64>>,
    /// Number of the last frame polled.
    polled: u64,
    /// Of lives seen in frames: the id.
    ids: BTreeMap<usize, VertexId>,
    frames: Vec<Arc<Frame>>,
}

impl Stage {
    fn act(&mut self, step: &Step) {
        match step {
            Insert(time, points) => {
                let refused = self.pipeline.feed_points(points, *time).into_iter().map(|(index, _)| index);
                let model = &mut self.model;
                let want = (0..points.len()).filter(|&index| !model.insert(points[index], *time));
                assert_eq!(refused.collect::<Vec<_>>(), want.collect::<Vec<_>>(), "places of refused points");
            }
            Retract(points) => {
                for &[x, y] in points {
                    let retracted = self.pipeline.feed_retraction(x, y);
                    if self.model.retract([x, y]) {
                        assert_eq!(retracted, Ok(()));
                    } else {
                        assert_eq!(retracted, Err(Refusal::NotThere { x, y }));
                    }
                }
            }
            Time(time) => {
                assert_eq!(self.pipeline.feed_time(*time), Ok(()));
                self.model.advance_time(*time);
            }
            Commit => {
                self.model.commit();
                self.times.push(self.model.newest());
                assert_eq!(self.pipeline.commit(self.model.newest()), self.model.commits(), "frame number");
            }
            Poll => self.poll(),
        }
        assert_eq!(self.pipeline.point_count(), self.model.points().len() as u64, "points in the window");
    }

    fn poll(&mut self) {
        let computed = self.pipeline.computed();
        let frame = self.pipeline.poll_frame();
        assert_eq!(frame.is_some(), self.polled < self.model.commits(), "whether there is a frame");
        let Some(frame) = frame else { return };
        self.polled = self.model.commits();
        assert_eq!(frame.number, self.polled);
        assert_eq!(frame.time, *self.times.last().expect("a frame has a commit"));
        assert_eq!(frame.points, self.model.committed_points() as u64, "points of the frame");
        assert_eq!(self.pipeline.computed(), computed + 1, "a frame is computed once");
        self.check_ids(&frame);
        let positions: Vec<Point> = self.model.committed().iter().map(|life| life.at).collect();
        ByPosition::of(&frame.skeleton).assert_same(&ByPosition::of(&skeleton_of(&positions)));
        self.frames.push(frame);
    }

    /// Ids are the lives' own: kept as long as a life, never given again, rising in order of first appearance.
    fn check_ids(&mut self, frame: &Frame) {
        let vertices = frame.skeleton.vertices().iter();
        let lives = self.model.committed().iter();
        assert_eq!(vertices.len(), lives.len(), "number of vertices");
        for (vertex, life) in vertices.zip(lives) {
            assert_eq!(vertex.position.xy(), life.at, "vertices stand in order of first appearance");
            assert_eq!(*self.ids.entry(life.number).or_insert(vertex.id), vertex.id, "a vertex keeps its id");
        }
        assert!(self.ids.values().is_sorted_by(|a, b| a < b), "ids rise and are never given twice");
    }
}

impl fmt::Debug for Script {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\n    #[test]\n    fn pasted_from_a_failure() {{")?;
        writeln!(f, "        run(&Script {{\n            kept: Kept::{:?},", self.kept)?;
        writeln!(f, "            resolution: {:?},\n            steps: vec![", self.resolution)?;
        for step in &self.steps {
            match step {
                Insert(time, points) => writeln!(f, "                Insert({time:?}, vec!{}),", Literal(points))?,
                Retract(points) => writeln!(f, "                Retract(vec!{}),", Literal(points))?,
                other => writeln!(f, "                {other:?},")?,
            }
        }
        writeln!(f, "            ],\n        }});\n    }}")
    }
}

/// Points as they are written in Rust, NaN and infinities too.
struct Literal<'a>(&'a [Point]);

impl fmt::Display for Literal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |v: f64| match v {
            f64::INFINITY => "f64::INFINITY".to_owned(),
            f64::NEG_INFINITY => "-f64::INFINITY".to_owned(),
            v if v.is_nan() => "f64::NAN".to_owned(),
            v => format!("{v:?}"),
        };
        let points: Vec<String> = self.0.iter().map(|&[x, y]| format!("[{}, {}]", number(x), number(y))).collect();
        write!(f, "[{}]", points.join(", "))
    }
}
